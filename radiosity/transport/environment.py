"""What rows send to no other row: the outside, obstructions and backs, by rays of its own."""

import numpy as np
from numba import njit

from radiosity.mesh.patches import Patches
from radiosity.transport.borrow import borrowed
from radiosity.transport.operator import FormFactors, Openness
from radiosity.transport.polygon import first_half, place_evenly
from radiosity.transport.sampling import cosine_direction, hashed, sobol
from radiosity.transport.threads import over_ranges
from radiosity.transport.visibility import LIFT, Visibility

# Rays from a row: the most where rows are many, and where all have no more than IN_ALL together.
FEWEST, MOST, MOST_OF_FEW, IN_ALL = 64, 1 << 12, 1 << 16, 1 << 21
AT_ONCE = 1 << 17  # rays that a scene of few rows gets at least, so that small holes are found
CHUNK = 1 << 13
PLACE = 1 << 41  # tells its patterns from those of rays between pairs
OUTSIDE, ROW, SURFACE = 0, 1, 2
LAYERS = 4  # of its own face that a ray may have to leave behind
BLUR = 5e-7  # of places where rays end, in ray coordinates
# Measured over layers of tiles and holes and over small sheets, 1 to 10,000 hits; and the largest
# of sqrt(s (1 - s)) s^(-0.1).
SPREAD, WORST = 1.2, 0.54
DOUBT = 0.2  # of the accuracy: rows that miss more of 1 than they explain get more rays
# A row misses what rays did not find where that is more than SURE of its error and rounding, and
# no more than RARE standard errors of the rays; in scenes of more than FEW rows also no more than
# the accuracy.
SURE, ROUNDING, RARE, FEW = 5.0, 1e-12, 3.0, 64


@njit(cache=True, nogil=True, error_model="numpy")
def _aim(rows, vertices, area, normals, first, count, seed, centre, scale, lift, start, direction):
    vertices, normals = borrowed((vertices, normals))
    x, d, middle = np.empty(3), np.empty(3), np.empty(3)
    for m in range(len(rows)):
        i = rows[m]
        n = normals[i]
        half, reach = first_half(vertices[i]), 0.0
        for c in range(3):
            middle[c] = vertices[i, :, c].mean()
            reach = max(reach, np.abs(vertices[i, :, c] - middle[c]).max())
        # off the edges as well as off the surface, for a neighbour may rise there
        inward = min(0.5, 4.0 * lift * reach / (scale * area[i]))
        place, way = hashed(i, PLACE, seed), hashed(i, PLACE + 1, seed)
        for k in range(count):
            r = m * count + k
            s, t = sobol(first + k, 0, place), sobol(first + k, 1, place >> np.uint64(32))
            place_evenly(vertices[i], half, s, t, x)
            u, v = sobol(first + k, 2, way), sobol(first + k, 3, way >> np.uint64(32))
            cosine_direction(u, v, n, d)
            for c in range(3):
                x[c] += inward * (middle[c] - x[c])
                start[r, c] = (x[c] - centre[c]) * scale + lift * n[c]
                direction[r, c] = d[c]


