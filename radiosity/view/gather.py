"""Final gather: the light that reaches every pixel, computed per pixel, pass by pass (E8).

A pass adds one jittered sight line a pixel, a few rays to every light and some over the
hemisphere. The mean over the passes is the picture, its indirect light smoothed between pixels, so
a window can show each as it comes. Pixels whose error is still too large then get more passes.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
from numba import njit

from radiosity.light.bands import Bands
from radiosity.light.reflection import lambert
from radiosity.scene.model import Camera
from radiosity.scene.names import UnknownName
from radiosity.solve.plan import check_fits
from radiosity.solve.solution import Solution
from radiosity.transport.hemisphere import MISS, look_out
from radiosity.transport.irradiance import direct_irradiance, irradiance_by
from radiosity.transport.sampling import hashed, shuffled, sobol
from radiosity.transport.threads import Progress, core_count, over_ranges, silent
from radiosity.transport.visibility import LIFT
from radiosity.view.camera import rays
from radiosity.view.contact import contact_light
from radiosity.view.effort import BUDGET, FEWEST, MOST, ROUNDS, even_enough, worth_more
from radiosity.view.film import Film
from radiosity.view.image import Image
from radiosity.view.shading import Shading, auto_exposure, make_shading
from radiosity.view.sightlines import Seen, first_rows
from radiosity.view.smoothing import MIXED

A_PASS = 8  # rays over a pixel's hemisphere in one pass
LIGHT_RAYS = 4  # to each light in one pass
PIXELS_AT_ONCE, TILES = (2048, 16384), 2  # in one tile; tiles a core
BYTES_A_PIXEL, BYTES_A_BAND = 250, 70  # the film, and the copies that developing it makes


def render(
    solution: Solution,
    camera: Camera | str | None = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    progress: Progress = silent,
) -> Image:
    """Gather a camera's picture.

    Parameters
    ----------
    solution : Solution
    camera : Camera or str, optional
        One of the scene's by name; its first by default.
    size : (w, h), optional
        Pixels, instead of the camera's own.
    samples : int, optional
        Rays over each pixel's hemisphere, in passes of 8 with a sight line each. If not given, the
        accuracy of the solution decides, pixel by pixel: see `radiosity.view.effort`.

    Returns
    -------
    Image
        (h, w, 3) radiance in W/(m2 sr), with the solution's automatic exposure and, of two passes
        or more, its standard error.

    Raises
    ------
    ValueError
        No such camera, or a size or number of samples out of range.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> render(solution, size=(8, 6), samples=8).pixels.shape
    (6, 8, 3)
    """
    total = pass_count(samples)
    shading = make_shading(solution)
    exposures = _exposures(solution, shading, camera, size, samples)
    film, done = next(exposures), 1
    for done, _ in enumerate(exposures, 2):
        progress("final gather", done, max(total, done + 1))
    progress("final gather", done, done)
    return _picture(film, shading, solution, auto_exposure(solution))


def pass_count(samples: int | None) -> int:
    """Return how many pictures `passes` yields for so many rays a pixel; for None usually."""
    if samples is None:
        return FEWEST + ROUNDS
    if not 1 <= samples <= 1 << 20:
        raise ValueError(f"samples = {samples} must lie between 1 and 1048576 rays a pixel")
    return -(-samples // A_PASS)


def passes(
    solution: Solution,
    camera: Camera | str | None = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Iterator[Image]:
    """Yield the picture as it grows, after each pass or round of them; the last one is `render`'s.

    Ends early, within a fraction of a pass, once ``stop()`` is true.
    """
    shading, exposure = make_shading(solution), auto_exposure(solution)
    for film in _exposures(solution, shading, camera, size, samples, stop):
        yield _picture(film, shading, solution, exposure)


def _picture(film, shading, solution, exposure) -> Image:
    bands, found = solution.scene.bands, film.developed(shading)
    lamp = found.lamp
    if lamp is not None:
        lamp = np.concatenate([bands.to_rgb(lamp[..., :-1]), lamp[..., -1:]], axis=2)
    return Image(bands.to_rgb(found.radiance), exposure, found.error, lamp)


def _exposures(
    solution, shading, camera, size, samples, stop=lambda: False
) -> Iterator[Film]:  # fmt: skip
    """Yield one film, exposed by one more pass or round each time, until done or ``stop()``."""
    camera = find_camera(solution.scene, camera)
    bands, detail, accuracy = solution.scene.bands, shading.detail, solution.plan.accuracy
    film = Film.blank(
        *picture_size(camera, size, bands), bands, lamps=bool(shading.emission.any()),
        varied=(detail is not None and detail.textured) or solution.space is not None,
    )  # fmt: skip
    every = np.arange(film.width * film.height)

    def expose(pixels, done, count):
        def tile(a, b):
            for index in range(done, done + count):
                if not stop():
                    _add(solution, shading, camera, index, pixels[a:b], film)

        size = len(pixels) // (TILES * core_count())
        over_ranges(tile, len(pixels), int(np.clip(size, *PIXELS_AT_ONCE)))
        return not stop()

    done, enough = 0, FEWEST if samples is None else pass_count(samples)
    while done < enough:
        if not expose(every, done, 1):
            return
        yield film
        done += 1
        if samples is None and done == enough < MOST:
            even = even_enough(film, film.developed(shading), accuracy)
            enough = done if even else 2 * done
    pixels = every
    for level in range(ROUNDS if samples is None else 0):
        most = int(BUDGET * len(every)) >> level
        pixels = worth_more(film, pixels, film.developed(shading), accuracy, most)
        if not len(pixels) or not expose(pixels, done, done):
            return
        done *= 2
        yield film


def find_camera(scene, camera: Camera | str | None) -> Camera:
    """Return a camera of the scene by name, the first where none is named."""
    if isinstance(camera, Camera):
        return camera
    if camera is None and not scene.cameras:
        raise ValueError("the scene has no camera: give one to look from")
    if camera is None:
        return next(iter(scene.cameras.values()))
    if camera not in scene.cameras:
        raise UnknownName("camera", camera, scene.cameras)
    return scene.cameras[camera]


def picture_size(camera: Camera, size: tuple[int, int] | None, bands: Bands) -> tuple[int, int]:
    """Return (w, h) in pixels, the camera's own by default.

    Raises
    ------
    TypeError
        No pair.
    ValueError
        Out of range.
    Refused
        The picture would not fit into memory.
    """
    size = size or camera.size
    if isinstance(size, str) or np.shape(size) != (2,):
        raise TypeError(f"size = {size!r} must be (width, height) in pixels, such as (640, 480)")
    width, height = size
    if not (1 <= width <= 16384 and 1 <= height <= 16384):
        raise ValueError(f"size = {width}x{height} must lie between 1x1 and 16384x16384 pixels")
    needed = (BYTES_A_PIXEL + BYTES_A_BAND * bands.count) * width * height
    check_fits(f"{width} x {height} pixels", needed, None, "use a smaller --size")
    return width, height


@njit(cache=True, nogil=True)
def _jitter(pixels, width, index, seed, xy):
    for k in range(len(xy)):
        shift = hashed(pixels[k], 1, seed)
        # In an order of their own, or where a pixel looks would decide where its rays go.
        order = shuffled(index, hashed(pixels[k], 2, seed))
        xy[k, 0] = pixels[k] % width + sobol(order, 0, shift)
        xy[k, 1] = pixels[k] // width + sobol(order, 1, shift >> np.uint64(32))


def _add(solution, shading, camera, index, pixels, film):
    """Add one pass's light to some pixels."""
    xy = np.empty((len(pixels), 2))
    _jitter(pixels, film.width, index, solution.seed, xy)
    origins, directions = rays(camera, (film.width, film.height), xy)
    rows, points = first_rows(solution, origins, directions)
    leaving, indirect, diffuse = np.zeros((3, len(pixels), film.bands.count))
    nearness, plane = np.zeros(len(pixels)), np.full(len(pixels), MIXED)
    leaving[rows == MISS] = solution.surroundings.field.outside / np.pi
    k = np.flatnonzero(rows >= 0)
    if len(k):
        seen = _seen(
            solution, shading, origins[k], rows[k], points[k], directions[k], pixels[k], index
        )
        leaving[k], indirect[k], diffuse[k] = seen.leaving, seen.indirect, seen.diffuse
        nearness[k], plane[k], points[k] = seen.nearness, seen.plane, seen.points
    film.add(pixels, plane, points, leaving, indirect, nearness, diffuse)
    if film.lamp is not None:
        emission = shading.emission[rows[k]]
        bright = emission.any(axis=1)
        film.add_lamps(pixels[k[bright]], emission[bright])


