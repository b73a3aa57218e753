"""Bumps: a surface's normal where small heights are laid over it."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.texture import Texture


@dataclass(frozen=True)
class Bump:
    """Heights over a surface, along its normal.

    Attributes
    ----------
    texture : Texture
        Of one band, dimensionless.
    height : float
        Length that a value of 1 stands for; negative for dents.

    Examples
    --------
    >>> wave = Texture(np.sin(2 * np.pi * (np.arange(256) + 0.5) / 256)[None, :, None])
    >>> Bump(wave, 0.01).slope(np.array([[1.0, 0.5]])).round(3).tolist()
    [[0.063, 0.0]]
    """

    texture: Texture
    height: float

    def slope(self, uv: np.ndarray) -> np.ndarray:
        """Return the derivatives (k, 2) of the height by u and v at texture coordinates (k, 2)."""
        return self.height * self.texture.slope(uv)[:, 0]


def tilt(normal, along_u, along_v, slope) -> np.ndarray:
    """Return what bumps add to unit normals (k, 3); the sums' lengths are not 1.

    N' - N = (B_u N x P_v - B_v N x P_u) / (N . P_u x P_v), the height's gradient on the surface,
    turned round (Blinn 1978, "Simulation of wrinkled surfaces", with |P_u x P_v| where u, v and N
    are right-handed). Heights count as small: the normal changes, the place does not.

    Parameters
    ----------
    normal : (k, 3) float64
        N.
    along_u, along_v : (k, 3) float64
        P_u and P_v, the derivatives of the place by u and v.
    slope : (k, 2) float64
        B_u and B_v, the derivatives of the height, a length.
    """
    turned = slope[:, :1] * np.cross(normal, along_v) - slope[:, 1:] * np.cross(normal, along_u)
    stretch = np.einsum("kc,kc->k", normal, np.cross(along_u, along_v))[:, None]
    return np.where(stretch == 0.0, 0.0, turned / np.where(stretch == 0.0, 1.0, stretch))
