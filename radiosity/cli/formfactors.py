"""``radiosity formfactors``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from radiosity.cli import completion
from radiosity.cli import options as o
from radiosity.cli.answer import print_answer
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Reading, load_scene

MESH, SCENE = 1e-3, 0.02  # default accuracies; that of a scene is the one that `solve` takes
SHOWN, NAME = 8, 12  # sealed rows and groups that the summary shows, letters of a group's name


@dataclass(frozen=True)
class Found:
    """Form factors with what the summary says of their rows.

    Attributes
    ----------
    factors : FormFactors
    corners : (n,) int
        Of each row; 0 where a face without area or one of several pieces has a row.
    group : (n,) int
        Group of each row; backs have groups of their own.
    names : list of str
        Of the groups.
    memory : int
        Bytes that were predicted.
    """

    factors: Any
    corners: Any
    group: Any
    names: list[str]
    memory: int


def formfactors(
    source: Annotated[
        str,
        typer.Argument(
            metavar="MESH",
            help="Mesh file (.obj, .ply, .stl, .glb, .gltf, .rad), or scene file (.toml).",
            autocompletion=completion.files(".toml", *completion.MESHES),
        ),
    ],
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE",
            help="Save here; if not given, only the summary is printed.",
            autocompletion=completion.files(".npz", ".csv", ".out", ".vf", ".txt"),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    format: Annotated[
        str | None,
        typer.Option(
            "--format", metavar="npz|csv|view3d",
            help="Of the file; if not given, by its suffix (.npz; .csv; .out, .vf, .txt: View3D).",
            autocompletion=completion.words("npz", "csv", "view3d"),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    by_group: Annotated[
        bool,
        typer.Option(
            "--by-group",
            help="Factors between the file's face groups, not its faces.",
            rich_help_panel=o.OUTPUT,
        ),
    ] = False,
    as_json: o.Json = False,
    accuracy: Annotated[
        float | None,
        typer.Option(
            "--accuracy",
            metavar="EPS",
            parser=o.number,
            help="Bound of the summed errors in each row; if not given, 0.001 (of a scene 0.02, as "
            "in solve).",
            rich_help_panel=o.SOLVING,
        ),
    ] = None,
    mesh: Annotated[
        str | None,
        typer.Option(
            "--mesh", metavar="auto|input|N", help="Patches of a scene, as in solve.",
            autocompletion=completion.words("auto", "input"),
            rich_help_panel=o.SOLVING,
        ),
    ] = None,
    obstructions: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Mesh file whose faces block but are no rows.",
            autocompletion=completion.files(*completion.MESHES),
            rich_help_panel=o.SOLVING,
        ),
    ] = None,
    two_sided: Annotated[
        bool,
        typer.Option(
            "--two-sided", help="Backs are rows too, after all fronts.", rich_help_panel=o.SOLVING
        ),
    ] = False,
    raw: Annotated[
        bool,
        typer.Option(
            "--raw", help="As computed, without closing the rows.", rich_help_panel=o.SOLVING
        ),
    ] = False,
    seed: o.Seed = 0,
    ambient: o.Ambient = 0.0,
    memory: o.Memory = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Compute the form factors between the faces of a mesh, or between the patches of a scene.

    Printed are how well the rows close, how reciprocal they are, and the error that was reached.
    Those of a scene are what solve --factors reuses when colours or lamps change.

    Examples
    --------
    radiosity formfactors scenes/cornell_box.obj -o F.npz
    radiosity formfactors scenes/cornell_box.obj --by-group
    radiosity formfactors scenes/cornell_box.toml --mesh 4 -o scene.npz
    radiosity solve scenes/cornell_box.toml --mesh 4 --factors scene.npz
    """
    import time

    kind = _check_output(output, format)
    limit = o.parse_memory(memory)
    o.use_threads(threads)
    begun = time.perf_counter()
    with progress_bars(quiet) as progress:
        rest = {"repair": not raw, "seed": seed, "memory": limit, "progress": progress}
        if Path(source).suffix.lower() == ".toml":
            _refuse("a scene's own faces block, its lit backs are rows", **{
                "--obstructions": obstructions, "--two-sided": two_sided})  # fmt: skip
            asked = SCENE if accuracy is None else accuracy
            model = load_scene(source, mesh or "auto", Reading(ambient=ambient), quiet)
            found = _of_scene(model, asked, mesh, rest)
        else:
            _refuse("a mesh file's faces are the rows; name a .toml scene", **{
                "--mesh": mesh, "--ambient": ambient})  # fmt: skip
            asked = MESH if accuracy is None else accuracy
            found = _of_mesh(source, obstructions, two_sided, asked, quiet, rest)
    facts = _facts(found, asked, raw, time.perf_counter() - begun)
    factors = found.factors
    if by_group:
        factors = factors.grouped(found.group, len(found.names))
        facts |= {"groups": found.names, "group_factors": factors.toarray().tolist(),
                  "group_openness": factors.openness.share.tolist()}  # fmt: skip
    if output:
        factors.save(output, kind)
    if as_json:
        print_answer({**facts, "output": output, "written": [output] if output else []})
    else:
        print(summary(facts))
    if output:
        remark(f"saved {output}", quiet)
    if output and kind == "view3d" and facts["absorbed_max"]:
        remark("note: View3D's text counts what meets surfaces without rows as leaving", quiet)
    _judge(facts)


