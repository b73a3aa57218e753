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
from radiosity.light.frames import polar
from radiosity.light.seed_forms import SeedForm
from radiosity.light.shadowing import v_groove
from radiosity.light.sources import Directional
from radiosity.light.texture import Texture
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.view.camera import basis

HERE = Path(__file__).resolve().parent
EDGE_ON, FRONT_ON = (0.75, 0.1, -0.9), (-0.35, 0.35, 1.0)  # to the light: right, up, to the eye
SAMPLES = 64  # 8 sight lines a pixel
NIGHT = np.full(3, 1e-9)  # W/(m2 sr), for ambient light that is given is not derived


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


@dataclass(frozen=True)
class Vase:
    """The vase of a scene, to be shaded by itself: lit from far away, without other light."""

    scene: radiosity.Scene
    height: int  # of pictures

    def shown(self, surface: Surface, lobe, to_light, shininess=None) -> np.ndarray:
        """Return (h, w, 3) uint8 of the vase in a surface, lit from a direction.

        With pi W/m2 diffuse light is p_d N.L, so what a lobe is multiplied by is divided by pi.
        """
        (camera,) = self.scene.cameras.values()
        light = np.asarray(to_light) / np.linalg.norm(to_light)
        travel = -light @ (np.array(basis(camera)) * [[1], [1], [-1]])  # right, up, to the eye
        lamp = Directional(travel, np.full(3, np.pi))
        share = np.full(3, surface.p_d)
        material = replace(
            self.scene.materials[0], diffuse=share, absorptance=1.0 - share, specular=lobe,
            shininess=shininess,
        )  # fmt: skip
        size = round(self.height * camera.size[0] / camera.size[1]), self.height
        scene = replace(self.scene, materials=(material,), lights=(lamp,), ambient=NIGHT)
        local = radiosity.render(
            scene, size=size, samples=SAMPLES, method="local", shadows=False
        )  # fmt: skip
        return replace(local, exposure=1.0).shown()


def materials(vase: Vase, path: Path) -> None:
    """Draw figures 7a and 7b: both models, lit from the edge and from the front."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 7.0), layout="constrained", facecolor="white")
    axes = figure.subplots(2, 4)
    for row, surface in zip(axes, (ALUMINIUM, CERAMIC), strict=True):
        for column, (light, where) in enumerate(((EDGE_ON, "edge lit"), (FRONT_ON, "front lit"))):
            models = {"Phong": surface.lobe, "Torrance-Sparrow": surface.facets}
            for k, (name, model) in enumerate(models.items()):
                place = row[2 * column + k]
                place.imshow(vase.shown(surface, scaled(model, 1.0 / np.pi), light))
                place.set_title(f"{surface.name}, {where}\n{name}", fontsize=9)
                place.set_axis_off()
    figure.savefig(path, dpi=100)


def scaled(form: SeedForm, share: float) -> SeedForm:
    """Return a model times a number."""
    return SeedForm(replace(form.model, reflectance=share * form.model.reflectance))


def shininess(vase: Vase, path: Path) -> None:
    """Draw figure 8: the spread of facets told by two textures.

    The paper scales D3 by (c_min/c3)^2, so that it is 1 at its peak only where c3 is least. That is
    the normalised form, with D3/(pi c3^2), times 4 c_min^2 for light of pi W/m2.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 3.9), layout="constrained", facecolor="white")
    woven = vase.scene.materials[0].shininess
    blots = imageio.v3.imread(HERE / "blinn_vase_blots.png")[..., None] / 255.0
    for place, told in zip(
        figure.subplots(1, 2), (woven, replace(woven, texture=Texture(blots))), strict=True
    ):
        place.imshow(vase.shown(TEXTURED, textured(TEXTURED, told.minimum), FRONT_ON, told))
        place.set_axis_off()
    figure.savefig(path, dpi=100)


def textured(surface: Surface, minimum: float) -> TorranceSparrow:
    """Return the model of a surface whose c3 a texture tells."""
    index, share = np.array([surface.n + 0j]), np.full(3, 4.0 * minimum**2 * surface.p_s)
    return TorranceSparrow(TrowbridgeReitz(minimum), v_groove, index, share)


def main() -> None:
    """Write the three pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=320, help="height of a picture of the vase")
    parser.add_argument("-o", "--output", default=".", help="folder for the pictures")
    args = parser.parse_args()
    folder, scene = Path(args.output), radiosity.load(HERE / "blinn_vase.toml")
    lobes(folder / "blinn_lobes.png")
    vase = Vase(scene, args.size)
    materials(vase, folder / "blinn_materials.png")
    shininess(vase, folder / "blinn_shininess.png")


if __name__ == "__main__":
    main()
