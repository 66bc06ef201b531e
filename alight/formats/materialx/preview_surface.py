"""``UsdPreviewSurface``, in networks of MaterialX, -> `principled`.

Source: Pixar, "UsdPreviewSurface specification", version 2.6.
"""

from __future__ import annotations

from alight.formats.materials.surfaces import Surface, is_metal, reflection
from alight.formats.materials.textures import cut
from alight.formats.materialx.shading import Data, Shading, is_zero
from alight.formats.materialx.values import Plain

#: Inputs with their defaults.
INPUTS: dict[str, float | tuple[float, ...]] = {
    "diffuseColor": (0.18,) * 3, "emissiveColor": (0.0,) * 3, "useSpecularWorkflow": 0.0,
    "specularColor": (0.0,) * 3, "metallic": 0.0, "roughness": 0.5, "clearcoat": 0.0,
    "clearcoatRoughness": 0.01, "opacity": 1.0, "opacityMode": 0.0, "opacityThreshold": 0.0,
    "ior": 1.5, "displacement": 0.0, "occlusion": 1.0,
}  # fmt: skip


def read(s: Shading) -> Surface:
    """Read a shader."""
    get = {name: s.value(name, default) for name, default in INPUTS.items()}
    bent = s.normals("normal", is_tangent=True)
    core: Data = {
        "type": "principled",
        "base_color": s.color("diffuseColor", get["diffuseColor"]),
        "roughness": s.number("roughness", get["roughness"]),
    }
    if s.flag("useSpecularWorkflow"):
        core |= _specular(s, core)
    else:
        core["metallic"] = s.number("metallic", get["metallic"])
        core["ior"] = s.ior("ior")
    if not is_zero(get["clearcoat"]):
        core["clearcoat"] = s.number("clearcoat", get["clearcoat"])
        core["clearcoat_roughness"] = s.number("clearcoatRoughness", get["clearcoatRoughness"])
    s.left_out("surfaces stay where they are", displacement=0.0)
    opacity = s.number("opacity", get["opacity"])
    threshold = s.constant("opacityThreshold", 0.0)
    if threshold > 0.0:
        opacity = cut(opacity, threshold)
    elif opacity != 1.0 and is_zero(get["opacityMode"]):
        s.say("opacity: rays pass straight through, reflections included")
    emission = s.emission("emissiveColor", get["emissiveColor"], Plain((1.0,)))
    return s.finished(core, bent, opacity, emission)


def _specular(s: Shading, core: Data) -> Data:
    """The workflow with a colour of what is reflected straight on: dielectric or metal."""
    color = s.color("specularColor", s.value("specularColor", 0.0))
    if isinstance(color, dict):
        s.say("specularColor is a texture: taken for the colour of reflection")
        return {"ior": 1.5, "specular_color": color}
    if max(color) <= 0.0:
        return {"specular": 0.0}
    if is_metal(core["base_color"], color):
        return {"metallic": 1.0, "base_color": color}
    found = reflection(color)
    if found.is_weaker:
        s.say(f"specularColor: at most {found.strength:.3g} is reflected straight on")
    return {"ior": found.ior, "specular_color": [min(part, 1.0) for part in found.tint]}
