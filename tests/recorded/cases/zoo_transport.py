"""Integrators, media, phases, cameras, filters, samplers, and what moves."""

# ruff: noqa: E501

from functools import partial

from tests.recorded.cases.zoo_lights import (
    BEAMS,
    LENS,
    PICTURES,
    POINTS,
    PROFILES,
    ROOM,
    SHAPES,
    SKY,
    SOURCES,
    THINGS,
    WINDOWS,
)
from tests.recorded.zoo import FLOOR, LAMP, STAGE, film_answer, films, scene

MASKS = """
  curtain: {shape: rectangle, bsdf: {type: mask, opacity: {type: checkerboard, color0: 0.9, color1: 0.2, scale: [4, 3]}, bsdf: {type: two_sided, bsdf: {type: diffuse, reflectance: [0.7, 0.3, 0.5]}}}, transform: [{scale: [0.7, 0.6, 1]}, {rotate: {axis: [0.1, 1, 0.2], angle: 25}}, {translate: [0.3, 0.8, 1.1]}]}
"""
MEDIA = """
  fog: {type: homogeneous, sigma_t: [0.21, 0.34, 0.13], albedo: [0.9, 0.8, 0.7], phase: {type: henyey_greenstein, g: 0.55}}
  tea: {type: homogeneous, sigma_a: [0.9, 1.4, 2.6], sigma_s: [0.3, 0.5, 0.2], scale: 0.8, phase: {type: rayleigh}}
  ink: {type: homogeneous, sigma_a: [0.12, 0.07, 0.04]}
  glow: {type: homogeneous, sigma_t: [0.21, 0.16, 0.29], albedo: 0.4, emission: [0.9, 0.4, 0.2]}
  smoke: {type: grid, values: [[[0.4, 0.9], [0.7, 0.3]]], sigma_a: [0.7, 0.5, 0.9], sigma_s: 0.4, emission: [0.5, 0.3, 0.1], low: [-0.9, 0.2, -0.8], high: [0.9, 1.4, 0.9]}
  cloud:
    type: grid
    values: [[[0.2, 1, 0.5], [0.7, 0.1, 0.9]], [[0.9, 0.3, 0], [0.1, 0.8, 0.5]]]
    sigma_t: [2.1, 3.4, 2.7]
    albedo: [0.95, 0.85, 0.9]
    scale: 1.3
    phase: {type: henyey_greenstein, g: -0.3}
    low: [-1.2, 0.2, -0.3]
    high: [-0.2, 1.1, 0.8]
  fire:
    type: grid
    values: [[[0.3, 0.9], [0.6, 0.2]], [[1, 0.4], [0.1, 0.7]], [[0.5, 0.8], [0.9, 0.3]]]
    albedo_values: [[[[0.9, 0.5, 0.2], [0.3, 0.6, 0.8]], [[0.1, 0.4, 0.7], [0.8, 0.2, 0.5]]]]
    emission_values: [[[[2, 1, 0.3], [0.5, 0.2, 0.1]], [[1.5, 0.9, 0.4], [0.2, 0.7, 0.6]]]]
    sigma_t: 2.5
    matrix: [0.9, 0.1, 0.05, 0.4, -0.1, 1.1, 0.1, 0.1, 0.02, -0.1, 0.8, -0.2]
"""
BODIES = """
  ball: {shape: {type: sphere, center: [-0.7, 0.65, 0.25], radius: 0.75}, bsdf: {type: "null"}, interior: cloud}
  box: {shape: cube, bsdf: {type: "null"}, interior: fire, transform: [{scale: [0.6, 0.7, 0.55]}, {translate: [0.9, 0.7, 0.2]}]}
"""
GLASSES = """
  cup: {shape: {type: sphere, radius: 0.55}, bsdf: {type: dielectric, int_ior: 1.4}, interior: tea, exterior: fog, transform: {translate: [-0.8, 0.7, 0.3]}}
  frosted: {shape: cube, bsdf: {type: rough_dielectric, alpha: 0.3}, interior: glow, transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 1], angle: 40}}, {translate: [0.7, 0.6, 0.2]}]}
  hollow: {shape: {type: sphere, radius: 0.3}, bsdf: {type: "null"}, interior: vacuum, transform: {translate: [0.1, 0.4, 1]}}
"""
#: Bodies in bodies, of which some absorb light and one has no inside of its own.
NESTED = """
  glass: {shape: {type: sphere, radius: 0.8}, bsdf: {type: dielectric, int_ior: 1.5, attenuation_color: [0.5, 0.8, 0.7], attenuation_distance: 0.6}, transform: {translate: [-0.5, 0.9, 0.3]}}
  drop: {shape: {type: sphere, radius: 0.4}, bsdf: {type: dielectric, int_ior: water, ext_ior: 1.5, attenuation_color: [0.9, 0.4, 0.3], attenuation_distance: 0.5}, transform: {translate: [-0.4, 0.85, 0.35]}}
  core: {shape: cube, bsdf: {type: rough_dielectric, alpha: 0.2, int_ior: 1.7, ext_ior: water, attenuation_color: [0.3, 0.6, 0.9], attenuation_distance: 0.3}, transform: [{scale: 0.15}, {rotate: {axis: [1, 1, 2], angle: 30}}, {translate: [-0.35, 0.9, 0.4]}]}
  wax: {shape: {type: sphere, radius: 0.45}, bsdf: {type: subsurface, color: [0.8, 0.6, 0.3], radius: [0.2, 0.1, 0.05]}, transform: {translate: [0.9, 0.6, 0.1]}}
"""
LOOK = "transform: {look_at: {origin: [0.7, 2.1, 4.4], target: [0.05, 0.5, -0.2], up: [0.11, 1, 0.07]}}"
MOVING_LOOK = (
    "transform: {keyframes: [{time: 0.1, look_at: {origin: [0.7, 2.1, 4.4], target: [0.05, 0.5, -0.2]}}, "
    "{time: 0.8, look_at: {origin: [0.9, 1.9, 4.2], target: [-0.1, 0.6, 0.1], up: [0.1, 1, 0]}}]}"
)
MOVING = """
  hub:
    transform: {keyframes: [{time: 0, translate: [0.1, 0.7, 0.2]}, {time: 0.6, rotate: {axis: [0.3, 0.2, 1], angle: 50}, translate: [0.2, 0.8, 0.1]}, {time: 1, rotate: {axis: [0.1, 1, 0.4], angle: 80}, scale: [1.1, 0.9, 1.2], translate: [0.3, 0.6, 0.3]}]}
    children:
      blade: {shape: cube, bsdf: {type: diffuse, reflectance: [0.7, 0.3, 0.4]}, transform: [{scale: [0.7, 0.15, 0.1]}, {translate: [0.4, 0.1, 0]}]}
      ball: {shape: {type: sphere, radius: 0.3}, bsdf: {type: plastic, diffuse_reflectance: {type: noise, color1: [0.2, 0.9, 0.6]}}, transform: {translate: [-0.7, 0.1, 0.2]}}
  lamp:
    transform: {keyframes: [{time: 0, translate: [-1.1, 2.1, 0.9]}, {time: 1, translate: [0.2, 2.4, 1.1], rotate: {axis: [1, 0.1, 0.3], angle: 60}}]}
    children:
      bulb: {shape: {type: sphere, radius: 0.15}, light: {type: area, radiance: [31, 22, 13]}, transform: {scale: [1, 0.8, 1.1]}}
      spot: {light: {type: spot, intensity: [9, 12, 15], cutoff_angle: 50}, transform: {rotate: {axis: [1, 0.2, 0.1], angle: 80}}}
      point: {light: {type: point, intensity: [2, 1, 3]}, transform: {translate: [0.3, 0.2, 0.1]}}
"""
MOVED = "{keyframes: [{time: 0, translate: [0, 0, 0]}, {time: 1, translate: [0.2, 0.1, -0.1], rotate: {axis: [0.2, 1, 0.1], angle: 15}}]}"
MOVING_LENS = f"\n  moved:\n    transform: {MOVED}\n    children:" + LENS.replace("\n", "\n    ")


