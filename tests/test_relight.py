"""Light groups: their own answers add up, and any mixture of them is the answer to that mixture."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import box, scene
from test_clustered import room_with_balls

import radiosity
from radiosity.light.sources import Directional, Point
from radiosity.scene.apart import apart
from radiosity.scene.groups import dimmed, groups_of_lights, light_groups
from radiosity.solve import adapt, relight
from radiosity.solve.level import solve_level
from radiosity.solve.solve import solve

SCENES = Path(__file__).resolve().parent.parent / "scenes"
WEIGHTS = 0.3, 0.7, 2.0  # of lamps, of the material that emits, and of the light from outside


def lit_again(name):
    """A scene of the collection with a point of light in a group, and light from outside."""
    bands = "8" if "spectral" in name else "auto"
    found = radiosity.load(SCENES / f"{name}.toml", bands=bands)
    low, high = (f(found.faces.vertices, axis=(0, 1)) for f in (np.min, np.max))
    inside = [0.53, 0.46, 0.55] if name == "textured_room" else [0.3, 0.75, 0.28]  # of nothing else
    place, bands = low + (high - low) * inside, found.bands.count
    power = (found.unit_m * np.ptp([low, high], axis=0).max()) ** 2
    lamp = Point(place, np.linspace(1, 2, bands) * power, group="lamps")
    return replace(found, lights=(lamp,), ambient=np.linspace(0.1, 0.2, bands))


def apart_from(one, other):
    """Return the largest difference, to the largest of the values."""
    return np.abs(one - other).max() / np.abs(other).max()


def places(solution, count=7):
    rows = np.flatnonzero(solution.live)
    rows = rows[:: max(1, len(rows) // count)]
    return solution.patches.centroid[rows], solution.patches.normal[rows]


@pytest.mark.parametrize("name", ["cornell_box", "mirror_room"])
def test_a_mixture_is_the_answer_to_the_mixed_light(name):
    model = lit_again(name)
    options = {"mesh": "1", "order": 1} if name == "mirror_room" else {}
    solution = solve(model, 0.2, **options)
    factors = dict(zip(solution.groups, WEIGHTS, strict=True))
    mixed = solution.dimmed(factors)
    like, level = dimmed(model, factors), solution.level
    exact = replace(level.recipe, tolerance=1e-10)
    fresh = solve_level(like, level.reach, exact)
    for part in ("coefficients", "arriving", "escaping", "lamplight", "straight"):
        # The solver's tolerance is 2e-6.
        assert apart_from(getattr(mixed.level, part), getattr(fresh, part)) < 3e-6, part
    where = places(solution)
    assert apart_from(mixed.irradiance(*where)[0], fresh.gathered(*where).total) < 3e-6
    assert mixed.emission.any() and apart_from(mixed.emission, fresh.terms.emission) < 1e-14


@pytest.mark.parametrize("name", ["cornell_box", "textured_room"])
def test_the_groups_add_up(name):
    solution = solve(lit_again(name), 0.5, mesh="1", order=int(name != "cornell_box"))
    alone, where = solution.by_groups(), places(solution)
    assert len(alone) == 3
    total = sum(each.irradiance(*where)[0] for each in alone.values())
    assert apart_from(total, solution.irradiance(*where)[0]) < 1e-12
    total = sum(each.radiosity for each in alone.values())
    assert apart_from(total, solution.radiosity) < 1e-12
    for part in ("emitted", "escaped") * (name == "cornell_box"):  # that of lobes is slow
        total = sum(getattr(each.balance, part) for each in alone.values())
        assert total == pytest.approx(getattr(solution.balance, part), rel=1e-9), part


def test_what_groups_miss_is_given_to_them_by_their_sizes():
    parts = np.array([[[1.0, 0.0]], [[-3.0, 0.0]]])
    fitted = relight._adding_up(parts, np.array([[-1.6, 0.0]]))
    assert fitted.sum(axis=0).tolist() == [[-1.6, 0.0]] and not fitted[:, :, 1].any()
    assert fitted[:, 0, 0] == pytest.approx([1.1, -2.7], rel=1e-15)  # 0.4 as 1 to 3


def test_checks_that_are_smoothed_answers(monkeypatch):
    """Constant elements too many for linear ones on the same patches, here by decree."""
    monkeypatch.setattr(adapt, "MOST_LINEAR", 10)
    model = lit_again("cornell_box")
    solution = solve(model, 0.5, mesh="1", order=0)
    assert solution.check.level.kept is not None
    alone, where = solution.by_groups(), places(solution)
    checks = [each.check.level for each in alone.values()]
    total = sum(check.gathered(*where).total for check in checks)
    assert apart_from(total, solution.check.level.gathered(*where).total) < 1e-12
    like = dimmed(model, {"light": 0, "ambient": 0})
    fresh = adapt.smoothed(relight._under(solution.level, like))
    assert apart_from(checks[0].coefficients, fresh.coefficients) < 1e-5


def test_many_faces_between_clusters():
    model = replace(
        room_with_balls(12), lights=(Point(np.array([0.5, 0.5, 2.0]), np.full(3, 3.0)),)
    )
    solution = solve(model, 0.2)
    assert solution.plan.clusters and solution.groups == ("point 1", "lamp")
    alone, where = solution.by_groups(), places(solution)
    total = sum(each.radiosity for each in alone.values())
    assert apart_from(total, solution.radiosity) < 1e-12
    total = sum(each.irradiance(*where)[0] for each in alone.values())
    # Of rays that look around, negative sums of slopes are cut off in each.
    assert apart_from(total, solution.irradiance(*where)[0]) < 1e-3
    fresh = relight._under(solution.level, dimmed(model, {"lamp": 0.0}))
    assert apart_from(alone["point 1"].radiosity, fresh.on_patches(fresh.coefficients)) < 1e-3


def test_a_furnace_scales():
    model = radiosity.load(SCENES / "furnace.toml")
    solution = solve(model, 0.2)
    half = solution.dimmed(dict.fromkeys(solution.groups, 0.25))
    expected = np.broadcast_to([0.3125, 1.0, 0.625], half.radiosity.shape)
    assert half.radiosity == pytest.approx(expected, rel=4e-6)  # twice the solver's tolerance
    assert half.estimate.reached == pytest.approx(solution.estimate.reached, abs=1e-9)
    assert half.truth_error() is None and half.scene.truth is None


def test_one_is_the_same_and_none_is_dark():
    solution = solve(lit_again("cornell_box"), 0.3)
    assert solution.dimmed({"lamps": 1.0}) is solution
    off = solution.dimmed(dict.fromkeys(solution.groups, 0.0))
    assert not off.radiosity.any() and not off.irradiance(*places(off))[0].any()
    assert not off.balance.emitted.any() and off.estimate.reached == 0.0


def test_dimming_twice_multiplies_and_what_is_off_stays_off():
    solution = solve(lit_again("cornell_box"), 0.3)
    twice = solution.dimmed({"lamps": 0.5, "light": 0.0}).dimmed({"lamps": 0.5, "light": 1.0})
    once = solution.dimmed({"lamps": 0.25, "light": 0.0})
    assert twice.groups == solution.groups == ("lamps", "light", "ambient")
    assert apart_from(twice.radiosity, once.radiosity) < 1e-14
    assert apart_from(twice.irradiance(*places(once))[0], once.irradiance(*places(once))[0]) < 1e-14


def test_errors_are_those_of_the_light_that_is_left():
    """Of one lamp near a wall, on a mesh made for the even light of another, more than of both."""
    walls = np.zeros((6, 3))
    walls[1] = 3.0
    lamp = Point(np.array([0.15, 1.5, 1.5]), np.full(3, 0.3), group="near")
    solution = solve(scene(box((0, 0, 0), (4, 3, 3)), 0.5, walls, lights=(lamp,)), 0.3, mesh="2",
                     order=1)  # fmt: skip
    alone = solution.by_groups()
    assert alone["near"].estimate.reached > solution.estimate.reached
    assert alone["m1"].estimate.reached < alone["near"].estimate.reached
    assert (alone["near"].error <= 3.0 * alone["near"].irradiance_on + 1e-9).mean() > 0.5


def test_names_of_groups():
    walls = np.zeros((6, 3))
    walls[1] = 1.0
    point = Point(np.ones(3), np.ones(3))
    sun = Directional(np.array([0.0, 0.0, -1.0]), np.ones(3))
    lights = point, replace(point, group="m1"), sun, point
    model = scene(box((0, 0, 0), (2, 2, 2)), 0.5, walls, lights=lights, ambient=np.ones(3))
    assert groups_of_lights(model) == ["point 1", "m1", "directional 1", "point 3"]
    assert light_groups(model) == ("point 1", "m1", "directional 1", "point 3", "ambient")
    half = dimmed(model, {"m1": 0.5, "directional 1": 0.0})
    assert half.materials[1].emission == pytest.approx(0.5 / np.pi)
    assert [light.strength[0] for light in half.lights] == [1.0, 0.5, 0.0, 1.0]
    spread = apart(model, light_groups(model))
    assert spread.bands.count == 15 and spread.lights[2].strength.tolist() == [0] * 6 + [1] * 3 + [
        0] * 6  # fmt: skip


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"lamp": 1.0}, "did you mean 'lamps'"),
        ({"sun": 1.0}, "the scene has 'lamps', 'light', 'ambient'"),
        ({"lamps": -1.0}, "-1, must lie in [0, 1e+06]"),
        ({"lamps": float("nan")}, "nan, must lie in"),
    ],
)
def test_wrong_names_and_factors(factors, words):
    solution = solve(lit_again("cornell_box"), 0.5)
    with pytest.raises(ValueError) as caught:
        solution.dimmed(factors)
    assert words in str(caught.value)


def test_too_many_groups_are_refused():
    lights = tuple(Point(np.full(3, 0.1 + 0.02 * k), np.ones(3)) for k in range(40))
    solution = solve(scene(box((0, 0, 0), (2, 2, 2)), 0.5, lights=lights), 0.5, mesh="1")
    assert not solution.can_dim
    with pytest.raises(ValueError, match='40 light groups .* group = "lamps"'):
        solution.dimmed({"point 1": 0.5})


def test_lights_without_a_group_go_by_the_type_of_the_scene_file():
    office = radiosity.load(SCENES / "office.toml")
    alone = replace(office, lights=tuple(replace(x, group="") for x in office.lights))
    assert light_groups(alone) == ("ies 1", "ies 2", "ies 3")


def test_a_dimmed_scene_says_so():
    office = radiosity.load(SCENES / "office.toml")
    assert dimmed(office, {"desk": 0.3}).notes[-1] == "dimmed: desk to 30 %"
    assert dimmed(office, {"desk": 1.0}).notes == office.notes