def _check_output(output, format) -> str | None:
    """Return the format to write, or raise the error that writing would end in."""
    if output is None:
        if format is not None:
            raise ValueError(f"--format {format} needs a file to write: add -o FILE")
        return None
    from radiosity.transport.files import check_place
    from radiosity.transport.store import FORMATS, find_format

    kind, suffix = find_format(output, format), Path(output).suffix.lower()
    if FORMATS.get(suffix, kind) != kind:
        raise ValueError(
            f"-o {output}: {suffix} is the suffix of the format {FORMATS[suffix]}, but --format "
            f"{kind} is asked for: leave one of them out"
        )
    check_place(output)
    return kind


def _refuse(why, **options):
    """Raise where an option is given that means nothing here."""
    for name, value in options.items():
        if value:
            raise ValueError(f"{name} does not apply: {why}")


def _of_mesh(path, obstructions, two_sided, accuracy, quiet, rest) -> Found:
    """Return the factors between a file's faces as they are numbered there."""
    import numpy as np

    from radiosity.scene.files import read_geometry
    from radiosity.solve.plan import check_factors

    geometry = read_geometry(path, merge=False)
    for note in geometry.notes:
        remark(f"note: {note}", quiet)
    faces, given, names = geometry.faces, geometry.given, list(geometry.group_names)
    blocking = None if obstructions is None else read_geometry(obstructions, merge=False).given
    rows = (2 if two_sided else 1) * given.size
    in_all = len(faces) + (0 if blocking is None else len(blocking.faces))
    memory = check_factors(rows, in_all, rest["memory"])
    from radiosity.solve.matrix import form_factors  # numba takes a second

    factors = form_factors(given, accuracy, obstructions=blocking, two_sided=two_sided, **rest)
    corners, group = np.zeros((2, given.count), int)
    pieces = np.bincount(given.owner, minlength=given.count)
    corners[given.owner] = np.where(pieces[given.owner] == 1, 4 - faces.is_triangle, 0)
    group[given.owner] = faces.group
    if two_sided:
        corners, group = np.tile(corners, 2), np.concatenate([group, group + len(names)])
        names += [f"{name} (back)" for name in names]
    return Found(factors, corners, group, names, memory)


def _of_scene(scene, accuracy, mesh, rest) -> Found:
    """Return the factors between the patches that `solve` has for a scene."""
    import numpy as np

    from radiosity.solve.plan import check_memory, make_plan

    plan = make_plan(scene, accuracy, mesh or "auto", order=0)
    memory = check_memory(plan.division.count, rest["memory"])
    from radiosity.solve.assembly import scene_factors

    found = scene_factors(scene, accuracy, mesh=mesh or "auto", **rest)
    patches, names = found.reach.patches, list(scene.groups)
    corners = 4 - np.all(patches.vertices[:, 3] == patches.vertices[:, 2], axis=1)
    group = scene.faces.group[patches.face] + np.where(patches.front, 0, len(names))
    if not patches.front.all():
        names += [f"{name} (back)" for name in names]
    return Found(found.factors, corners, group, names, memory)