def _seen(solution, shading, origins, rows, points, directions, keys, index) -> Seen:
    """Return what sight lines show, with what mirrors and clear bodies send on along them."""
    if solution.space is None:
        return _own(solution, shading, rows, points, -directions, keys, index)
    from radiosity.view.coherent import with_coherent  # others need none of it

    def own(*there):
        return _own(solution, shading, *there)

    return with_coherent(
        solution, shading, origins, rows, points, directions, keys, index, own
    )


def _own(solution, shading, rows, points, to_view, keys, index) -> Seen:
    """Return what leaves points of patches towards the viewer by itself."""
    leaving, indirect, nearness = radiance(
        solution, shading, rows, points, to_view, keys, index
    )
    diffuse = shading.diffuse[rows]
    if shading.detail is not None:
        diffuse = shading.detail.diffuse(solution.patches.face[rows], points, diffuse)
    return Seen(leaving, indirect, nearness, diffuse, shading.plane[rows], points)


def radiance(solution: Solution, shading: Shading, rows, points, to_view, keys, index: int):
    """Return what leaves points of patches towards the viewer.

    L = emission + diffuse E/pi + the lobe's reflection, with E gathered at the point; of a
    translucent sheet + tau E/pi, with E on its other side; of a base under a clear coat,
    diffuse (1 - a(theta_o)) E/pi with E as it enters (L14).

    Returns
    -------
    leaving : (k, bands) float64
        L in W/(m2 sr).
    indirect : (k, bands) float64
        The part of E in W/m2 that does not come straight from lights, as far as a coat lets its
        light out.
    nearness : (k,) float64
        Mean of 1/distance to the surroundings.
    """
    around, seed = solution.surroundings, solution.seed
    diffuse, face = shading.diffuse[rows], solution.patches.face[rows]
    if shading.detail is not None:
        diffuse = shading.detail.diffuse(face, points, diffuse)
    flat, sides = solution.patches.normal[rows], np.where(solution.patches.front[rows], 1.0, -1.0)
    places, normals = _standing(around, shading.detail, face, points, flat, sides)
    looks = range(index * A_PASS, (index + 1) * A_PASS)
    aims = range(index * LIGHT_RAYS, (index + 1) * LIGHT_RAYS)
    indirect, direct, nearness = _arriving(solution, places, normals, keys, looks, aims)
    glossy = np.zeros_like(direct)
    for which, k in _of_lobes(shading, rows):
        from radiosity.view.gloss import dimming, glossy_radiance

        here, lobe = (places[k], normals[k]), _lobe_at(shading, which, face[k], points[k])
        coats = tuple(lobe if c is shading.lobes[which] else c for c in shading.coats[which])
        if coats:
            out = dimming(coats, normals[k], to_view[k])
            indirect[k] *= out
            direct[k] = out * _entering(around, coats, *here, keys[k], aims, seed)
        if lobe is not None:
            glossy[k] = glossy_radiance(around, lobe, *here, to_view[k], keys[k], aims, seed)
    leaving = shading.emission[rows] + lambert(diffuse) * (indirect + direct) + glossy
    if shading.through is not None:
        k = np.flatnonzero(shading.through[rows].any(axis=1))
        beneath = solution, shading, rows[k], points[k], to_view[k], keys[k], looks, aims
        leaving[k] += _from_behind(*beneath)
    return leaving, indirect, nearness


