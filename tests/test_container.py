"""The container .radsol: what is loaded answers as what was saved, to the bit; damage is named."""

import hashlib
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from test_clustered import room_with_balls
from test_relight import SCENES, lit_again, places

import radiosity
from radiosity.light.sources import Point
from radiosity.scene.model import Camera, SceneError
from radiosity.scene.toml import read_toml
from radiosity.solve.archive import MANIFEST
from radiosity.solve.plan import Refused
from radiosity.solve.record import Unreadable, rebuilt, recorded
from radiosity.solve.solve import solve

GLASS = """
[[geometry]]
material = "wall"
polygons = [[[0,0,0],[2,0,0],[2,2,0],[0,2,0]], [[0,0,2],[0,2,2],[2,2,2],[2,0,2]]]
[[geometry]]
material = "glass"
polygons = [[[0.5,0.5,0.6],[0.5,1,0.6],[1,1,0.6],[1,0.5,0.6]],
            [[0.5,0.5,1],[1,0.5,1],[1,1,1],[0.5,1,1]], [[0.5,0.5,0.6],[1,0.5,0.6],[1,0.5,1],[0.5,0.5,1]],
            [[1,0.5,0.6],[1,1,0.6],[1,1,1],[1,0.5,1]], [[1,1,0.6],[0.5,1,0.6],[0.5,1,1],[1,1,1]],
            [[0.5,1,0.6],[0.5,0.5,0.6],[0.5,0.5,1],[0.5,1,1]]]
[[geometry]]
material = "sheet"
polygons = [[[1.2,1.2,0.5],[1.8,1.2,0.5],[1.8,1.8,0.5],[1.2,1.8,0.5]]]
[materials.wall]
diffuse = 0.5
[materials.glass]
diffuse = 0.0
mirror = "fresnel"
transmit = "fresnel"
ior = 1.5
absorption = [1, 2, 3]
[materials.sheet]
diffuse = 0.3
translucent = 0.4
emission = { radiance = 2 }
[[lights]]
type = "spot"
position = [1, 1, 1.8]
target = [0.7, 0.7, 0]
intensity = 3
beam_angle = 20
cutoff_angle = 40
[cameras.front]
position = [1.9, 1.9, 1.5]
target = [0.7, 0.7, 0.6]
fov = 50
size = [12, 8]
"""  # noqa: E501


def clusters():
    eye = Camera("eye", np.array([0.3, 0.3, 1.5]), np.array([3, 2.5, 1.0]),
                 np.array([0, 0, 1.0]), 60.0, (12, 8))  # fmt: skip
    lamp = Point(np.array([0.5, 0.5, 2.0]), np.full(3, 3.0))
    return solve(replace(room_with_balls(12), cameras={"eye": eye}, lights=(lamp,)), 0.3)


MADE = {
    "diffuse": lambda: solve(lit_again("cornell_box"), 0.3),
    "spectral": lambda: solve(lit_again("cornell_box_spectral"), 0.5, mesh="1"),
    "order 0": lambda: solve(lit_again("cornell_box"), 0.5, mesh="1", order=0, solver="gmres"),
    "glossy": lambda: solve(lit_again("cornell_glossy"), 0.5, mesh="1", order=1),
    "mirror": lambda: solve(lit_again("mirror_room"), 0.5, mesh="1", order=1),
    "glass": lambda: solve(read_toml(GLASS, "glass.toml", None), 0.5, mesh="1", order=1),
    "textured": lambda: solve(lit_again("textured_room"), 0.5, mesh="1", order=1),
    "clusters": clusters,
    "luminaires": lambda: solve(radiosity.load(SCENES / "office.toml"), 0.5, mesh="1", order=1),
    "read from a file of others": lambda: solve(radiosity.load(OTHERS), 0.5, mesh="1", order=1),
}
OTHERS = SCENES.parent / "tests" / "foreign" / "CornellBox-Original.obj"


