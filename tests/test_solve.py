"""Whole scenes against closed forms, and what must not change the answer."""

import numpy as np
import pytest
from scenes_for_tests import (
    SQUARE,
    block,
    box,
    l_room,
    mean_of,
    rotation,
    scene,
    tetrahedron,
    uv_sphere,
)

from radiosity.analytic import box_radiosity, furnace, load_cases, sphere_cavity
from radiosity.scene.model import SceneError
from radiosity.solve.methods import SOLVERS
from radiosity.solve.solve import solve

CASES = {c["id"]: c for c in load_cases("radiosity")}
RHO = [0.2, 0.7, 0.5, 0.3, 0.6, 0.4]
LAMP = [0, 1.0, 0, 0, 0, 0.3]
ROOM = box((0, 0, 0), (4, 3, 2.5))


def face_means(solution):
    return np.array(
        [
            mean_of(solution.radiosity[:, 0], solution.patches, f)
            for f in range(len(solution.scene.faces))
        ]
    )


# ---------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("name", [n for n in CASES if n.startswith("box6")])
def test_a_box_of_six_patches(name):
    g = CASES[name]["geometry"]
    room = scene(list(g["faces"].values()), g["reflectance"], g["emission"])
    found = face_means(solve(room, 0.01, mesh="1"))
    # 1e-6: factors to 1e-8, the solver to 1e-7 of the largest B; reached 3e-8
    assert found == pytest.approx(CASES[name]["value"], abs=1e-6 * max(CASES[name]["value"]))


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("rho", [0.5, 0.9])
@pytest.mark.parametrize("mesh", ["1", "4"])
def test_a_furnace(solver, rho, mesh):
    solution = solve(scene(ROOM, rho, 1.0), 0.01, mesh=mesh, solver=solver)
    expected = furnace(1.0, rho)
    # 1e-6: rows sum to 1 within 5e-9, times 1/(1 - rho); the solver to 1e-7; reached 1e-7
    assert solution.radiosity == pytest.approx(np.full((len(solution.live), 3), expected), rel=1e-6)
    assert solution.irradiance_on == pytest.approx(solution.radiosity, rel=1e-6)
    assert solution.closed and solution.solver == solver


def test_a_furnace_that_is_not_convex():
    """The L-room: rows sum to 1 only as well as 64 rays a pair see around the corner."""
    solution = solve(scene(l_room(), 0.5, 1.0), 0.009, mesh="4")
    assert solution.radiosity == pytest.approx(np.full((160, 3), 2.0), rel=0.02)
    mean = np.average(solution.radiosity[:, 0], weights=solution.patches.area)
    assert mean == pytest.approx(2.0, rel=1e-3)


def test_a_tetrahedron_with_one_emitter():
    case = CASES["tetra_one_emitter"]
    solution = solve(scene(tetrahedron(), case["geometry"]["rho"], [1, 0, 0, 0]), 0.01, mesh="1")
    emitter, other = case["value"]
    # 1e-6: as for boxes; reached 2e-8
    assert face_means(solution) == pytest.approx([emitter, other, other, other], rel=1e-6)


@pytest.mark.parametrize("name", [n for n in CASES if n.startswith("cube_full")])
def test_constant_elements_of_a_cube(name):
    """Exact values of constant elements on 8 x 8 patches a face, to 12 digits."""
    g = CASES[name]["geometry"]
    room = scene(list(g["faces"].values()), g["reflectance"], g["emission"])
    found = face_means(solve(room, 0.001, mesh="8"))
    # 1e-7: factors to 1e-8, the solver to 1e-8; reached 2e-9
    assert found == pytest.approx(g["constant_element_values"]["n=8"], abs=1e-7)


