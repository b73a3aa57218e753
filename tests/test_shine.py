"""Direct light on the fine grid: closed form, and no darkness borrowed from under a block."""

import numpy as np
from scenes_for_tests import block, box, scene

from radiosity.analytic import point_to_parallel_rectangle
from radiosity.mesh.patches import centroids
from radiosity.solve.plan import make_plan
from radiosity.solve.reach import find_reach
from radiosity.solve.system import lights_of
from radiosity.transport.irradiance import FINER
from radiosity.transport.lookup import margin_in
from radiosity.transport.shine import _leave_the_dark, shine


def shone_on(model, mesh):
    reach = find_reach(model, make_plan(model, 0.1, mesh).division, 0)
    lights = lights_of(model)
    irradiance, face = shine(
        model.faces, reach.patches, reach.live, reach.visibility, reach.table, lights, 0
    )
    return reach, irradiance, face


def test_empty_room_meets_the_closed_form():
    """Under a ceiling that shines all over, E on the floor is a sum of four B-3 factors."""
    exitance = np.zeros(6)
    exitance[1] = 7.0
    model = scene(box((0, 0, 0), (2, 1, 1)), 0.5, exitance)
    reach, irradiance, face = shone_on(model, "2")
    cells = reach.patches.grid.division.divided(FINER).cells(model.faces)
    x, y, _ = centroids(cells)[face == 0].T
    exact = 7 * sum(point_to_parallel_rectangle(a, b, 1.0) for a in (x, 2 - x) for b in (y, 1 - y))
    np.testing.assert_allclose(irradiance[0, face == 0, 0], exact, rtol=1e-12)
    assert not irradiance[1].any()  # no back is modelled


def room_with_a_block():
    stood = block((0.31, 0.33, 0), (0.62, 0.64, 0.4), False)
    walls = np.concatenate([box((0, 0, 0), (1, 1, 1)), stood])
    exitance = np.zeros(len(walls))
    exitance[1] = 1.0
    return scene(walls, 0.5, exitance)


def test_points_of_cut_cells_lie_where_light_is():
    model = room_with_a_block()
    reach = find_reach(model, make_plan(model, 0.1, "4").division, 0)
    patches, start = reach.patches, reach.patches.grid.start
    finer = patches.grid.division.divided(FINER)
    face, points = finer.face, centroids(finer.cells(model.faces))
    before = points.copy()
    _leave_the_dark(points, face, patches, reach.live, reach.table)
    moved = np.flatnonzero(np.any(points != before, axis=1))
    assert len(moved) > 0
    lit = np.flatnonzero(reach.live[: patches.fronts] & (patches.face == 0))
    for p in moved:
        assert face[p] == 0
        assert max(margin_in(patches.vertices[k], patches.normal[k], points[p]) for k in lit) > 0
    assert np.any(np.diff(start) > 1)


def test_floor_beside_a_block_is_not_dark():
    """Every fine cell of which some part is lit carries light: next to the block too."""
    reach, irradiance, face = shone_on(room_with_a_block(), "4")
    floor = irradiance[0, face == 0, 0]
    assert floor.min() > 0.05  # in the open 0.17; at the block half of the ceiling is still seen