def assert_same(one, other):
    """Assert that pictures, probes and patches of two solutions are the same to the bit."""
    where = places(one)
    for a, b in zip(one.irradiance(*where), other.irradiance(*where), strict=True):
        assert np.array_equal(a, b)
    for name in ("radiosity", "irradiance_on", "error", "emission", "reflectance"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    pictures = [radiosity.render(s, size=(12, 8), samples=8) for s in (one, other)]
    assert pictures[0].pixels.any() and pictures[0].exposure == pictures[1].exposure
    assert np.array_equal(pictures[0].pixels, pictures[1].pixels)


@pytest.mark.parametrize("name", MADE)
def test_what_is_loaded_answers_as_what_was_saved(name, tmp_path):
    solution, path = MADE[name](), tmp_path / "answer.radsol"
    radiosity.save(solution, path)
    found = radiosity.load(path)
    assert_same(solution, found)
    assert found.estimate.reached == solution.estimate.reached
    assert found.plan.recipe == solution.plan.recipe and found.closed == solution.closed
    assert found.history == solution.history and found.solver == solution.solver
    assert found.scene.read_as == solution.scene.read_as
    if name in ("diffuse", "order 0", "clusters"):
        assert found.balance.defect == solution.balance.defect
        half = {solution.groups[0]: 0.5}
        assert_same(solution.dimmed(half), found.dimmed(half))
    radiosity.save(found, tmp_path / "again.radsol")
    assert path.read_bytes() == (tmp_path / "again.radsol").read_bytes()


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "box.radsol"
    radiosity.save(solve(lit_again("cornell_box"), 0.3), path)
    return path


def test_a_dimmed_solution_is_saved_as_it_is(saved, tmp_path):
    half = radiosity.load(saved).dimmed({"lamps": 0.5, "light": 0.0})
    radiosity.save(half, tmp_path / "half.radsol")
    found = radiosity.load(tmp_path / "half.radsol")
    assert found.groups == half.groups == ("lamps", "light", "ambient")
    assert_same(half, found)


def test_nothing_in_it_is_pickled_or_dated(saved):
    with zipfile.ZipFile(saved) as file:
        manifest = json.loads(file.read(MANIFEST))
        assert {info.date_time for info in file.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        for name, told in manifest["members"].items():
            with file.open(name) as member:
                array = np.lib.format.read_array(member, allow_pickle=False)
            assert (array.dtype.str, list(array.shape)) == (told["type"], told["shape"])
            assert hashlib.sha256(file.read(name)).hexdigest() == told["sha256"]
    assert manifest["format"] == "radsol" and manifest["version"] == 1
    assert manifest["program"] == f"radiosity {radiosity.__version__}"


def rewritten(saved, path, change):
    """Write a container again with its members, bytes by name, and its manifest changed."""
    with zipfile.ZipFile(saved) as file:
        members = {name: file.read(name) for name in file.namelist()}
    manifest = json.loads(members.pop(MANIFEST))
    change(manifest, members)
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(MANIFEST, json.dumps(manifest))
        for name, data in members.items():
            file.writestr(name, data)
    return path


ARRIVING = "solution/level/share/arriving.npy"


def newer(manifest, members):
    manifest["version"], manifest["program"] = 2, "radiosity 9.0"


def flipped(manifest, members):
    members[ARRIVING] = members[ARRIVING][:-1] + b"\x7f"


def missing(manifest, members):
    del members[ARRIVING]


def added(manifest, members):
    members["virus.npy"] = b""


def larger(manifest, members):
    manifest["members"][ARRIVING]["shape"] = [1 << 30, 3]


def pickled(manifest, members):
    manifest["members"][ARRIVING]["type"] = "|O"


def unknown(manifest, members):
    manifest["content"]["class"] = "Popen"


def level_of(manifest):
    return manifest["content"]["fields"]["level"]["fields"]


def faces_of(manifest):
    return manifest["content"]["fields"]["scene"]["fields"]["faces"]["fields"]


def no_such_material(manifest, members):
    faces_of(manifest)["material"]["values"][3] = 99


def bright(manifest, members):
    white = manifest["content"]["fields"]["scene"]["fields"]["materials"][0]["fields"]
    white["diffuse"]["values"][0] = 1.5


def endless(manifest, members):
    level_of(manifest)["mesh"]["fields"]["division"]["fields"]["shape"]["values"][0] = 30000


def strange(manifest, members):
    level_of(manifest)["weight"] = 1.0


def wrong_kind(manifest, members):
    level_of(manifest)["solver"] = 7


def shorter(manifest, members):
    del level_of(manifest)["share"]["fields"]["arriving"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (newer, "version 2, made by radiosity 9.0; this release reads 1: use the release"),
        (flipped, f"{ARRIVING}' has another SHA-256"),
        (missing, f"{ARRIVING}' is missing in the archive"),
        (added, "'virus.npy' is missing in manifest.json"),
        (larger, "25769803776 are needed for <f8"),
        (pickled, "has the type '|O'"),
        (unknown, "'Popen', which is not known"),
        (no_such_material, "faces.material holds an index outside of [0, 4)"),
        (bright, "materials.white.diffuse[0] = 1.5 must be in [0, 1]"),
        (endless, "division.splits must hold a number from 1 to 32768 for each cell"),
        (strange, "has the part 'weight', which is not known"),
        (wrong_kind, "SavedLevel.solver is a int, must be"),
        (shorter, "Share.arriving is missing"),
    ],
)
def test_damage_is_named(saved, tmp_path, change, words):
    path = rewritten(saved, tmp_path / "bad.radsol", change)
    with pytest.raises(SceneError) as caught:
        radiosity.load(path)
    assert words in str(caught.value) and str(caught.value).startswith(str(path))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is no .radsol file"),
        (b"solid nothing", "is no .radsol file"),
        (None, "does not exist"),
    ],
)
def test_what_is_no_container(tmp_path, data, words):
    path = tmp_path / "bad.radsol"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(SceneError, match=words):
        radiosity.load(path)


