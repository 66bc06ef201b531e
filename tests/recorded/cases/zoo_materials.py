"""Materials: small pictures of a ball, a block and a gem, and what each does with directions."""

# ruff: noqa: E501

from functools import partial

import numpy as np

from alight.formats import loads
from alight.laws.compiled import scatter
from alight.scene import flatten
from tests.recorded.zoo import STAGE, films, scene

#: A gem that is shaded as a ball, with coordinates, further coordinates and colours.
GEM = """
  gem:
    bsdf: %s
    transform: [{scale: [0.6, 0.7, 0.5]}, {rotate: {axis: [1, 2, 0.3], angle: 31}}, {translate: [1.05, 0.72, 0.35]}]
    shape:
      type: mesh
      vertices: [[1, 0, 0.1], [-1, 0.1, 0], [0, 1, -0.1], [0.1, -1, 0], [0, 0.1, 1], [0, 0, -1]]
      normals: [[1, 0.2, 0], [-1, 0, 0.1], [0, 1, 0.2], [0.1, -1, 0], [0.2, 0, 1], [0, 0.1, -1]]
      uvs: [[0.1, 0.2], [1.3, 0.4], [0.3, 0.9], [0.7, -0.6], [0.5, 0.45], [2.1, 0.15]]
      more_uvs: [[[0.8, 0.1], [0.2, 0.3], [0.6, 0.7], [-0.4, 0.5], [1.2, 1.1], [0.3, 0.9]]]
      colors: [[0.9, 0.1, 0.2], [0.3, 0.8, 0.1], [0.2, 0.4, 0.9], [0.7, 0.6, 0.1], [0.1, 0.7, 0.8], [0.6, 0.2, 0.7]]
      faces: [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
"""
BALL = """
  ball:
    shape: {type: sphere, center: [-1.05, 0.65, 0.3], radius: 0.6}
    bsdf: %s
    transform: {rotate: {axis: [0.2, 1, 0.4], angle: 23}}
"""
BLOCK = """
  block:
    shape: cube
    bsdf: %s
    transform: [{scale: [0.35, 0.5, 0.3]}, {rotate: {axis: [0.1, 1, 0.2], angle: 37}}, {translate: [0.05, 0.55, -0.6]}]
"""
#: Textures in the place of colours and numbers.
CHEQUERS = "{type: checkerboard, color0: [0.72, 0.31, 0.14], color1: [0.16, 0.43, 0.58], scale: [5, 3], offset: [0.3, 0.1]}"
STEPS = "{type: checkerboard, color0: 0.23, color1: 0.67, scale: [4, 7]}"
SLOPES = "{type: checkerboard, color0: [0.62, 0.41, 0.9], color1: [0.4, 0.55, 0.83], scale: 3}"
HILLS = "{type: noise, pattern: turbulence, scale: [3, 5, 4], octaves: 3, gain: 0.4}"

