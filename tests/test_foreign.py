"""Files that other programs and people made."""

from pathlib import Path

import numpy as np
import pytest

import radiosity

FOREIGN = Path(__file__).resolve().parent / "foreign"


def area_of(scene, name):
    index = [m.name for m in scene.materials].index(name)
    return scene.faces.areas()[scene.faces.material == index].sum()


def test_the_cornell_box_of_williams_college():
    """Its library is named in a folder that is not there, and lies beside it."""
    scene = radiosity.load(FOREIGN / "CornellBox-Original.obj")
    made = {m.name: m for m in scene.materials}
    assert len(scene.faces) == 17 and len(made) == 8
    np.testing.assert_array_equal(made["light"].emission, [17, 12, 4])
    np.testing.assert_array_equal(made["rightWall"].diffuse, [0.14, 0.45, 0.091])
    assert not scene.sends_on  # Ks is 0
    assert area_of(scene, "light") == pytest.approx(0.47 * 0.38)


def test_radiances_diorama():
    """Walls with holes, moved files, a box that is made, a view."""
    scene = radiosity.load(FOREIGN / "radiance" / "diorama.rad")
    rims = 2 * (5.2 * 3.2 - 5 * 3)  # round the opening at either end
    outside = 2 * 8.0 * 3.2 + 2 * 8.0 * 5.2  # of which slopes make a little more
    assert area_of(scene, "black_outside") == pytest.approx(rims + outside, rel=1e-3)
    assert area_of(scene, "floor_mat") == pytest.approx(8 * 5)
    box = 2 * (0.2 * 5.2 + 0.2 * 3.2 + 5.2 * 3.2)
    assert area_of(scene, "wall_mat") == pytest.approx(2 * 8 * 3 + box)
    floor = scene.materials[-1].diffuse  # plastic with a weak highlight
    np.testing.assert_allclose(floor, np.multiply([0.3, 0.2, 0.1], 0.98) + 0.02)
    assert scene.cameras["view"].size == (512, 512) and scene.cameras["view"].fov == 45
