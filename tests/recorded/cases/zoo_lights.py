"""Lights of every kind, found in every way."""

# ruff: noqa: E501

from functools import partial

from tests.recorded.zoo import FLOOR, LAMP, film_answer, films, scene

THINGS = """
  ball: {shape: {type: sphere, center: [-0.8, 0.5, 0.2], radius: 0.5}, bsdf: {type: plastic, diffuse_reflectance: [0.5, 0.2, 0.3]}}
  block: {shape: cube, bsdf: {type: rough_conductor, metal: gold, alpha: 0.35}, transform: [{scale: [0.3, 0.6, 0.25]}, {rotate: {axis: [0.1, 1, 0.2], angle: 33}}, {translate: [0.7, 0.6, -0.2]}]}
"""
ROOM = FLOOR + THINGS
SKY = """{type: environment, pixels: [[[0.4, 0.6, 1.2], [0.5, 0.7, 1.1], [0.3, 0.5, 0.9]],
  [[1.5, 0.9, 0.4], [7.1, 5.3, 2.2], [0.6, 0.5, 0.8]], [[0.3, 0.4, 0.2], [0.2, 0.1, 0.3], [0.1, 0.3, 0.2]]],
  scale: [0.8, 0.9, 0.7], rotate: 37%s}"""
POINTS = """
  bulb: {light: {type: point, intensity: [9, 7, 5]}, transform: [{scale: 2}, {translate: [-1.2, 2.3, 1.1]}]}
  far: {light: {type: directional, irradiance: [0.7, 0.9, 1.2]}, transform: {look_at: {origin: [1, 4, 2], target: [1.7, 8, 3.9]}}}
  spot: {light: {type: spot, intensity: [19, 23, 11], cutoff_angle: 31}, transform: {look_at: {origin: [1.6, 2.9, 1.5], target: [2.8, 5.6, 2.9]}}}
"""
BEAMS = """
  smooth: {light: {type: spot, intensity: [29, 13, 9], cutoff_angle: 27, beam_width: 11, falloff: smooth}, transform: {look_at: {origin: [-1.6, 2.9, 1.5], target: [-2.5, 5.6, 2.7]}}}
  quadratic: {light: {type: spot, intensity: [9, 23, 15], cutoff_angle: 33, beam_width: 5, falloff: quadratic}, transform: {look_at: {origin: [0.2, 3.1, 1.9], target: [0.3, 6.2, 3.2]}}}
  quartic: {light: {type: spot, intensity: [11, 8, 31], cutoff_angle: 41, beam_width: 17, falloff: quartic}, transform: {look_at: {origin: [1.9, 2.2, 0.5], target: [2.9, 4.1, 0.8]}}}
"""
PROFILES = """
  lantern:
    light: {type: ies, vertical_angles: [0, 25, 60, 95, 130], horizontal_angles: [0, 40, 90], candela: [[900, 700, 400, 200, 90], [500, 800, 300, 500, 60], [1100, 300, 600, 100, 40]], scale: [6, 5, 3]}
    transform: {look_at: {origin: [-1.1, 2.6, 0.9], target: [-1.6, 5.2, 1.6]}}
  sconce:
    light: {type: ies, vertical_angles: [0, 45, 90], horizontal_angles: [90, 150, 270], candela: [[300, 900, 200], [700, 200, 500], [400, 600, 100]], scale: 4}
    transform: {look_at: {origin: [1.4, 1.9, 1.2], target: [2.3, 3.7, 2], up: [0.3, 1, 0]}}
"""
PICTURES = """
  slides:
    light: {type: projector, pixels: [[[9, 1, 2], [2, 8, 1]], [[1, 3, 9], [7, 6, 1]], [[4, 2, 5], [3, 7, 8]]], scale: [3, 2.5, 2], fov: 37, aspect: 1.3}
    transform: {look_at: {origin: [-0.9, 2.7, 2.1], target: [-1.4, 5.2, 4.1]}}
  gobo:
    light: {type: projector, pixels: [[4, 9], [7, 2]], scale: 3, fov: 50, evenness: intensity, cutoff_angle: 22, beam_width: 9}
    transform: {look_at: {origin: [1.7, 2.4, 1.3], target: [2.8, 4.5, 2.5], up: [0.2, 1, 0.1]}}
"""
SHAPES = """
  panel: {shape: rectangle, light: {type: area, radiance: {type: multiply, a: {type: checkerboard, color0: [0.9, 0.2, 0.1], color1: [0.1, 0.6, 1], scale: [2, 3]}, b: 13}}, bsdf: {type: diffuse, reflectance: 0.1}, transform: [{scale: [0.5, 0.7, 1]}, {look_at: {origin: [-1.7, 1.6, 1.2], target: [-2.9, 2.9, 2.3]}}]}
  globe: {shape: {type: sphere, radius: 0.2}, light: {type: area, radiance: [11, 9, 5]}, transform: [{scale: [1, 1.4, 0.8]}, {translate: [0.2, 1.9, 0.7]}]}
  tube: {shape: {type: cylinder, p0: [0.9, 1.3, 0.8], p1: [1.6, 1.7, 0.3], radius: 0.08}, light: {type: area, radiance: [5, 12, 9]}}
  cube: {shape: cube, light: {type: area, radiance: [7, 3, 8]}, transform: [{scale: 0.1}, {rotate: {axis: [1, 2, 3], angle: 35}}, {translate: [-0.1, 0.5, 1.1]}]}
  shade:
    light: {type: area, radiance: {type: multiply, a: {type: vertex_color}, b: [17, 14, 11]}}
    bsdf: {type: mask, opacity: 0.6, bsdf: {type: diffuse, reflectance: [0.3, 0.1, 0.2]}}
    transform: [{scale: 0.5}, {translate: [1.2, 1.2, -0.9]}]
    shape: {type: mesh, vertices: [[-0.6, -0.5, 0.1], [0.5, -0.6, 0], [0.6, 0.5, 0.3], [-0.5, 0.6, -0.2]], colors: [[0.9, 0.1, 0.2], [0.3, 0.8, 0.1], [0.2, 0.4, 0.9], [0.7, 0.6, 0.1]], faces: [[0, 1, 2], [0, 2, 3]]}
  thread: {shape: {type: curves, points: [[-0.3, 0.2, 1.3], [0.1, 0.6, 1.5], [0.4, 0.1, 1.2], [0.6, 0.4, 1.4]], radii: 0.03}, light: {type: area, radiance: [14, 6, 3]}}
"""
WINDOWS = """
  window: {light: {type: portal}, transform: [{scale: [0.7, 0.9, 1]}, {look_at: {origin: [-2.1, 1.4, 0.3], target: [-4.2, 2.2, 0.5]}}]}
  skylight: {light: {type: portal}, transform: [{scale: [0.5, 0.8, 1]}, {rotate: {axis: [1, 0.1, 0.2], angle: 93}}, {translate: [0.3, 2.9, 0.2]}]}
"""
#: Many small lamps in two clusters, for the tree.
MANY = "".join(
    f"""
  lamp {i}: {{shape: {kind}, light: {{type: area, radiance: [{2 + i}, {9 - 0.5 * i}, {4 + 0.3 * i}]}}, transform: [{{scale: {0.04 + 0.01 * i}}}, {{rotate: {{axis: [1, 0.3, 0.1], angle: {20 + 31 * i}}}}}, {{translate: [{-1.4 + 0.29 * i}, {0.9 + 0.37 * ((5 * i) % 4)}, {-0.6 + 0.43 * ((3 * i) % 5)}]}}]}}"""
    for i, kind in enumerate(("disk", "rectangle", "sphere", "cube", "disk") * 2)
)
#: A lamp behind glass and one that a mirror shows: caustics.
LENS = """
  lens: {shape: {type: sphere, radius: 0.4}, bsdf: {type: dielectric, int_ior: 1.5, attenuation_color: [0.8, 0.9, 0.6], attenuation_distance: 0.7}, transform: [{scale: [1, 0.7, 1.2]}, {translate: [-0.5, 0.8, 0.4]}]}
  mirror: {shape: rectangle, bsdf: {type: mirror, reflectance: [0.9, 0.8, 0.7]}, transform: [{scale: 0.6}, {look_at: {origin: [1.2, 0.7, -0.4], target: [0.1, 1.3, 1.1]}}]}
"""
SOURCES = """
  small: {shape: {type: sphere, radius: 0.12}, light: {type: area, radiance: [90, 70, 50]}, transform: {translate: [-0.9, 2.2, 0.8]}}
  bulb: {light: {type: point, intensity: [4, 6, 3]}, transform: {translate: [0.8, 1.9, 1.1]}}
"""
NIGHT = {"environment": ""}


