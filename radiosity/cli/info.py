"""``radiosity info``."""

import typer

from radiosity.cli import options as o
from radiosity.cli.answer import print_answer
from radiosity.cli.contents import facts, find_in_mesh
from radiosity.cli.given import refuse_solving
from radiosity.cli.session import reached_line


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
        f"solved: {len(solution.patches)} patches, {kind} elements, {len(level.history)} "
        f"iterations of {level.solver}, seed {solution.seed}",
        f"error: {reached_line(solution)}",
        f"dim: {', '.join(solution.groups) if solution.can_dim else 'too many light groups'}",
    ]


def describe(scene) -> str:
    """Return a scene's contents as text, with units."""
    import numpy as np

    faces = scene.faces
    area = faces.areas() * scene.unit_m**2
    low, high = (f(faces.vertices.reshape(-1, 3), axis=0) for f in (np.min, np.max))
    extent = " x ".join(f"{v:g}" for v in high - low)
    triangles = int(faces.is_triangle.sum())
    lines = [
        f"{scene.name}: faces {len(faces)} (quadrilaterals {len(faces) - triangles}, "
        f"triangles {triangles}), {area.sum():.6g} m2, {extent} {scene.unit}, {scene.up} up",
        *_colours(scene),
        "",
        f"{'material':16}{'faces':>7}{'area m2':>12}  {'diffuse reflectance':24}emission W/(m2 sr)",
    ]
    for k, material in enumerate(scene.materials):
        mine = faces.material == k
        lines.append(
            f"{material.name:16}{int(mine.sum()):7}{area[mine].sum():12.6g}  "
            f"{_share(material.diffuse):24} "
            + (_light(material.emission, scene.bands) if material.emits else "-")
            + _optics(material)
            + _detail(material)
            + ("" if material.two_sided else "  back black")
        )
    lines += _lights(scene)
    lines += ["", f"{'camera':16}{'position':26}{'target':26}{'view':16}size"]
    for camera in scene.cameras.values():
        lines.append(
            f"{camera.name:16}{_bands(camera.position):26}{_bands(camera.target):26}"
            f"{_view(camera, scene.unit):16}{camera.size[0]}x{camera.size[1]}"
        )
    return "\n".join(lines + _findings(scene))


def _view(camera, unit) -> str:
    """Return how much of the scene a camera shows from top to bottom."""
    if camera.orthographic:
        return f"{camera.height:.4g} {unit} high"
    return f"{camera.fov:.4g} degrees"


def _lights(scene) -> list[str]:
    """Return the abstract light sources, and what enters from outside."""
    from radiosity.scene.groups import AMBIENT, groups_of_lights, kind_of_light

    lines = ["", f"{'light':16}{'position or direction':26} {'W/sr or W/m2':28} group"]
    for light, group in zip(scene.lights, groups_of_lights(scene), strict=True):
        kind = kind_of_light(light)
        where = light.direction if kind == "directional" else light.position
        strength = _light(light.strength, scene.bands)
        lines.append(f"{kind:16}{_bands(where):26} {strength:28} {group}")
        lines += _read_as(light, scene.bands)
    if scene.ambient.any():
        strength = _light(scene.ambient, scene.bands)
        lines.append(f"{'ambient':16}{'from outside, W/(m2 sr)':26} {strength:28} {AMBIENT}")
    return lines if len(lines) > 2 else []


def _read_as(light, bands) -> list[str]:
    """Return what a luminaire was read from, and how strong it is."""
    label = getattr(light, "label", "")
    if not label:
        return []
    from radiosity.light.photometry import photometric

    peak = photometric(light.strength, bands)
    flux = peak * light.solid_angle
    return [f"    read as {label}", f"    at most {peak:.6g} cd, {flux:.6g} lm in all"]


def _findings(scene) -> list[str]:
    """Return what was found in the mesh, and what the readers noted."""
    from radiosity.mesh.findings import MEANS

    contacts, flaws = find_in_mesh(scene)
    covered = sum(bool(c.covers or c.hides) for c in contacts.values())
    found = [
        f"contact: {len(contacts)} faces are met by others in their plane, {covered} lie on others",
        f"mesh: {flaws.outward + flaws.inward} closed pieces ({flaws.outward} look out, "
        f"{flaws.inward} in), {flaws.open} open",
        *(f"found: {f.count} {MEANS[f.kind]}{_places(f, scene)}" for f in flaws.found),
    ]
    if scene.truth is not None:
        found.append(
            f"truth: carries its radiosity for mesh {scene.truth.mesh}, "
            f"to {scene.truth.relative_tolerance:g} relative"
        )
    if scene.faces.is_curved.any():
        curved = int(scene.faces.is_curved.sum())
        found.append(f"normals: {curved} faces stand for a curved surface")
    found += [f"read as: {name}: {said.origin}" for name, said in scene.read_as.items()]
    if scene.read_as:
        found.append("radiosity materials shows what these became, as tables of a scene file")
    return ["", *found, *(f"note: {note}" for note in scene.notes)]


def _places(finding, scene) -> str:
    """Return where the first of a kind are: faces, their groups and points."""
    places = [
        f"face {f} ({scene.groups[scene.faces.group[f]]}) at {_bands(point)}"
        for f, point in zip(finding.faces, finding.points, strict=True)
    ]
    return "; ".join(["", *places]) + ("; .." if finding.count > len(places) > 0 else "")


def _bands(values) -> str:
    return " ".join(f"{v:.6g}" for v in values)


def _detail(material) -> str:
    """Return what is said of a material's texture, whose mean was printed, and of its bumps."""
    words = ""
    if material.texture is not None:
        height, width, _ = material.texture.texels.shape
        words += f"  texture {width}x{height}, from {_share(material.texture.lowest)} to "
        words += _share(material.texture.highest)
    if material.shininess is not None:
        words += f"  roughness by a texture from {material.shininess.minimum:g}"
    if material.bump is not None:
        words += f"  bumps {material.bump.height:g} high"
    return words


def _optics(material) -> str:
    named = {"": material.specular, "mirror ": material.mirror, "transmits ": material.transmit}
    words = "".join(f"  {name}{part.summary}" for name, part in named.items() if part is not None)
    if material.translucent is not None:
        words += f"  translucent {_share(material.translucent)}"
    if material.absorption is not None:
        words += f"  absorbs {_share(material.absorption)} a metre"
    return words


def _share(values) -> str:
    """Return shares as text, of many wavelengths the least and the most."""
    if len(values) <= 3:
        return _bands(values)
    return " to ".join(dict.fromkeys(f"{v:.6g}" for v in (values.min(), values.max())))


def _light(values, bands) -> str:
    """Return watts as text, of wavelengths as RGB."""
    return _bands(values if bands.wavelengths is None else bands.to_rgb(values))


def _colours(scene) -> list[str]:
    """Return what a scene is computed in where that is not red, green and blue."""
    from radiosity.light.bands import RGB

    if scene.bands is RGB and not scene.spectra:
        return []
    wavelengths = scene.bands.wavelengths is not None
    kind = f"{scene.bands.count} wavelengths" if wavelengths else " ".join(scene.bands.names)
    return [f"colours in {kind}" + (", of " if scene.spectra else "") + ", ".join(scene.spectra)]
