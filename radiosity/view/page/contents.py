"""What a page is given to show: the mesh, its light, and what there is to say about them."""

import numpy as np

from radiosity import __version__
from radiosity.light.photometry import EFFICACY, luminance
from radiosity.scene.model import Camera
from radiosity.scene.units import turn_between
from radiosity.solve.solution import Solution
from radiosity.view.camera import basis
from radiosity.view.falsecolour import STEPS, Scale
from radiosity.view.fine.finemesh import FineMesh
from radiosity.view.fine.looks import looks_of
from radiosity.view.image import exposure_for
from radiosity.view.page.looks import not_shown, picture_of
from radiosity.view.page.packing import Packer, picture_url
from radiosity.view.scales import illuminance_scale
from radiosity.view.shading import auto_exposure

NOTES = 5  # of the scene that are told at most


def contents_of(
    solution: Solution, mesh: FineMesh, camera: Camera | None, exposure: float | None
) -> tuple[dict, str]:
    """Return what a page is to know as plain lists and numbers, and its arrays as text."""
    scene, packer = solution.scene, Packer()
    parts = _pack(packer, solution, mesh)
    cameras = [camera] if camera is not None else []
    cameras += [c for c in scene.cameras.values() if c is not camera]
    return {
        "name": scene.name,
        "unit": scene.unit,
        "up": turn_between("y", scene.up)[:, 1].tolist(),
        "efficacy": EFFICACY,
        "exposure": page_exposure(solution) if exposure is None else exposure,
        "most": illuminance_scale(solution).maximum,
        "map": Scale(STEPS).colours(np.arange(STEPS) + 0.5).tolist(),
        "groups": list(mesh.groups),
        "materials": _materials(solution, mesh),
        "parts": parts,
        "cameras": [_camera(c) for c in cameras],
        "facts": _facts(solution, mesh),
        "missing": not_shown(scene),
        "arrays": packer.entries,
    }, packer.text()


def _pack(packer, solution, mesh) -> list[dict]:
    """Add a mesh's arrays; return which of its triangles are alike: material, side, lit or not."""
    scene, patches = solution.scene, solution.patches
    patch = mesh.patch[mesh.triangles[:, 0]]
    kind = 4 * scene.faces.material[patches.face[patch]] + 2 * ~patches.front[patch]
    kind += ~solution.live[patch]
    order = np.argsort(kind, kind="stable")
    kinds, start, count = np.unique(kind[order], return_index=True, return_counts=True)
    corner = mesh.triangles[order].ravel()
    vertex, first, which = np.unique(corner, return_index=True, return_inverse=True)
    vertex = vertex[np.argsort(first)]  # by first use, so that steps are short
    packer.steps("triangles", np.argsort(np.argsort(first))[which])
    packer.floats("points", mesh.points[vertex])
    rows = np.concatenate([mesh.lux[..., None], mesh.reflected], axis=2)[vertex]
    packer.halves("light", rows.reshape(len(vertex), -1).T)  # a group's lux, red, green and blue
    if np.isfinite(mesh.error).all():
        packer.halves("error", mesh.error[vertex][None])
    if mesh.uv.any():
        packer.floats("uv", mesh.uv[vertex])
    made = zip(kinds.tolist(), (3 * start).tolist(), (3 * count).tolist(), strict=True)
    return [
        {"material": k // 4, "back": k // 2 % 2, "dark": k % 2, "start": a, "count": n}
        for k, a, n in made
    ]


def _materials(solution, mesh) -> list[dict]:
    """Return what is to be known of each material, emission of fronts by light groups."""
    scene, looks, found = solution.scene, looks_of(solution.scene), []
    for k, m in enumerate(scene.materials):
        mine = m.name if m.name in mesh.groups else mesh.groups[0]
        rgb = (np.pi * scene.bands.to_rgb(m.emission)).tolist()
        emission = {"group": mesh.groups.index(mine), "rgb": rgb} if m.emits else None
        reflected = luminance(looks.reflects[:, k], scene.bands)
        white = luminance(np.ones(scene.bands.count), scene.bands)
        one = {"name": m.name, "emission": emission, "opacity": float(looks.opacity[k]),
               "reflectance": (reflected / white).tolist()}  # fmt: skip
        if m.texture is not None:
            texels, repeats = picture_of(m)
            url, white = picture_url(texels)
            one["picture"] = {"url": url, "white": white, "repeat": repeats}
        found.append(one)
    return found


def _camera(camera: Camera) -> dict:
    """Return where a camera stands, its axes and what it sees."""
    right, up, forward = basis(camera)
    width, height = camera.size
    return {
        "name": camera.name, "position": np.asarray(camera.position, float).tolist(),
        "right": right.tolist(), "up": up.tolist(), "forward": forward.tolist(),
        "fov": camera.fov, "height": camera.height, "aspect": width / height,
    }  # fmt: skip


def page_exposure(solution) -> float:
    """Return that of pictures, or less where surfaces that are shown matte would all be white."""
    found, scene, patches = auto_exposure(solution), solution.scene, solution.patches
    dark = solution.live & ~solution.emission.any(axis=1)
    if not scene.sends_on or not dark.any():
        return found
    side, material = np.where(patches.front, 0, 1), scene.faces.material[patches.face]
    sent = looks_of(scene).reflects[side, material] * solution.irradiance_on / np.pi
    bright = np.maximum(scene.bands.luminance(sent[dark]), 0.0)
    return min(found, exposure_for(bright, patches.area[dark])) if bright.any() else found


def _facts(solution, mesh) -> list[list[str]]:
    """Return what a page says of the solution, names and values."""
    plan, reached = solution.plan, solution.estimate.reached
    asked = f"{100 * plan.accuracy:.2g} %" if plan.seconds is None else f"{plan.seconds:g} s"
    return [
        ["asked", asked],
        ["estimated error", f"{100 * reached:.2g} %" if np.isfinite(reached) else "not estimated"],
        ["patches", f"{len(solution.patches)}"],
        ["points shown", f"{len(mesh.points)}"],
        ["made with", f"radiosity {__version__}"],
        *(["note", note] for note in solution.scene.notes[:NOTES]),
    ]
