"""A virtual gonioreflectometer: f = L_o/E_i of flat samples, with sources and sensors of one's own.

The radiance that a narrow sensor sees leaving a sample over the irradiance that a narrow beam
causes on it depends neither on the size of the source nor on that of the sensor. Scene, solution,
picture and irradiance all come from the public API.
"""

import numpy as np
import pytest

import radiosity
from radiosity.light.coat import coated_diffuse
from radiosity.light.frames import polar
from radiosity.light.phong import Phong
from radiosity.scene.toml import read_toml

SAMPLES = {
    "lambert": "diffuse = [0.2, 0.5, 0.8]",
    "phong": 'specular = { model = "phong", reflectance = [0.2, 0.5, 0.8], exponent = 20 }',
    "dielectric": 'specular = { model = "torrance-sparrow", roughness = 0.3, ior = 1.5 }',
    "rough dielectric": 'specular = { model = "torrance-sparrow", facets = "beckmann", '
    'half_angle = 25, shadowing = "smith", ior = [1.4, 1.5, 1.7] }',
    "copper": 'specular = { model = "torrance-sparrow", facets = "gaussian", half_angle = 15, '
    'metal = "copper" }',
    "varnished": "diffuse = [0.2, 0.5, 0.8]\n"
    'specular = { model = "torrance-sparrow", roughness = 0.3, ior = 1.5 }',
}
FAR = 40.0
BENCH = np.array([[2, 1, -2], [-2, 2, -1], [1, 2, 2]]) / 3.0  # rows: the sample's axes, askew


def measured(sample, light, view, source, sensor):
    """Return L_o/E_i (3,) of a sample 2 x 2 with a square source and a sensor of given sizes."""
    light, view = light @ BENCH, view @ BENCH
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) @ BENCH
    scene = read_toml(f"""
[[geometry]]
material = "sample"
polygons = [{square.tolist()}]
[[geometry]]
material = "lamp"
polygons = [{facing_square(light, source)}]
[materials.sample]
{sample}
[materials.lamp]
diffuse = 0
emission = {{ radiance = [1000, 800, 500] }}
[cameras.sensor]
position = {(FAR * view).tolist()}
target = [0, 0, 0]
up = [0.1, 1, 0.2]
fov = {np.degrees(2 * np.arctan(sensor / 2 / FAR))}
size = [8, 8]
""", "bench.toml", None)  # fmt: skip
    solution = radiosity.solve(scene, 0.2)
    irradiance, _ = solution.irradiance([[0, 0, 0]], BENCH[2:])
    seen = radiosity.render(solution, "sensor", samples=32).pixels
    return seen.mean(axis=(0, 1)) / irradiance[0]


def facing_square(towards, side):
    """Return a square at the distance FAR in a direction, whose front faces the origin."""
    one = np.cross(towards, [0.3, 0.9, 0.1])
    one /= np.linalg.norm(one)
    two = np.cross(towards, one)
    corners = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
    return [(FAR * towards + side / 2 * (a * one + b * two)).tolist() for a, b in corners]


def tilted(degrees, azimuth):
    return polar(np.cos(np.radians(degrees)), np.radians(azimuth))


def expected(sample, light, view):
    """Return f (3,) of what the scene file says, by the models themselves."""
    material = read_toml(
        '[[geometry]]\nmaterial = "m"\npolygons = [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]\n'
        f"[materials.m]\n{sample}\n", "sample.toml", None,
    ).materials[0]  # fmt: skip
    lobe, base = material.specular, material.diffuse
    if lobe is None:
        return base / np.pi
    f = lobe.value(light, view)
    if isinstance(lobe, Phong) or not lobe.dielectric:
        return f + base / np.pi
    into, out = lobe.albedo(light[2]), lobe.albedo(view[2])
    return f + coated_diffuse(base, into, out, lobe.mean_albedo)


GEOMETRIES = [((30, 20), (30, 200)), ((50, 0), (35, 170)), ((20, 90), (60, 300)), ((0, 0), (10, 0))]


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize(("light", "view"), GEOMETRIES)
def test_it_measures_what_was_put_in(name, light, view):
    light, view = tilted(*light), tilted(*view)
    f = expected(SAMPLES[name], light, view)
    found = measured(SAMPLES[name], light, view, 0.5, 0.2)
    assert found == pytest.approx(f, rel=1e-2)  # the source is 0.7 degrees wide


@pytest.mark.parametrize("name", ["lambert", "phong", "dielectric"])
def test_neither_source_nor_sensor_matter(name):
    light, view = tilted(50, 0), tilted(40, 175)
    whole = measured(SAMPLES[name], light, view, 0.5, 0.2)
    assert measured(SAMPLES[name], light, view, 0.25, 0.2) == pytest.approx(whole, rel=1e-2)
    assert measured(SAMPLES[name], light, view, 0.5, 0.1) == pytest.approx(whole, rel=1e-2)
    ray = np.array([light, view])
    assert measured(SAMPLES[name], *ray[::-1], 0.5, 0.2) == pytest.approx(whole, rel=1e-2)
