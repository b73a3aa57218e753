"""The mesh of a page: its light is what is gathered, its groups add up, and it has no cracks."""

import base64
import io
from dataclasses import replace
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from scenes_for_tests import TRIANGLE, block, box, material, scene
from test_clustered import room_with_balls

import radiosity
from radiosity.light.coherent import Constant
from radiosity.light.photometry import illuminance
from radiosity.light.sources import Point
from radiosity.light.texture import Texture, srgb_to_linear
from radiosity.mesh.faces import Faces, welded
from radiosity.scene.model import Scene
from radiosity.solve.positive import not_negative
from radiosity.solve.relight import told_apart
from radiosity.solve.solve import solve
from radiosity.view.fine.cells import is_triangle, numbered, points_of, whole_patches
from radiosity.view.fine.finemesh import gathered_mesh
from radiosity.view.fine.looks import looks_of
from radiosity.view.page.contents import page_exposure
from radiosity.view.page.looks import not_shown, picture_of
from radiosity.view.page.packing import Packer, picture_url
from radiosity.view.polydata import shown_patches
from radiosity.view.shading import auto_exposure

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def scattered(solution, mesh, count, values=None):
    """Return random points on a mesh, their normals, and there the mesh's illuminance, lx.

    Or other ``values`` of its vertices (k,).
    """
    values = mesh.lux.sum(axis=1) if values is None else values
    rng = np.random.default_rng(0)
    corner = mesh.points[mesh.triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(across, axis=1)
    lit = solution.live[mesh.patch[mesh.triangles[:, 0]]]
    t = rng.choice(len(area), count, p=lit * area / (lit * area).sum())
    share, vertex = rng.dirichlet(np.ones(3), count), mesh.triangles[t]
    points = np.einsum("kv,kvc->kc", share, mesh.points[vertex])
    there = np.einsum("kv,kv->k", share, values[vertex])
    return points, solution.patches.normal[mesh.patch[vertex[:, 0]]], there


def misses(solution, found, expected):
    """Return errors of illuminances, expected as irradiances, in the norm of the accuracy."""
    expected = illuminance(expected, solution.scene.bands)
    live = solution.live
    mean = np.average(solution.illuminance[live], weights=solution.patches.area[live])
    return np.abs(found - expected) / np.maximum(expected, 0.1 * mean)


@pytest.fixture(scope="module")
def cornell():
    solution = solve(radiosity.load(SCENES / "cornell_box.toml"), 0.2)
    return solution, gathered_mesh(solution, most=9000, with_errors=True)


@pytest.fixture(scope="module")
def two_lamps():
    """A room with a block, and two lamps in groups of their own."""
    room = np.concatenate([box([0, 0, 0], [3, 2, 2]), block([1, 0.7, 0], [1.5, 1.2, 0.6], False)])
    lamps = (
        Point(np.array([0.6, 1.0, 1.7]), np.array([3.0, 2.0, 1.0]), group="left"),
        Point(np.array([2.6, 0.4, 1.2]), np.array([0.5, 1.0, 2.0]), group="right"),
    )
    solution = solve(scene(room, 0.6, lights=lamps), mesh="2")
    return solution, gathered_mesh(solution, most=2500)


def test_light_between_vertices_is_gathered_light(cornell):
    solution, mesh = cornell
    points, normals, lux = scattered(solution, mesh, 400)
    expected = not_negative(solution.level).gathered(points, normals).total
    # A quarter of the 2 % by which light may miss a line; fewer vertices than by default.
    assert np.percentile(misses(solution, lux, expected), 95) < 0.01


def test_error_bars_are_those_of_probe(cornell):
    solution, mesh = cornell
    points, normals, found = scattered(solution, mesh, 300, mesh.error)
    ratio = found / illuminance(solution.irradiance(points, normals)[1])
    assert np.mean((ratio > 0.5) & (ratio < 2.0)) > 0.95
    assert np.mean((ratio > 0.8) & (ratio < 1.25)) > 0.9  # 0.7 with those of whole patches


def test_error_bars_are_not_known_where_not_asked_for(two_lamps):
    assert np.isinf(two_lamps[1].error).all()


def test_coarser_cells_are_worse(cornell):
    solution, _ = cornell
    mesh = gathered_mesh(solution, most=0)
    points, normals, lux = scattered(solution, mesh, 200)
    expected = not_negative(solution.level).gathered(points, normals).total
    assert np.percentile(misses(solution, lux, expected), 95) > 0.02
    assert len(mesh.points) < 3000


def test_elements_send_no_negative_light(cornell):
    level = cornell[0].level
    found, n = not_negative(level), len(level.rows)
    elements, corner = level.senders.elements, level.senders.elements.vertices.reshape(-1, 3)
    owner = np.repeat(np.arange(n), 4)
    before, after = (elements.at(corner, owner, x.coefficients) for x in (level, found))
    top = before.max()
    assert before.min() < -1e-3 * top and after.min() > -1e-12 * top
    assert np.array_equal(found.coefficients[:n], level.coefficients[:n])  # means
    fine = (before.reshape(n, 4, 3) > 0).all(axis=1)
    assert np.mean(fine) > 0.9
    for a in (1, 2):
        some = slice(a * n, (a + 1) * n)
        assert np.array_equal(found.coefficients[some][fine], level.coefficients[some][fine])


def test_groups_of_light_add_up_to_the_whole(two_lamps):
    solution, mesh = two_lamps
    assert mesh.groups == ("left", "right") == solution.groups
    points, normals, _ = scattered(solution, mesh, 40)
    found = told_apart(solution).gathered(points, normals).total.reshape(40, 2, 3)
    for k, one in enumerate(solution.by_groups().values()):
        alone = one.level.gathered(points, normals).total
        assert np.abs(found[:, k] - alone).max() < 1e-12 * alone.max()
    whole = solution.level.gathered(points, normals).total
    assert np.abs(found.sum(axis=1) - whole).max() < 1e-12 * whole.max()
    # at all vertices: both lamps by themselves, up to the lines between points
    at = np.random.default_rng(1).choice(len(mesh.points), 200)
    inward = solution.patches.centroid[mesh.patch[at]] - mesh.points[at]
    where = mesh.points[at] + 1e-3 * inward, solution.patches.normal[mesh.patch[at]]
    for k, one in enumerate(solution.by_groups().values()):
        expected = one.level.gathered(*where).total
        assert np.median(misses(one, mesh.lux[at, k], expected)) < 1e-3


def test_many_small_patches_are_told_apart_too():
    """Of clusters of patches, whose light is gathered by rays."""
    lamps = (Point(np.array([0.5, 0.5, 2.0]), np.full(3, 3.0)),)
    solution = solve(replace(room_with_balls(12), lights=lamps), 0.2)
    assert len(solution.groups) == 2 and solution.plan.clusters
    rows = np.flatnonzero(solution.live)[::200]
    where = solution.patches.centroid[rows], solution.patches.normal[rows]
    found = told_apart(solution).gathered(*where).total.reshape(len(rows), 2, -1)
    whole = solution.level.gathered(*where).total
    # Of rays that look around, negative sums of slopes are cut off in each.
    assert np.abs(found.sum(axis=1) - whole).max() < 1e-3 * whole.max()
    assert found.any(axis=(0, 2)).all()


def test_reflected_light_is_what_patches_reflect(two_lamps):
    solution, mesh = two_lamps
    corner = mesh.points[mesh.triangles]
    area = 0.5 * np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    owner = mesh.patch[mesh.triangles[:, 0]]
    whole = np.bincount(owner, area, len(solution.patches))
    shown = shown_patches(solution)
    # Triangles cover each patch once.
    assert whole[shown] == pytest.approx(solution.patches.area[shown], rel=1e-9)
    mean = mesh.reflected.sum(axis=1)[mesh.triangles].mean(axis=1)
    power = np.stack([np.bincount(owner, area * mean[:, b]) for b in range(3)], axis=1).sum(axis=0)
    area = solution.patches.area
    expected = (area[:, None] * (solution.radiosity - solution.emission)).sum(axis=0)
    assert power == pytest.approx(expected, rel=0.02)  # elements have other means than points


def test_light_that_comes_through_a_sheet_is_shown():
    """A sheet that lets all light through and reflects none, in a furnace of E = 1."""
    sheet = np.array([[[0.3, 0.3, 0.5], [0.7, 0.3, 0.5], [0.7, 0.7, 0.5], [0.3, 0.7, 0.5]]])
    polygons = np.concatenate([box([0, 0, 0], [1, 1, 1]), sheet])
    walls = replace(material(0.5, 0.5), name="wall")
    paper = replace(material(0.0, name="paper"), translucent=np.ones(3))
    faces = Faces.from_polygons(polygons, [0] * 6 + [1], 0, merge=False)
    solution = solve(Scene("furnace", faces, (walls, paper), ("all",)), mesh="1")
    mesh = gathered_mesh(solution)
    on_sheet = solution.scene.faces.material[solution.patches.face[mesh.patch]] == 1
    assert on_sheet.sum() > 16
    assert mesh.reflected[on_sheet].sum(axis=1) == pytest.approx(1.0, rel=2e-3)


def inner_points(points, triangles):
    """Return how many vertices lie inside of an edge of a triangle, edge by edge."""
    count = 0
    for a, b in {tuple(sorted(e)) for t in triangles for e in zip(t, np.roll(t, -1), strict=True)}:
        span, r = points[b] - points[a], points - points[a]
        along = r @ span / (span @ span)
        off = np.linalg.norm(r - along[:, None] * span, axis=1)
        count += np.sum((off < 1e-9) & (along > 1e-6) & (along < 1 - 1e-6))
    return count


def test_no_vertex_lies_on_an_edge(two_lamps):
    """Also of a block on the floor and of cells that are halved where their neighbours are not."""
    _, mesh = two_lamps
    place, number = np.unique(mesh.points, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[mesh.triangles]
    assert len(place) == welded(mesh.points).max() + 1  # what touches has the same coordinates
    assert inner_points(place, triangles) == 0


def test_triangles_face_the_side_that_is_shown(cornell):
    solution, mesh = cornell
    corner = mesh.points[mesh.triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    own = solution.patches.normal[mesh.patch[mesh.triangles[:, 0]]]
    assert np.einsum("tc,tc->t", across, own).min() > 0.999


def test_cells_of_triangles_and_quadrilaterals_cover_them():
    solution = solve(scene(np.concatenate([box([0, 0, 0], [3, 3, 3]), [TRIANGLE]]), 0.5, 1.0),
                     mesh="1")  # fmt: skip
    patches = solution.patches
    shown = shown_patches(solution)
    cells = whole_patches(patches, shown)
    for _ in range(2):
        cells = cells.quartered()
    area = np.bincount(cells.patch, cells.areas(patches), len(patches))
    assert area[shown] == pytest.approx(patches.area[shown])
    assert cells.is_triangle.any() and not cells.is_triangle.all()
    # Every edge but those of the outline, four a side, has a cell on either side.
    corner = numbered(cells.patch[:, None], cells.corners)
    edges = set(zip(corner.ravel(), np.roll(corner, -1, axis=1).ravel(), strict=True))
    outline = {(a, b) for a, b in edges if a != b and (b, a) not in edges}
    assert len(outline) == 4 * np.sum(np.where(is_triangle(patches)[shown], 3, 4))


def test_points_on_edges_look_from_just_inside(two_lamps):
    solution, _ = two_lamps
    patches = solution.patches
    cell = whole_patches(patches, np.array([0]))
    points, looked = points_of(patches, numbered(np.zeros(9, int), cell.samples()[0]))
    moved = np.linalg.norm(points - looked, axis=1)
    assert np.all(moved[:8] > 0) and moved[8] == 0
    assert points[:8:2] == pytest.approx(patches.vertices[0])


def test_mirrors_are_shown_matte_and_glass_clear():
    mirror = replace(material(0.0, name="mirror"), mirror=Constant(np.full(3, 0.9)))
    pane = replace(material(0.0, name="pane"), mirror=Constant(np.full(3, 0.1)),
                   transmit=Constant(np.full(3, 0.6)))  # fmt: skip
    faces = Faces.from_polygons(box([0, 0, 0], [1, 1, 1])[:2], [0, 1], 0, merge=False)
    made = Scene("two", faces, (mirror, pane), ("all",))
    looks = looks_of(made)
    assert looks.reflects[0].tolist() == [[0.9] * 3, [0.1] * 3]
    assert looks.opacity.tolist() == pytest.approx([1.0, 0.4])
    told = not_shown(made)
    assert "mirror images (mirror, pane)" in told and "what clear bodies bend (pane)" in told
    assert told.startswith("What shines or is clear is shown matte")
    assert not_shown(replace(made, materials=(material(0.5),) * 2)).startswith("Nothing is left")


def test_textures_are_shown_relative_to_their_mean():
    texels = np.random.default_rng(0).uniform(0.1, 0.9, (4, 5, 3))
    wall = replace(material(0.5), texture=Texture(texels, repeat=False))
    found, repeats = picture_of(wall)
    assert found.mean(axis=(0, 1)) == pytest.approx(np.ones(3)) and not repeats
    url, white = picture_url(found)
    head, data = url.split(",")
    assert head == "data:image/png;base64"
    shown = srgb_to_linear(iio.imread(io.BytesIO(base64.b64decode(data))) / 255.0)
    assert white * shown == pytest.approx(found, abs=0.01 * white)


def test_packed_numbers_keep_eleven_digits():
    packer, values = Packer(), np.random.default_rng(0).lognormal(0, 3, (2, 100))
    packer.halves("light", values)
    kept = np.frombuffer(packer._parts[0], np.uint8).reshape(2, -1).T.copy().view("<f2")
    scale = np.array(packer.entries["light"]["scale"])[:, None]
    assert kept.reshape(2, 100) * scale == pytest.approx(values, rel=2**-11)


def test_shiny_surfaces_shown_matte_are_not_all_white():
    """The exposure of pictures knows diffuse light alone; a mirror that is shown matte has more."""
    walls = box([0, 0, 0], [1, 1, 1])
    grey = replace(material(0.2, name="grey"), mirror=Constant(np.full(3, 0.6)))
    faces = Faces.from_polygons(walls, [0] * 5 + [1], 0, merge=False)
    made = Scene("shiny", faces, (grey, material(0.0, 1.0, name="lamp")), ("all",))
    solution = solve(made, 0.3, mesh="2")
    expected = auto_exposure(solution) * 0.2 / 0.8
    assert page_exposure(solution) == pytest.approx(expected, rel=1e-4)  # the solver's tolerance
    plain = solve(replace(made, materials=(material(0.2), made.materials[1])), 0.3, mesh="2")
    assert page_exposure(plain) == auto_exposure(plain)