def measure_openness(
    patches: Patches,
    visibility: Visibility,
    live: np.ndarray,
    accuracy: float,
    seed: int = 0,
    pairs: FormFactors | None = None,
    flat: np.ndarray | bool = False,
) -> Openness:
    """Return what each row sends to no row, by cosine-distributed rays from all over it.

    Few rays for every row; for those that see anything but rows, and for doubtful ones, more until
    the error meets ``accuracy``. That of N points in four dimensions, h of them on the rarer side
    of an edge, is SPREAD sqrt(s (1 - s)/N) h^(-0.1), s = h/N: they are more even than random ones
    only where many fall on either side.

    Parameters
    ----------
    live : (n,) bool
        Rows; the others get 0. A ray that meets a side of a face without any row ends on no row.
    accuracy : float
        Of the share.
    pairs : FormFactors, optional
        Of the rows. Those that miss much of 1 get more rays; what is missing is the error of the
        share where rays cannot tell, because they are too few or start beyond what is ``flat``.
    flat : (n,) bool, optional
        Rows that something lies on, nearer than rays start.
    """
    rows = np.flatnonzero(live)
    count = int(np.clip(1 << int(np.log2(max(1, AT_ONCE // max(1, len(rows))))), FEWEST, MOST))
    met = np.zeros((len(patches), 3))
    ends = _Ends(patches, visibility, live)
    _trace(met, rows, range(count), patches, visibility, ends, seed)
    more = met[:, ROW] < count
    if pairs is not None:
        missing, known = 1.0 - pairs.row_sums(), pairs.row_errors()
        more |= np.abs(missing) > known + DOUBT * accuracy
    most = np.clip(IN_ALL // max(1, len(rows)), MOST, MOST_OF_FEW)
    wanted = int(np.clip((WORST * SPREAD / accuracy) ** (1.0 / 0.6) + 2.0, count, most))
    if wanted > count:
        _trace(met, rows[more[rows]], range(count, wanted), patches, visibility, ends, seed)
    total = np.maximum(met.sum(axis=1), 1.0)
    share = (met[:, OUTSIDE] + met[:, SURFACE]) / total
    hits = np.minimum(share, 1.0 - share) * total + 1.0  # one more, for few may be none by chance
    spread = SPREAD * np.sqrt(hits * (1.0 - hits / (total + 2.0))) / total * hits**-0.1
    is_open = np.any(share > 0)
    error = np.where(more & live & is_open, spread, 0.0)
    if pairs is not None:
        left = missing - share
        rare = (left > SURE * known + ROUNDING) & (left <= RARE * spread)
        rare &= (left <= accuracy) | (len(rows) <= FEW)  # else the pairs may be what is wrong
        error = np.where(live & (rare | (flat & is_open)), np.maximum(error, np.abs(left)), error)
    return Openness(share, error, met[:, SURFACE] / total)


class _Ends:
    """Tells where rays end: OUTSIDE, on a ROW, or on a SURFACE without a row.

    Where a row and another face coincide and look the same way, a copy of it among the
    obstructions say, a ray meets either; such faces stand for the row. What lies on a covered part
    of a row's face with its front towards it hides that part; a ray meets either as well.
    """

    def __init__(self, patches, visibility, live):
        self._visibility = visibility
        self._is_row = np.zeros((len(visibility.face_normal), 2), bool)
        self._is_row[patches.face[live], patches.front[live].astype(int)] = True
        some = self._is_row.any(axis=1)
        self._rows_only = None if live.all() and some.all() else visibility.first_hits_of(some)
        self._covered = np.zeros_like(self._is_row)
        self._covered[patches.face[~live], patches.front[~live].astype(int)] = True
        self._covered &= self._is_row
        any_covered = self._covered.any() and not some.all()
        self._others_only = visibility.first_hits_of(~some) if any_covered else None

    def of(self, start, direction, own):
        """Return (k,) the kind of surface that each ray meets first, its own face (k,) apart.

        A flat face does not see itself; that of a sliver, rounded, may rise over where rays start.
        """
        face, far = self._visibility.first_hits(start, direction)
        for _ in range(LAYERS):
            again = np.flatnonzero(face == own)
            if len(again) == 0:
                break
            start[again] += (far[again, None] + 2.0 * np.float32(LIFT)) * direction[again]
            face[again], far[again] = self._visibility.first_hits(start[again], direction[again])
        cosine = self._cosine(face, direction)
        kind = np.where(face < 0, OUTSIDE, np.where(self._rows(face, cosine), ROW, SURFACE))
        if self._rows_only is not None:
            again = np.flatnonzero(kind == SURFACE)
            row, other, near = self._met_there(self._rows_only, start, direction, far, again)
            kind[again[near & (other * cosine[again] > 0) & self._rows(row, other)]] = ROW
        if self._others_only is not None:
            again = np.flatnonzero((kind == ROW) & self._covered[face, (cosine < 0).astype(int)])
            _, other, near = self._met_there(self._others_only, start, direction, far, again)
            kind[again[near & (other * cosine[again] < 0)]] = SURFACE
        return kind

    def _met_there(self, first_hits, start, direction, far, rays):
        """Return the faces (k,) of some that rays meet, their cosines, whether where they ended."""
        face, distance = first_hits(start[rays], direction[rays])
        cosine = self._cosine(face, direction[rays])
        apart = np.abs((distance - far[rays]) * cosine)
        return face, cosine, (face >= 0) & (apart <= self._visibility.touch + BLUR)

    def _cosine(self, face, direction):
        return np.einsum("kc,kc->k", direction, self._visibility.face_normal[face])

    def _rows(self, face, cosine):
        return self._is_row[face, (cosine < 0).astype(int)]


def _trace(met, rows, samples, patches, visibility, ends, seed):
    """Add to met (n, 3) how many rays from the rows end outside, on rows and on other surfaces."""
    count = len(samples)
    step = max(1, CHUNK // count)

    def work(a, b):
        block = rows[a:b]
        start = np.empty((len(block) * count, 3), np.float32)
        direction = np.empty_like(start)
        _aim(
            block, patches.vertices, patches.area, patches.normal, samples.start, count, seed,
            visibility.centre, visibility.scale, LIFT, start, direction,
        )  # fmt: skip
        own = np.repeat(patches.face[block], count)
        kind = ends.of(start, direction, own).reshape(len(block), count)
        for k in (OUTSIDE, ROW, SURFACE):
            met[block, k] += np.count_nonzero(kind == k, axis=1)

    over_ranges(work, len(rows), step)