def test_constant_elements_converge_to_the_cube():
    """Orders of 1.3 to 2 were found by those who tabulated it: edge singularities."""
    g = CASES["cube_full_nonuniform_0.5_0.5_0.5"]["geometry"]
    limit = np.array(CASES["cube_full_nonuniform_0.5_0.5_0.5"]["value"])
    room = scene(list(g["faces"].values()), g["reflectance"], g["emission"])
    errors = [np.abs(face_means(solve(room, 0.01, mesh=str(n))) - limit).max() for n in (2, 4, 8)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 6e-4  # the tabulated n = 8 is off by 5.2e-4
    assert np.all((orders > 1.0) & (orders < 2.2))


@pytest.mark.parametrize("name", [n for n in CASES if n.startswith("parallel_unit_squares")])
def test_parallel_squares_in_black_surroundings(name):
    """Area means of the full integral equation; constant elements of size h are of order h^2."""
    g, value = CASES[name]["geometry"], CASES[name]["value"]
    polygons = np.array([g["A1"], g["A2"]], float)
    errors = []
    for n in (3, 6, 12):
        solution = solve(scene(polygons, g["rho"], g["emission"]), 0.01, mesh=str(n))
        errors.append(np.abs(face_means(solution) - value[:2]).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 4e-4  # reached 3e-4 at a gap of half the side
    assert orders[-1] == pytest.approx(2, abs=0.3)  # smooth kernels: no shared edges
    assert not solution.closed


def sphere_errors(n):
    polygons = uv_sphere(n)
    upper = polygons[:, :, 2].mean(axis=1) > 0
    rho, emitted = np.where(upper, 0.5, 0.8), np.where(upper, 1.0, 0.0)
    solution = solve(scene(polygons, rho, emitted), 0.001, mesh="1")
    exact, arriving = sphere_cavity([0.5, 0.5], [1, 0], [0.5, 0.8])
    area, b = solution.patches.area, solution.radiosity[:, 0]
    parts = [np.average(b[k], weights=area[k]) for k in (upper, ~upper)]
    spread = np.sqrt(np.average((solution.irradiance_on[:, 0] / arriving - 1) ** 2, weights=area))
    return np.abs(np.array(parts) / exact - 1).max(), spread


def test_a_spherical_cavity_converges_with_its_tessellation():
    """Facets of angle d see less of the near sphere and more of the far, by d^2: order 2."""
    means, spreads = np.array([sphere_errors(n) for n in (4, 8, 16)]).T
    assert means[-1] < 6e-4 and spreads[-1] < 5e-4  # reached 4.6e-4 and 3.7e-4 with 512 facets
    assert np.log2(means[:-1] / means[1:]) == pytest.approx(2, abs=0.3)


# ---------------------------------------------------------------------- ambient light


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.9])
def test_a_convex_body_under_a_uniform_sky(rho):
    """Each face sees nothing but sky: E = pi L, and no multiple reflection."""
    sky = np.array([1.0, 2.0, 0.5])
    solution = solve(scene(block((0, 0, 0), (1, 2, 3)), rho, ambient=sky), 0.02, mesh="3")
    lit = solution.live
    assert solution.patches.front[lit].all() and lit.sum() == 54 and not solution.closed
    # 1e-12: all 256 rays of every patch leave
    assert solution.irradiance_on[lit] == pytest.approx(np.tile(np.pi * sky, (54, 1)), rel=1e-12)
    assert solution.radiosity[lit] == pytest.approx(np.tile(rho * np.pi * sky, (54, 1)), rel=1e-12)
    assert solution.balance.defect < 1e-12


@pytest.mark.parametrize("rho", [1.0, 0.7, [0.1, 0.9, 0.5, 0.3, 0.8] + [0.6] * 5])
def test_equilibrium_with_the_sky(rho):
    """Walls of an open box that emit (1 - rho) pi L, as bodies at the sky's temperature do.

    B = E = pi L everywhere, whatever stands in the box (Kirchhoff).
    """
    polygons = np.concatenate(
        [box((0, 0, 0), (1, 1, 1))[[0, 2, 3, 4, 5]], block((0.3, 0.3, 0), (0.6, 0.7, 0.5), False)]
    )
    sky = 1.0
    emitted = (1 - np.asarray(rho)) * np.pi * sky
    solution = solve(scene(polygons, rho, emitted, ambient=np.full(3, sky)), 0.009, mesh="4")
    patches = solution.patches
    foot = np.all(np.abs(patches.centroid[:, :2] - [0.45, 0.5]) < [0.15, 0.2], axis=1)
    foot &= (patches.face == 0) & patches.front
    assert foot.any() and np.all(solution.live[foot] == np.any(emitted > 0))  # no sky gets there
    inside = solution.live & patches.front & ~foot
    found = solution.radiosity[inside] / np.pi
    # 256 rays for the open share of a patch, 64 for a pair; reached .6 % rms, 2 % at most
    assert np.sqrt(np.mean((found - 1) ** 2)) < 0.012 and np.abs(found - 1).max() < 0.04
    mean = np.average(found[:, 0], weights=patches.area[inside])
    assert mean == pytest.approx(1.0, abs=2e-3)  # reached 2e-4


