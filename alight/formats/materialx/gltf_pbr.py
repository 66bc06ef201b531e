"""``gltf_pbr`` -> `principled`, which has glTF's parameters.

Source: Khronos Group, glTF 2.0, appendix B; the node graph of MaterialX's library, whose defaults
these are.
"""

from __future__ import annotations

from alight.formats.materials.surfaces import Surface
from alight.formats.materials.textures import cut
from alight.formats.materialx.shading import Data, Shading, is_zero
from alight.formats.materialx.values import Plain

#: Inputs with their defaults.
INPUTS: dict[str, float | tuple[float, ...]] = {
    "base_color": (1.0,) * 3, "metallic": 1.0, "roughness": 1.0, "occlusion": 1.0,
    "transmission": 0.0, "specular": 1.0, "specular_color": (1.0,) * 3, "ior": 1.5, "alpha": 1.0,
    "alpha_mode": 0.0, "alpha_cutoff": 0.5, "iridescence": 0.0, "iridescence_ior": 1.3,
    "iridescence_thickness": 100.0, "sheen_color": (0.0,) * 3, "sheen_roughness": 0.0,
    "clearcoat": 0.0, "clearcoat_roughness": 0.0, "emissive": (0.0,) * 3,
    "emissive_strength": 1.0, "thickness": 0.0, "attenuation_distance": 0.0,
    "attenuation_color": (1.0,) * 3, "anisotropy_strength": 0.0, "anisotropy_rotation": 0.0,
    "dispersion": 0.0,
}  # fmt: skip
_OPAQUE, _MASK = 0, 1


def read(s: Shading) -> Surface:
    """Read a shader."""
    get = {name: s.value(name, default) for name, default in INPUTS.items()}
    bent = s.normals("normal")
    core: Data = {
        "type": "principled",
        "base_color": s.color("base_color", get["base_color"]),
        "metallic": s.number("metallic", get["metallic"]),
        "roughness": s.number("roughness", get["roughness"]),
        "ior": s.ior("ior"),
        "specular": s.number("specular", get["specular"]),
        "specular_color": s.color("specular_color", get["specular_color"]),
    }
    if not is_zero(get["transmission"]):
        core["transmission"] = s.number("transmission", get["transmission"])
        core["thin"] = is_zero(get["thickness"])
        distance = s.constant("attenuation_distance", 0.0)
        if not core["thin"] and distance > 0.0:
            core["attenuation_distance"] = distance
            color = get["attenuation_color"]
            plain = color if isinstance(color, Plain) else Plain((1.0,) * 3)
            if plain is not color:
                s.say("attenuation_color must not vary: white is taken")
            core["attenuation_color"] = s.color("attenuation_color", plain)
        spread = s.constant("dispersion", 0.0)
        s.dispersion(core, 20.0 / spread if spread > 0.0 else 0.0)
    if not is_zero(get["clearcoat"]):
        core["clearcoat"] = s.number("clearcoat", get["clearcoat"])
        core["clearcoat_roughness"] = s.number("clearcoat_roughness", get["clearcoat_roughness"])
        core |= s.coat_normals("clearcoat_normal", s.normals("normal"))
    if not is_zero(get["sheen_color"]):
        core["sheen_color"] = s.color("sheen_color", get["sheen_color"])
        core["sheen_roughness"] = s.number("sheen_roughness", get["sheen_roughness"])
    if not is_zero(get["iridescence"]):
        core["iridescence"] = s.number("iridescence", get["iridescence"])
        core["iridescence_ior"] = s.ior("iridescence_ior", 1.3)
        core["iridescence_thickness"] = s.thickness(get["iridescence_thickness"])
    if not is_zero(get["anisotropy_strength"]):
        core["anisotropy"] = s.number("anisotropy_strength", get["anisotropy_strength"])
        core["anisotropy_rotation"] = s.constant("anisotropy_rotation", 0.0, -1e3, 1e3)
    s.asked |= {"tangent", "clearcoat_normal"}
    mode = int(s.constant("alpha_mode", _OPAQUE))
    opacity = 1.0 if mode == _OPAQUE else s.number("alpha", get["alpha"])
    if mode == _MASK:
        opacity = cut(opacity, s.constant("alpha_cutoff", 0.5))
    emission = s.emission("emissive", get["emissive"], get["emissive_strength"])
    return s.finished(core, bent, opacity, emission)
