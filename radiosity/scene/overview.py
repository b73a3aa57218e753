"""A scene as notebooks show it: what it holds, as tables."""

from radiosity.scene.contents import (
    colour_words,
    face_words,
    light_rows,
    material_rows,
    number_words,
    view_words,
)
from radiosity.scene.markup import Markup, cell, in_notebook, line, swatch, table
from radiosity.scene.model import Scene

MOST = 30  # rows of a table


def scene_html(scene: Scene) -> str:
    """Return the contents of a scene as HTML: faces, materials, lights, cameras and notes.

    Examples
    --------
    >>> import radiosity
    >>> "4.2 x 3.6 x 2.7 m" in scene_html(radiosity.load("scenes/office.toml"))
    True
    """
    parts = [line(face_words(scene)), line(colour_words(scene)), capped(_materials(scene))]
    parts += [capped(_lights(scene)), capped(_cameras(scene))]
    parts += [line(f"note: {note}") for note in scene.notes]
    return in_notebook(scene.name, *parts)


def capped(made: tuple) -> Markup:
    """Return a table of heads, rows and columns of numbers; "" of no rows, few of many."""
    heads, rows, numbers = made
    if not rows:
        return Markup("")
    more = line(f"and {len(rows) - MOST} more") if len(rows) > MOST else ""
    return Markup(table(heads, rows[:MOST], numbers) + more)


def _materials(scene):
    rows = [
        [Markup(f"{swatch(m.rgb)} {cell(m.name)}"), m.faces, f"{m.area_m2:.4g}", m.diffuse,
         m.emission, m.more.strip().replace("  ", "; ")]
        for m in material_rows(scene)
    ]  # fmt: skip
    heads = ["material", "faces", "area m²", "diffuse reflectance", "emission W/(m² sr)", ""]
    return heads, rows, [1, 2]


def _lights(scene):
    rows = [
        [x.kind, x.place_words, x.strength, x.group,
         "-" if x.flux_lm is None else f"{x.flux_lm:.4g}", x.label]
        for x in light_rows(scene)
    ]  # fmt: skip
    heads = ["light", "position or direction", "W/sr or W/m²", "light group", "flux lm", ""]
    return heads, rows, [4]


def _cameras(scene):
    rows = [
        [c.name, number_words(c.position), number_words(c.target), view_words(c, scene.unit),
         f"{c.size[0]} x {c.size[1]}"]
        for c in scene.cameras.values()
    ]  # fmt: skip
    return ["camera", "position", "target", "view", "pixels"], rows, []
