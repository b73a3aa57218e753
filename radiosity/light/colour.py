"""Colour: from tristimulus values to what screens show, and how different two colours look.

X, Y, Z are those of the CIE 1931 observer for 2 degrees, Y the luminance in the unit of what is
weighed; RGB is linear sRGB unless it is said to be encoded.
"""

import numpy as np

# Chromaticities of sRGB's primaries and of its white, D65, rounded as IEC 61966-2-1 gives them.
_PRIMARIES = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])
_WHITE = np.array([0.3127, 0.3290])
_LINEAR = 0.0031308  # below it, sRGB's curve is a line
SEEN = 0.5 / 255.0 / 12.92  # linear value that 8 bits round to 0
_EPSILON, _KAPPA = (6 / 29) ** 3, (29 / 3) ** 3  # CIE 15: where the cube root becomes a line


def _primary_matrix() -> np.ndarray:
    """Return (3, 3): the columns are X, Y, Z of red, green and blue whose sum is white, Y = 1."""
    x, y = np.vstack([_PRIMARIES, _WHITE]).T
    directions = np.array([x / y, np.ones(4), (1.0 - x - y) / y])
    return directions[:, :3] * np.linalg.solve(directions[:, :3], directions[:, 3])


RGB_TO_XYZ = _primary_matrix()
XYZ_TO_RGB = np.linalg.inv(RGB_TO_XYZ)


def encode(linear: np.ndarray, gamma: float | None = None) -> np.ndarray:
    """Return display values in [0, 1] of linear ones, which are clipped to [0, 1].

    v = 12.92 c for c <= 0.0031308, otherwise v = 1.055 c^(1/2.4) - 0.055 (sRGB, IEC 61966-2-1).
    With a ``gamma`` instead v = c^(1/gamma), the inverse of a screen whose light is a power of what
    it is sent (Szirmay-Kalos, eq. 3.6).

    Raises
    ------
    ValueError
        A gamma that is not positive and finite.
    """
    c = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    if gamma is None:
        return np.where(c <= _LINEAR, 12.92 * c, 1.055 * c ** (1.0 / 2.4) - 0.055)
    if not 0.0 < gamma < np.inf:
        raise ValueError(f"gamma = {gamma} must be positive and finite: screens have about 2.2")
    return c ** (1.0 / gamma)


def outside(rgb: np.ndarray) -> np.ndarray:
    """Return (...) whether linear RGB (..., 3) in display values lies outside of sRGB.

    By more than 8 bits can show; what is brighter than white counts as inside: it is overexposed.
    """
    return np.min(rgb, axis=-1) < -SEEN


def in_gamut(rgb: np.ndarray) -> np.ndarray:
    """Return linear RGB (..., 3) with what lies `outside` greyed until it is inside.

    c' = Y + t (c - Y) with the largest t for which no component is negative: luminance and, about,
    hue stay; nothing is left of light that has no luminance.
    """
    bad = outside(rgb)
    if not np.any(bad):
        return rgb
    inside, some = np.array(rgb, float), np.asarray(rgb, float)[bad]
    y = np.maximum(some @ RGB_TO_XYZ[1], 0.0)[:, None]
    share = y / (y - some.min(axis=1, keepdims=True))
    inside[bad] = np.maximum(y + share * (some - y), 0.0)
    return inside


def lab(xyz: np.ndarray, white: np.ndarray) -> np.ndarray:
    """Return (..., 3) CIELAB L*, a*, b* of X, Y, Z beside a white (3,) (CIE 15).

    L* = 116 f(Y/Y_n) - 16, a* = 500 (f(X/X_n) - f(Y/Y_n)), b* = 200 (f(Y/Y_n) - f(Z/Z_n)), with
    f(t) = t^(1/3) for t > (6/29)^3, otherwise (kappa t + 16)/116, kappa = (29/3)^3.
    """
    t = np.asarray(xyz, float) / np.asarray(white, float)
    f = np.where(t > _EPSILON, np.cbrt(t), (_KAPPA * t + 16.0) / 116.0)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def delta_e_76(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return (...) the distance of two colours in CIELAB (CIE76); 1 is just seen, about 2.3."""
    return np.linalg.norm(np.subtract(one, two), axis=-1)


def delta_e_2000(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return (...) the difference CIEDE2000 of two colours in CIELAB, all weights 1.

    Sharma, Wu & Dalal (2005), "The CIEDE2000 color-difference formula: implementation notes,
    supplementary test data, and mathematical observations".
    """
    (l1, c1, h1), (l2, c2, h2) = _stretched(one, two)
    colourless = c1 * c2 == 0.0
    turn = h2 - h1
    turn = np.where(colourless, 0.0, turn - 360.0 * ((turn > 180.0) * 1.0 - (turn < -180.0)))
    dl, dc = l2 - l1, c2 - c1
    dh = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2.0))
    light, chroma = (l1 + l2) / 2.0, (c1 + c2) / 2.0
    hue = np.where(colourless, h1 + h2, h1 + turn / 2.0)
    t = 1.0 + sum(
        a * np.cos(np.radians(k * hue + b))
        for a, k, b in ((-0.17, 1, -30), (0.24, 2, 0), (0.32, 3, 6), (-0.20, 4, -63))
    )
    off = (light - 50.0) ** 2
    sl, sc, sh = (
        1.0 + 0.015 * off / np.sqrt(20.0 + off),
        1.0 + 0.045 * chroma,
        1.0 + 0.015 * chroma * t,
    )
    bend = 60.0 * np.exp(-((((hue % 360.0) - 275.0) / 25.0) ** 2))
    cross = -np.sin(np.radians(bend)) * 2.0 * _saturated(chroma)
    dl, dc, dh = dl / sl, dc / sc, dh / sh
    return np.sqrt(dl**2 + dc**2 + dh**2 + cross * dc * dh)


def _stretched(*colours):
    """Return lightness, chroma and hue (degrees) of each, a* stretched where chroma is small."""
    colours = [np.moveaxis(np.asarray(c, float), -1, 0) for c in colours]
    chroma = sum(np.hypot(a, b) for _, a, b in colours) / len(colours)
    stretch = 1.0 + 0.5 * (1.0 - _saturated(chroma))
    return [
        (light, np.hypot(stretch * a, b), np.degrees(np.arctan2(b, stretch * a)) % 360.0)
        for light, a, b in colours
    ]


def _saturated(chroma):
    """Return sqrt(C^7 / (C^7 + 25^7)): 0 for greys, 1 for vivid colours."""
    return np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
