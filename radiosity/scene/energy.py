"""Whether a material returns more light than arrives, at any angle and in any band."""

import numpy as np

from radiosity.light.coat import is_coat, layered

ROUNDING = 1e-9  # by which shares may add up to more than 1, as decimals are not exact
DEGREES = np.append(np.arange(0.0, 89.6, 0.5), [89.8, 89.9, 90.0])


def excess(base, lobe, mirror, transmit, through=None, names="rgb", degrees=DEGREES) -> str:
    """Return how much too much leaves a surface as a sentence, "" where nothing is wrong.

    Parameters
    ----------
    base : (bands,) float64
        Share of light that is reflected evenly.
    lobe, mirror, transmit : object or None
        See `radiosity.scene.model.Material`. A lobe without an albedo, a seed's, is left out.
    through : (bands,) float64, optional
        Share of light that leaves the other side evenly.
    names : sequence of str
        Of the bands.
    degrees : (k,) float64
        Angles of incidence at which the sum is taken.
    """
    base = np.asarray(base)
    cosine = np.maximum(np.cos(np.radians(degrees)), 0.0)
    total = np.broadcast_to(base + (0.0 if through is None else through), (len(cosine), len(base)))
    named = {"mirror": mirror, "specular": lobe, "transmit": transmit}
    parts = {k: v for k, v in named.items() if hasattr(v, "albedo")}
    for name, part in parts.items():  # a lobe lies on a mirror, and both on the base
        total = layered(total, part.albedo(cosine), is_coat(part) and name != "transmit")
    where, band = np.unravel_index(np.argmax(total), total.shape)
    if total[where, band] <= 1.0 + ROUNDING:
        return ""
    said = ["diffuse", *([] if through is None else ["translucent"]), *parts]
    return (
        f"{' + '.join(said)} = {total[where, band]:.6g} at {degrees[where]:g} "
        f"degrees in band {names[band]} must be at most 1: a surface cannot reflect more than it "
        "receives; lower one of them"
    )
