"""Irradiance at 10,000 points of the Cornell box's surfaces, 1 % asked: all told, beside Mitsuba 3.

    python benchmarks/points.py > benchmarks/points.md

Of ours the time from the scene in memory to values and error bars, warm: `solve` for the points and
`irradiance`. Mitsuba, where it is installed, traces paths through one surface point each with next
event estimation (E = pi L / rho, so points on the lamp are left out) in its compiled variant; its
time is that of as many samples as bring 95 % of the points below 1 %, from the error of fewer.
"""

import time
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.light.photometry import luminance

SCENES = Path(__file__).resolve().parent.parent / "scenes"
COUNT, ASKED, SAMPLES, DEPTH = 10_000, 0.01, (256, 1024), 64


def points_on(solution):
    """Return COUNT random points on the lit faces but the lamp, their normals and reflectances."""
    rng, patches = np.random.default_rng(0), solution.patches
    area = patches.area * solution.live * (solution.emission.sum(axis=1) == 0)
    rows = rng.choice(len(area), COUNT, p=area / area.sum())
    s, t = rng.random((2, COUNT, 1))
    a, b, c, d = patches.vertices[rows].transpose(1, 0, 2)
    points = (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d
    return points, patches.normal[rows], solution.reflectance[rows]


def ours(scene, points, normals):
    """Return the seconds that the answer takes, and the luminance of the irradiance."""
    for _ in range(2):
        begun = time.perf_counter()
        solution = radiosity.solve(scene, ASKED, goal=(points, normals))
        found, _ = solution.irradiance(points, normals)
        seconds = time.perf_counter() - begun
    return seconds, luminance(found)


def mitsuba_scene(mi, scene):
    """Return Mitsuba's scene of the faces, a mesh for each material."""
    made = {"type": "scene", "integrator": {"type": "path", "max_depth": DEPTH, "rr_depth": 16}}
    for k, material in enumerate(scene.materials):
        faces = scene.faces.vertices[scene.faces.material == k]
        if len(faces) == 0:
            continue
        rgb = {"type": "rgb", "value": [float(x) for x in material.diffuse]}
        props = mi.Properties()
        diffuse = {"type": "diffuse", "reflectance": rgb}
        props["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": diffuse})
        if material.emits:
            light = {"type": "rgb", "value": [float(x) for x in material.emission]}
            props["emitter"] = mi.load_dict({"type": "area", "radiance": light})
        mesh = mi.Mesh(material.name, 4 * len(faces), 2 * len(faces), props=props)
        given = mi.traverse(mesh)
        given["vertex_positions"] = faces.ravel().astype(np.float32)
        corners = np.array([0, 1, 2, 0, 2, 3])
        index = (4 * np.arange(len(faces)))[:, None] + corners
        given["faces"] = index.ravel().astype(np.uint32)
        given.update()
        made[f"mesh{k}"] = mesh
    return mi.load_dict(made)


def theirs(mi, scene, points, normals, rho, samples, seed=0):
    """Return the seconds that so many paths a point take, and the luminance of the irradiance."""
    begun = time.perf_counter()
    lift = 1e-3 * np.ptp(points, axis=0).max()
    many = np.repeat(points + lift * normals, samples, axis=0).astype(np.float32)
    down = np.repeat(-normals, samples, axis=0).astype(np.float32)
    rays = mi.RayDifferential3f(mi.Point3f(many.T), mi.Vector3f(down.T))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, len(many))
    radiance, _, _ = scene.integrator().sample(scene, sampler, rays)
    found = np.array(radiance).T.reshape(len(points), samples, 3).mean(axis=1)
    return time.perf_counter() - begun, luminance(np.pi * found / rho)


def main():
    scene = radiosity.load(SCENES / "cornell_box.toml")
    exact = radiosity.solve(scene, 0.002)
    points, normals, rho = points_on(exact)
    y = luminance(exact.irradiance(points, normals)[0])
    scale = np.maximum(y, 0.1 * exact.estimate.scale)

    def error(found):
        return np.percentile(np.abs(found - y) / scale, 95)

    begin(__doc__, "| samples a point | error, 95 % | s | s for 1 %")
    seconds, found = ours(scene, points, normals)
    print(f"| radiosity | | {error(found):.4f} | {seconds:.1f} | {seconds:.1f} |", flush=True)
    try:
        import mitsuba as mi
    except ImportError:
        return
    mi.set_variant("llvm_ad_rgb")
    room = mitsuba_scene(mi, scene)
    theirs(mi, room, points[:10], normals[:10], rho[:10], 4)  # compiled
    for samples in SAMPLES:
        spent, found = theirs(mi, room, points, normals, rho, samples)
        wrong = error(found)
        needed = spent * (wrong / ASKED) ** 2
        print(
            f"| Mitsuba {mi.__version__} | {samples} | {wrong:.4f} | {spent:.1f} | {needed:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
