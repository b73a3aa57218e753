"""Plots of every reflection model, for docs/light.md: its lobe and its albedo.

.venv/bin/python benchmarks/lobes.py docs/gallery
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from radiosity.light import fresnel
from radiosity.light.blinn import Blinn
from radiosity.light.coat import coated_diffuse, layered
from radiosity.light.facets import Beckmann, Gaussian, TrowbridgeReitz
from radiosity.light.frames import polar
from radiosity.light.metals import metal_bands
from radiosity.light.phong import Phong
from radiosity.light.reflection import lambert
from radiosity.light.seed_forms import SeedForm
from radiosity.light.shadowing import smith, v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow

ONE, GLASS = np.ones(1), np.array([1.5])
INCIDENCES = (0, 30, 70)
DEGREES = np.linspace(-89.9, 89.9, 721)
ANGLES = np.linspace(0, 90, 181)


class Lambert:
    """The Lambertian model in the form of the others, to be drawn."""

    def value(self, to_light, to_view):
        return lambert(np.ones((*np.shape(to_view)[:-1], 1)))

    def albedo(self, cosine):
        return np.ones((*np.shape(cosine), 1))


class Varnished:
    """A white base under a coat."""

    def __init__(self, coat):
        self.coat = coat

    def value(self, to_light, to_view):
        into, out = self.coat.albedo(to_light[..., 2]), self.coat.albedo(to_view[..., 2])
        base = coated_diffuse(1.0, into, out, self.coat.mean_albedo)
        return self.coat.value(to_light, to_view) + base

    def albedo(self, cosine):
        return layered(0.5 * ONE, self.coat.albedo(cosine), True)


def facets(kind, index=None, shadowing=v_groove):
    return TorranceSparrow(kind.of_half_angle(15), shadowing, index, ONE)


MODELS = {
    "lambert": {"Lambert, reflectance 1": Lambert()},
    "phong": {f"Phong, n = {n}": Phong(ONE, n) for n in (5, 50)},
    "blinn": {f"Blinn, n = {n}": Blinn(ONE, n) for n in (20, 200)},
    "torrance_sparrow": {
        "Gaussian, F = 1": facets(Gaussian), "Beckmann, F = 1": facets(Beckmann),
        "Trowbridge-Reitz, F = 1": facets(TrowbridgeReitz),
        "Trowbridge-Reitz, Smith, F = 1": facets(TrowbridgeReitz, None, smith),
    },
    "dielectric": {
        "index 1.5, 15 degrees": facets(TrowbridgeReitz, GLASS),
        "index 1.5, 5 degrees": TorranceSparrow(
            TrowbridgeReitz.of_half_angle(5), v_groove, GLASS, ONE),
    },
    "coated": {
        "coat alone, index 1.5": facets(TrowbridgeReitz, GLASS),
        "base of 1 (lobe), of 0.5 (albedo)": Varnished(facets(TrowbridgeReitz, GLASS)),
    },
    "seed_forms": {
        "Phong, k = 0.5, n = 50": SeedForm(Phong(0.5 * ONE, 50)),
        "Blinn's aluminium": SeedForm(TorranceSparrow(
            TrowbridgeReitz(0.5), v_groove, np.array([200.0]), 0.4 * ONE)),
    },
}  # fmt: skip


def draw(models):
    """Return a figure: f cos(theta_o) against the angle of view, and the albedo."""
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    lobe = figure.add_subplot(1, 2, 1, projection="polar")
    view = polar(np.cos(np.radians(DEGREES)), np.where(DEGREES < 0, np.pi, 0.0))
    for colour, (label, model) in enumerate(models.items()):
        for style, degrees in zip(("-", "--", ":"), INCIDENCES, strict=True):
            light = polar(np.cos(np.radians(degrees)), np.pi)
            f = model.value(np.broadcast_to(light, view.shape), view)[:, 0] * view[:, 2]
            name = label if degrees == 0 else None
            lobe.plot(np.radians(DEGREES), f, style, color=f"C{colour}", label=name, lw=1)
    lobe.set(theta_zero_location="N", theta_direction=-1, thetamin=-90, thetamax=90)
    lobe.set_title("f cos(view), light from 0 (-), 30 (--), 70 (..) degrees left", fontsize=8)
    lobe.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, -0.1), ncols=2)
    albedo = figure.add_subplot(1, 2, 2)
    for label, model in models.items():
        albedo.plot(ANGLES, sent(model), label=label, lw=1)
    albedo.set(xlabel="angle of incidence, degrees", ylabel="albedo", xlim=(0, 90))
    albedo.set_ylim(0, None)
    albedo.grid(True, alpha=0.3)
    return figure


def sent(model):
    """Return the albedo at `ANGLES`; of a seed's form by summing its lobe, up to 3."""
    cosine = np.maximum(np.cos(np.radians(ANGLES)), 0.0)
    if hasattr(model, "albedo"):
        return model.albedo(cosine)[:, 0]
    z, phi = np.meshgrid((np.arange(200) + 0.5) / 200, (np.arange(200) + 0.5) * np.pi / 100)
    leaves = polar(z.ravel(), phi.ravel())
    total = [
        (model.value(polar(c, 0.0), leaves)[:, 0] * leaves[:, 2]).mean() * 2 * np.pi
        for c in np.maximum(cosine, 1e-3)
    ]
    return np.where(np.array(total) > 3, np.nan, total)


def draw_fresnel():
    """Return a figure of R_s, R_p and F of glass and metals against the angle."""
    figure = Figure(figsize=(9, 3.4), layout="constrained")
    glass, metals = figure.subplots(1, 2)
    c = np.maximum(np.cos(np.radians(ANGLES)), 0.0)
    for label, index in (("into glass 1.5", 1.5), ("out of glass", 1 / 1.5)):
        r_s, r_p = fresnel.polarised_reflectance(c, index)
        line = glass.plot(ANGLES, fresnel.reflectance(c, index), label=f"F, {label}")
        for r, style in ((r_s, "--"), (r_p, ":")):
            glass.plot(ANGLES, r, style, color=line[0].get_color(), lw=1)
    glass.set_title("R_s (--), R_p (..) and their mean", fontsize=8)
    for name in ("aluminium", "copper", "gold", "chromium"):
        f = fresnel.reflectance(c[:, None], metal_bands(name))
        for band, colour in enumerate("rgb"):
            metals.plot(ANGLES, f[:, band], color=colour, lw=1)
        metals.annotate(name, (2, f[0, 1] + 0.01), fontsize=7)
    metals.set_title("metals in three bands", fontsize=8)
    for axes in (glass, metals):
        axes.set(xlabel="angle of incidence, degrees", xlim=(0, 90), ylim=(0, 1.02))
        axes.grid(True, alpha=0.3)
    glass.legend(fontsize=7)
    return figure


def main(folder):
    for name, models in MODELS.items():
        draw(models).savefig(folder / f"light_{name}.png", dpi=90)
    draw_fresnel().savefig(folder / "light_fresnel.png", dpi=90)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
