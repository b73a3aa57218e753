"""The form-factor matrix as a linear operator."""

import numpy as np
from scipy.sparse.linalg import LinearOperator


class FormFactors(LinearOperator):
    """F as a linear operator: ``F @ B`` is the irradiance that radiosities B cause.

    Parameters
    ----------
    exchange : (n, n) float64
        Symmetric exchange areas A_i F_ij.
    area : (n,) float64
    """

    def __init__(self, exchange: np.ndarray, area: np.ndarray):
        super().__init__(np.float64, exchange.shape)
        self.exchange = exchange
        self.area = area

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        return (self.exchange @ x) / self.area[:, None]

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matmat(x.reshape(-1, 1)).reshape(x.shape)

    def toarray(self) -> np.ndarray:
        """Return F as an (n, n) array; F[i, j] is the fraction leaving i that arrives at j."""
        return self.exchange / self.area[:, None]

    def row_sums(self) -> np.ndarray:
        """Return (n,): what of a patch's light arrives anywhere; 1 in a closed scene."""
        return self.exchange.sum(axis=1) / self.area
