"""A page: one file that shows a solution in any browser, without a network."""

import base64
import hashlib
import html
import json
from importlib.resources import files
from os import PathLike

from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution
from radiosity.transport.files import written_whole
from radiosity.transport.threads import Progress, silent
from radiosity.view.fine.finemesh import FineMesh, gathered_mesh
from radiosity.view.page.contents import contents_of

SCRIPTS = "vectors", "light", "camera", "draw", "pick", "panel", "main"  # in this order


def write_page(
    solution: Solution, path: str | PathLike, *, camera: Camera | None = None,
    exposure: float | None = None, progress: Progress = silent,
) -> None:  # fmt: skip
    """Write a page that shows a solution: whole, or not at all.

    Parameters
    ----------
    path : path-like
        Of the ``.html`` file.
    camera : Camera, optional
        What is shown first; by default the scene's first camera.
    exposure : float, optional
        Display value per radiance, at first; by default that of pictures, or less where surfaces
        that shine would be all white, shown matte.

    Raises
    ------
    OSError
        Where the file cannot be written.
    """
    with written_whole(path) as temporary:
        mesh = gathered_mesh(solution, progress, with_errors=True)
        text = page_of(solution, mesh, camera, exposure)
        temporary.write_text(text, encoding="utf-8", newline="\n")


def page_of(
    solution: Solution, mesh: FineMesh, camera: Camera | None = None, exposure: float | None = None
) -> str:
    """Return the text of a page that shows a solution's mesh; see `write_page`.

    It may run the script that it holds and no other, and load nothing.
    """
    about, light = contents_of(solution, mesh, camera, exposure)
    style, scripts = _part("viewer.css"), "\n".join(_part(f"{name}.js") for name in SCRIPTS)
    script = f"(() => {{\n'use strict';\n{scripts}}})();\n"
    filled = {
        "POLICY": f"default-src 'none'; script-src {_hash(script)}; style-src {_hash(style)}; "
        "img-src data:; base-uri 'none'; form-action 'none'",
        "TITLE": html.escape(solution.scene.name),
        "STYLE": style,
        "ABOUT": embedded(about),
        "LIGHT": light,
        "SCRIPT": script,
    }
    pieces = _part("viewer.html").split("@@")  # text, name, text, name, ..., text
    pieces[1::2] = [filled[name] for name in pieces[1::2]]
    return "".join(pieces)


def embedded(value) -> str:
    r"""Return a value as JSON that can stand in a page: no text in it ends, or begins, an element.

    Examples
    --------
    >>> embedded({"name": "</script>"})
    '{"name":"\\u003c/script\\u003e"}'
    """
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def _part(name) -> str:
    return (files("radiosity.view.page") / "viewer" / name).read_text(encoding="utf-8")


def _hash(text) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"
