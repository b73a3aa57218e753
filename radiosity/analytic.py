"""Closed forms: the truths that tests, `verify` and benchmarks compare with.

Form factors carry the names of Howell's catalogue (J. R. Howell, "A Catalog of Radiation Heat
Transfer Configuration Factors"). Lengths are in any one unit. C-11 and C-14 cancel for slivers and
far rectangles; measured against extended precision, the absolute error stays below 1e-15 for
squares and 1e-16 times the ratio of a rectangle's sides for slivers. Beyond that, use quadrature.
"""

import json
from importlib import resources

import numpy as np


def parallel_rectangles(a, b, distance):
    """Return F between identical, directly opposed rectangles a x b (Howell C-11).

    With X = a/c, Y = b/c, p = sqrt(1 + X^2), q = sqrt(1 + Y^2):
    F = 2/(pi X Y) {ln sqrt(p^2 q^2/(1 + X^2 + Y^2)) + X q atan(X/q) + Y p atan(Y/p)
    - X atan X - Y atan Y}.

    Parameters
    ----------
    a, b, distance : float or ndarray
        Sides, and the distance c between the planes; positive.
    """
    _check_positive(a=a, b=b, distance=distance)
    x, y = np.divide(a, distance), np.divide(b, distance)
    p, q = np.hypot(1.0, x), np.hypot(1.0, y)
    logarithm = 0.5 * np.log1p((x * y) ** 2 / (1.0 + x * x + y * y))
    along_x = x * (q * np.arctan(x / q) - np.arctan(x))
    along_y = y * (p * np.arctan(y / p) - np.arctan(y))
    return 2.0 / (np.pi * x * y) * (logarithm + along_x + along_y)


def perpendicular_rectangles(edge, width, height):
    """Return F from a rectangle to one at right angles that shares an edge (Howell C-14).

    With W = w/l, H = h/l, s = W^2 + H^2:
    F = 1/(pi W) {W atan(1/W) + H atan(1/H) - sqrt(s) atan(1/sqrt(s))
    + 1/4 ln[(1 + W^2)(1 + H^2)/(1 + s)] + W^2/4 ln[W^2 (1 + s)/((1 + W^2) s)]
    + H^2/4 ln[H^2 (1 + s)/((1 + H^2) s)]}.

    Parameters
    ----------
    edge : float or ndarray
        Length l of the common edge; positive, like the others.
    width : float or ndarray
        w, across the edge, of the rectangle that the light leaves.
    height : float or ndarray
        h, across the edge, of the rectangle where it arrives.
    """
    _check_positive(edge=edge, width=width, height=height)
    w, h = np.divide(width, edge), np.divide(height, edge)
    w2, h2 = w * w, h * h
    s = w2 + h2
    root = np.sqrt(s)
    angles = w * np.arctan(1.0 / w) + h * np.arctan(1.0 / h) - root * np.arctan(1.0 / root)
    # Each logarithm through log1p, since its argument tends to 1 for long edges or short ones.
    logarithms = (
        np.log1p(w2 * h2 / (1.0 + s))
        - w2 * np.log1p(h2 / (w2 * (1.0 + s)))
        - h2 * np.log1p(w2 / (h2 * (1.0 + s)))
    )
    return (angles + 0.25 * logarithms) / (np.pi * w)


def point_to_parallel_rectangle(a, b, distance):
    """Return F from a surface element to a parallel rectangle a x b (Howell B-3).

    A corner of the rectangle lies on the element's normal. With A = a/c, B = b/c:
    F = 1/(2 pi) {A/sqrt(1 + A^2) atan(B/sqrt(1 + A^2)) + B/sqrt(1 + B^2) atan(A/sqrt(1 + B^2))}.

    Parameters
    ----------
    a, b, distance : float or ndarray
        Sides, and the distance c along the normal; positive.
    """
    _check_positive(a=a, b=b, distance=distance)
    x, y = np.divide(a, distance), np.divide(b, distance)
    p, q = np.hypot(1.0, x), np.hypot(1.0, y)
    return (x / p * np.arctan(y / p) + y / q * np.arctan(x / q)) / (2.0 * np.pi)


def point_to_perpendicular_rectangle(height, width, distance):
    """Return F from a surface element to a rectangle at right angles (Howell B-4).

    The rectangle stands on the element's plane, with a corner at the foot of the perpendicular
    from the element. With a = height, b = width, c = distance, d = sqrt(a^2 + c^2):
    F = 1/(2 pi) {atan(b/c) - c/d atan(b/d)}.

    Parameters
    ----------
    height : float or ndarray
        a, along the element's normal; positive, like the others.
    width : float or ndarray
        b, along the element's plane.
    distance : float or ndarray
        c, from the element to the rectangle's plane.
    """
    _check_positive(height=height, width=width, distance=distance)
    b, c, d = width, distance, np.hypot(height, distance)
    return (np.arctan(np.divide(b, c)) - np.divide(c, d) * np.arctan(b / d)) / (2.0 * np.pi)