# ---------------------------------------------------------------------- balance and limits


@pytest.mark.parametrize("unit_m", [1.0, 1e-3])
def test_power_balances_in_a_closed_room(unit_m):
    solution = solve(scene(ROOM, RHO, LAMP, unit_m=unit_m), 0.01, mesh="3")
    balance = solution.balance
    assert balance.emitted == pytest.approx(unit_m**2 * (12 * 1.0 + 10 * 0.3), rel=1e-12)
    assert np.all(balance.escaped == 0)
    assert balance.defect < 1e-6  # row sums to 5e-9, solver to 1e-7


def test_power_balances_in_an_open_room():
    solution = solve(scene(ROOM[[0, 2, 3, 4, 5]], 0.5, [1.0, 0, 0, 0, 0]), 0.01, mesh="6")
    balance = solution.balance
    assert np.all(balance.escaped > 0.2 * balance.emitted)
    assert balance.defect < 5e-3  # the open shares are measured by 256 rays a patch


def test_black_walls_only_receive():
    solution = solve(scene(ROOM, 0.0, LAMP), 0.01, mesh="2")
    assert np.array_equal(solution.radiosity, solution.emission)
    found = mean_of(solution.irradiance_on[:, 0], solution.patches, 0)
    exact = box_radiosity((4, 3, 2.5), [1, 0, 0, 0, 0, 0], LAMP)[0]  # a white floor sends E back
    assert found == pytest.approx(exact, rel=1e-6)  # factors to 1e-8


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_scene_that_emits_nothing_is_dark(solver):
    solution = solve(scene(ROOM, 0.5, 0.0), 0.02, mesh="2", solver=solver)
    assert np.all(solution.radiosity == 0) and np.all(solution.irradiance_on == 0)
    assert not solution.live.any() and solution.balance.defect == 0
    found, error = solution.irradiance([[2, 1, 0]], [[0, 0, 1]])
    assert np.all(found == 0) and np.all(error == 0)


def test_a_closed_room_that_absorbs_nothing_is_refused():
    with pytest.raises(SceneError, match="every lit surface has reflectance 1 in a closed scene"):
        solve(scene(ROOM, 1.0, LAMP), 0.02, mesh="1")
    with pytest.raises(SceneError, match="let something absorb"):
        solve(scene(ROOM, np.array([[0.5, 1.0, 0.5]] * 6), LAMP), 0.02, mesh="1")  # one band


def test_an_open_room_may_reflect_all():
    solution = solve(scene(ROOM[[0, 2, 3, 4, 5]], 1.0, [1.0, 0, 0, 0, 0]), 0.02, mesh="3")
    assert np.isfinite(solution.radiosity).all()
    assert solution.balance.escaped == pytest.approx(solution.balance.emitted, rel=0.02)


def test_one_absorber_is_enough():
    rho = np.array([1.0, 1, 1, 1, 1, 0.5])
    solution = solve(scene(ROOM, rho, LAMP), 0.01, mesh="2")
    absorbed = 0.5 * mean_of(solution.irradiance_on[:, 0], solution.patches, 5) * 10
    assert absorbed == pytest.approx(15.0, rel=1e-6)  # all that is emitted ends there


def test_a_closed_part_that_absorbs_nothing_is_refused():
    """Two rooms that do not see each other: one has a way out for its light, one has none."""
    rooms = np.concatenate([box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (3, 1, 1))])
    rho, exitance = np.repeat([1.0, 0.5], 6), np.zeros(12)
    exitance[[1, 7]] = 1.0
    with pytest.raises(SceneError, match="closed part"):
        solve(scene(rooms, rho, exitance), 0.1, mesh="1")


def test_nearly_white_rooms_are_solved_directly():
    solution = solve(scene(ROOM, 0.9999, 1.0), 0.01, mesh="2")
    assert solution.solver == "direct"
    # 5e-5: row sums to 5e-9, times 1/(1 - rho) = 1e4
    assert solution.radiosity == pytest.approx(np.full((24, 3), 1e4), rel=1e-4)


