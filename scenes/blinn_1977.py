"""Draw figures 5 to 8 of Blinn (1977), "Models of light reflection ..".

    python scenes/blinn_1977.py [--size 320] [-o FOLDER]

Writes ``blinn_lobes.png`` (figures 5 and 6), ``blinn_materials.png`` (7a and 7b) and
``blinn_shininess.png`` (8). The forms are those of the paper, i = p_d N.L + p_s s with s = (N.H)^c1
(which it calls Phong's) or D3 F G/(N.E), lights and eye far away, no shadows, no light from other
surfaces; i = 1 is white. Given in the paper: p_s, p_d, n and c3 of aluminium and of magnesium
oxide. Not given, and chosen here: the metal of the plots and of figure 8, the object and textures
(`blinn_vase.py`), the directions of the light, and p_s and c1 of Phong's model, so that both models
have the same highlight at normal incidence: c1 by the angle at which facets are half as many, p_s
times F there.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import imageio.v3
import numpy as np

import radiosity
from radiosity.light.blinn import Blinn
from radiosity.light.facets import TrowbridgeReitz
from radiosity.light.frames import frame, polar, to_local
from radiosity.light.seed_forms import SeedForm
from radiosity.light.shadowing import v_groove
from radiosity.light.texture import Texture
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.mesh.contact import find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.patches import make_patches
from radiosity.transport.lookup import make_table
from radiosity.transport.visibility import Visibility
from radiosity.view.camera import basis, rays
from radiosity.view.detail import Detail
from radiosity.view.image import tone_map

HERE = Path(__file__).resolve().parent
EDGE_ON, FRONT_ON = (0.75, 0.1, -0.9), (-0.35, 0.35, 1.0)  # to the light: right, up, to the eye
GRID = 3  # sight lines a pixel, each way


@dataclass(frozen=True)
class Surface:
    """A material of the paper: shares of diffuse and specular light, index and spread of facets."""

    name: str
    p_d: float
    p_s: float
    n: float
    c3: float

    @property
    def facets(self) -> SeedForm:
        """Torrance & Sparrow's model."""
        index, share = np.array([self.n]), np.array([self.p_s])
        return SeedForm(TorranceSparrow(TrowbridgeReitz(self.c3), v_groove, index, share))

    @property
    def lobe(self) -> SeedForm:
        """The model that the paper calls Phong's, with the same highlight at normal incidence."""
        c = self.c3**2
        half = (np.sqrt(2.0) * c - 1.0) / (c - 1.0)  # cos^2 of the angle where D3 = 1/2
        fresnel = ((self.n - 1.0) / (self.n + 1.0)) ** 2
        return SeedForm(Blinn(np.array([self.p_s * fresnel]), np.log(0.25) / np.log(half)))


PLOTTED = Surface("metal", 0.4, 0.4, 200.0, 0.2)
TEXTURED = Surface("metal", 0.4, 0.8, 200.0, np.nan)
ALUMINIUM = Surface("aluminium", 0.6, 0.4, 200.0, 0.5)
CERAMIC = Surface("magnesium oxide", 0.333, 0.667, 1.8, 0.35)


def intensity(surface: Surface, model: SeedForm, to_light, to_view) -> np.ndarray:
    """Return i = p_d N.L + p_s s (...) of directions (..., 3) in the surface's frame."""
    lit = np.maximum(np.asarray(to_light)[..., 2], 0.0)
    return lit * (surface.p_d + model.value(to_light, to_view)[..., 0])


