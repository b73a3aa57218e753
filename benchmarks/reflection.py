"""Time of one evaluation of every reflection model, and whether Blinn's D3 is the cheapest.

    .venv/bin/python benchmarks/reflection.py > benchmarks/reflection.md

Arrays of 8192 pairs of directions (they fit into the cache), one thread; the best of 40, in turn.
Facet distributions also one by one in compiled code, with all that does not change worked out
before (Blinn's k1 and k2). Shares of Phong's time depend less on the machine than nanoseconds.
"""

import math
import time

import numpy as np
from numba import njit
from tables import begin

from radiosity.light import fresnel
from radiosity.light.blinn import Blinn
from radiosity.light.facets import Beckmann, CosinePower, Gaussian, TrowbridgeReitz
from radiosity.light.frames import polar
from radiosity.light.metals import metal_bands
from radiosity.light.phong import Phong
from radiosity.light.reflection import lambert
from radiosity.light.shadowing import smith, v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow

COUNT, TIMES = 8192, 40
GLASS = np.array([1.5])


def directions():
    rng = np.random.default_rng(0)
    return tuple(polar(rng.random(COUNT), 2 * np.pi * rng.random(COUNT)) for _ in range(2))


def works(light, view):
    """Return what is timed by name: functions without arguments."""
    rgb, cosine = np.array([0.2, 0.5, 0.8]), np.ascontiguousarray(light[:, 2])
    models = {
        "Phong, n = 50": Phong(rgb, 50.0), "Blinn, n = 50": Blinn(rgb, 50.0),
        **{f"Torrance-Sparrow, {k.__name__}, v-groove, F = 1": TorranceSparrow(k(0.3), v_groove)
           for k in (TrowbridgeReitz, Beckmann, Gaussian)},
        "Torrance-Sparrow, TrowbridgeReitz, Smith, F = 1":
            TorranceSparrow(TrowbridgeReitz(0.3), smith),
        "Torrance-Sparrow, Gaussian, Smith, F = 1": TorranceSparrow(Gaussian(0.3), smith),
        "Torrance-Sparrow, TrowbridgeReitz, v-groove, index 1.5":
            TorranceSparrow(TrowbridgeReitz(0.3), v_groove, GLASS),
        "Torrance-Sparrow, TrowbridgeReitz, v-groove, gold":
            TorranceSparrow(TrowbridgeReitz(0.3), v_groove, metal_bands("gold")),
    }  # fmt: skip
    kinds = {"D1 = cos^n": CosinePower(20.0), "D2, Gaussian": Gaussian(0.3),
             "D3, Trowbridge-Reitz": TrowbridgeReitz(0.3), "Beckmann": Beckmann(0.3)}  # fmt: skip
    return {
        "Lambert": lambda: np.broadcast_to(lambert(rgb), (COUNT, 3)).copy(),
        **{name: lambda m=m: m.value(light, view) for name, m in models.items()},
        **{f"facets alone: {name}": lambda f=f: f.relative(cosine) for name, f in kinds.items()},
        "Fresnel, index 1.5, g and c": lambda: fresnel.reflectance(cosine, 1.5),
        "Fresnel, index 1.5, (R_s + R_p)/2": lambda: sum(
            fresnel.polarised_reflectance(cosine, 1.5)) / 2,
        "Fresnel, complex index": lambda: fresnel.reflectance(cosine, 0.16 + 3.5j),
        **{f"compiled: {name}": lambda f=f: f(cosine) for name, f in COMPILED.items()},
    }  # fmt: skip


@njit
def power(cosine):
    total = 0.0
    for c in cosine:
        total += c**20.5
    return total


@njit
def gaussian(cosine):
    total = 0.0
    for c in cosine:
        alpha = math.acos(c)
        total += math.exp(-alpha * alpha * 11.1)
    return total


@njit
def trowbridge_reitz(cosine):
    k1 = 1.0 / (0.09 - 1.0)
    k2 = k1 + 1.0
    total = 0.0
    for c in cosine:
        d = k2 / (c * c + k1)
        total += d * d
    return total


@njit
def beckmann(cosine):
    total = 0.0
    for c in cosine:
        c2 = c * c
        total += math.exp((c2 - 1.0) / (c2 * 0.09)) / (c2 * c2)
    return total


COMPILED = {"D1 = cos^n": power, "D2, Gaussian": gaussian,
            "D3, Trowbridge-Reitz": trowbridge_reitz, "Beckmann": beckmann}  # fmt: skip


def best_times(jobs):
    """Return the least seconds of each job, run in turn so that all meet the same load."""
    seconds = dict.fromkeys(jobs, math.inf)
    for _ in range(TIMES):
        for name, job in jobs.items():
            started = time.perf_counter()
            job()
            seconds[name] = min(seconds[name], time.perf_counter() - started)
    return seconds


def main():
    jobs = works(*directions())
    for job in jobs.values():
        job()  # compile, and make tables
    seconds = best_times(jobs)
    begin(__doc__, "evaluation | ns | of Phong's time")
    for name, s in seconds.items():
        print(f"| {name} | {1e9 * s / COUNT:.3g} | {s / seconds['Phong, n = 50']:.2g} |")


if __name__ == "__main__":
    main()
