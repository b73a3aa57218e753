"""``radiosity info``."""

import typer

from radiosity.cli import options as o
from radiosity.cli.answer import print_answer
from radiosity.cli.contents import facts
from radiosity.cli.given import refuse_solving
from radiosity.cli.session import reached_line
from radiosity.scene.names import counted


def info(
    context: typer.Context,
    scene: o.SceneFile,
    as_json: o.Json = False,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
) -> None:
    """Print what was read from a scene's files: materials, lights, cameras, mesh findings.

    Of a .radsol file also how it was solved, what was reached and what can be dimmed.

    Examples
    --------
    radiosity info scenes/cornell_box.toml
    radiosity info scenes/cornell_box.obj --unit mm --up y --json
    """
    from radiosity.solve.load import is_solved, load

    solution = None
    if is_solved(scene):
        refuse_solving(context, scene)
        solution = load(scene)
    model = solution.scene if solution else load(scene, bands=bands, unit=unit, up=up)
    if as_json:
        print_answer(facts(model, solution))
        return
    print("\n".join([describe(model), *(_solved(solution) if solution else [])]))


def _solved(solution) -> list[str]:
    """Return how a scene was solved, what was reached, and what of its light can be dimmed."""
    level, recipe = solution.level, solution.level.recipe
    kind = "linear" if recipe.order else "constant"
    kind = "clusters of constant" if solution.plan.clusters else kind
    return [
        "",
        f"solved: {counted(len(solution.patches), 'patch')}, {kind} elements, "
        f"{counted(len(level.history), 'iteration')} of {level.solver}, seed {solution.seed}",
        f"error: {reached_line(solution)}",
        f"dim: {', '.join(solution.groups) if solution.can_dim else 'too many light groups'}",
    ]


def describe(scene) -> str:
    """Return a scene's contents as text, with units."""
    from radiosity.scene.contents import (
        colour_words,
        face_words,
        material_rows,
        number_words,
        view_words,
    )

    colours = colour_words(scene)
    lines = [f"{scene.name}: {face_words(scene)}", *([colours] if colours else []), ""]
    lines.append(
        f"{'material':16}{'faces':>7}{'area m2':>12}  {'diffuse reflectance':24}emission W/(m2 sr)"
    )
    for m in material_rows(scene):
        size = f"{m.faces:7}{m.area_m2:12.6g}"
        lines.append(f"{m.name:16}{size}  {m.diffuse:24} {m.emission}{m.more}")
        if m.flux_lm > 0.0:
            shines = f"{m.luminance_cd_m2:.6g} cd/m2, {m.flux_lm:.6g} lm in all"
            lines.append(f"    shines with {shines}")
    lines += _lights(scene)
    lines += ["", f"{'camera':16}{'position':26}{'target':26}{'view':16}size"]
    for camera in scene.cameras.values():
        lines.append(
            f"{camera.name:16}{number_words(camera.position):26}{number_words(camera.target):26}"
            f"{view_words(camera, scene.unit):16}{camera.size[0]}x{camera.size[1]}"
        )
    return "\n".join(lines + _findings(scene))


def _lights(scene) -> list[str]:
    """Return the abstract light sources, and what enters from outside."""
    from radiosity.scene.contents import light_rows

    lines = ["", f"{'light':16}{'position or direction':26} {'W/sr or W/m2':28} group"]
    for light in light_rows(scene):
        lines.append(f"{light.kind:16}{light.place_words:26} {light.strength:28} {light.group}")
        if light.label:
            lines.append(f"    read as {light.label}")
        if light.peak_cd is not None:
            flux = "" if light.flux_lm is None else f", {light.flux_lm:.6g} lm in all"
            lines.append(f"    at most {light.peak_cd:.6g} cd{flux}")
    return lines if len(lines) > 2 else []


def _findings(scene) -> list[str]:
    """Return what was found in the mesh, and what the readers noted."""
    from radiosity.scene.contents import finding_words

    found = finding_words(scene)
    found += [f"read as: {name}: {said.origin}" for name, said in scene.read_as.items()]
    if scene.read_as:
        found.append("radiosity materials shows what these became, as tables of a scene file")
    return ["", *found, *(f"note: {note}" for note in scene.notes)]