def test_another_zip_is_no_container(tmp_path):
    path = tmp_path / "bad.radsol"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("readme.txt", "hello")
    with pytest.raises(SceneError, match="has no manifest.json"):
        radiosity.load(path)


def test_a_bomb_is_seen_before_it_goes_off(saved, tmp_path):
    def bomb(manifest, members):
        members["zeros.npy"] = bytes(1 << 24)

    path = tmp_path / "bomb.radsol"
    plain = rewritten(saved, tmp_path / "plain.radsol", bomb)
    with zipfile.ZipFile(plain) as file, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as to:
        for name in file.namelist():
            to.writestr(name, file.read(name))
    from radiosity.solve.container import read_solution

    with pytest.raises(Refused, match="allow more with --memory"):
        read_solution(path, 1e6)
    with pytest.raises(SceneError, match="'zeros.npy' is missing in manifest.json"):
        read_solution(path)


def test_random_damage_never_gives_another_answer(saved, tmp_path):
    data, rng = saved.read_bytes(), np.random.default_rng(7)
    path, told = tmp_path / "bad.radsol", 0
    for k in range(60):
        bad = bytearray(data)
        if k % 3 == 0:
            del bad[rng.integers(len(bad)) :]
        for place in rng.integers(len(bad), size=1 + k % 4) if bad else ():
            bad[place] ^= 1 << rng.integers(8)
        path.write_bytes(bad)
        try:
            found = radiosity.load(path)
        except SceneError:
            told += 1
        else:  # a bit that no one reads, such as one of a date
            assert np.array_equal(found.radiosity, radiosity.load(saved).radiosity)
    assert told > 45


def test_options_of_scenes_are_refused(saved):
    with pytest.raises(ValueError, match="bands is for scenes, but .* is solved"):
        radiosity.load(saved, bands="grey")


def test_only_known_classes_are_recorded():
    with pytest.raises(TypeError, match="cannot be stored"):
        recorded(zipfile.ZipInfo("x"), "x", {})
    arrays = {}
    values = (1, 2.5, float("inf"), "a", None, True, [1, (2,)], {"k": np.arange(3)}, np.ones(100),
              np.array([1 + 2j, 3]), np.array([True, False]), np.zeros((0, 3)))  # fmt: skip
    tree = json.loads(json.dumps(recorded(values, "all", arrays), allow_nan=False))
    found = rebuilt(tree, arrays)
    assert list(arrays) == ["all/8"] and found[:7] == values[:7]
    for a, b in zip(found[8:], values[8:], strict=True):
        assert a.dtype == b.dtype and np.array_equal(a, b)
    for bad in ({"class": "os"}, {"known": "system"}, {"array": "no"}, {"x": 1}, {"float": "1"},
                {"type": "<f8", "shape": [2], "values": [1]}, {"items": [[1]]}):  # fmt: skip
        with pytest.raises(Unreadable):
            rebuilt(bad, {})


def test_scenes_load_without_the_container():
    import subprocess
    import sys

    code = (
        "import sys, radiosity; radiosity.load('scenes/cornell_box.toml')\n"
        "print([m for m in sys.modules if 'radsol' in m or 'container' in m or 'relight' in m])"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=SCENES.parent, capture_output=True,
                           text=True)  # fmt: skip
    assert found.stdout.strip() == "[]", found.stderr


def test_pictures_that_are_not_finite_are_refused(tmp_path):
    solution = MADE["textured"]()
    materials = list(solution.scene.materials)
    (k,) = [k for k, m in enumerate(materials) if m.bump is not None][:1]
    relief = materials[k].bump
    texels = np.full_like(relief.texture.texels, np.nan)
    broken = replace(relief, texture=replace(relief.texture, texels=texels))
    materials[k] = replace(materials[k], bump=broken)
    odd = replace(solution, scene=replace(solution.scene, materials=tuple(materials)))
    radiosity.save(odd, tmp_path / "odd.radsol")
    with pytest.raises(radiosity.SceneError, match=f"materials.{materials[k].name}.bump holds"):
        radiosity.load(tmp_path / "odd.radsol")