def test_unknown_solvers_are_refused():
    with pytest.raises(ValueError, match="solver = 'magic' must be one of gauss-seidel, jacobi"):
        solve(scene(ROOM, 0.5, 1.0), solver="magic")


# ---------------------------------------------------------------------- invariances


def solved(polygons, mesh="3", **more):
    rho, lamp = [*RHO, *[0.5] * (len(polygons) - 6)], [*LAMP, *[0.0] * (len(polygons) - 6)]
    return solve(scene(polygons, rho, lamp, **more), 0.02, mesh=mesh)


FURNISHED = np.concatenate([ROOM, block((1, 1, 0), (2, 2, 1)), [SQUARE + [2.5, 1.5, 1.5]]])


@pytest.mark.parametrize("size, unit_m", [(1e3, 1e-3), (1.0, 1.0), (1e9, 1e-9), (1e-9, 1.0)])
@pytest.mark.parametrize("polygons", [ROOM, FURNISHED], ids=["empty", "furnished"])
def test_the_unit_of_length_changes_nothing(polygons, size, unit_m):
    one, other = solved(polygons), solved(size * polygons, unit_m=unit_m)
    # 1e-3 furnished: single-precision rays that graze edges may flip; reached 2e-5
    tolerance = 1e-9 if len(polygons) == 6 else 1e-3  # rounding of contour integrals: 2e-11
    assert other.radiosity == pytest.approx(one.radiosity, rel=tolerance, abs=1e-6 * tolerance)
    power = one.balance.emitted * (size * unit_m) ** 2
    assert other.balance.emitted == pytest.approx(power, rel=1e-12)


@pytest.mark.parametrize("polygons", [ROOM, FURNISHED], ids=["empty", "furnished"])
def test_turning_the_scene_changes_nothing(polygons):
    rng = np.random.default_rng(0)
    one = solved(polygons)
    for _ in range(2):
        other = solved(polygons @ rotation(rng).T + rng.normal(size=3))
        tolerance = 1e-9 if len(polygons) == 6 else 1e-2  # furnished: rays near edges flip
        assert other.radiosity == pytest.approx(one.radiosity, rel=tolerance, abs=tolerance / 10)


def test_the_order_of_faces_changes_nothing():
    order = np.random.default_rng(1).permutation(6)
    one = solve(scene(ROOM, RHO, LAMP), 0.001, mesh="3")
    other = solve(scene(ROOM[order], np.array(RHO)[order], np.array(LAMP)[order]), 0.001, mesh="3")
    # 1e-7: Gauss-Seidel sweeps in another order, to 1e-8; factors p-q or q-p to 1e-8
    assert face_means(other) == pytest.approx(face_means(one)[order], rel=1e-7)


def test_light_superposes():
    one = solve(scene(ROOM, RHO, [1, 0, 0, 0, 0, 0]), 0.001, mesh="2").radiosity
    two = solve(scene(ROOM, RHO, [0, 0, 2, 0, 0, 0]), 0.001, mesh="2").radiosity
    both = solve(scene(ROOM, RHO, [1, 0, 2, 0, 0, 0]), 0.001, mesh="2").radiosity
    assert both == pytest.approx(one + two, rel=1e-6)  # the solver, to 1e-8 of the largest


def test_reciprocity_of_whole_solutions():
    """Light from i absorbed at j = light from j absorbed at i, each for its own emittance."""
    rho = np.array(RHO)
    area = np.array([12, 12, 7.5, 7.5, 10, 10])
    gathered = []
    for i, j in ((0, 3), (3, 0)):
        solution = solve(scene(ROOM, rho, (1 - rho) * (np.arange(6) == i)), 0.001, mesh="3")
        e = mean_of(solution.irradiance_on[:, 0], solution.patches, j)
        gathered.append(area[j] * (1 - rho[j]) * e)
    assert gathered[0] == pytest.approx(gathered[1], rel=1e-6)  # symmetric by construction


def test_bands_do_not_mix():
    rho = np.random.default_rng(2).uniform(0.1, 0.9, (6, 3))
    lamp = np.array(LAMP)[:, None] * [1.0, 2.0, 0.0]
    solution = solve(scene(ROOM, rho, lamp), 0.001, mesh="1")
    for band in range(3):
        exact = box_radiosity((4, 3, 2.5), rho[:, band], lamp[:, band])
        found = [mean_of(solution.radiosity[:, band], solution.patches, f) for f in range(6)]
        assert found == pytest.approx(exact, rel=1e-6, abs=1e-12)  # factors to 1e-8


