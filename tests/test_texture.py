"""Textures: lookup, slopes and exact means over polygons, against closed forms and sums."""

import numpy as np
import pytest

from radiosity.light.texture import PIECES, Texture, srgb_to_linear


def noise(h=5, w=7, bands=2, repeat=True, seed=0):
    return Texture(np.random.default_rng(seed).random((h, w, bands)), repeat)


def twin(texture, u, v):
    """Bilinear lookup of one point, written out."""
    h, w, _ = texture.texels.shape
    x, y = u * w - 0.5, (1 - v) * h - 0.5
    total = 0.0
    for i in (int(np.floor(x)), int(np.floor(x)) + 1):
        for j in (int(np.floor(y)), int(np.floor(y)) + 1):
            share = (1 - abs(x - i)) * (1 - abs(y - j))
            if texture.repeat:
                texel = texture.texels[j % h, i % w]
            else:
                texel = texture.texels[min(max(j, 0), h - 1), min(max(i, 0), w - 1)]
            total = total + share * texel
    return total


def test_the_picture_stands_upright():
    texture = Texture(np.arange(6).reshape(2, 3, 1))  # 0 1 2 above 3 4 5
    middles = [[(i + 0.5) / 3, (j + 0.5) / 2] for j in (0, 1) for i in (0, 1, 2)]
    assert texture.at(middles).ravel().tolist() == [3, 4, 5, 0, 1, 2]


@pytest.mark.parametrize("repeat", [True, False])
def test_lookup_equals_its_plain_twin(repeat):
    texture = noise(repeat=repeat)
    uv = np.random.default_rng(1).uniform(-2, 3, (200, 2))
    expected = [twin(texture, u, v) for u, v in uv]
    np.testing.assert_allclose(texture.at(uv), expected, rtol=0, atol=1e-6)  # float32 texels


def test_repeating_pictures_have_a_period_of_one_and_others_go_on():
    uv = np.random.default_rng(2).random((50, 2))
    np.testing.assert_allclose(noise().at(uv + [3, -2]), noise().at(uv), atol=1e-12)
    edge = noise(repeat=False)
    np.testing.assert_array_equal(edge.at([[-4, 0.3], [0, 0.3]])[0], edge.at([[0, 0.3]])[0])
    np.testing.assert_array_equal(edge.at([[7, 9]])[0], edge.texels[0, -1])


@pytest.mark.parametrize("repeat", [True, False])
def test_mean_over_a_polygon_is_that_of_many_points(repeat):
    """Triangles and quadrilaterals of any size and winding, beyond the picture's edges too."""
    texture, rng = noise(repeat=repeat), np.random.default_rng(3)
    corners = rng.uniform(-1.5, 1.5, (6, 3, 2))
    found = texture.mean_over(corners[:, [0, 1, 2, 2]])
    k = (np.arange(1200) + 0.5) / 1200
    s, t = (x.ravel() for x in np.meshgrid(k, k))
    s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
    for (a, b, c), mean in zip(corners, found, strict=True):
        points = a + s[:, None] * (b - a) + t[:, None] * (c - a)
        assert mean == pytest.approx(texture.at(points).mean(axis=0), abs=2e-5)  # points: 1/1200^2


def test_mean_over_whole_texels_is_theirs():
    texture = noise(8, 8)
    middle = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    np.testing.assert_allclose(texture.mean_over(middle[None])[0], texture.mean, rtol=1e-12)
    # A square between the middles of four texels has their mean.
    square = (middle + [2.5, 3.5]) / 8
    expected = texture.texels[3:5, 2:4].astype(float).mean(axis=(0, 1))
    np.testing.assert_allclose(texture.mean_over(square[None])[0], expected, rtol=1e-12)


def test_means_of_parts_add_up_at_any_angle():
    texture, rng = noise(31, 17), np.random.default_rng(4)
    for scale in (1e-3, 1.0, 10.0):
        turn = np.linalg.qr(rng.normal(size=(2, 2)))[0]
        n = 6
        x, y = np.meshgrid(np.arange(n), np.arange(n))
        low = np.stack([x.ravel(), y.ravel()], axis=1)[:, None]
        cells = scale * (low + [[0, 0], [1, 0], [1, 1], [0, 1]]) / n @ turn
        whole = scale * np.array([[[0, 0], [1, 0], [1, 1], [0, 1]]]) @ turn
        parts = texture.mean_over(cells).mean(axis=0)
        # 1e-9: T is a sum over the texels before the place, of which small polygons see little.
        np.testing.assert_allclose(parts, texture.mean_over(whole)[0], rtol=1e-9)


def test_long_edges_of_many_texels_are_sampled():
    texture = noise(64, 64)
    size = 3.0 * PIECES / 64
    polygon = np.array([[[0, 0], [size, 0.1], [size, size], [0.3, size]]])
    assert texture.mean_over(polygon)[0] == pytest.approx(texture.mean, rel=1e-3)


def test_lines_and_points_have_the_mean_along_them():
    ramp = Texture(np.linspace(0, 1, 101)[None, :, None], repeat=False)
    line = np.array([[[0.2, 0.5], [0.8, 0.5], [0.8, 0.5], [0.8, 0.5]]])
    point = np.full((1, 4, 2), 0.5)
    assert ramp.mean_over(line)[0, 0] == pytest.approx(0.5, abs=1e-7)
    assert ramp.mean_over(point)[0, 0] == pytest.approx(0.5, abs=1e-7)


@pytest.mark.parametrize("axis", [0, 1])
def test_slopes_converge_to_a_waves(axis):
    """Second order in the size of a texel: errors of differences and of bilinear values."""
    uv, errors = np.random.default_rng(5).random((400, 2)), []
    for n in (32, 64, 128):
        middle = (np.arange(n) + 0.5) / n
        middle = middle if axis == 0 else 1 - middle
        wave = np.sin(2 * np.pi * middle)
        picture = np.broadcast_to(wave[None, :] if axis == 0 else wave[:, None], (n, n))
        slope = Texture(picture[..., None]).slope(uv)[:, 0]
        exact = 2 * np.pi * np.cos(2 * np.pi * uv[:, axis])
        errors.append(np.abs(slope[:, axis] - exact).max())
        assert np.abs(slope[:, 1 - axis]).max() < 1e-4  # float32 texels over 2/128
        assert errors[-1] < 2 * np.pi * (2 * np.pi / n) ** 2 * (1 / 6 + 1 / 8)
    rates = np.log2(errors[:-1]) - np.log2(errors[1:])
    assert (rates > 1.9).all()


def test_bounds_are_those_of_the_texels():
    texture = noise()
    np.testing.assert_array_equal(texture.highest, texture.texels.max(axis=(0, 1)))
    np.testing.assert_array_equal(texture.lowest, texture.texels.min(axis=(0, 1)))


def test_other_shapes_are_refused():
    for shape in ((3, 4), (0, 4, 3)):
        with pytest.raises(ValueError, match=r"must be \(h, w, bands\)"):
            Texture(np.zeros(shape))


def test_srgb_is_decoded_as_the_standard_says():
    values = [0.0, 0.04045, 0.5, 1.0]
    assert srgb_to_linear(values) == pytest.approx([0, 0.0031308, 0.21404114, 1.0], abs=1e-7)
    from radiosity.view.image import tone_map

    byte = np.arange(256)
    np.testing.assert_array_equal(tone_map(srgb_to_linear(byte / 255), 1.0), byte)