MATERIALS = {
    "diffuse": "{type: diffuse, reflectance: [0.71, 0.34, 0.17]}",
    "diffuse-uniform": f"{{type: diffuse, reflectance: {CHEQUERS}, sampling: uniform}}",
    "uniform_scatter": "{type: uniform_scatter, reflectance: [0.31, 0.62, 0.44]}",
    "mirror": f"{{type: mirror, reflectance: {CHEQUERS}}}",
    "phong": "{type: phong, diffuse: [0.21, 0.33, 0.14], specular: [0.41, 0.22, 0.35], exponent: 17}",
    "phong-maps": f"{{type: phong, diffuse: {CHEQUERS}, specular: 0.2, exponent: {{type: multiply, a: {STEPS}, b: 9}}}}",
    "conductor": "{type: conductor, metal: copper, specular_reflectance: [0.92, 0.81, 0.73]}",
    "conductor-eta": "{type: conductor, eta: [0.3, 1.2, 2.6], k: [4.1, 2.2, 0.7]}",
    "dielectric": "{type: dielectric, int_ior: 1.47, ext_ior: water, specular_reflectance: [0.93, 0.85, 0.77], specular_transmittance: [0.71, 0.83, 0.95]}",
    "dielectric-tea": "{type: dielectric, int_ior: diamond, attenuation_color: [0.7, 0.4, 0.2], attenuation_distance: 0.8}",
    "dielectric-name": "{type: dielectric, dispersion: sf11}",
    "dielectric-abbe": "{type: dielectric, int_ior: 1.62, ext_ior: 1.1, dispersion: 19}",
    "dielectric-cauchy": "{type: dielectric, dispersion: [1.48, 0.0062]}",
    "dielectric-sellmeier": "{type: dielectric, dispersion: [1.1, 0.25, 0.9, 0.0061, 0.021, 98]}",
    "rough_conductor": f"{{type: rough_conductor, metal: silver, alpha: {STEPS}, specular_reflectance: [0.9, 0.8, 0.6]}}",
    "rough_conductor-two": "{type: rough_conductor, distribution: beckmann, eta: [0.4, 1.1, 2.2], k: [3.1, 2.4, 1.7], alpha_u: 0.14, alpha_v: 0.45}",
    "rough_conductor-brushed": "{type: rough_conductor, metal: titanium, alpha_u: 0.47, alpha_v: 0.12}",
    "rough_dielectric": "{type: rough_dielectric, int_ior: 1.6, alpha_u: 0.21, alpha_v: 0.52, specular_reflectance: [0.92, 0.84, 0.76], specular_transmittance: [0.75, 0.87, 0.96], attenuation_color: [0.5, 0.8, 0.6], attenuation_distance: 1.3}",
    "rough_dielectric-beckmann": f"{{type: rough_dielectric, distribution: beckmann, int_ior: ice, ext_ior: ethanol, alpha: {STEPS}}}",
    "rough_dielectric-dispersed": "{type: rough_dielectric, dispersion: sf10, alpha: 0.17}",
    "thin_dielectric": "{type: thin_dielectric, int_ior: 1.8, ext_ior: 1.2, specular_reflectance: [0.91, 0.82, 0.73], specular_transmittance: [0.64, 0.75, 0.86]}",
    "plastic": f"{{type: plastic, int_ior: 1.7, ext_ior: 1.1, diffuse_reflectance: {CHEQUERS}, specular_reflectance: [0.9, 0.7, 0.8]}}",
    "plastic-nonlinear": "{type: plastic, diffuse_reflectance: [0.8, 0.5, 0.2], nonlinear: true}",
    "rough_plastic": f"{{type: rough_plastic, int_ior: 1.6, ext_ior: 1.05, diffuse_reflectance: [0.3, 0.5, 0.7], specular_reflectance: [0.8, 0.9, 0.7], alpha: {STEPS}}}",
    "rough_plastic-nonlinear": "{type: rough_plastic, distribution: beckmann, diffuse_reflectance: [0.8, 0.3, 0.5], nonlinear: true, alpha: 0.37}",
    "oren_nayar": "{type: oren_nayar, reflectance: [0.7, 0.5, 0.3], sigma: 33}",
    "eon": f"{{type: eon, reflectance: [0.8, 0.6, 0.3], roughness: {STEPS}}}",
    "diffuse_transmission": f"{{type: diffuse_transmission, reflectance: [0.3, 0.2, 0.4], transmittance: {CHEQUERS}}}",
    "principled-paint": f"{{type: principled, base_color: {CHEQUERS}, roughness: 0.43, ior: 1.6, specular: 0.7, specular_color: [0.8, 0.9, 0.6], clearcoat: 0.6, clearcoat_roughness: 0.25, sheen_color: [0.3, 0.1, 0.2], sheen_roughness: 0.45}}",
    "principled-metal": f"{{type: principled, base_color: [0.9, 0.6, 0.3], metallic: {STEPS}, roughness: 0.5, anisotropy: 0.7, anisotropy_rotation: 0.6}}",
    "principled-glass": f"{{type: principled, base_color: [0.9, 0.7, 0.8], transmission: {STEPS}, roughness: 0.35, ior: 1.45, attenuation_color: [0.6, 0.8, 0.4], attenuation_distance: 0.9}}",
    "principled-clear": "{type: principled, base_color: [0.8, 0.9, 0.7], transmission: 1, roughness: 0.02, ior: 1.52, dispersion: 23}",
    "principled-sheet": "{type: principled, base_color: [0.5, 0.8, 0.6], transmission: 0.6, roughness: 0.4, thin: true, specular: 0.8}",
    "principled-film": "{type: principled, base_color: [0.7, 0.2, 0.3], metallic: 0.4, roughness: 0.3, iridescence: 0.8, iridescence_ior: 1.7, iridescence_thickness: 330}",
    "principled-alone": "{type: principled, base_color: [0.8, 0.5, 0.2], metallic: 0.3, roughness: 0.7, compensation: false, transmission: 0.2, clearcoat: 0.3}",
    "burley": "{type: burley, base_color: [0.7, 0.4, 0.2], metallic: 0.3, roughness: 0.45, anisotropic: 0.6, spec_trans: 0.4, spec_tint: 0.5, sheen: 0.35, sheen_tint: 0.65, flatness: 0.55, clearcoat: 0.7, clearcoat_gloss: 0.25, ior: 1.4}",
    "burley-maps": f"{{type: burley, base_color: {CHEQUERS}, metallic: {STEPS}, roughness: 0.6, sheen: 0.8, clearcoat: 0.4}}",
    "burley_thin": "{type: burley_thin, base_color: [0.6, 0.7, 0.3], roughness: 0.55, anisotropic: 0.3, spec_trans: 0.35, through: 0.45, spec_tint: 0.25, sheen: 0.5, sheen_tint: 0.4, flatness: 0.3, ior: 1.35}",
    "two_sided": "{type: two_sided, bsdf: {type: plastic, diffuse_reflectance: [0.2, 0.5, 0.4]}, back: {type: phong, exponent: 6}}",
    "two_sided-one": "{type: two_sided, bsdf: {type: eon, reflectance: [0.6, 0.5, 0.2]}}",
    "blend": f"{{type: blend, weight: {STEPS}, bsdfs: [{{type: rough_conductor, metal: gold, alpha: 0.3}}, {{type: blend, weight: 0.3, bsdfs: [{{type: diffuse, reflectance: [0.2, 0.6, 0.5]}}, {{type: mirror, reflectance: [0.9, 0.7, 0.8]}}]}}]}}",
    "mask": f"{{type: mask, opacity: {STEPS}, bsdf: {{type: rough_plastic, diffuse_reflectance: [0.3, 0.2, 0.6]}}}}",
    "mask-of-a-blend": "{type: blend, weight: 0.35, bsdfs: [{type: mask, opacity: 0.7, bsdf: {type: diffuse, reflectance: [0.8, 0.3, 0.4]}}, {type: 'null'}]}",
    "normal_map": f"{{type: normal_map, texture: {SLOPES}, scale: 0.8, bsdf: {{type: rough_conductor, metal: gold, alpha_u: 0.2, alpha_v: 0.4}}}}",
    "normal_map-folded": f"{{type: normal_map, texture: {SLOPES}, rims: folded, follow_uv: false, bsdf: {{type: diffuse, reflectance: [0.7, 0.5, 0.6]}}}}",
    "normal_map-black": f"{{type: normal_map, texture: {SLOPES}, scale: 2.5, rims: black, fading: false, bsdf: {{type: dielectric, int_ior: 1.4}}}}",
    "bump_map": f"{{type: bump_map, texture: {HILLS}, scale: -0.3, bsdf: {{type: plastic, diffuse_reflectance: [0.4, 0.6, 0.3]}}}}",
    "bump_map-folded": f"{{type: bump_map, texture: {HILLS}, scale: 0.2, rims: folded, fading: false, bsdf: {{type: oren_nayar, reflectance: [0.6, 0.5, 0.4]}}}}",
    "bump_map-black": f"{{type: bump_map, texture: {HILLS}, scale: 0.6, rims: black, bsdf: {{type: mirror}}}}",
    "coat-normals": f"{{type: normal_map, texture: {SLOPES}, bsdf: {{type: principled, base_color: [0.6, 0.3, 0.2], roughness: 0.4, clearcoat: 0.8, clearcoat_roughness: 0.3, clearcoat_normal: [0.4, 0.57, 0.88], clearcoat_normal_scale: 0.7}}}}",
    "coat-normals-alone": f"{{type: principled, base_color: [0.3, 0.6, 0.2], clearcoat: 0.9, clearcoat_roughness: 0.2, clearcoat_normal: {SLOPES}}}",
    "two_sided-normal_map": f"{{type: two_sided, bsdf: {{type: normal_map, texture: {SLOPES}, bsdf: {{type: phong}}}}, back: {{type: bump_map, texture: {HILLS}, scale: 0.2, bsdf: {{type: eon}}}}}}",
    "coated_conductor": "{type: coated_conductor, metal: copper, int_ior: 1.6, ext_ior: 1.1, alpha: 0.25, coat_alpha: 0.15, thickness: 0.2, bounces: 7}",
    "coated_conductor-eta": "{type: coated_conductor, eta: [0.3, 0.8, 1.9], k: [3.3, 2.5, 1.6]}",
    "subsurface": "{type: subsurface, color: [0.8, 0.5, 0.3], radius: [0.3, 0.17, 0.09], scale: 1.2, ior: 1.35, roughness: 0.6}",
    "subsurface-bare": f"{{type: subsurface, color: {CHEQUERS}, radius: [0.2, 0.12, 0.3], ior: 1}}",
    "hair": "{type: hair, sigma_a: [0.4, 0.7, 1.1], beta_m: 0.35, beta_n: 0.45, alpha: 3, ior: 1.5}",
    "hair-color": "{type: hair, color: [0.6, 0.4, 0.2], beta_m: 0.7, beta_n: 0.2, alpha: -4}",
    "hair-pigments": "{type: hair, eumelanin: 0.7, pheomelanin: 0.4}",
    "measured": "{type: measured, file: 'builtin:brushed'}",
    "measured-satin": "{type: measured, file: 'builtin:satin'}",
}  # fmt: skip

