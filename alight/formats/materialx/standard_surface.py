"""``standard_surface`` -> `principled`.

Coat, metal, specular, transmission and the diffuse base lie over each other as those of
`principled` do, and the coat's colour tints all that is below it, sheen and emission included.

Source: Georgiev et al., Autodesk Standard Surface, version 1.0.1 (2019), and the node graph of
MaterialX's library, whose defaults these are.
"""

from __future__ import annotations

import math

from alight.formats.materials.surfaces import Surface
from alight.formats.materialx.bodies import Below, body_of
from alight.formats.materialx.shading import Data, Shading, is_one, is_zero
from alight.formats.materialx.values import Plain, Value

#: Inputs with their defaults; of version 1.0.0 `base` was 0.8 and `base_color` white.
INPUTS: dict[str, float | tuple[float, ...]] = {
    "base": 1.0, "base_color": (0.8,) * 3, "diffuse_roughness": 0.0, "metalness": 0.0,
    "specular": 1.0, "specular_color": (1.0,) * 3, "specular_roughness": 0.2, "specular_IOR": 1.5,
    "specular_anisotropy": 0.0, "specular_rotation": 0.0, "transmission": 0.0,
    "transmission_color": (1.0,) * 3, "transmission_depth": 0.0,
    "transmission_scatter": (0.0,) * 3, "transmission_scatter_anisotropy": 0.0,
    "transmission_dispersion": 0.0, "transmission_extra_roughness": 0.0, "subsurface": 0.0,
    "subsurface_color": (1.0,) * 3, "subsurface_radius": (1.0,) * 3, "subsurface_scale": 1.0,
    "subsurface_anisotropy": 0.0, "sheen": 0.0, "sheen_color": (1.0,) * 3, "sheen_roughness": 0.3,
    "coat": 0.0, "coat_color": (1.0,) * 3, "coat_roughness": 0.1, "coat_anisotropy": 0.0,
    "coat_rotation": 0.0, "coat_IOR": 1.5, "coat_affect_color": 0.0, "coat_affect_roughness": 0.0,
    "thin_film_thickness": 0.0, "thin_film_IOR": 1.5, "emission": 0.0, "emission_color": (1.0,) * 3,
    "opacity": (1.0,) * 3, "thin_walled": 0.0,
}  # fmt: skip
#: Of the oldest version.
OLDEST = {"base": 0.8, "base_color": (1.0,) * 3}


def read(s: Shading) -> Surface:
    """Read a shader."""
    defaults = INPUTS | (OLDEST if s.node.version == "1.0.0" else {})
    get = {name: s.value(name, default) for name, default in defaults.items()}
    bent = s.normals("normal")
    tint = s.mixed(Plain((1.0,) * 3), get["coat_color"], get["coat"])
    matte = s.product(get["base"], get["base_color"])
    if not is_zero(get["subsurface"]):
        matte = s.mixed(matte, get["subsurface_color"], get["subsurface"])
    core: Data = {
        "type": "principled",
        "base_color": s.color("base_color", s.product(matte, tint)),
        "metallic": s.number("metalness", get["metalness"]),
        "ior": s.ior("specular_IOR"),
        "specular": s.number("specular", get["specular"]),
        "specular_color": s.color("specular_color", s.product(get["specular_color"], tint)),
        **s.brush(get["specular_roughness"], get["specular_anisotropy"], open_pbr=False),
    }
    if "anisotropy" in core and not is_zero(get["specular_rotation"]):
        turned = s.constant("specular_rotation", 0.0, -1e3, 1e3)
        core["anisotropy_rotation"] = 2.0 * math.pi * turned
    depth = s.constant("transmission_depth", 0.0)
    color = s.product(get["transmission_color"], tint)
    s.glass(core, get["transmission"], color, depth, s.flag("thin_walled"))
    s.dispersion(core, s.constant("transmission_dispersion", 0.0))
    core |= s.coat(get["coat"], get["coat_roughness"], s.ior("coat_IOR"))
    if not is_zero(get["coat"]):
        core |= s.coat_normals("coat_normal", bent)
    sheen = s.product(get["sheen"], get["sheen_color"], tint)
    if not is_zero(sheen):
        core["sheen_color"] = s.color("sheen_color", sheen)
        core["sheen_roughness"] = s.number("sheen_roughness", get["sheen_roughness"])
    if not is_zero(get["thin_film_thickness"]):
        core["iridescence"] = 1.0
        core["iridescence_ior"] = s.ior("thin_film_IOR")
        core["iridescence_thickness"] = s.thickness(get["thin_film_thickness"])
    _say_what_is_left_out(s, get)
    opacity = s.number("opacity", s.grey("opacity", get["opacity"]))
    shine = s.product(get["emission_color"], tint)
    emission = s.emission("emission_color", shine, get["emission"])
    below = Below(
        get["subsurface"], get["subsurface_color"], get["subsurface_radius"],
        get["subsurface_scale"], get["subsurface_anisotropy"], get["specular_roughness"],
        get["specular"], get["specular_color"], s.ior("specular_IOR"),
        (get["metalness"], get["transmission"], get["coat"], sheen, get["thin_film_thickness"]),
    )  # fmt: skip
    inside = body_of(s, below, opacity, s.flag("thin_walled"))
    return s.finished(core, bent, opacity, emission, inside)


def _say_what_is_left_out(s: Shading, get: dict[str, Value]) -> None:
    if not is_one(get["metalness"]):
        s.left_out("what is matte is Lambertian", diffuse_roughness=0.0)
    elif not is_one(get["specular_color"]):
        s.say("specular_color is left out: metals have Schlick's rim")
    if not is_zero(get["transmission"]):
        s.left_out(
            "nothing scatters inside",
            transmission_scatter=0.0, transmission_extra_roughness=0.0,
        )  # fmt: skip
    if not is_zero(get["coat"]):
        s.left_out(
            "the coat is the same in all directions and leaves what is below as it is",
            coat_anisotropy=0.0, coat_affect_color=0.0, coat_affect_roughness=0.0,
        )  # fmt: skip
    s.asked |= {"tangent", "coat_normal"}
