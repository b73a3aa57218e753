"""Whole solutions with abstract light sources: other programs, closed forms, clusters, pictures."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, scene, uv_sphere

import radiosity
from radiosity.light.photometry import luminance
from radiosity.light.sources import Directional, Flood, Point, Spot
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Camera, Scene
from radiosity.solve.clustered import _kinds
from radiosity.solve.plan import make_plan
from radiosity.view.gather import radiance
from radiosity.view.shading import make_shading

SCENES = Path(__file__).resolve().parent.parent / "scenes"
ROOM = box((0, 0, 0), (4, 3, 2.5))
LAMP = Point(np.array([1.5, 1.0, 2.0]), np.array([3.0, 2.0, 1.0]))


def lit(polygons, rho, *lights, **more):
    return replace(scene(polygons, rho, **more), lights=lights)


def columns(path, *names):
    table = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    return np.stack([table[n] for n in names], axis=1)


@pytest.mark.parametrize("accuracy", [0.03, 0.01])
def test_point_and_spot_meet_the_other_program(accuracy):
    """Mitsuba's irradiance at 16 points; two of its standard errors (0.09 % each) are allowed."""
    folder = SCENES / "point_spot_reference"
    points = columns(folder / "points.csv", *"xyz", "nx", "ny", "nz")
    exact = columns(folder / "irradiance.csv", "E_r", "E_g", "E_b")
    rest = 2 * luminance(columns(folder / "irradiance.csv", "se_r", "se_g", "se_b"))
    points, normals = points[:, :3], points[:, 3:]
    scene = radiosity.load(SCENES / "point_spot.toml")
    solution = radiosity.solve(scene, accuracy, goal=(points, normals))
    e, bars = solution.irradiance(points, normals)
    off, y = np.abs(luminance(e - exact)), luminance(exact)
    error = np.maximum(off - rest, 0) / np.maximum(y, 0.1 * solution.estimate.scale)
    assert len(points) == 16 and np.percentile(error, 95) <= accuracy
    assert np.mean(off <= luminance(bars) + rest) >= 0.95


@pytest.mark.parametrize(
    ("lamp", "power"),
    [
        (LAMP, 4 * np.pi),
        (Flood(LAMP.position, LAMP.intensity, axis=np.array([0, 0, -1.0]), exponent=3), np.pi / 2),
        (Spot(LAMP.position, LAMP.intensity, axis=np.array([0.6, 0, -0.8]), beam=0.4, cutoff=0.6),
         2 * np.pi * (1 - (np.sin(0.6) - np.sin(0.4)) / 0.2)),
    ],
    ids=["point", "flood", "spot"],
)  # fmt: skip
def test_power_of_a_closed_room_is_that_of_its_lamp(lamp, power):
    balance = radiosity.solve(lit(ROOM, 0.5, lamp), 0.05).balance
    np.testing.assert_allclose(balance.emitted, power * lamp.intensity, rtol=2e-3)  # beam's edge
    assert balance.defect < 0.01 and not balance.escaped.any()


def test_lamp_next_to_a_surface_gives_no_infinity():
    near, close = (
        Point(np.array([1.5, 1.0, 2.5 - height]), LAMP.intensity) for height in (1e-9, 1e-4)
    )
    solution = radiosity.solve(lit(ROOM, 0.5, near), 0.05)
    assert np.all(np.isfinite(solution.radiosity)) and np.all(np.isfinite(solution.error))
    np.testing.assert_allclose(solution.balance.emitted, 4 * np.pi * LAMP.intensity, rtol=1e-3)
    above = np.array([[1.5, 1.0, 2.5], [1.5, 1.0, 0]])
    e, bars = solution.irradiance(above, np.array([[0, 0, -1.0], [0, 0, 1]]))
    assert np.all(np.isfinite(e)) and np.all(np.isfinite(bars))
    other = radiosity.solve(lit(ROOM, 0.5, close), 0.05).irradiance(above[1:], [[0, 0, 1.0]])[0]
    assert e[0, 0] > 1e17 and e[1, 0] == pytest.approx(other[0, 0], rel=0.01)


@pytest.mark.parametrize("options", [{"order": 0}, {"solver": "gmres"}, {"force": True}])
def test_other_ways_to_solve_agree(options):
    made = lit(ROOM, 0.6, LAMP)
    points = np.array([[2.0, 1.5, 0], [0.0, 1.0, 1.2], [3.0, 2.0, 2.5]])
    normals = np.array([[0, 0, 1.0], [1, 0, 0], [0, 0, -1]])
    one = radiosity.solve(made, 0.02).irradiance(points, normals)[0]
    other = radiosity.solve(made, 0.02, **options).irradiance(points, normals)[0]
    np.testing.assert_allclose(other, one, rtol=0.02)  # the accuracy asked