#: What stands beside each other in one picture: on the ball, the block and the gem.
TOGETHER = {
    "matte": ("diffuse-uniform", "oren_nayar", "eon"),
    "sheets": ("uniform_scatter", "diffuse_transmission", "thin_dielectric"),
    "phong": ("phong", "phong-maps", "mirror"),
    "metals": ("conductor", "rough_conductor", "conductor-eta"),
    "brushed": ("rough_conductor-brushed", "coated_conductor", "rough_conductor-two"),
    "lacquer": ("coated_conductor-eta", "measured", "measured-satin"),
    "glass": ("dielectric-tea", "dielectric", "thin_dielectric"),
    "frosted": ("rough_dielectric", "rough_dielectric-beckmann", "dielectric"),
    "prisms": ("dielectric-name", "dielectric-abbe", "rough_dielectric-dispersed"),
    "more-prisms": ("dielectric-cauchy", "principled-clear", "dielectric-sellmeier"),
    "plastics": ("plastic", "rough_plastic", "plastic-nonlinear"),
    "paints": ("rough_plastic-nonlinear", "principled-paint", "principled-film"),
    "principled": ("principled-metal", "principled-glass", "principled-sheet"),
    "disney": ("burley", "burley_thin", "burley-maps"),
    "uncompensated": ("principled-alone", "two_sided-one", "coat-normals-alone"),
    "mixtures": ("blend", "two_sided", "mask-of-a-blend"),
    "holes": ("mask", "mask-of-a-blend", "mask"),
    "normals": ("normal_map-folded", "normal_map", "coat-normals"),
    "rims": ("normal_map-black", "bump_map-black", "bump_map-folded"),
    "bumps": ("bump_map", "two_sided-normal_map", "bump_map"),
    "flesh": ("subsurface", "subsurface-bare", "subsurface"),
    "fibres": ("hair", "hair-color", "hair-pigments"),
}
SCENES = {
    name: scene(STAGE + "".join(
        body % MATERIALS[material]
        for body, material in zip((BALL, BLOCK, GEM), materials, strict=True)
    ))
    for name, materials in TOGETHER.items()
}  # fmt: skip


def scattering(text: str) -> dict[str, np.ndarray]:
    """Directions, weights, densities, values, albedos and flags of random directions.

    Some of them as they are, and of all the means, and the means of their sizes.
    """
    flat = flatten(loads(scene(BALL % text), "zoo.yaml"))
    spec = flat.bsdfs[flat.shapes[0].bsdf]
    rows = scatter([spec], np.zeros(2048, np.uint32), compiled=False).astype(float)
    return {"samples": rows[:, :1024:64].T, "means": rows.mean(1), "sizes": np.abs(rows).mean(1)}


CASES = films(SCENES) | {
    f"scattering/{name}": partial(scattering, text) for name, text in MATERIALS.items()
}
