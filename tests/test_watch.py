"""Watching a solution in the making: pictures of what is found so far."""

import numpy as np
import pytest
from scenes_for_tests import box, scene
from test_clustered import room_with_balls

import radiosity
from radiosity.scene.model import Camera

RHO = np.array([0.2, 0.7, 0.5, 0.3, 0.8, 0.9])[:, None] * [1.0, 0.9, 0.8]  # bands solved apart
ROOM = scene(box((0, 0, 0), (4, 3, 2.5)), RHO, [0, 1.0, 0, 0, 0, 0.3])
EYE = Camera("eye", *np.array([[0.5, 0.4, 1.2], [4, 3, 1], [0, 0, 1]]), 70.0, (16, 12))


def watched(room, **options):
    """Return the final solution and all that were shown before it."""
    seen = []
    return radiosity.solve(room, watch=seen.append, **options), seen


def power(solution):
    return solution.patches.area @ solution.radiosity[:, 0]


def test_jacobi_shows_bounce_by_bounce():
    """B after k reflections, each summed directly: B_k = M_e + rho F B_(k-1)."""
    final, seen = watched(ROOM, accuracy=0.05, mesh="2", order=0, solver="jacobi")
    b, factors = final.emission, final.level.factors
    for shown in seen[:5]:
        b = final.emission + final.reflectance * (factors @ b)
        assert shown.radiosity == pytest.approx(b, rel=1e-12)
        assert shown.irradiance_on == pytest.approx(factors @ b, rel=1e-12)
    assert np.all(np.diff([power(x) for x in seen]) > 0)


@pytest.mark.parametrize("solver", ["jacobi", "gauss-seidel", "southwell"])
@pytest.mark.parametrize("order", [0, 1])
def test_what_is_shown_becomes_the_answer(solver, order):
    final, seen = watched(ROOM, accuracy=0.05, mesh="4", order=order, solver=solver)
    off = [np.abs(x.radiosity - final.radiosity).max() for x in seen]
    assert off[-1] < 1e-3 * final.radiosity.max() < off[0]
    assert len(seen) > 3 and len({id(x.level.coefficients) for x in seen}) == len(seen)


def test_shooting_shows_nearly_all_light_from_the_start():
    """An eighth of the patches have sent their light: the ambient correction stands for the rest.

    Without it two fifths of the power would be missing.
    """
    final, seen = watched(ROOM, accuracy=0.05, mesh="6", order=0, solver="southwell")
    assert power(seen[0]) == pytest.approx(power(final), rel=0.05)
    early, late = (radiosity.render(x, EYE, samples=8).pixels.mean() for x in (seen[0], final))
    assert early == pytest.approx(late, rel=0.05)


def test_errors_are_not_known_before_the_end():
    final, seen = watched(ROOM, accuracy=0.1)
    e, error = seen[-1].irradiance([[1, 1, 0]], [[0, 0, 1]])
    assert np.all(np.isinf(error)) and np.all(np.isinf(seen[-1].error[seen[-1].live]))
    assert e == pytest.approx(final.irradiance([[1, 1, 0]], [[0, 0, 1]])[0], rel=0.01)
    assert np.all(np.isinf(radiosity.to_pyvista(seen[-1]).cell_data["error_lx"]))


def test_each_round_of_refinement_is_shown_on_its_own_mesh():
    final, seen = watched(ROOM, accuracy=0.003, solver="southwell")
    sizes = [len(x.patches) for x in seen]
    assert sizes == sorted(sizes) and len(set(sizes)) > 1 and sizes[-1] == len(final.patches)


def test_clusters_are_shown_too():
    final, seen = watched(room_with_balls(12), accuracy=0.1, solver="southwell")
    assert seen and final.plan.clusters
    assert power(seen[0]) == pytest.approx(power(final), rel=0.1)
    assert power(seen[-1]) == pytest.approx(power(final), rel=1e-3)