def furnace(emission, reflectance):
    """Return the radiosity of any closed enclosure that is the same everywhere, in W/m2.

    B = M_e/(1 - rho): B = M_e + rho E and E = B, since every row of F sums to 1.

    Parameters
    ----------
    emission : float or ndarray
        M_e in W/m2.
    reflectance : float or ndarray
        rho, below 1.
    """
    if np.any(np.asarray(reflectance) >= 1):
        raise ValueError(
            f"reflectance = {reflectance} must be below 1: a closed enclosure that absorbs "
            "nothing has no steady state"
        )
    return np.divide(emission, 1.0 - np.asarray(reflectance, dtype=np.float64))


def sphere_cavity(fractions, emission, reflectance):
    """Return the radiosity of each part of a sphere seen from inside, and the irradiance.

    H = sum(f M_e)/(1 - sum(f rho)), B = M_e + rho H: a sphere's F_ij = A_j/A, so that the
    irradiance H is the same everywhere. Fractions below 1 in sum leave an opening, black and
    cold (Gouffe; Sparrow & Jonsson 1962).

    Parameters
    ----------
    fractions : (k,) float64
        Share f of the sphere's area.
    emission : (k,) float64
        M_e in W/m2.
    reflectance : (k,) float64
        rho, dimensionless.

    Returns
    -------
    radiosity : (k,) float64
        W/m2.
    irradiance : float
        H in W/m2.
    """
    f, emitted, rho = (np.asarray(v, dtype=np.float64) for v in (fractions, emission, reflectance))
    if np.any(f < 0) or f.sum() > 1 + 1e-12:
        raise ValueError(f"fractions = {fractions} must be shares of the sphere, 1 in sum at most")
    absorbed = 1.0 - f @ rho
    if not absorbed > 0:
        raise ValueError(f"reflectance = {reflectance} must let some part absorb or be open")
    irradiance = float(f @ emitted / absorbed)
    return emitted + rho * irradiance, irradiance


def box_form_factors(dims):
    """Return F between the six inner faces of a box, by C-11 and C-14.

    Parameters
    ----------
    dims : (3,) float64
        Lengths along x, y and z (z is up).

    Returns
    -------
    (6, 6) float64
        Rows leave, columns receive; floor, ceiling, x0, x1, y0, y1. Every row sums to 1.
    """
    normals = (2, 2, 0, 0, 1, 1)
    factors = np.zeros((6, 6))
    for i, p in enumerate(normals):
        for j, q in enumerate(normals):
            if i != j:
                factors[i, j] = _face_factor(dims, p, q)
    return factors


def box_radiosity(dims, reflectance, emission):
    """Return the radiosity of a box's six faces, one constant element a face, in W/m2.

    Solves (I - rho F) B = M_e with the exact F of `box_form_factors`.

    Parameters
    ----------
    dims : (3,) float64
        Lengths along x, y and z (z is up).
    reflectance : (6,) or float
        rho of floor, ceiling, x0, x1, y0, y1.
    emission : (6,) or float
        M_e in W/m2, in the same order.

    Returns
    -------
    (6,) float64
    """
    rho = np.broadcast_to(np.asarray(reflectance, dtype=np.float64), 6)
    emitted = np.broadcast_to(np.asarray(emission, dtype=np.float64), 6)
    return np.linalg.solve(np.eye(6) - rho[:, None] * box_form_factors(dims), emitted)


def load_cases(name):
    """Return the tabulated cases of ``radiosity/cases/NAME.json``.

    Returns
    -------
    list of dict
        With at least ``id``, ``source``, ``quantity``, ``geometry``, ``value`` and ``digits``.
    """
    folder = resources.files("radiosity") / "cases"
    file = folder / f"{name}.json"
    if not file.is_file():
        known = sorted(f.name[:-5] for f in folder.iterdir() if f.name.endswith(".json"))
        raise ValueError(f"no cases named {name!r}; there are {', '.join(known)}")
    return json.loads(file.read_text(encoding="utf-8"))["cases"]


def _face_factor(dims, p, q):
    """Return F between two faces of a box that are normal to the axes p and q."""
    if p == q:
        a, b = (dims[k] for k in range(3) if k != p)
        return parallel_rectangles(a, b, dims[p])
    return perpendicular_rectangles(dims[3 - p - q], width=dims[q], height=dims[p])


def _check_positive(**lengths):
    for name, length in lengths.items():
        if not np.all(np.asarray(length) > 0):
            raise ValueError(f"{name} = {length} must be a positive length")