def _from_behind(solution, shading, rows, points, to_view, keys, looks, aims):
    """Return (k, bands) radiance of what comes through sheets, past the coats on both sides."""
    around, seed, through = solution.surroundings, solution.seed, shading.through[rows]
    face, flat = solution.patches.face[rows], -solution.patches.normal[rows]
    sides = np.where(solution.patches.front[rows], -1.0, 1.0)
    places, normals = _standing(around, shading.detail, face, points, flat, sides)
    indirect, direct, _ = _arriving(solution, places, normals, keys, looks, aims)
    for which, k in _of_lobes(shading, rows):
        if coats := shading.coats[which]:
            from radiosity.view.gloss import dimming

            through[k] *= dimming(coats, -normals[k], to_view[k])
            through[k] /= math.prod(1.0 - coat.mean_albedo for coat in coats)
            direct[k] = _entering(around, coats, places[k], normals[k], keys[k], aims, seed)
    return lambert(through) * (indirect + direct)


def _entering(around, coats, points, normals, keys, aims, seed):
    """Return what `entering` does, with their light by mirrors as if it came evenly."""
    from radiosity.view.gloss import entering

    direct = entering(around, coats, points, normals, keys, aims, seed)
    if around.tracer is not None:
        direct += around.tracer.by_mirrors(points, normals, keys, aims, seed)
    return direct


