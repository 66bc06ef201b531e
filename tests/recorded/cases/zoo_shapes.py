"""Shapes in all positions, with textures of all kinds, and the layers of what is seen first."""

# ruff: noqa: E501

from functools import partial

from tests.recorded.cases.zoo_materials import GEM
from tests.recorded.zoo import FLOOR, LAMP, STAGE, film_answer, films, scene

PAINT = "{type: rough_plastic, diffuse_reflectance: %s, alpha: 0.3}"
TURNED = "{rotate: {axis: [0.4, 1, 0.2], angle: %s}}, {translate: %s}"

ROUND = """
  ball:
    shape: {type: sphere, center: [0.1, -0.05, 0.2], radius: 1.1}
    bsdf: {type: diffuse, reflectance: [0.7, 0.3, 0.2]}
    transform: [{scale: [0.5, 0.3, 0.6]}, {rotate: {axis: [1, 0.3, 0.2], angle: 25}}, {translate: [-1.1, 0.6, 0.2]}]
  bowl:
    shape: {type: sphere, flip_normals: true, radius: 0.4}
    bsdf: {type: two_sided, bsdf: {type: phong, diffuse: [0.2, 0.5, 0.3]}}
    transform: {translate: [0.1, 0.45, 0.9]}
  tube:
    shape: {type: cylinder, p0: [0.1, -0.3, 0.2], p1: [-0.2, 0.8, 0.1], radius: 0.32}
    bsdf: {type: two_sided, bsdf: {type: diffuse, reflectance: [0.3, 0.4, 0.8]}}
    transform: [{scale: [1.1, 0.9, 0.8]}, {translate: [1.2, 0.6, 0.1]}]
  pipe:
    shape: {type: cylinder, flip_normals: true, p1: [0, 0.2, 1.1], radius: 0.2}
    bsdf: {type: two_sided, bsdf: {type: diffuse, reflectance: [0.5, 0.2, 0.6]}}
    transform: {translate: [-0.3, 0.9, -1.2]}
"""
FLAT = """
  ground: {shape: plane, bsdf: {type: diffuse, reflectance: [0.3, 0.5, 0.4]}, transform: [{rotate: {axis: [1, 0.1, 0], angle: -86}}, {translate: [0, -0.1, 0.3]}]}
  sky: {shape: {type: plane, flip_normals: true}, bsdf: {type: diffuse, reflectance: [0.2, 0.3, 0.4]}, transform: [{rotate: {axis: [1, 0.2, 0.1], angle: -80}}, {translate: [0, 7, 0]}]}
  sign: {shape: {type: rectangle, flip_normals: true}, bsdf: {type: two_sided, bsdf: {type: eon}}, transform: [{scale: [0.6, 0.4, 1]}, {rotate: {axis: [0.3, 1, 0.1], angle: 40}}, {translate: [-1, 0.8, 0.3]}]}
  coin: {shape: disk, bsdf: {type: rough_conductor, metal: gold, alpha: 0.3}, transform: [{scale: [0.5, 0.6, 1]}, {rotate: {axis: [1, 0.2, 0.4], angle: -50}}, {translate: [0.2, 0.7, 0.6]}]}
  hole: {shape: {type: disk, flip_normals: true}, bsdf: {type: two_sided, bsdf: {type: diffuse, reflectance: [0.8, 0.2, 0.3]}}, transform: [{scale: 0.4}, {rotate: {axis: [1, 0.7, 0.1], angle: 60}}, {translate: [1.1, 0.6, 0.1]}]}
  box: {shape: {type: cube, flip_normals: true}, bsdf: {type: two_sided, bsdf: {type: phong}}, transform: [{scale: [0.3, 0.5, 0.2]}, {rotate: {axis: [0.2, 1, 0.3], angle: 20}}, {translate: [0.3, 0.5, -0.9]}]}
  slanted:
    shape: cube
    bsdf: {type: diffuse, reflectance: [0.6, 0.6, 0.2]}
    transform: {matrix: [[0.3, 0.1, 0.02, -0.6], [0.05, 0.4, 0.1, 0.5], [0.1, -0.05, -0.35, 1.0], [0, 0, 0, 1]]}
"""
HILLS = """
  hills:
    bsdf: {type: diffuse, reflectance: [0.4, 0.6, 0.3]}
    transform: [{rotate: {axis: [1, 0.3, 0.1], angle: -70}}, {translate: [-0.9, 0.3, 0.2]}]
    shape:
      type: mesh
      vertices: [[-0.9, -0.8, 0], [0.9, -0.7, 0.1], [0.8, 0.9, 0], [-0.8, 0.7, 0.1]]
      uvs: [[0.1, 0], [1.2, 0.1], [1, 1.1], [0, 0.9]]
      faces: [[0, 1, 2], [0, 2, 3]]
      displacement: {type: noise, space: uv, scale: [2, 3, 1]}
      displacement_scale: 0.5
      displacement_midlevel: 0.4
      displacement_edge: 0.3
  folded:
    bsdf: {type: two_sided, bsdf: {type: diffuse, reflectance: [0.7, 0.4, 0.5]}}
    transform: [{rotate: {axis: [0.2, 1, 0.3], angle: 50}}, {translate: [1, 0.7, 0.4]}]
    shape:
      type: mesh
      flip_normals: true
      face_normals: true
      vertices: [[-0.6, -0.5, 0.1], [0.5, -0.6, 0], [0.6, 0.5, 0.3], [-0.5, 0.6, -0.2], [0, 0.1, 0.6]]
      normals: [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1], [0, 0, 1]]
      faces: [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
"""
_STRAND = "[[-0.6, 0.1, 0.2], [-0.3, 0.9, 0], [0.1, 0.5, 0.3], [0.5, 1.2, 0.1], [0.2, 1.7, -0.2]"
_OTHER = "[0.7, 0.2, 0.3], [0.6, 0.9, 0.5], [0.9, 1.1, 0.1], [0.4, 1.4, 0.2]]"
STRANDS = """
  strands:
    shape: {type: curves, points: POINTS, radii: [0.09, 0.12, 0.05, 0.1, 0.04, 0.11, 0.07, 0.13, 0.06], counts: [5, 4], basis: %s}
    bsdf: {type: hair, color: [0.5, 0.3, 0.2]}
    transform: [{scale: [1.1, 0.9, 1]}, {rotate: {axis: [0.1, 1, 0.2], angle: 20}}, {translate: [-0.6, 0.1, 0.3]}]
  rope:
    shape: {type: curves, points: [[1.2, 0.1, 0.2], [0.9, 0.7, 0.5], [1.3, 1.1, 0.1], [0.8, 1.6, 0.3]], radii: 0.1, basis: %s}
    bsdf: {type: diffuse, reflectance: {type: checkerboard, scale: [3, 2], color0: [0.7, 0.2, 0.1], color1: [0.1, 0.6, 0.5]}}
""".replace("POINTS", f"{_STRAND}, {_OTHER}")
#: Parts of a tree below each other, some of them copied, one of them mirrored.
COPIES = """
  group:
    bsdf: {type: plastic, diffuse_reflectance: [0.3, 0.2, 0.6]}
    transform: [{rotate: {axis: [0.2, 1, 0.1], angle: 30}}, {translate: [-0.3, 0.3, 0.2]}]
    children:
      first: {instance: tool, transform: {translate: [-0.8, 0.1, 0.3]}}
      second: {instance: tool, transform: [{scale: [-0.8, 1.1, 0.7]}, {translate: [0.9, 0.2, 0.1]}]}
      third:
        instance: tool
        bsdf: {type: diffuse, reflectance: [0.2, 0.7, 0.3]}
        transform: {translate: [0.2, 0.9, -0.7]}
"""
TOOL = """
  tool:
    children:
      head: {shape: cube, transform: [{scale: [0.3, 0.15, 0.2]}, {rotate: {axis: [1, 1, 0], angle: 25}}, {translate: [0, 0.6, 0]}]}
      handle: {shape: {type: cylinder, p0: [0, -0.2, 0.1], p1: [0.1, 0.6, 0], radius: 0.1}, bsdf: {type: two_sided, bsdf: {type: oren_nayar, reflectance: [0.6, 0.4, 0.2]}}}
"""