def test_clusters_agree_with_exact_exchange():
    """A ball of 512 facets in the room is solved by clusters, one of 32 is not."""
    def room(n):
        ball = 0.4 * uv_sphere(n)[:, ::-1] + [2.6, 1.5, 1]
        made = lit(ROOM, 0.5, LAMP)
        kind = np.minimum(np.arange(6 + len(ball)), 5)
        faces = Faces.from_polygons(np.concatenate([ROOM, ball]), kind, 0, merge=False)
        return Scene("ball", faces, made.materials, ("all",), lights=made.lights)

    many, few = room(16), room(4)
    assert make_plan(many, 0.1).clusters and not make_plan(few, 0.03).clusters
    points = np.array([[2.0, 1.5, 0], [0.0, 1.0, 1.2], [3.9, 2.0, 2.5], [3.6, 1.6, 0]])
    normals = np.array([[0, 0, 1.0], [1, 0, 0], [0, 0, -1], [0, 0, 1]])
    one, bars = radiosity.solve(many, 0.1).irradiance(points, normals)
    exact = radiosity.solve(few, 0.03).irradiance(points, normals)[0]
    assert exact[3, 0] < 0.6 * exact[0, 0]  # it lies in the shadow of the ball
    np.testing.assert_allclose(one, exact, rtol=0.1)  # the accuracy asked, and another ball


def test_edge_of_the_sun_refines_the_mesh():
    """Cells that the edge of a patch of sun crosses are smaller than the others of the floor."""
    roof = [[[a, 0, 2.5], [a, 3, 2.5], [b, 3, 2.5], [b, 0, 2.5]] for a, b in ((0, 1), (2, 4))]
    polygons = np.concatenate([ROOM[[0, 2, 3, 4, 5]], np.array(roof, float)])
    sun = Directional(np.array([0.3, 0, -1.0]) / np.hypot(0.3, 1), np.full(3, 20.0))
    patches = radiosity.solve(lit(polygons, 0.5, sun), 0.01).patches
    floor = (patches.face == 0) & patches.front
    x, area = patches.vertices[floor][..., 0], patches.area[floor]
    crossed = np.zeros(len(x), bool)
    for edge in (1.75, 2.75):  # the opening from 1 to 2, moved by 0.3 times the height
        crossed |= (x.min(axis=1) < edge) & (x.max(axis=1) > edge)
    elsewhere = np.average(area[~crossed], weights=area[~crossed])  # where a point is by chance
    assert crossed.any() and np.average(area[crossed], weights=area[crossed]) < 0.4 * elsewhere


def test_picture_of_a_black_floor_and_of_a_grey_one_under_a_lamp():
    """In a black room a pixel has rho/pi I cos/d^2, and the lamp itself is not seen."""
    made = lit(ROOM, np.array([0.5, 0, 0, 0, 0, 0]), LAMP)
    down = Camera("down", LAMP.position + [0, 0, 0.4], LAMP.position - [0, 0, 2.0],
                  np.array([0, 1.0, 0]), 60.0, (9, 9))  # fmt: skip
    pixels = radiosity.render(radiosity.solve(made, 0.05), down).pixels
    np.testing.assert_allclose(pixels[4, 4], 0.5 / np.pi * LAMP.intensity / 4, rtol=0.02)  # a pixel
    away = pixels[4, 0]
    x = 2.4 * np.tan(np.radians(30)) * 8 / 9
    np.testing.assert_allclose(
        away, 0.5 / np.pi * LAMP.intensity * 2 / np.hypot(2, x) ** 3, rtol=0.02
    )


def test_back_of_a_sheet_that_only_a_lamp_reaches_is_modelled():
    """A sheet under a lamp that shines up at it from below, in the open: only its back is lit."""
    up = Spot(np.array([0.5, 0.5, -1.0]), np.ones(3), axis=np.array([0, 0, 1.0]), beam=0.1,
              cutoff=0.1)  # fmt: skip
    solution = radiosity.solve(lit(SQUARE[None], 0.5, up), 0.05)
    assert not solution.radiosity[solution.patches.front].any()
    power = 2 * np.pi * (1 - np.cos(0.1))
    np.testing.assert_allclose(solution.balance.emitted, power, rtol=2e-3)
    np.testing.assert_allclose(solution.balance.absorbed, 0.5 * power, rtol=2e-3)
    np.testing.assert_allclose(solution.balance.escaped, 0.5 * power, rtol=2e-3)


def test_closed_block_around_a_lamp_lets_nothing_out():
    shade = block((1, 1, 1.0), (2, 2, 2.0))
    inside = Point(np.array([1.5, 1.5, 1.5]), np.ones(3))
    solution = radiosity.solve(lit(np.concatenate([ROOM, shade]), 0.5, inside), 0.05)
    room = (solution.patches.face < 6) | solution.patches.front
    assert not solution.radiosity[room].any() and solution.radiosity[~room].all()


