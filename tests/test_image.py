"""Pictures: tone curve, exposure, and files that come back as they went."""

import os
import stat
from pathlib import Path

import numpy as np
import pytest

from radiosity.transport.files import written_whole
from radiosity.view import image as image_module
from radiosity.view.image import Image, exposure_for, tone_map, write


@pytest.fixture
def picture():
    """Wide range, black and one-band pixels, and a mantissa that rounds up to 256."""
    rng = np.random.default_rng(0)
    pixels = 10.0 ** rng.uniform(-6, 6, (24, 37, 3))
    pixels[0, 0], pixels[0, 1], pixels[1, 0] = 0.0, [1.0, 0.0, 0.0], 255.9 / 256
    return Image(pixels, exposure=0.7)


def srgb_twin(c):
    """The curve of IEC 61966-2-1, one number at a time."""
    c = min(max(c, 0.0), 1.0)
    v = 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055
    return round(255 * v)


def test_tone_map_known_values():
    linear = [0.0, 1.0, 2.0, -0.5, 0.5, 0.2140411, 0.0031308, 0.001]
    assert tone_map(np.array(linear), 1.0).tolist() == [0, 255, 255, 0, 188, 127, 10, 3]


def test_tone_map_is_the_plain_curve_times_the_exposure():
    values = np.random.default_rng(1).uniform(-0.1, 1.2, 3000)
    found = tone_map(values.reshape(10, 100, 3), 0.5)
    assert found.dtype == np.uint8 and found.shape == (10, 100, 3)
    assert found.ravel().tolist() == [srgb_twin(0.5 * v) for v in values]


def test_every_grey_level_comes_back():
    level = np.arange(256) / 255
    linear = np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)
    assert tone_map(linear, 1.0).tolist() == list(range(256))


def test_exposure_shows_the_90th_percentile_at_80_percent():
    luminance = np.arange(1.0, 101.0)
    assert exposure_for(luminance, np.ones(100)) == pytest.approx(0.8 / 90, rel=1e-15)
    shuffled = np.random.default_rng(0).permutation(luminance)
    assert exposure_for(shuffled, np.full(100, 0.1)) == pytest.approx(0.8 / 90, rel=1e-15)


def test_exposure_weighs_by_area():
    assert exposure_for([1.0, 5.0], [95.0, 5.0]) == pytest.approx(0.8)
    assert exposure_for([1.0, 5.0], [85.0, 15.0]) == pytest.approx(0.16)
    assert exposure_for([5.0, 1.0], [5.0, 95.0]) == pytest.approx(0.8)
    assert exposure_for([1.0, 5.0], [1.0, 0.0]) == pytest.approx(0.8)


def test_exposure_scales_with_the_light():
    rng = np.random.default_rng(3)
    luminance, area = rng.random(50), rng.random(50)
    assert exposure_for(10 * luminance, area) == pytest.approx(exposure_for(luminance, area) / 10)
    assert exposure_for(luminance, 10 * area) == exposure_for(luminance, area)


def test_exposure_of_the_dark():
    assert exposure_for(np.zeros(5), np.ones(5)) == 1.0
    assert exposure_for([], []) == 1.0
    assert exposure_for([0.0, 2.0], [99.0, 1.0]) == pytest.approx(0.4)  # of what is lit


def test_exposure_refuses_what_is_no_luminance():
    with pytest.raises(ValueError, match="2 luminances and 1 weights must be as many"):
        exposure_for([1.0, 2.0], [1.0])
    with pytest.raises(ValueError, match="none negative"):
        exposure_for([-1.0], [1.0])


@pytest.mark.parametrize(
    "pixels, exposure, message",
    [
        (np.zeros((4, 5)), 1.0, r"shape \(4, 5\) must be \(h, w, 3\)"),
        (np.zeros((4, 5, 4)), 1.0, r"must be \(h, w, 3\)"),
        (np.full((1, 2, 3), np.nan), 1.0, "2 pixels are not finite, the first in row 0, column 0"),
        (np.full((1, 2, 3), 1e300), 1.0, "float32's range"),
        (np.zeros((4, 5, 3)), 0.0, r"exposure = 0\.0 must be positive"),
    ],
)
def test_images_that_cannot_be(pixels, exposure, message):
    with pytest.raises(ValueError, match=message):
        Image(pixels, exposure)


def test_png_holds_the_tone_mapped_values(picture, tmp_path):
    import imageio.v3

    write(picture, tmp_path / "a.png")
    assert np.array_equal(imageio.v3.imread(tmp_path / "a.png"), tone_map(picture.pixels, 0.7))


def test_exr_and_npy_hold_the_same_floats(picture, tmp_path):
    import OpenEXR

    write(picture, tmp_path / "a.exr")
    write(picture, tmp_path / "a.npy")
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        exr = file.channels()["RGB"].pixels
    npy = np.load(tmp_path / "a.npy")
    assert exr.dtype == npy.dtype == np.float32
    assert np.array_equal(exr, npy) and np.array_equal(npy, picture.pixels)