def lobes(path: Path) -> None:
    """Draw figures 5 and 6: what leaves in every direction of light from 30 and 70 degrees."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    axes = figure.subplots(2, 2, sharex="row", sharey="row", height_ratios=[2.2, 1])
    angle = np.radians(np.linspace(-89.9, 89.9, 1441))  # to the left of the normal
    view = polar(np.cos(angle), np.where(angle < 0, 0.0, np.pi))
    for row, degrees in zip(axes, (30, 70), strict=True):
        light = np.broadcast_to(polar(np.cos(np.radians(degrees)), 0.0), view.shape)
        models = {"Phong": PLOTTED.lobe, "Torrance-Sparrow": PLOTTED.facets}
        for place, (name, model) in zip(row, models.items(), strict=True):
            i = intensity(PLOTTED, model, light, view)
            place.fill(-i * np.sin(angle), i * np.cos(angle), color="0.85")
            place.plot(-i * np.sin(angle), i * np.cos(angle), "k", lw=1)
            _rays(place, np.radians(degrees))
            place.set_title(f"{name}, {degrees}\u00b0", fontsize=10)
    figure.savefig(path, dpi=100)


def _rays(place, angle):
    """Draw the ground, the incoming ray from the right and the mirror direction to the left."""
    x, y = np.sin(angle), np.cos(angle)
    place.axhline(0, color="0.5", lw=1)
    place.plot([0, x], [0, y], "C1", lw=1.5)
    place.plot([0, -x], [0, y], "C0--", lw=1.5)
    place.set_aspect("equal")
    place.set_axis_off()


class Seen:
    """What the camera of a scene sees of its one surface: normals, spread of facets, directions."""

    def __init__(self, scene: radiosity.Scene, height: int):
        """Follow ``GRID`` x ``GRID`` sight lines a pixel to the surface."""
        (camera,) = scene.cameras.values()
        self.size = round(height * camera.size[0] / camera.size[1]), height
        x, y = ((np.arange(n * GRID) + 0.5) / GRID for n in self.size)
        pixels = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        origins, directions = rays(camera, self.size, pixels)
        found = Visibility(scene.faces)
        start = ((origins - found.centre) * found.scale).astype(np.float32)
        face, distance = found.first_hits(start, directions.astype(np.float32))
        self.met = face >= 0
        self.face = face[self.met]
        away = distance[self.met, None] / found.scale
        self.points = (origins + 0.0)[self.met] + away * directions[self.met]
        own = scene.faces.normals()[self.face]
        self.sides = -np.sign(np.einsum("kc,kc->k", own, directions[self.met]))
        self.table, self.directions = _table_of(scene.faces), directions[self.met]
        self.axes = np.array(basis(camera)) * [[1], [1], [-1]]  # right, up, to the eye
        self.frames = frame(self.detail(scene).normals(self.face, self.points, self.sides))

    def detail(self, scene: radiosity.Scene) -> Detail:
        """Return what varies inside of the faces, of a scene with these faces."""
        return Detail(scene, self.table)

    def shown(self, shade, to_light) -> np.ndarray:
        """Return (h, w, 3) uint8 of ``shade(to_light, to_view)`` in the frames of the surface."""
        light = np.asarray(to_light) / np.linalg.norm(to_light) @ self.axes
        values = np.zeros(len(self.met))
        here = (np.broadcast_to(light, self.directions.shape), -self.directions)
        values[self.met] = shade(*(to_local(self.frames, d) for d in here))
        width, height = self.size
        grid = np.minimum(values, 1.0).reshape(height, GRID, width, GRID).mean(axis=(1, 3))
        return tone_map(np.repeat(grid[..., None], 3, axis=2), 1.0)


def _table_of(faces):
    """Return the table that finds places on faces."""
    cells = np.where(faces.is_triangle[:, None], [1, 0], [1, 1])
    dark = np.zeros(len(faces), bool)
    return make_table(faces, make_patches(faces, Division(cells), find_contacts(faces, dark)))


def materials(seen: Seen, path: Path) -> None:
    """Draw figures 7a and 7b: both models, lit from the edge and from the front."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 7.0), layout="constrained", facecolor="white")
    axes = figure.subplots(2, 4)
    for row, surface in zip(axes, (ALUMINIUM, CERAMIC), strict=True):
        for column, (light, where) in enumerate(((EDGE_ON, "edge lit"), (FRONT_ON, "front lit"))):
            models = {"Phong": surface.lobe, "Torrance-Sparrow": surface.facets}
            for k, (name, model) in enumerate(models.items()):

                def shade(to_light, to_view, surface=surface, model=model):
                    return intensity(surface, model, to_light, to_view)

                place = row[2 * column + k]
                place.imshow(seen.shown(shade, light))
                place.set_title(f"{surface.name}, {where}\n{name}", fontsize=9)
                place.set_axis_off()
    figure.savefig(path, dpi=100)


def shininess(seen: Seen, scene: radiosity.Scene, path: Path) -> None:
    """Draw figure 8: the spread of facets told by two textures."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 3.9), layout="constrained", facecolor="white")
    woven = scene.materials[0].shininess
    blots = imageio.v3.imread(HERE / "blinn_vase_blots.png")[..., None] / 255.0
    patterns = woven, replace(woven, texture=Texture(blots))
    for place, told in zip(figure.subplots(1, 2), patterns, strict=True):
        material = replace(scene.materials[0], shininess=told)
        c3 = seen.detail(replace(scene, materials=(material,))).roughness(seen.face, seen.points)
        place.imshow(seen.shown(textured(replace(TEXTURED, c3=c3), told.minimum), FRONT_ON))
        place.set_axis_off()
    figure.savefig(path, dpi=100)


def textured(surface: Surface, minimum: float):
    """Return the shading of a surface whose c3 is one for each point.

    The paper scales D3 by (c_min/c3)^2, so that it is 1 at its peak only where c3 is least.
    """
    share = (minimum / surface.c3) ** 2
    return lambda to_light, to_view: np.maximum(to_light[..., 2], 0.0) * (
        surface.p_d + share * surface.facets.value(to_light, to_view)[..., 0]
    )


def main() -> None:
    """Write the three pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=320, help="height of a picture of the vase")
    parser.add_argument("-o", "--output", default=".", help="folder for the pictures")
    args = parser.parse_args()
    folder, scene = Path(args.output), radiosity.load(HERE / "blinn_vase.toml")
    lobes(folder / "blinn_lobes.png")
    seen = Seen(scene, args.size)
    materials(seen, folder / "blinn_materials.png")
    shininess(seen, scene, folder / "blinn_shininess.png")


if __name__ == "__main__":
    main()