#: Reliefs on every shape.
BUMPS = "{type: bump_map, texture: {type: add, a: {type: bitmap, pixels: [[[0.1, 0.9, 0.3], [0.5, 0.2, 0.8]], [[0.7, 0.4, 0.6], [0.2, 0.9, 0.1]]], to_uv: {scale: [3, 2]}, color_space: linear}, b: {type: noise, space: uv, scale: 3}}, scale: 0.2, bsdf: {type: rough_plastic, diffuse_reflectance: [0.5, 0.3, 0.4]}}"
_KEYS = "\n    bsdf: {type: two_sided, bsdf: relief}"
RELIEFS = "".join(
    f"\n  relief {i}:{_KEYS}\n    shape: {shape}\n    transform: [{{scale: [0.45, 0.5, 0.4]}}, "
    f"{{rotate: {{axis: [1, 0.4, 0.2], angle: {23 + 40 * i}}}}}, {{translate: [{place}]}}]"
    for i, (shape, place) in enumerate(
        (
            ("sphere", "-1.2, 0.6, 0.3"),
            ("{type: cylinder, p1: [0.2, 0, 1]}", "-0.3, 0.5, 0.9"),
            ("disk", "0.4, 0.7, 0.5"),
            ("rectangle", "1.3, 0.7, 0.4"),
            ("cube", "-0.4, 0.9, -0.8"),
            (
                "{type: curves, points: [[-0.9, 0, 0], [0, 0.6, 0.2], [0.7, 0.2, 0.5], [1, 1, 0.3]], radii: 0.3}",
                "0.9, 1.4, -0.4",
            ),
        )
    )
)

