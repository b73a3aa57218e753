"""What of a scene's looks a page is given as pictures, and what it says that it leaves out."""

import numpy as np

from radiosity.light.texture import Mixed
from radiosity.scene.model import Material, Scene

MATTE = {
    "mirror": "mirror images", "specular": "highlights and gloss",
    "transmit": "what clear bodies bend", "bump": "relief",
}  # fmt: skip


def picture_of(material: Material) -> tuple[np.ndarray, bool]:
    """Return a material's texture (h, w, 3), linear, over its mean; and whether it repeats."""
    texture = material.texture
    picture = texture.picture if isinstance(texture, Mixed) else texture
    texels = np.broadcast_to(picture.texels.astype(float)[..., :3], (*picture.texels.shape[:2], 3))
    return texels / np.maximum(texels.mean(axis=(0, 1)), 1e-12), picture.repeat


def not_shown(scene: Scene) -> str:
    """Return in words what a page leaves out of how a scene looks."""
    used = [scene.materials[k] for k in np.unique(scene.faces.material)]
    shiny = []
    for kind, word in MATTE.items():
        names = [m.name for m in used if getattr(m, kind) is not None]
        if names:
            shiny.append(f"{word} ({', '.join(names)})")
    lamps = ["lamps, which cameras do not see either"] if scene.lights else []
    if not shiny and not lamps:
        return "Nothing is left out: all surfaces are matte."
    matte = "What shines or is clear is shown matte, as bright as it is on the whole. "
    return (matte if shiny else "") + f"Not shown: {'; '.join(shiny + lamps)}."
