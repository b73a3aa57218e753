"""The form-factor matrix as a linear operator."""

from dataclasses import astuple, dataclass
from os import PathLike

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator


@dataclass(frozen=True)
class Openness:
    """What the rows send to no row: measured by rays of its own.

    Attributes
    ----------
    share : (n,) float64
        Factor from a row to all that is no row: the outside, obstructions, backs.
    error : (n,) float64
        Its estimated error.
    absorbed : (n,) float64
        The part of ``share`` that meets a surface; the rest leaves the scene.
    """

    share: np.ndarray
    error: np.ndarray
    absorbed: np.ndarray | float = 0.0

    @classmethod
    def closed(cls, n: int) -> "Openness":
        """Return that of n rows that see rows only."""
        return cls(np.zeros(n), np.zeros(n))


class FormFactors(LinearOperator):
    """F as a linear operator: ``F @ B`` is the irradiance that radiosities B cause.

    Parameters
    ----------
    exchange : (n, n) float64
        Exchange areas A_i F_ij in m2, not negative, symmetric to the bit.
    area : (n,) float64
        A_i in m2; rows of area 0 see nothing.
    error : (n, n) float32, optional
        Estimated error of each exchange area, symmetric to the bit; 0 where not given.
    openness : Openness, optional
        Factors to all that is no row; a closed scene where not given.
    raw_closure : (n,) float64, optional
        Defects of the rows before they were repaired; those found where not given.
    centroid : (n, 3) float64, optional
        Where rows with area lie, in scene units; None where that is not known.

    Raises
    ------
    ValueError
        Where the shapes do not fit together.

    Examples
    --------
    >>> import numpy as np
    >>> from radiosity import FormFactors
    >>> F = FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.array([1.0, 2.0]))  # A_i F_ij, A_i
    >>> F @ np.array([3.0, 4.0])
    array([4. , 1.5])
    """

    def __init__(
        self,
        exchange: np.ndarray,
        area: np.ndarray,
        error: np.ndarray | None = None,
        openness: Openness | None = None,
        raw_closure: np.ndarray | None = None,
        centroid: np.ndarray | None = None,
    ):
        n = len(area)
        self.exchange = exchange
        self.area = area
        self.error = np.zeros((n, n), np.float32) if error is None else error
        self.openness = Openness.closed(n) if openness is None else openness
        self._raw_closure = raw_closure
        self.centroid = centroid
        for name, array in (("exchange", self.exchange), ("error", self.error)):
            if array.shape != (n, n):
                raise ValueError(
                    f"{name} has shape {array.shape}, but must be {(n, n)}: a row and a column "
                    f"for each of the {n} areas"
                )
        super().__init__(np.float64, (n, n))

    def replaced(self, **parts) -> "FormFactors":
        """Return the same factors with other ``parts``, named as when they were made."""
        same = {
            "exchange": self.exchange, "area": self.area, "error": self.error,
            "openness": self.openness, "raw_closure": self._raw_closure, "centroid": self.centroid,
        }  # fmt: skip
        return FormFactors(**same | parts)

    def save(self, path: str | PathLike, format: str | None = None) -> None:
        """Write them to a file: see `radiosity.transport.store.save_factors`.

        Examples
        --------
        >>> import radiosity
        >>> F = radiosity.form_factors("scenes/cornell_box.obj", accuracy=0.01)
        >>> F.save("F.npz")
        >>> bool((radiosity.FormFactors.load("F.npz").toarray() == F.toarray()).all())
        True
        """
        from radiosity.transport.store import save_factors  # which imports this module

        save_factors(self, path, format)

    @staticmethod
    def load(path: str | PathLike, format: str | None = None) -> "FormFactors":
        """Read what `save` wrote, or View3D: see `radiosity.transport.store.load_factors`.

        Examples
        --------
        >>> FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.ones(2)).save("two.npz")
        >>> FormFactors.load("two.npz").toarray().tolist()
        [[0.0, 1.0], [1.0, 0.0]]
        """
        from radiosity.transport.store import load_factors  # which imports this module

        return load_factors(path, format)

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        return self._per_area(self.exchange @ x)

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matmat(x.reshape(-1, 1)).reshape(x.shape)

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        return self.exchange @ self._per_area(x)

    def _rmatvec(self, x: np.ndarray) -> np.ndarray:
        return self._rmatmat(x.reshape(-1, 1)).reshape(x.shape)

    def _per_area(self, x):
        """Divide rows by their area; rows without area stay 0."""
        return x / np.where(self.area > 0, self.area, 1.0)[:, None]

    def toarray(self) -> np.ndarray:
        """Return F as an (n, n) array; F[i, j] is the fraction leaving i that arrives at j."""
        return self._per_area(self.exchange)

    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a matrix and (n,) divisors of its rows whose quotient is F."""
        return self.exchange, self.area

    @property
    def weight(self) -> np.ndarray:
        """Return (n,) what a coefficient's radiosity is worth: the area of its patch."""
        return self.area

    @property
    def loss(self) -> np.ndarray:
        """Return (n,) shares of a row's light that arrive at no row: 1 - its sum."""
        return np.where(self.exposed, self.openness.share - self.closure, 0.0)

    def row_sums(self) -> np.ndarray:
        """Return (n,): what of a patch's light arrives anywhere; 1 in a closed scene."""
        return self._per_area(self.exchange.sum(axis=1, keepdims=True))[:, 0]

    @property
    def environment(self) -> np.ndarray:
        """Return (n,) factors from the rows to what lies outside the scene."""
        return self.openness.share - self.openness.absorbed

    @property
    def is_closed(self) -> bool:
        """Whether no row sees the outside."""
        return not np.any(self.environment > 0)

    @property
    def exposed(self) -> np.ndarray:
        """Return (n,) bool: rows with area that see anything at all."""
        return (self.area > 0) & (self.exchange.any(axis=1) | (self.openness.share > 0))

    @property
    def sealed(self) -> np.ndarray:
        """Return (k,) int: the rows that see nothing, whose light goes nowhere."""
        return np.flatnonzero(~self.exposed)

    @property
    def closure(self) -> np.ndarray:
        """Return (n,) defects: row sum + openness.share - 1 of exposed rows, 0 of sealed ones."""
        return np.where(self.exposed, self.row_sums() + self.openness.share - 1.0, 0.0)

    @property
    def raw_closure(self) -> np.ndarray:
        """Return (n,) defects of the rows before they were repaired."""
        return self.closure if self._raw_closure is None else self._raw_closure

    @property
    def reciprocity(self) -> float:
        """Return the largest |A_i F_ij - A_j F_ji| as a share of the largest A_i F_ij."""
        g, largest, unequal = self.exchange, 0.0, 0.0
        for rows in (slice(a, a + 256) for a in range(0, len(g), 256)):
            largest = max(largest, np.abs(g[rows]).max(initial=0.0))
            unequal = max(unequal, np.abs(g[rows] - g[:, rows].T).max(initial=0.0))
        return float(unequal / (largest or 1.0))

    def row_errors(self) -> np.ndarray:
        """Return (n,): the estimated sum over j of |error of F_ij|."""
        return self._per_area(self.error.sum(axis=1, dtype=np.float64, keepdims=True))[:, 0]

    def grouped(self, labels: np.ndarray, count: int | None = None) -> "FormFactors":
        """Return the factors between groups of rows, such as the surfaces that patches belong to.

        F_gh = sum over i in g and j in h of A_i F_ij / sum over i in g of A_i.

        Parameters
        ----------
        labels : (n,) int
            Group of each row, from 0; a row with a negative label is left out, and with it what
            others send there.
        count : int, optional
            How many groups there are; one more than the largest label if not given.

        Returns
        -------
        FormFactors
            Exchange areas, areas and errors summed (errors by magnitude, so never too small);
            openness and centroids averaged by area. A group that sees itself has F_gg > 0.

        Raises
        ------
        ValueError
            Where the labels are not one whole number for each row, below ``count`` or, where that
            is not given, below the number of rows.
        """
        labels = np.asarray(labels)
        if labels.shape != self.area.shape or labels.dtype.kind not in "iu":
            raise ValueError(
                f"labels are {labels.dtype} {labels.shape}, but must be one whole number a row, "
                f"int {self.area.shape}"
            )
        groups = len(labels) if count is None else count
        if labels.max(initial=-1) >= groups:
            raise ValueError(
                f"labels go up to {labels.max()}, but must be below {groups}, the number of "
                f"{'rows' if count is None else 'groups'}: number the groups 0, 1, 2 .. by "
                "np.unique(labels, return_inverse=True)[1]"
            )
        members = _membership(labels, count)
        area = members @ self.area
        mean = 1.0 / np.where(area > 0, area, 1.0)

        def averaged(x):
            return ((members @ (self.area * np.transpose(x)).T).T * mean).T

        return FormFactors(
            _pooled(self.exchange, members),
            area,
            _pooled(self.error, members).astype(np.float32),
            Openness(*(averaged(x) for x in astuple(self.openness))),
            averaged(self.raw_closure),
            None if self.centroid is None else averaged(self.centroid),
        )


def _membership(labels, count):
    """Return the sparse (g, n) matrix that sums rows over their groups."""
    rows = np.flatnonzero(labels >= 0)
    groups = int(labels.max(initial=-1)) + 1 if count is None else count
    return csr_array((np.ones(len(rows)), (labels[rows], rows)), shape=(groups, len(labels)))


def _pooled(matrix, members):
    """Return the (g, g) sums of a symmetric matrix over groups of its rows and columns."""
    pooled = members @ np.ascontiguousarray((members @ matrix).T)
    return (pooled + pooled.T) / 2
