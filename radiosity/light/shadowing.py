"""Shadowing and masking: the share G of facets that both the light and the eye reach.

G comes divided by (N.L)(N.V), as it always occurs, so that no cosine is divided by that may be 0.
``light`` = N.L > 0, ``view`` = N.V > 0, ``across`` = V.H = L.H and ``half`` = N.H are cosines.
"""

import numpy as np

_TINY = 1e-150  # whose square can still be divided by


def v_groove(facets, light, view, across, half):
    """Return G/((N.L)(N.V)), G = min(1, 2(N.H)(N.V)/(V.H), 2(N.H)(N.L)/(V.H)).

    The facets are the two sides of symmetric grooves, whatever their distribution. *Torrance &
    Sparrow (1967)*; Blinn (1977); eq. 3.51.
    """
    lower, higher = np.minimum(light, view), np.maximum(light, view)
    return np.minimum(1.0 / np.maximum(lower, _TINY), 2.0 * half / np.maximum(across, _TINY)) / (
        np.maximum(higher, _TINY)
    )


def smith(facets, light, view, across, half):
    """Return G/((N.L)(N.V)), G = 1/(1 + Lambda(L) + Lambda(V)), of facets in no order.

    With P = cos(theta)(1 + Lambda) the area of the facets' fronts seen under theta, it is
    1/((N.L) P(V) + (N.V) P(L) - (N.L)(N.V)): facets as high as others hide less from both
    directions than they would on their own. *Smith (1967)*; Heitz (2014), "Understanding the
    masking-shadowing function in microfacet-based BRDFs".
    """
    both = light * facets.hidden(view) + view * facets.hidden(light) + light * view
    return 1.0 / np.maximum(both, _TINY)


SHADOWING = {"v-groove": v_groove, "smith": smith}
