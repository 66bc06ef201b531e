"""``open_pbr_surface`` -> `principled`.

Source: Andersson et al., OpenPBR Surface, version 1.1 (Academy Software Foundation), and the node
graph of MaterialX's library, whose defaults these are.
"""

from __future__ import annotations

from alight.formats.materials.surfaces import Surface
from alight.formats.materialx.bodies import Below, body_of
from alight.formats.materialx.shading import Data, Shading, is_one, is_zero
from alight.formats.materialx.values import Plain, Value, affine

#: Inputs with their defaults.
INPUTS: dict[str, float | tuple[float, ...]] = {
    "base_weight": 1.0, "base_color": (0.8,) * 3, "base_diffuse_roughness": 0.0,
    "base_metalness": 0.0, "specular_weight": 1.0, "specular_color": (1.0,) * 3,
    "specular_roughness": 0.3, "specular_ior": 1.5, "specular_roughness_anisotropy": 0.0,
    "transmission_weight": 0.0, "transmission_color": (1.0,) * 3, "transmission_depth": 0.0,
    "transmission_scatter": (0.0,) * 3, "transmission_scatter_anisotropy": 0.0,
    "transmission_dispersion_scale": 0.0, "transmission_dispersion_abbe_number": 20.0,
    "subsurface_weight": 0.0, "subsurface_color": (0.8,) * 3, "subsurface_radius": 1.0,
    "subsurface_radius_scale": (1.0, 0.5, 0.25), "subsurface_scatter_anisotropy": 0.0,
    "fuzz_weight": 0.0, "fuzz_color": (1.0,) * 3, "fuzz_roughness": 0.5, "coat_weight": 0.0,
    "coat_color": (1.0,) * 3, "coat_roughness": 0.0, "coat_roughness_anisotropy": 0.0,
    "coat_ior": 1.6, "coat_darkening": 1.0, "thin_film_weight": 0.0, "thin_film_thickness": 0.5,
    "thin_film_ior": 1.4, "emission_luminance": 0.0, "emission_color": (1.0,) * 3,
    "geometry_opacity": 1.0, "geometry_thin_walled": 0.0,
}  # fmt: skip


def read(s: Shading) -> Surface:
    """Read a shader."""
    get = {name: s.value(name, default) for name, default in INPUTS.items()}
    bent = s.normals("geometry_normal")
    tint = s.mixed(Plain((1.0,) * 3), get["coat_color"], get["coat_weight"])
    matte = s.product(get["base_weight"], get["base_color"])
    if not is_zero(get["subsurface_weight"]):
        matte = s.mixed(matte, get["subsurface_color"], get["subsurface_weight"])
    if is_one(get["base_metalness"]):
        # Of a metal it scales what is reflected; `principled` has no such weight there.
        matte = s.product(matte, get["specular_weight"])
    core: Data = {
        "type": "principled",
        "base_color": s.color("base_color", s.product(matte, tint)),
        "metallic": s.number("base_metalness", get["base_metalness"]),
        "ior": s.ior("specular_ior"),
        "specular": s.number("specular_weight", get["specular_weight"]),
        "specular_color": s.color("specular_color", s.product(get["specular_color"], tint)),
        **s.brush(get["specular_roughness"], get["specular_roughness_anisotropy"], open_pbr=True),
    }
    depth = s.constant("transmission_depth", 0.0)
    color = s.product(get["transmission_color"], tint)
    thin = s.flag("geometry_thin_walled")
    s.glass(core, get["transmission_weight"], color, depth, thin)
    spread = s.constant("transmission_dispersion_scale", 0.0)
    abbe = s.constant("transmission_dispersion_abbe_number", 20.0)
    s.dispersion(core, abbe / spread if spread > 0.0 else 0.0)
    core |= s.coat(get["coat_weight"], get["coat_roughness"], s.ior("coat_ior", 1.6))
    if not is_zero(get["coat_weight"]):
        core |= s.coat_normals("geometry_coat_normal", bent)
    fuzz = s.product(get["fuzz_weight"], get["fuzz_color"])
    if not is_zero(fuzz):
        core["sheen_color"] = s.color("fuzz_color", fuzz)
        core["sheen_roughness"] = s.number("fuzz_roughness", get["fuzz_roughness"])
    if not is_zero(get["thin_film_weight"]):
        core["iridescence"] = s.number("thin_film_weight", get["thin_film_weight"])
        core["iridescence_ior"] = s.ior("thin_film_ior", 1.4)
        # Micrometres.
        core["iridescence_thickness"] = s.thickness(
            affine(get["thin_film_thickness"], (1000.0,), (0.0,))
        )
    _say_what_is_left_out(s, get)
    opacity = s.number("geometry_opacity", get["geometry_opacity"])
    # Below the coat; fuzz lies above it.
    shine = s.product(get["emission_color"], tint)
    emission = s.emission("emission_color", shine, get["emission_luminance"])
    below = Below(
        get["subsurface_weight"], get["subsurface_color"], get["subsurface_radius"],
        get["subsurface_radius_scale"], get["subsurface_scatter_anisotropy"],
        get["specular_roughness"], get["specular_weight"], get["specular_color"],
        s.ior("specular_ior"),
        (get["base_metalness"], get["transmission_weight"], get["coat_weight"], fuzz,
         get["thin_film_weight"]),
    )  # fmt: skip
    inside = body_of(s, below, opacity, thin)
    return s.finished(core, bent, opacity, emission, inside)


def _say_what_is_left_out(s: Shading, get: dict[str, Value]) -> None:
    if not is_one(get["base_metalness"]):
        s.left_out("what is matte is Lambertian", base_diffuse_roughness=0.0)
        if not is_zero(get["base_metalness"]) and not is_one(get["specular_weight"]):
            s.say("specular_weight is left out of the metal: it counts for the rest only")
    else:
        if not is_one(get["specular_color"]):
            s.say("specular_color is left out: metals have Schlick's rim")
        if not is_one(get["specular_weight"]):
            s.say("specular_weight scales what the metal reflects straight on, not at its rim")
    if not is_zero(get["transmission_weight"]):
        s.left_out("nothing scatters inside", transmission_scatter=0.0)
    if not is_zero(get["coat_weight"]):
        s.left_out("the coat is the same in all directions", coat_roughness_anisotropy=0.0)
        if not is_zero(get["coat_darkening"]):
            s.say("coat_darkening is left out: light below the coat does not return to it")
    if s.node.inputs.get("geometry_tangent") is not None:
        s.say("geometry_tangent is left out: tangents follow from the texture coordinates")
    s.asked |= {"geometry_tangent", "geometry_coat_tangent", "geometry_coat_normal"}