def _of_lobes(shading, rows):
    """Yield each number of a lobe and coats, and which of the points lie on such patches."""
    which = shading.lobe[rows]
    for lobe in np.unique(which[which >= 0]):
        yield lobe, np.flatnonzero(which == lobe)


def _lobe_at(shading, which, face, points):
    """Return a material's lobe or None, its roughness one for each point where pictures tell."""
    lobe = shading.lobes[which]
    rough = None if shading.detail is None else shading.detail.roughness(face, points)
    return lobe if lobe is None or rough is None else lobe.with_roughness(rough[:, None])


def _standing(around, detail, face, points, flat, sides):
    """Return where light to points of faces is followed from and the normals there, (k, 3) each.

    ``flat`` are the faces' normals on the ``sides`` looked at, 1 for fronts, -1 for backs.
    """
    if detail is None:
        return points, flat
    normals = detail.normals(face, points, sides)
    # Rays are lifted along the normals they are given, and have to start over the faces.
    lift = LIFT / around.visibility.scale * (flat - normals)
    return detail.raised(face, points, sides) + lift, normals


def _arriving(solution, points, normals, keys, looks, aims):
    """Return the indirect and the direct irradiance (k, bands), and the nearness (k,)."""
    around, seed = solution.surroundings, solution.seed
    visibility, lights = around.visibility, around.lights
    if around.even is not None:
        indirect, nearness = np.tile(np.pi * around.even, (len(points), 1)), np.zeros(len(points))
    else:
        met = look_out(visibility, around.table, points, normals, keys, looks, seed)
        indirect, _, nearness = irradiance_by(around, points, *met)
        indirect += contact_light(solution, points, *met, keys, looks.start)
        if around.space is not None:
            from radiosity.transport.onward import irradiance_sent_on

            indirect += irradiance_sent_on(around, points, normals, *met, keys, looks, seed)
    direct = direct_irradiance(visibility, lights, points, normals, keys, aims, seed)
    if around.tracer is not None:
        direct += around.tracer.by_mirrors(points, normals, keys, aims, seed)
    return indirect, direct, nearness