def path(**options: str) -> str:
    """An integrator."""
    text = "".join(f", {key}: {value}" for key, value in options.items())
    return f"{{type: path, max_depth: 5{text}}}"


_SUN = "sun_direction: [0.4, 0.7, 0.5]"
SCENES = {
    "points": scene(ROOM + POINTS),
    "beams": scene(ROOM + BEAMS, **NIGHT),
    "profiles": scene(ROOM + PROFILES, **NIGHT),
    "projectors": scene(ROOM + PICTURES, **NIGHT),
    "shapes": scene(ROOM + SHAPES, **NIGHT),
    "shapes-bsdf": scene(ROOM + SHAPES, integrator=path(light_sampling="bsdf"), **NIGHT),
    "shapes-emitter": scene(ROOM + SHAPES, integrator=path(light_sampling="emitter", light_choice="uniform", heuristic="balance"), **NIGHT),
    "map": scene(ROOM, environment=SKY % ""),
    "map-all": scene(ROOM + LAMP, environment=SKY % ", compensation: false", integrator=path(heuristic="balance")),
    "map-uniform": scene(ROOM, environment=SKY % ", sampling: uniform", integrator=path(light_sampling="emitter")),
    "map-bsdf": scene(ROOM + POINTS, environment=SKY % "", integrator=path(light_sampling="bsdf", light_choice="power")),
    "sky": scene(ROOM, environment=f"{{type: sky, {_SUN}, turbidity: 5.5, scale: [0.06, 0.05, 0.07], ground: [0.2, 0.4, 0.3]}}"),
    "sun": scene(ROOM, environment=f"{{type: sun, {_SUN}, turbidity: 4.2, scale: [0.02, 0.03, 0.025], diameter: 4}}"),
    "clear-day": scene(ROOM, environment=f"{{type: sunsky, {_SUN}, turbidity: 6, scale: [0.05, 0.06, 0.04], sun_scale: [0.7, 0.8, 0.9], sky_scale: [1.2, 1.1, 1.3], diameter: 7, ground: [0.1, 0.3, 0.2]}}"),
    "by-date": scene(ROOM, environment="{type: sky, time: '2026-06-21T15:30:00+02:00', latitude: 48.2, longitude: 11.6, scale: 0.05}"),
    "sun-by-date": scene(ROOM, environment="{type: sun, time: '2026-03-11T09:20:00+01:00', latitude: 41.3, longitude: -3.7, scale: 0.02}"),
    "day-by-date": scene(ROOM, environment="{type: sunsky, time: '2026-09-02T16:10:00+02:00', latitude: -33.4, longitude: 18.5, scale: 0.03}"),
    "windows": scene(ROOM + WINDOWS, environment=SKY % ""),
    "windows-day": scene(ROOM + WINDOWS, environment=f"{{type: sunsky, {_SUN}, scale: 0.04}}", integrator=path(light_choice="tree")),
    "windows-constant": scene(ROOM + WINDOWS + LAMP, integrator=path(light_sampling="emitter")),
    "many-tree": scene(ROOM + MANY + POINTS, integrator=path(light_choice="tree"), environment=SKY % ""),
    "many-power": scene(ROOM + MANY, integrator=path(light_choice="power")),
    "many-uniform": scene(ROOM + MANY + BEAMS, integrator=path(light_choice="uniform"), **NIGHT),
    "hidden": scene(ROOM + SHAPES, integrator=path(hide_emitters="true"), environment=SKY % ""),
    "caustics": scene(ROOM + LENS + SOURCES, integrator=path(caustics="manifold"), **NIGHT),
    "caustics-of-the-sun": scene(ROOM + LENS, integrator=path(caustics="manifold"), environment=f"{{type: sunsky, {_SUN}, scale: 0.04}}"),
    "caustics-missed": scene(ROOM + LENS + SOURCES, integrator=path(russian_roulette="none"), **NIGHT),
}  # fmt: skip
CASES = films(SCENES) | {
    "layers/hidden": partial(film_answer, SCENES["hidden"], 4, ("direct", "indirect", "alpha")),
}