def test_hdr_holds_the_radiance_to_its_precision(picture, tmp_path):
    """Read by VTK, which shares no code with the writer (it fails on files below 512 bytes)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkHDRReader

    write(picture, tmp_path / "a.hdr")
    reader = vtkHDRReader()
    reader.SetFileName(str(tmp_path / "a.hdr"))
    reader.Update()
    found = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(24, 37, 3)[::-1]
    error = np.abs(found - picture.pixels).max(axis=2)
    assert np.all(error <= picture.pixels.max(axis=2) / 256)  # half a step of a 7.x-bit mantissa
    assert np.all(found[0, 0] == 0) and found[0, 1].tolist() == [1.0, 0.0, 0.0]
    assert found[1, 0].tolist() == [1.0, 1.0, 1.0]  # rounded up into the next exponent


def test_rgbe_bytes_of_known_values():
    bright = np.finfo(np.float32).max
    bytes_of = {
        (1.0, 0.5, 0.25): [128, 64, 32, 129],
        (-1.0, 0.0, 2.0): [0, 0, 128, 130],
        (0.0, 0.0, 0.0): [0, 0, 0, 0],
        (1e-39, 0.0, 0.0): [0, 0, 0, 0],
        (bright, 0.0, 0.0): [255, 0, 0, 255],
    }
    pixels = np.array([list(bytes_of)], dtype=np.float32)
    assert image_module._rgbe(pixels)[0].tolist() == list(bytes_of.values())


def test_rgbe_never_looks_like_a_run():
    """A row that starts 2, 2, below 128 would be read as run-length code."""
    dim = np.random.default_rng(5).uniform(0, 1, (200, 200, 3)) * [0.02, 0.02, 1.0]
    rgbe = image_module._rgbe(dim.astype(np.float32))
    assert np.all(rgbe[..., :3].max(axis=2) >= 128)


def test_suffix_may_be_capital(picture, tmp_path):
    write(picture, tmp_path / "a.NPY")
    write(picture, tmp_path / "a.PNG")
    assert sorted(f.name for f in tmp_path.iterdir()) == ["a.NPY", "a.PNG"]


def test_unknown_suffix_names_the_known(picture, tmp_path):
    message = r"suffix '\.jpg'; supported are \.png, \.exr, \.hdr, \.npy"
    with pytest.raises(ValueError, match=message):
        write(picture, tmp_path / "a.jpg")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_failed_write_leaves_the_old_file(error, picture, tmp_path, monkeypatch):
    place = tmp_path / "a.png"
    place.write_text("old")

    def fails(image, path):
        path.write_text("half")
        raise error

    monkeypatch.setitem(image_module._WRITERS, ".png", fails)
    with pytest.raises(error):
        write(picture, place)
    assert [f.name for f in tmp_path.iterdir()] == ["a.png"] and place.read_text() == "old"


def test_the_temporary_file_lies_beside_with_the_same_suffix(tmp_path):
    place = tmp_path / "b.glb"
    with written_whole(place) as temporary:
        assert temporary.parent == tmp_path and temporary.suffix == ".glb" and temporary != place
        temporary.write_text("new")
        assert not place.exists()
    assert place.read_text() == "new" and len(list(tmp_path.iterdir())) == 1


def test_the_file_has_ordinary_permissions(tmp_path):
    (tmp_path / "ordinary").touch()
    with written_whole(tmp_path / "whole"):
        pass
    modes = [stat.S_IMODE((tmp_path / n).stat().st_mode) for n in ("ordinary", "whole")]
    assert modes[0] == modes[1]


def test_a_link_is_followed(tmp_path):
    target, link = tmp_path / "target.txt", tmp_path / "link.txt"
    target.write_text("old")
    link.symlink_to(target)
    with written_whole(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink() and target.read_text() == "new"


@pytest.mark.skipif(not os.path.exists("/dev/null"), reason="no devices here")
def test_a_device_is_not_replaced():
    with written_whole("/dev/null") as temporary:
        assert temporary == Path("/dev/null")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_a_missing_folder_is_named(picture, tmp_path):
    with pytest.raises(FileNotFoundError, match=r"gone' does not exist; create it first.*a\.png"):
        write(picture, tmp_path / "gone" / "a.png")


def test_a_folder_is_not_overwritten(tmp_path):
    with pytest.raises(IsADirectoryError, match="add a file name"), written_whole(tmp_path):
        pytest.fail("no file may be made")


def test_a_closed_place_is_named(picture, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"cannot write in folder '.*file': Not a directory"):
        write(picture, tmp_path / "file" / "a.png")


def test_a_lamp_s_edge_is_cut_to_the_screen_before_it_is_mixed():
    """A pixel half filled by a lamp shows half of white; the linear radiance keeps the mean."""
    light = np.full((1, 3, 3), [[0.1], [5.05], [10.0]])
    lamp = np.zeros((1, 3, 4))
    lamp[0, 1], lamp[0, 2] = [5.0, 5.0, 5.0, 0.5], [10.0, 10.0, 10.0, 1.0]
    picture = Image(light, 1.0, lamp=lamp)
    expected = tone_map(np.array([0.1, 0.5 * 1.0 + 0.5 * 0.1, 1.0]), 1.0)
    np.testing.assert_array_equal(picture.shown()[0, :, 0], expected)
    np.testing.assert_array_equal(picture.pixels, light.astype(np.float32))
    dimmed = Image(light, 0.05, lamp=lamp)  # nothing is cut, so nothing changes
    np.testing.assert_array_equal(dimmed.shown(), Image(light, 0.05).shown())


@pytest.mark.parametrize(("name", "shape"), [("error", (3, 2)), ("lamp", (2, 3))])
def test_what_goes_with_pixels_has_their_shape(name, shape):
    with pytest.raises(ValueError, match=f"{name} of shape"):
        Image(np.ones((2, 3, 3)), **{name: np.zeros(shape)})
