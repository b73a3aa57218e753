"""What a report says in words: what no figure shows, what errors mean, what terms stand for."""

from typing import TYPE_CHECKING

from radiosity.light.bands import RGB
from radiosity.scene.model import Scene

if TYPE_CHECKING:
    from radiosity.view.report.figures import Error

TERMS = {
    "illuminance E": "luminous flux that falls on a surface, per area; lx = lm/m²",
    "luminance L": "luminous flux that leaves per projected area and solid angle; cd/m²",
    "luminous flux": "power weighted by the eye; lm",
    "luminous intensity I": "luminous flux per solid angle, of a point-like light; cd = lm/sr",
    "reflectance ρ": "share of the incident light that is reflected, here of the diffuse part, "
    "weighed by the eye under neutral light",
    "radiosity B": "all that leaves a surface per area, emitted and reflected; W/m²",
    "U0": "uniformity: smallest over mean illuminance of the points",
    "Ud": "diversity: smallest over largest illuminance of the points",
    "isolux line": "line of equal illuminance",
    "patch": "a cell of the mesh that light is exchanged between",
    "± (error bar)": "what at least 95 % of the errors stay below, as estimated by comparing two "
    "solutions of known order; it tells the error of the computation for the scene as described, "
    "not how well the description fits the building",
}


def left_out(scene: Scene) -> tuple[str, ...]:
    """Return what is not modelled at all, of a scene like this one."""
    found = []
    if scene.lights:
        found.append(
            "Size and body of luminaires: abstract lights are points. They cast no shadows and "
            "reflect nothing; nearer than about five times its size a real luminaire differs."
        )
    if scene.ambient.any():
        found.append(
            "Sky and sun as they are: light from outside is the same from all directions, but for "
            "directional lights."
        )
    else:
        found.append("Daylight: no light comes from outside, but from lights of the scene.")
    if scene.bands is RGB:
        found.append("Spectra: colours are three bands, red, green and blue.")
    found += [
        "Maintenance: the values are of new lamps and clean surfaces (maintenance factor 1).",
        "Glare (UGR), flicker, electrical power and energy are not evaluated.",
        "Polarisation, interference, diffraction, fluorescence, and scattering or absorption by "
        "air.",
        "Furniture, people and whatever else the scene does not hold.",
    ]
    return tuple(found)


def error_words(error: "Error") -> list[str]:
    """Return in sentences what accuracy was asked, what was reached, and what that means."""
    if error.asked is None:
        first = "The best answer within a given time was asked for"
    elif error.aimed:
        first = f"An error of at most {percent(error.asked)} was asked for"
    else:
        first = "The mesh was given, so no accuracy could be aimed at"
    met = ""
    if error.asked is not None and error.aimed:
        met = ", as asked" if error.reached <= error.asked else ": NOT what was asked"
    said = [
        f"{first}; {percent(error.reached)} is estimated to be reached{met}.",
        "That is the 95th percentile over all lit surfaces of the error of the illuminance at a "
        "point, relative to the illuminance there or, where that is less, to a tenth of the mean.",
        f"Of it the mesh causes {percent(error.mesh)}, form factors and rays "
        f"{percent(error.factors)}, and the solver {percent(error.solver)}; they do not "
        "add up, as they seldom fall on the same places.",
    ]
    if error.truth is not None:
        said.append(
            f"The scene carries its own answer: the radiosity differs from it by "
            f"{percent(error.truth)}; it is stated to hold to {percent(error.stated)}."
        )
    return said


def percent(share: float) -> str:
    """Return a share in percent of two digits."""
    return "under 0.001 %" if 0.0 < share < 1e-5 else f"{100 * share:.2g} %"