def _facts(found, asked, raw, seconds) -> dict:
    """Return what is to be said of the factors, as plain values for JSON."""
    import numpy as np

    f = found.factors
    before = f.raw_closure[f.exposed]
    return {
        "rows": len(f.area),
        "triangles": int(np.count_nonzero(found.corners == 3)),
        "quadrilaterals": int(np.count_nonzero(found.corners == 4)),
        "closed": f.is_closed,
        "environment_max": float(f.environment.max(initial=0.0)),
        "openness_error": float(f.openness.error[f.exposed].max(initial=0.0)),
        "absorbed_max": float(np.max(f.openness.absorbed, initial=0.0)),
        "sealed": f.sealed.tolist(),
        "closure_raw_max": float(np.abs(before).max(initial=0.0)),
        "closure_raw_rms": float(np.sqrt(np.mean(before**2))) if len(before) else 0.0,
        "repaired": not raw,
        "closure_max": float(np.abs(f.closure).max(initial=0.0)),
        "reciprocity": f.reciprocity,
        "error": float(f.row_errors().max(initial=0.0)),
        "unexplained": float(_unexplained(f).max(initial=0.0)),
        "accuracy": asked,
        "seconds": seconds,
        "memory_bytes": found.memory,
        "groups": None,
        "group_factors": None,
        "group_openness": None,
    }


def _unexplained(f):
    """Return (n,) by how much the rows failed to close beyond what rays may have missed outside.

    A row's error is no smaller than its defect; three standard errors of the openness are granted.
    """
    import numpy as np

    return np.abs(f.raw_closure) - 3.0 * f.openness.error


def summary(facts: dict) -> str:
    """Return the size of the matrix and how well it keeps its laws, as text."""
    from radiosity.solve.plan import size_text

    kinds = f"{facts['triangles']} triangles, {facts['quadrilaterals']} quadrilaterals"
    others = facts["rows"] - facts["triangles"] - facts["quadrilaterals"]
    lines = [
        f"rows          {facts['rows']} ({kinds}{f', {others} others' if others else ''})",
        f"scene         {_openness(facts)}",
        f"sealed        {_some(facts['sealed']) or 'none'}",
        f"raw closure   worst {facts['closure_raw_max']:.1e}, rms {facts['closure_raw_rms']:.1e}",
        f"repaired      {_repair(facts)}",
        f"reciprocity   {facts['reciprocity']:.1e}",
        f"error         {facts['error']:.1e} estimated for the worst row, "
        f"{facts['accuracy']:g} asked",
        f"time          {facts['seconds']:.1f} s",
        f"memory        {size_text(facts['memory_bytes'])} predicted",
    ]
    if facts["groups"] is not None:
        lines.insert(1, f"groups        {_some(facts['groups'])}")
        lines += ["", *_table(facts)]
    return "\n".join(lines)


def _table(facts) -> list[str]:
    """Return a line for each of the first groups: its factors to these, and to no row."""
    names, factors = facts["groups"], facts["group_factors"]
    names = [name if len(name) <= NAME else f"{name[:5]}..{name[-5:]}" for name in names[:SHOWN]]
    heads = [*names, "no row"]
    lines = [f"{'from, to':{NAME}}" + "".join(f"{name:>{NAME + 1}}" for name in heads)]
    for name, row, out in zip(names, factors, facts["group_openness"], strict=False):
        shown = [*row[:SHOWN], out]
        lines.append(f"{name:{NAME}}" + "".join(f"{x:{NAME + 1}.6f}" for x in shown))
    return lines if len(factors) <= SHOWN else [*lines, f"first {SHOWN} of {len(factors)}"]


def _openness(facts) -> str:
    text = "closed"
    if not facts["closed"]:
        text = f"open: up to {facts['environment_max']:.4g} of a row's light leaves"
    if facts["absorbed_max"]:
        text += f"; up to {facts['absorbed_max']:.4g} meets surfaces that are no rows"
    if facts["openness_error"]:
        text += f"; what leaves the rows is known to {facts['openness_error']:.1e}"
    return text


def _repair(facts) -> str:
    return f"worst {facts['closure_max']:.1e}" if facts["repaired"] else "no, as --raw asks"


def _some(items) -> str:
    """Return how many items there are and the first few; nothing where there are none."""
    if not items:
        return ""
    more = ", .." if len(items) > SHOWN else ""
    return f"{len(items)}: {', '.join(map(str, items[:SHOWN]))}{more}"


def _judge(facts):
    """End with exit code 1 where the error, estimated or found, is above the asked one."""
    found, asked = facts["unexplained"], facts["accuracy"]
    if found > max(facts["error"], asked):
        remark(
            f"radiosity: a row fails to close by {found:.2e}, more than the asked {asked:g} and "
            "than any error that was estimated: faces may overlap or cross where they should meet, "
            "or see out by gaps that rays did not find"
        )
        raise typer.Exit(1)
    if facts["error"] > asked:
        remark(
            f"radiosity: reached an estimated error of {facts['error']:.2e}, above the asked "
            f"{asked:g}: divide the faces that are partly hidden, or ask for less"
        )
        raise typer.Exit(1)
