"""The radiosity system B = M_e + rho F B, with what sheets and chains add (E7, E20, E23)."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

from radiosity.mesh.elements import Elements, from_other_side
from radiosity.solve.system import Terms
from radiosity.transport.linear import LinearFactors
from radiosity.transport.operator import FormFactors

if TYPE_CHECKING:
    from radiosity.transport.chains import Chains


@dataclass(frozen=True)
class Sheets:
    """What goes through translucent sheets.

    Attributes
    ----------
    transmittance : (m, bands) float64
        tau of the patch that a coefficient belongs to.
    across : (m, m) csr_array
        Coefficients of a field as seen from the other side of each patch.
    """

    transmittance: np.ndarray
    across: csr_array

    def spread(self, rows: np.ndarray, n: int) -> "Sheets":
        """Return the same for n coefficients of which these are the ``rows`` (m,)."""
        put = csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(n, len(rows)))
        return Sheets(put @ self.transmittance, put @ self.across @ put.T)

    def grouped(self, labels: np.ndarray, area: np.ndarray, n: int) -> "Sheets":
        """Return the same for n groups of patches of areas (m,), each of one value."""
        put = csr_array((np.ones(len(labels)), (np.arange(len(labels)), labels)))
        share = area / np.bincount(labels, area, n)[labels]
        mean = csr_array((share, (labels, np.arange(len(labels)))))
        return Sheets(mean @ self.transmittance, mean @ self.across @ put)

    def asked(self, importance: np.ndarray, band: int) -> np.ndarray:
        """Return (k, m): how rows p of importances of what comes through weigh what arrives."""
        return (self.across.T @ (importance * self.transmittance[:, band]).T).T

    def passed(self, e: np.ndarray) -> np.ndarray:
        """Return the coefficients (m, bands) of what comes through of irradiances e."""
        return self.transmittance * (self.across @ e)


@dataclass(frozen=True)
class System:
    """B = M_e + rho F B for m coefficients, in bands; with sheets B = M_e + (rho + tau P) F B.

    With chains F + X takes the place of F.

    Attributes
    ----------
    factors : FormFactors or LinearFactors
    reflectance : (m, bands) float64
        rho of the patch that a coefficient belongs to.
    absorptance : (m, bands) float64
        1 - rho, given by itself so that it keeps its digits near rho = 1.
    source : (m, bands) float64
        M_e, and what is reflected of the light that enters from outside.
    sheets : Sheets, optional
    chains : Chains, optional
    """

    factors: FormFactors | LinearFactors
    reflectance: np.ndarray
    absorptance: np.ndarray
    source: np.ndarray
    sheets: Sheets | None = None
    chains: "Chains | None" = None

    @property
    def is_plain(self) -> bool:
        """Whether the same matrix carries the light of all bands, and rho alone scatters it."""
        return self.sheets is None and self.chains is None

    @property
    def laws(self) -> np.ndarray:
        """Return (k, bands) numbers that tell bands apart whose light is not treated alike."""
        laws = [self.reflectance, self.absorptance]
        if self.chains is not None:
            laws.append(self.chains.which[None].astype(float))
        if self.sheets is not None:
            laws.append(self.sheets.transmittance)
        return np.concatenate(laws)

    @property
    def margin(self) -> float:
        """Return min_i (1 - rho_i sum_j F_ij): what an error loses at least at each bounce."""
        if self.chains is not None:
            return self._margin_of_chains()
        loss = self.factors.loss[:, None]
        left = self.absorptance + self.reflectance * loss
        if self.sheets is not None:
            through = np.minimum(abs(self.sheets.across) @ loss, 1.0)
            left = left + self.sheets.transmittance * through
        return float(left.min(initial=1.0))

    def _margin_of_chains(self) -> float:
        """Return the margin where light arrives by way of mirrors: bounces as irradiances fade.

        An error of B grows by 1 + max rho |G| / (1 - |G rho|), G = F + X, at most.
        """
        n, margin = len(self.factors.area), 1.0
        matrix, area = self.factors.rows()
        direct = np.abs(matrix[:n, :n]) / np.where(area > 0, area, 1.0)[:n, None]
        for k in np.unique(self.chains.which):
            g = direct + np.abs(self.chains.matrix[k, :n, :n])
            rho = self.reflectance[:n, self.chains.which == k].max(axis=1, initial=0.0)
            left = 1.0 - np.max(g @ rho, initial=0.0)
            if left <= 0.0:
                return 0.0
            gain = 1.0 + rho.max(initial=0.0) * np.max(g.sum(axis=1), initial=0.0) / left
            margin = min(margin, 1.0 / gain)
        return margin

    def arriving(self, b: np.ndarray) -> np.ndarray:
        """Return the irradiances (m, bands) that radiosities cause."""
        e = self.factors @ b
        return e if self.chains is None else e + self.chains.arriving(b)

    def scattered(self, e: np.ndarray) -> np.ndarray:
        """Return what irradiances (m, bands) make patches send: reflected, and come through."""
        sent = self.reflectance * e
        return sent if self.sheets is None else sent + self.sheets.passed(e)

    def of_bands(self, bands: np.ndarray | slice) -> "System":
        """Return the equations of some bands."""
        parts = (x[:, bands] for x in (self.reflectance, self.absorptance, self.source))
        sheets = self.sheets and replace(
            self.sheets, transmittance=self.sheets.transmittance[:, bands]
        )
        chains = self.chains and self.chains.of_bands(bands)
        return System(self.factors, *parts, sheets, chains)

    def residual(self, b: np.ndarray) -> np.ndarray:
        """Return M_e + rho F B - B."""
        return self.source + self.scattered(self.arriving(b)) - b

    def bound(
        self, b: np.ndarray, residual: np.ndarray | None = None, gain: np.ndarray | None = None
    ) -> float:
        """Return the bound of the largest error in B of any band, relative to its largest B.

        ``gain`` (bands,) is by how much errors may exceed residuals, at most 1 / `margin`.
        """
        residual = self.residual(b) if residual is None else residual
        worst, largest = (np.abs(x).max(axis=0, initial=0.0) for x in (residual, b))
        if not np.any(worst):
            return 0.0
        if gain is None:
            gain = 1.0 / self.margin if self.margin > 0.0 else np.inf
        return float(np.max(gain * worst / np.where(largest > 0.0, largest, 1.0)))


def sheets_of(terms: Terms, elements: Elements, rows: np.ndarray) -> Sheets:
    """Return what goes through the patches ``rows``, of these elements."""
    place = np.full(len(terms.twin) + 1, -1)
    place[rows] = np.arange(len(rows))
    across = from_other_side(elements, place[terms.twin[rows]])
    return Sheets(np.tile(terms.transmittance[rows], (elements.width, 1)), across)
