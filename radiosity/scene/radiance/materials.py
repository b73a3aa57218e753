"""Radiance's materials as tables of a scene file; docs/files.md gives the formulas and reasons."""

from collections.abc import Callable

import numpy as np

from radiosity.light.photometry import EFFICACY, luminance
from radiosity.scene.radiance.text import Primitive
from radiosity.scene.wavefront.tables import SHARPEST
from radiosity.scene.weak import WEAK

RADIANCE_EFFICACY = 179.0  # lm/W of its white
RADIANCE_LUMINANCE = np.array([0.265, 0.670, 0.065])
GLASS = 1.52  # index of refraction where glass gives none
NOTHING = "antimatter", "mist"  # what marks volumes and is no surface
EMITTERS = "light", "glow", "illum", "spotlight"


class MaterialError(ValueError):
    """Arguments that make no material."""


def radiance_of(rgb) -> np.ndarray:
    """Return the radiance (3,) in W/(m2 sr) of linear sRGB that Radiance's own (3,) stands for.

    Its channels are kept in proportion and have the same luminance,
    179 (0.265 R + 0.670 G + 0.065 B) = 683 (0.2126 r + 0.7152 g + 0.0722 b).

    Examples
    --------
    >>> radiance_of([1.0, 1.0, 1.0]).round(4).tolist()
    [0.2621, 0.2621, 0.2621]
    """
    rgb = np.asarray(rgb, float)
    ours = EFFICACY * luminance(rgb)
    return rgb * (RADIANCE_EFFICACY * (RADIANCE_LUMINANCE @ rgb) / ours) if ours > 0 else 0.0 * rgb


def table_of(said: Primitive) -> tuple[dict, list[str]]:
    """Return the table that a material becomes, and notes.

    Raises
    ------
    MaterialError
        Too few or impossible arguments.

    Examples
    --------
    >>> table_of(Primitive(1, "void", "plastic", "wall", (), (0.5, 0.4, 0.3, 0.0, 0.0)))[0]
    {'diffuse': [0.5, 0.4, 0.3]}
    """
    make, least = MAKERS[said.kind]
    if len(said.reals) < least:
        raise MaterialError(f"needs at least {least} numbers, found {len(said.reals)}")
    notes = []
    return make(said, notes), notes


def _share(said, low, high, notes):
    """Return some of the arguments as shares of light, cut to [0, 1]."""
    given = np.array(said.reals[low:high])
    cut = np.clip(given, 0.0, 1.0)
    if (given != cut).any():
        notes.append("shares of light outside [0, 1] are cut")
    return cut


def _radiant(said, notes):
    given = np.array(said.reals[:3])
    if (given < 0).any():
        notes.append("negative radiance is taken as 0")
    return radiance_of(np.maximum(given, 0.0))


def _finish(colour, specular, roughness, tinted, notes):
    """Return base (3,), and the lobe or mirror, of a share of specular reflection."""
    share = specular * (colour if tinted else np.ones(3))
    base = colour * (1.0 - specular)
    if not share.any():
        return base, {}
    if share.max() <= WEAK:
        notes.append(f"specular reflection up to {WEAK:g} counts as diffuse")
        return base + share, {}
    if roughness < SHARPEST:
        return base, {"mirror": share.tolist()}
    return base, {
        "specular": {
            "model": "torrance-sparrow", "facets": "beckmann", "roughness": min(roughness, 1.0),
            "reflectance": share.tolist(),
        }  # fmt: skip
    }


def _opaque(said, notes):
    """Return plastic and metal: base C (1 - s), highlight s, of metal s C."""
    colour, specular = _share(said, 0, 3, notes), float(_share(said, 3, 4, notes)[0])
    tinted = said.kind.startswith("met")
    base, optics = _finish(colour, specular, _roughness(said, notes), tinted, notes)
    return {"diffuse": base.tolist(), **optics}


def _roughness(said, notes):
    if said.kind.endswith("2"):
        notes.append(f"{said.kind}: the mean roughness is taken in all directions")
        return float(np.sqrt(abs(said.reals[4] * said.reals[5])))
    if said.kind.endswith(("func", "data")):
        notes.append(f"{said.kind}: its function is left out, specular reflection is a mirror's")
        return 0.0
    return abs(said.reals[4])


def _trans(said, notes):
    """Return a translucent sheet: of C (1 - s) a share t goes through, of that a share straight."""
    first = {"trans": 5, "trans2": 6}.get(said.kind, 4)
    colour, specular = _share(said, 0, 3, notes), float(_share(said, 3, 4, notes)[0])
    through, straight = _share(said, first, first + 2, notes)
    roughness = _roughness(said, notes)
    base, optics = _finish(colour, specular, roughness, False, notes)
    sent = colour * (1.0 - specular) * through
    clear = sent * straight
    if clear.max() <= WEAK:
        clear = np.zeros(3)
    elif roughness > SHARPEST:
        notes.append("what goes through without being scattered evenly goes straight on")
    table = {"diffuse": (base - sent).tolist(), **optics}
    if (sent - clear).any():
        table["translucent"] = (sent - clear).tolist()
    return table | ({"transmit": clear.tolist()} if clear.any() else {})