def volpath(**options: str) -> str:
    """An integrator for media."""
    text = "".join(f", {key}: {value}" for key, value in options.items())
    return f"{{type: volpath, max_depth: 8{text}}}"


def integrator(text: str) -> str:
    """Lamps, glass and holes by another integrator."""
    return scene(ROOM + LENS + MASKS + SOURCES + LAMP, integrator=text)


def filmed(text: str) -> str:
    """The stage with another film."""
    return scene(STAGE + THINGS, film=text)


def sampled(text: str) -> str:
    """The stage with another sampler."""
    return scene(STAGE + THINGS + POINTS, sampler=text)


def seen(text: str, size: str = "[12, 8]") -> str:
    """The stage by another camera."""
    return scene(STAGE + THINGS, camera="{" + text + f", {LOOK}}}", film=f"{{size: {size}}}")


FOG = {"medium": "fog", "media": MEDIA}
SCENES = {
    "direct": integrator("{type: direct}"),
    "direct-bsdf": integrator("{type: direct, light_sampling: bsdf, hide_emitters: true}"),
    "direct-emitter": integrator("{type: direct, light_sampling: emitter, light_choice: power, heuristic: balance}"),
    "ambient-occlusion": integrator("{type: ambient_occlusion}"),
    "ambient-occlusion-near": integrator("{type: ambient_occlusion, distance: 0.7}"),
    "random-walk": integrator("{type: random_walk, max_depth: 6}"),
    "roulette": integrator("{type: path, rr_depth: 2}"),
    "light": integrator("{type: light, max_depth: 6}"),
    "light-roulette": scene(ROOM + SHAPES + POINTS, integrator="{type: light, rr_depth: 2}", environment=SKY % "", film="{size: [12, 8], filter: {type: tent, radius: 1.3}}"),
    "light-lens": scene(ROOM + LAMP, integrator="{type: light, max_depth: 4, russian_roulette: none}", camera=f"{{type: thin_lens, fov: 43, aperture_radius: 0.2, focus_distance: 4.6, {LOOK}}}"),
    "light-beams": scene(ROOM + PROFILES + PICTURES + BEAMS, integrator="{type: light, max_depth: 4}", environment=""),
    "bidirectional-beams": scene(ROOM + PROFILES + PICTURES + BEAMS, integrator="{type: bidirectional, max_depth: 4}", environment=""),
    "bidirectional": integrator("{type: bidirectional, max_depth: 6}"),
    "bidirectional-balance": scene(ROOM + SHAPES + POINTS, integrator="{type: bidirectional, max_depth: 5, heuristic: balance, light_choice: tree, russian_roulette: none}", environment=SKY % ""),
    "bidirectional-lens": scene(ROOM + LAMP + POINTS, integrator="{type: bidirectional, max_depth: 4}", camera=f"{{type: thin_lens, fov: 43, aperture_radius: 0.2, focus_distance: 4.6, {LOOK}}}"),
    "bidirectional-windows": scene(ROOM + WINDOWS, integrator="{type: bidirectional, rr_depth: 2, light_choice: uniform}", environment="{type: sunsky, sun_direction: [0.3, 0.8, 0.5], scale: 0.04}", camera=f"{{type: orthographic, height: 3.1, {LOOK}}}"),
    "fog": scene(ROOM + LAMP, integrator=volpath(), **FOG),
    "fog-bsdf": scene(ROOM + LAMP, integrator=volpath(light_sampling="bsdf", rr_depth=3), **FOG),
    "fog-emitter": scene(ROOM + LAMP + POINTS, integrator=volpath(light_sampling="emitter", light_choice="tree", russian_roulette="none"), **FOG),
    "grids": scene(STAGE + BODIES, integrator=volpath(), media=MEDIA),
    "grids-in-fog": scene(STAGE + BODIES + POINTS, integrator=volpath(hide_emitters="true", light_choice="uniform"), environment=SKY % "", **FOG),
    "glasses": scene(STAGE + GLASSES, integrator=volpath(), media=MEDIA, medium="fog"),
    "glasses-emitter": scene(STAGE + GLASSES + MASKS, integrator=volpath(light_choice="power"), media=MEDIA, environment=""),
    "cloud": scene(FLOOR + "\n  box: {shape: cube, bsdf: {type: 'null'}, interior: cumulus, transform: [{scale: [1.4, 0.8, 1.1]}, {translate: [0, 0.9, 0]}]}\n", media="{cumulus: {type: grid, file: 'builtin:cloud', low: [-1.2, 0.2, -0.9], high: [1.1, 1.5, 0.8], sigma_s: [7, 8, 9]}}", integrator=volpath()),
    "smoke": scene(STAGE + "\n  box: {shape: cube, bsdf: {type: 'null'}, interior: smoke, transform: [{scale: 1.1}, {translate: [0, 0.9, 0]}]}\n", integrator=volpath(), media=MEDIA),
    "camera-in-ink": scene(ROOM + LAMP, integrator=volpath(), media=MEDIA, camera=f"{{type: pinhole, fov: 41, medium: ink, {LOOK}}}"),
    "camera-in-tea": scene(ROOM + LAMP, integrator=volpath(), media=MEDIA, camera=f"{{type: thin_lens, fov: 41, focus_distance: 4, medium: tea, shutter: [0.2, 0.4], {LOOK}}}"),
    "camera-in-glow": scene(ROOM + LAMP, integrator=volpath(), media=MEDIA, medium="glow", camera=f"{{type: orthographic, height: 3, medium: ink, shutter: [0, 0.3], {LOOK}}}"),
    "nested": scene(STAGE + NESTED, integrator="{type: path, max_depth: 12}"),
    "nested-volpath": scene(STAGE + NESTED, integrator=volpath(), environment=SKY % ""),
    "nested-both-ends": scene(STAGE + NESTED.partition("  wax:")[0] + "\n", integrator="{type: bidirectional, max_depth: 9}"),
    "pinhole": seen("type: pinhole, fov: 57, fov_axis: x, shutter: [0.3, 0.6]"),
    "pinhole-diagonal": seen("type: pinhole, fov: 63, fov_axis: diagonal"),
    "thin-lens": seen("type: thin_lens, fov: 37, fov_axis: smaller, aperture_radius: 0.23, focus_distance: 3.7", "[8, 11]"),
    "thin-lens-larger": seen("type: thin_lens, fov: 61, fov_axis: larger, aperture_radius: 0.11, focus_distance: 5.1"),
    "orthographic": seen("type: orthographic, height: 2.9", "[9, 10]"),
    "box": filmed("{size: [13, 9], filter: {type: box, radius: 0.9}}"),
    "tent": filmed("{size: [12, 8], filter: {type: tent, radius: 1.4}, replicates: 3}"),
    "gaussian": filmed("{size: [12, 8], filter: {type: gaussian, stddev: 0.7, radius: 1.8}}"),
    "mitchell": filmed("{size: [12, 8], filter: {type: mitchell, radius: 1.7, b: 0.2, c: 0.5}}"),
    "crop": filmed("{size: [31, 23], crop: [9, 5, 12, 10]}"),
    "independent": sampled("independent"),
    "stratified": sampled("{type: stratified, strata: 3}"),
    "multijittered": sampled("{type: multijittered, strata: 3}"),
    "halton": sampled("halton"),
    "sobol": sampled("sobol"),
    "moving": scene(FLOOR + MOVING, camera=f"{{type: thin_lens, fov: 41, aperture_radius: 0.1, focus_distance: 4, shutter: [0.2, 0.9], {MOVING_LOOK}}}"),
    "moving-tree": scene(FLOOR + MOVING + SHAPES, integrator="{type: path, max_depth: 4, light_choice: tree}"),
    "moving-both-ends": scene(FLOOR + MOVING, integrator="{type: bidirectional, max_depth: 5}", camera=f"{{type: pinhole, shutter: [0.2, 0.9], {MOVING_LOOK}}}"),
    "moving-fog": scene(FLOOR + MOVING + GLASSES, integrator=volpath(), **FOG),
    "moving-caustics": scene(FLOOR + MOVING + MOVING_LENS, integrator="{type: path, max_depth: 5, caustics: manifold}", environment=""),
}  # fmt: skip
MATTES = ("cryptomatte_object", "cryptomatte_material", "alpha", "direct")
SHADOWS = {
    "shadows": scene(
        ROOM + MASKS + POINTS,
        environment=SKY % "",
        integrator="{type: path, max_depth: 3, hide_emitters: true}",
    ),
    "shadows-tree": scene(
        ROOM + LENS + POINTS + BEAMS,
        environment="",
        integrator="{type: path, max_depth: 3, hide_emitters: true, light_choice: tree}",
    ),
}
CASES = (
    films(SCENES)
    | {
        f"layers/{name}": partial(film_answer, text, 3, ("alpha", "shadow"))
        for name, text in SHADOWS.items()
    }
    | {
        f"layers/{name}": partial(film_answer, SCENES[name], 3, MATTES)
        for name in ("direct", "moving", "mitchell", "crop")
    }
)