LAYERS = (
    "direct", "indirect", "albedo", "normal", "geometric_normal", "position", "depth", "uv", "id",
    "alpha", "albedo_through", "normal_through",
)  # fmt: skip

_PIXELS = """[[[0.9, 0.2, 0.1], [0.3, 0.7, 0.2], [0.1, 0.4, 0.8]],
              [[0.6, 0.5, 0.1], [0.2, 0.1, 0.5], [0.7, 0.8, 0.6]]]"""
TEXTURES = {
    "chequers": "{type: checkerboard, color0: [0.9, 0.1, 0.2], color1: [0.2, 0.5, 0.7], scale: [3, 5], offset: [0.3, 0.6], to_uv: [{scale: [1.2, 0.8]}, {rotate: 25}, {translate: [0.1, -0.3]}], uv_set: 1}",
    "plain": "{type: constant, color: [0.7, 0.5, 0.2]}",
    "picture": f"{{type: bitmap, pixels: {_PIXELS}, wrap: mirror, wrap_v: clamp, to_uv: [{{scale: [1.7, 2.3]}}, {{rotate: -20}}], uv_set: 1}}",
    "texels": f"{{type: bitmap, pixels: {_PIXELS}, interpolation: nearest, wrap: clamp, color_space: srgb}}",
    "tiles": f"{{type: bitmap, pixels: {_PIXELS}, to_uv: {{scale: [3, 2]}}, color_space: linear}}",
    "rings": "{type: bitmap, file: 'builtin:zone-plate', wrap_v: mirror}",
    "vertices": "{type: vertex_color, fallback: [0.4, 0.6, 0.3]}",
    "clouds": "{type: noise, color0: [0.1, 0.2, 0.5], color1: [0.9, 0.8, 0.6], scale: [2, 3, 1.5], offset: [0.3, 0.1, 0.7], octaves: 5, gain: 0.6}",
    "marble": "{type: noise, pattern: turbulence, space: uv, color0: [0.8, 0.7, 0.6], color1: [0.2, 0.1, 0.3], scale: 2.5, octaves: 2, gain: 0.3, uv_set: 1}",
    "product": "{type: multiply, a: chequers, b: {type: add, a: clouds, b: [0.1, 0.2, 0.05]}}",
    "mixture": "{type: mix, a: picture, b: vertices, weight: {type: channel, texture: clouds, channel: g}}",
    "tinted": "{type: mix, a: [0.1, 0.7, 0.3], b: [0.9, 0.2, 0.6], weight: {type: bitmap, pixels: [[[0.9, 0.2, 0.1], [0.3, 0.7, 0.2]]], to_uv: {scale: 3}}}",
    "edges": "{type: mix, a: [0.8, 0.3, 0.1], b: marble, weight: {type: threshold, texture: {type: channel, texture: tiles, channel: b}, cutoff: 0.35}}",
    "cut": "{type: clamp, texture: {type: add, a: picture, b: chequers}, high: 0.7}",
    "opacity": "{type: channel, texture: {type: bitmap, pixels: [[[0.9, 0.2, 0.1, 0.3], [0.3, 0.7, 0.2, 0.8]]], to_uv: {scale: 4}}, channel: a}",
}  # fmt: skip
_TEXTURES = "".join(f"\n  {name}: {text}" for name, text in TEXTURES.items())
_GEM = """
  %s:
    bsdf: {type: diffuse, reflectance: %s}
    transform: [{scale: 0.6}, {rotate: {axis: [1, 2, 0.3], angle: 31}}, {translate: %s}]
    shape:
      type: mesh
      vertices: [[-1, -0.8, 0.1], [0.9, -1, 0], [1, 0.7, 0.2], [-0.8, 1, -0.1]]
      uvs: [[0.1, 0.2], [1.3, 0.4], [0.8, 1.9], [-0.7, 0.6]]
      more_uvs: [[[0.8, 0.1], [2.2, 0.3], [1.6, 0.9], [-0.4, 0.7]]]
      colors: [[0.9, 0.1, 0.2], [0.3, 0.8, 0.1], [0.2, 0.4, 0.9], [0.7, 0.6, 0.1]]
      faces: [[0, 1, 2], [0, 2, 3]]
"""


