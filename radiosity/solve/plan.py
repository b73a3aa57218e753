"""What reaching an accuracy takes: mesh, rays, samples and tolerance; and whether it fits."""

import os
from dataclasses import dataclass

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.mesh.patches import divisions

FEWEST = 150
# Bytes at the peak an entry of the matrix; measured: 28 while closure is repaired, 39 with the
# direct solver (29 with the others). And a face, in the trees that are searched.
FACTORS, SOLUTION, FACE = 32, 40, 2500
PATCHES_AT_UNIT_ACCURACY = 15.0  # gathered irradiance is of second order in the patch size


class Refused(RuntimeError):
    """The plan needs more memory than it may take; nothing was computed."""


@dataclass(frozen=True)
class Plan:
    """How a scene will be solved.

    Attributes
    ----------
    accuracy : float
        Asked bound of the relative error (95th percentile over the surfaces).
    shape : (f, 2) int
        Cells a face is divided into, see `divisions`.
    factors : float
        Accuracy of the form factors.
    samples : int
        Rays from a point that looks around; a quarter of them goes to each light.
    tolerance : float
        Of the solver, relative.
    """

    accuracy: float
    shape: np.ndarray
    factors: float
    samples: int
    tolerance: float

    @property
    def cells(self) -> int:
        """Return how many cells the faces are divided into."""
        n, m = self.shape.T
        return int(np.where(m == 0, n * n, n * m).sum())


def make_plan(faces: Faces, accuracy: float, mesh: str = "auto") -> Plan:
    """Choose mesh, rays, samples and tolerance for an accuracy.

    Parameters
    ----------
    faces : Faces
    accuracy : float
        In (0, 1).
    mesh : str
        ``auto``; ``input`` for the faces as they are; or N for N x N cells a face.

    Raises
    ------
    ValueError
        Accuracy or mesh out of range.
    """
    if not 1e-4 <= accuracy < 1:
        raise ValueError(
            f"accuracy = {accuracy:g} must lie in [0.0001, 1): 0.02 asks for 2 percent"
        )
    wanted = max(PATCHES_AT_UNIT_ACCURACY / accuracy, FEWEST)
    samples = int(2 ** np.clip(np.ceil(np.log2(20 / accuracy)), 8, 14))
    return Plan(accuracy, _shape(faces, mesh, wanted), accuracy, samples, 1e-5 * accuracy)


def _shape(faces, mesh, wanted):
    if mesh == "auto":
        return divisions(faces, np.sqrt(faces.areas().sum() / wanted))
    if mesh == "input":
        count = 1
    elif mesh.isascii() and mesh.isdigit() and 0 < int(mesh) <= 1024:
        count = int(mesh)
    else:
        raise ValueError(f"mesh = {mesh!r} must be auto, input or a number from 1 to 1024")
    return np.where(faces.is_triangle[:, None], [count, 0], [count, count])


def check_memory(patches: int, limit: float | None) -> int:
    """Raise `Refused` where a dense solution would not fit; return the bytes that it takes."""
    way_out = "use a larger --accuracy, a coarser --mesh, or allow more with --memory"
    return check_fits(f"{patches} patches", SOLUTION * patches**2, limit, way_out)


def check_factors(rows: int, faces: int, limit: float | None) -> int:
    """Raise `Refused` where factors of so many rows would not fit; return the bytes they take.

    ``faces`` counts all that may block, rows or not.
    """
    way_out = "merge faces, or allow more with --memory"
    what = f"form factors of {rows} faces" + (f", {faces} in all," if faces > rows else "")
    return check_fits(what, FACTORS * rows**2 + FACE * faces, limit, way_out)


def check_fits(what: str, needed: int, limit: float | None, way_out: str) -> int:
    """Return ``needed`` bytes; raise `Refused` above ``limit``, half of what is free if None."""
    limit = free_memory() / 2 if limit is None else limit
    if needed > limit:
        raise Refused(
            f"{what} need about {size_text(needed)}, more than the {size_text(limit)} allowed: "
            f"{way_out}"
        )
    return needed


def size_text(count: float) -> str:
    """Return a count of bytes in GB, MB or kB."""
    for unit, name in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= 0.1 * unit:
            return f"{count / unit:.1f} {name}"
    return f"{count:.0f} bytes"


def free_memory() -> float:
    """Return the bytes of memory that are free now (4 GB where the system does not say)."""
    try:
        with open("/proc/meminfo") as info:
            for line in info:
                if line.startswith("MemAvailable"):
                    return 1024.0 * int(line.split()[1])
    except OSError:
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")) / 2
    except (ValueError, OSError, AttributeError):
        return 4e9