@pytest.mark.parametrize("polygons", [ROOM, FURNISHED], ids=["empty", "furnished"])
def test_the_number_of_threads_changes_no_bit(polygons, monkeypatch):
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    one = solved(polygons).radiosity
    monkeypatch.setenv("RADIOSITY_THREADS", "3")
    assert np.array_equal(one, solved(polygons).radiosity)


def test_backs_emit_nothing():
    """A lamp that looks up in a black room: its back and the floor under it stay dark."""
    polygons = np.concatenate([ROOM, [SQUARE + [1.5, 1, 0.5]]])
    solution = solve(scene(polygons, 0.0, [0, 0, 0, 0, 0, 0, 1.0]), 0.02, mesh="3")
    back, floor = ~solution.patches.front, solution.patches.face == 0
    assert back.sum() == 9 and np.all(solution.radiosity[back] == 0)
    assert np.all(solution.irradiance_on[floor] == 0)
    assert mean_of(solution.irradiance_on[:, 0], solution.patches, 1) > 0.01


def test_one_sided_sheets_have_black_backs():
    sheet = SQUARE + [1.5, 1, 1.2]
    polygons = np.concatenate([ROOM, sheet[None]])
    for two_sided in (True, False):
        solution = solve(scene(polygons, 0.5, [0, 1, 0, 0, 0, 0, 0], two_sided), 0.02, mesh="2")
        back = ~solution.patches.front
        assert back.sum() == 4 and solution.live[back].all()
        expected = 0.5 * two_sided * solution.irradiance_on[back]
        assert solution.radiosity[back] == pytest.approx(expected, rel=1e-6)
        assert np.all(solution.irradiance_on[back] > 0)


def test_a_room_that_is_inside_out_is_lit_as_it_should():
    """Walls, ceiling and floor wound the other way round a lamp in the ceiling's plane."""
    lamp = np.array([[1, 1, 2.5], [1, 2, 2.5], [2, 2, 2.5], [2, 1, 2.5]], float)
    walls, rho, exitance = box((0, 0, 0), (4, 3, 2.5)), [0.5] * 6 + [0.2], [0.0] * 6 + [10.0]
    right = solve(scene(np.concatenate([walls, lamp[None]]), rho, exitance), 0.1)
    turned = solve(scene(np.concatenate([walls[:, ::-1], lamp[None]]), rho, exitance), 0.1)
    points, normals = [[1, 1, 0], [4, 1.5, 1], [3, 2, 2.5]], [[0, 0, 1], [-1, 0, 0], [0, 0, -1]]
    expected, _ = right.irradiance(points, normals)
    found, _ = turned.irradiance(points, normals)
    assert found == pytest.approx(expected, rel=0.02)  # another mesh, of the accuracy .1
    assert turned.balance.emitted == pytest.approx(right.balance.emitted, rel=1e-12)
    assert turned.balance.absorbed == pytest.approx(turned.balance.emitted, rel=0.01)


def test_a_small_far_lamp_lights_every_patch_it_sees():
    """A lamp that no ray from a middle meets: E at the target is L A cos cos'/d^2, pi L = 1."""
    lamp = 0.1 * (SQUARE[::-1] - [0.5, 0.5, 0]) + [0, 0, 5]
    target = 0.1 * (SQUARE - [0.5, 0.5, 0])
    solution = solve(scene(np.array([lamp, target]), 0.5, [1.0, 0]), 0.1)
    assert solution.live.all()
    mean = mean_of(solution.irradiance_on[:, 0], solution.patches, 1)
    assert mean == pytest.approx(0.01 / (np.pi * 25), rel=1e-3)  # (side/distance)^2 = 4e-4


def test_a_shining_box_below_the_ceiling_is_covered_where_it_touches():
    polygons = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 2.8), (2, 2, 3.0))])
    solution = solve(scene(polygons, 0.5, [0.0] * 6 + [1.0] * 6), 0.2)
    assert solution.closed
    assert solution.balance.emitted == pytest.approx(1 + 4 * 0.2, rel=1e-9)  # not its top