def test_bare_walls_cost_no_ray(monkeypatch):
    """In a convex room nothing can come between a lamp and a point."""
    from radiosity.transport.visibility import Visibility

    def cast(*_):
        raise AssertionError("a ray was cast")

    monkeypatch.setattr(Visibility, "blocked", cast)
    solution = radiosity.solve(lit(ROOM, 0.5, LAMP), 0.05)
    assert solution.irradiance([[2.0, 1.5, 0]], [[0, 0, 1.0]])[0][0, 0] > 0


@pytest.mark.parametrize(
    "specular",
    [
        'model = "phong", reflectance = 0.3, exponent = 40',
        'model = "blinn", reflectance = 0.3, exponent = 40',
        'model = "torrance-sparrow", roughness = 0.3, ior = 1.5',
    ],
    ids=["phong", "blinn", "plastic"],
)
@pytest.mark.parametrize("bands", ["rgb", 16])
def test_highlight_has_the_colour_of_its_source_and_the_rest_the_product(tmp_path, specular, bands):
    """What the lobe adds in a black room has the lamp's colour, what it leaves rho times that."""
    scenes = []
    for lobe in (f"specular = {{ {specular} }}\n", ""):
        (tmp_path / "plate.toml").write_text(
            '[[geometry]]\nmaterial = "m"\n'
            "polygons = [[[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]]\n"
            f"[materials.m]\ndiffuse = [0.5, 0.1, 0.3]\n{lobe}"
            '[[lights]]\ntype = "point"\nposition = [-1, 0, 1]\nintensity = [1, 5, 2]\n'
        )
        scenes.append(radiosity.load(tmp_path / "plate.toml", bands=bands))
    lamp, rho = scenes[0].lights[0].intensity, scenes[0].materials[0].diffuse
    bright, dull = (_seen_from_the_mirror_direction(s) for s in scenes)
    np.testing.assert_allclose(dull / dull.sum(), rho * lamp / (rho @ lamp), rtol=1e-12)
    share = dull
    if "ior" in specular:  # what its coat lets in and out, alike in all bands
        share = dull * ((bright[1] - bright[0] * lamp[1] / lamp[0])
                        / (dull[1] - dull[0] * lamp[1] / lamp[0]))  # fmt: skip
    gloss = bright - share
    assert gloss.min() > 0
    np.testing.assert_allclose(gloss / gloss.sum(), lamp / lamp.sum(), rtol=1e-9)  # a difference


def _seen_from_the_mirror_direction(made):
    solution = radiosity.solve(made, 0.1)
    view = np.array([[1.0, 0, 1]]) / np.sqrt(2)
    row, one = np.zeros(1, int), np.zeros((1, 3))
    return radiance(solution, make_shading(solution), row, one, view, row, 0)[0][0]


def test_picture_of_a_lit_room_is_what_its_walls_send():
    """rho E/pi of the irradiance at each point: what lamps send counts once in what rays meet."""
    made = lit(ROOM, 0.7, LAMP)
    solution = radiosity.solve(made, 0.02)
    points = np.array([[2.5, 2.0, 0.0], [0.7, 2.2, 0.0], [3.3, 1.0, 2.5], [2.0, 0.0, 1.0]])
    normals = np.array([[0, 0, 1.0], [0, 0, 1], [0, 0, -1], [0, 1, 0]])
    patches = solution.patches
    away = np.linalg.norm(patches.centroid[:, None] - points, axis=2)
    rows = np.argmin(away + 10.0 * (patches.normal @ normals.T < 0.5), axis=0)
    shading, keys = make_shading(solution), np.arange(4)
    seen = np.mean(
        [radiance(solution, shading, rows, points, normals, keys, k)[0] for k in range(64)], axis=0
    )
    exact = 0.7 / np.pi * solution.irradiance(points, normals)[0]
    np.testing.assert_allclose(seen, exact, rtol=0.02)  # the accuracy asked


def test_clusters_of_sheets_keep_all_light_and_hold_no_walls():
    """A ball of 512 translucent facets about a lamp, in a room of opaque walls as grey."""
    ball = 0.4 * uv_sphere(16) + [2.0, 1.5, 1]
    made = lit(ROOM, 0.5, Point(np.array([2.0, 1.5, 1]), np.ones(3)))
    kind = np.minimum(np.arange(6 + len(ball)), 6)
    faces = Faces.from_polygons(np.concatenate([ROOM, ball]), kind, 0, merge=False)
    milk = replace(made.materials[0], name="milk", translucent=np.full(3, 0.5))
    made = replace(made, faces=faces, materials=(*made.materials, milk))
    assert make_plan(made, 0.1).clusters
    solution = radiosity.solve(made, 0.1)
    balance, rows = solution.balance, np.flatnonzero(solution.live)
    kinds = _kinds(made, solution.patches, rows)
    sheet = made.faces.material[solution.patches.face[rows]] == 6
    assert not set(kinds[sheet]) & set(kinds[~sheet])
    assert balance.defect < 1e-3
    np.testing.assert_allclose(balance.absorbed, 4 * np.pi, rtol=0.01)  # the ball keeps nothing