def _glass(said, notes):
    """Return a pane, at normal incidence: T = t (1 - r)^2/(1 - t^2 r^2), R = r + r t (1 - r) T/...

    With t the transmissivity of one passage and r = ((n - 1)/(n + 1))^2 of one surface; all
    reflections between the faces are summed.
    """
    index = max(said.reals[3], 1.0) if len(said.reals) > 3 else GLASS
    t, r = _share(said, 0, 3, notes), ((index - 1.0) / (index + 1.0)) ** 2
    inside = (1.0 - r) ** 2 / (1.0 - (t * r) ** 2)
    through, back = t * inside, r + r * t**2 * inside
    table = {"diffuse": 0.0}
    shares = (back, "mirror", "diffuse"), (through, "transmit", "translucent")
    for value, key, scattered in shares:
        weak = 0.0 < value.max() <= WEAK
        if value.any():
            table[scattered if weak else key] = value.tolist()
        if weak:
            notes.append(f"glass: up to {WEAK:g} of light counts as scattered")
    return table


def _dielectric(said, notes):
    """Return a clear body; what is left of light after a metre is given."""
    index = said.reals[3]
    if said.kind == "interface":
        notes.append("interface: the index of its inside over that of its outside is taken")
        index = max(said.reals[3] / said.reals[7], 1.0) if said.reals[7] > 0 else 1.0
    if not 1.0 <= index <= 100.0:
        raise MaterialError(f"has the index of refraction {index:g}, it must lie in [1, 100]")
    left = np.maximum(_share(said, 0, 3, notes), 1e-12)
    table = {"diffuse": 0.0, "mirror": "fresnel", "transmit": "fresnel", "ior": index}
    if len(said.reals) > 4 and said.reals[4] and said.kind == "dielectric":
        notes.append("dielectric: dispersion (Hartmann's constant) is left out")
    return table | ({"absorption": (-np.log(left)).tolist()} if (left < 1.0).any() else {})


def _mirror(said, notes):
    return {"diffuse": 0.0, "mirror": _share(said, 0, 3, notes).tolist()}


def _light(said, notes):
    """Return a lamp, which reflects nothing."""
    radiance = _radiant(said, notes)
    if said.kind == "spotlight":
        cone = 2.0 * np.pi * (1.0 - np.cos(np.radians(min(abs(said.reals[3]), 360.0) / 2.0)))
        notes.append("spotlight: its flux is sent out evenly, not in a cone")
        radiance = radiance * min(cone / np.pi, 1.0)
    if said.kind == "glow" and len(said.reals) > 3 and said.reals[3]:
        notes.append("glow: the radius that bounds its light is left out")
    if said.kind == "illum":
        notes.append("illum: taken as a lamp")
    if (radiance > 1e30).any():
        raise MaterialError("is brighter than 1e+30 W/(m2 sr)")
    return {"diffuse": 0.0, "emission": {"radiance": radiance.tolist()}}


def _ashik2(said, notes):
    notes.append("ashik2: the mean exponent is taken in all directions")
    base, share = _share(said, 0, 3, notes), _share(said, 3, 6, notes)
    share = np.minimum(share, 1.0 - base)
    if share.max() <= WEAK:
        return {"diffuse": (base + share).tolist()}
    exponent = min(float(np.sqrt(abs(said.reals[6] * said.reals[7]))), 1e9)
    lobe = {"model": "blinn", "reflectance": share.tolist(), "exponent": exponent}
    return {"diffuse": base.tolist(), "specular": lobe}


def _by_function(said, notes):
    """Return what its diffuse arguments say of a material that functions describe."""
    notes.append(f"{said.kind}: only its diffuse reflection and transmission are read")
    shares = [_share(said, k, k + 3, notes) for k in (0, 3, 6)]
    front, back, through = (x if len(x) == 3 else np.zeros(3) for x in shares)
    if not (front.any() or back.any() or through.any()):
        notes.append(f"{said.kind}: without them it is taken to reflect 0.5")
        return {"diffuse": 0.5}
    most = float(np.max(front + through))
    scale = 1.0 / most if most > 1.0 else 1.0
    if (front != back).any():
        notes.append(f"{said.kind}: the back is taken to reflect as the front does")
    table = {"diffuse": (front * scale).tolist()}
    return table | ({"translucent": (through * scale).tolist()} if through.any() else {})


def _prism(said, notes):
    notes.append(f"{said.kind}: light goes straight through, unbent")
    return {"diffuse": 0.0, "transmit": 0.9}


MAKERS: dict[str, tuple[Callable, int]] = {
    "plastic": (_opaque, 5), "metal": (_opaque, 5), "plastic2": (_opaque, 6),
    "metal2": (_opaque, 6), "plasfunc": (_opaque, 4), "metfunc": (_opaque, 4),
    "plasdata": (_opaque, 4), "metdata": (_opaque, 4), "trans": (_trans, 7), "trans2": (_trans, 8),
    "transfunc": (_trans, 6), "transdata": (_trans, 6), "glass": (_glass, 3),
    "dielectric": (_dielectric, 4), "interface": (_dielectric, 8), "mirror": (_mirror, 3),
    "light": (_light, 3), "glow": (_light, 3), "illum": (_light, 3), "spotlight": (_light, 4),
    "ashik2": (_ashik2, 8), "BRTDfunc": (_by_function, 0), "WGMDfunc": (_by_function, 0),
    "BSDF": (_by_function, 0), "aBSDF": (_by_function, 0), "prism1": (_prism, 0),
    "prism2": (_prism, 0),
}  # fmt: skip