def painted(*names: str) -> str:
    """Three boards and a floor with textures."""
    places = "[-1.1, 0.6, 0.3]", "[0.2, 0.8, 0.1]", "[1.3, 0.6, 0.4]"
    boards = [_GEM % (f"board {i}", n, places[i]) for i, n in enumerate(names[:3])]
    floor = FLOOR.replace("[0.61, 0.47, 0.33]", names[3])
    return scene("".join([floor, LAMP, *boards]), textures=_TEXTURES)


SCENES = {
    "round": scene(STAGE + ROUND),
    "flat": scene(LAMP + FLAT),
    "hills": scene(STAGE + HILLS),
    "strands-b_spline": scene(STAGE + STRANDS % ("b_spline", "catmull_rom")),
    "strands-bezier": scene(
        STAGE
        + (STRANDS % ("linear", "bezier")).replace("points: [[-0.6, 0.1, 0.2], ", "points: [")
        .replace("[0.09, ", "[").replace("[5, 4]", "[4, 4]")
    ),
    "strands-linear": scene(STAGE + STRANDS % ("catmull_rom", "linear")),
    "copies": scene(STAGE + COPIES, prototypes=TOOL),
    "reliefs": scene(STAGE + RELIEFS, bsdfs=f"{{relief: {BUMPS}}}"),
    "relief-mesh": scene(STAGE + GEM % BUMPS + "\n  hills:" + HILLS.partition("hills:")[2].partition("  folded:")[0].replace("{type: diffuse, reflectance: [0.4, 0.6, 0.3]}", BUMPS)),
    "chequers": painted("chequers", "picture", "texels", "tiles"),
    "patterns": painted("clouds", "vertices", "marble", "rings"),
    "sums": painted("product", "mixture", "cut", "plain"),
    "parts": painted("edges", "opacity", "tinted", "clouds"),
}  # fmt: skip

CASES = films(SCENES) | {
    f"layers/{name}": partial(film_answer, SCENES[name], 3, LAYERS)
    for name in ("round", "flat", "hills", "copies", "strands-linear")
}
