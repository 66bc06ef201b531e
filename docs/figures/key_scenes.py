"""What the pictures of scene keys show: for each key a scene and values, for instance three.

A strip is made of built-in scenes and of the small ones below; its caption on the page are the
values. Keys without one change nothing that a small picture shows, such as samples or file names.
"""

from __future__ import annotations

from typing import NamedTuple

#: A floor, a wall and a ball, without any light.
STAGE = """
alight: 1
camera: {type: pinhole, fov: 34, transform: {look_at: {origin: [0, 1.6, 6], target: [0, 0.9, 0]}}}
bsdfs:
  floor: {type: diffuse, reflectance: {type: checkerboard, color0: 0.5, color1: 0.35, scale: 2}}
  wall: {type: diffuse, reflectance: [0.6, 0.58, 0.55]}
  clay: {type: rough_plastic, diffuse_reflectance: [0.6, 0.2, 0.1], alpha: 0.15}
nodes:
  floor: {shape: plane, bsdf: floor, transform: {rotate: {axis: x, angle: -90}}}
  wall: {shape: plane, bsdf: wall, transform: {translate: [0, 0, -2]}}
  ball: {shape: {type: sphere, center: [0.3, 0.6, 0.4], radius: 0.6}, bsdf: clay}
"""

#: The same floor under a sky of one colour and a lamp, for shapes at the origin.
TABLE = """
alight: 1
camera: {type: pinhole, fov: 34, transform: {look_at: {origin: [2.4, 2.6, 5], target: [0, 0.8, 0]}}}
environment: {type: constant, radiance: 0.35}
bsdfs:
  floor: {type: diffuse, reflectance: {type: checkerboard, color0: 0.5, color1: 0.35, scale: 2}}
  clay: {type: rough_plastic, diffuse_reflectance: [0.1, 0.3, 0.5], alpha: 0.15}
  black: {type: diffuse, reflectance: 0}
nodes:
  floor: {shape: plane, bsdf: floor, transform: {rotate: {axis: x, angle: -90}}}
  thing: {shape: sphere, bsdf: clay, transform: {translate: [0, 1, 0]}}
  lamp:
    shape: rectangle
    bsdf: black
    light: {type: area, radiance: 14}
    transform: {look_at: {origin: [-3, 5, 3], target: [-6, 9.2, 6]}}
"""

OWN = {"stage": STAGE, "table": TABLE}


class Strip(NamedTuple):
    """Pictures of one key.

    Attributes
    ----------
    scene : str
        Name of a built-in scene, or of one above.
    change : str
        Assignment of ``--set``, with ``{}`` for the value.
    values : tuple of str
        As a scene file writes them.
    further : tuple of str
        Changes that all pictures share.
    exposure : float, stops
    coarse : int
        Pixels of the page that one of the picture is wide.
    spp : int
    """

    scene: str
    change: str
    values: tuple[str, ...]
    further: tuple[str, ...] = ()
    exposure: float = 0.0
    coarse: int = 1
    spp: int = 48


def _ball(name: str, fixed: str = "", **keys: str) -> dict[str, Strip]:
    """Keys of a material, on the ball that shows materials; values are divided by ``|``."""
    rest = f", {fixed}" if fixed else ""
    return {
        f"{name}.{key}": Strip(
            "material-ball", f"bsdfs.ball={{{{type: {name}{rest}, {key}: {{}}}}}}",
            tuple(values.split("|")),
        )
        for key, values in keys.items()
    }  # fmt: skip


def _texture(name: str, fixed: str = "", **keys: str) -> dict[str, Strip]:
    """Keys of a texture, as the colour of the ball."""
    rest = f", {fixed}" if fixed else ""
    return {
        f"{name}.{key}": Strip(
            "material-ball",
            f"bsdfs.ball.diffuse_reflectance={{{{type: {name}{rest}, {key}: {{}}}}}}",
            tuple(values.split("|")),
        )
        for key, values in keys.items()
    }  # fmt: skip


def _lamp(name: str, fixed: str = "", exposure: float = 0.0, **keys: str) -> dict[str, Strip]:
    """Keys of a light with a place, from the upper left of the stage."""
    rest = f", {fixed}" if fixed else ""
    place = "transform: {{look_at: {{origin: [-2.2, 3.4, 3], target: [-4.4, 6.3, 5.8]}}}}"
    return {
        f"{name}.{key}": Strip(
            "stage", f"nodes.lamp={{{{light: {{{{type: {name}{rest}, {key}: {{}}}}}}, {place}}}}}",
            tuple(values.split("|")), exposure=exposure,
        )
        for key, values in keys.items()
    }  # fmt: skip


def _around(name: str, fixed: str = "", exposure: float = 0.0, **keys: str) -> dict[str, Strip]:
    """Keys of a light from everywhere."""
    rest = f", {fixed}" if fixed else ""
    return {
        f"{name}.{key}": Strip(
            "table", f"environment={{{{type: {name}{rest}, {key}: {{}}}}}}",
            tuple(values.split("|")), ("nodes.lamp.light.radiance=0",), exposure,
        )
        for key, values in keys.items()
    }  # fmt: skip


def _shape(name: str, fixed: str = "", **keys: str) -> dict[str, Strip]:
    """Keys of a shape, on the table."""
    rest = f", {fixed}" if fixed else ""
    return {
        f"{name}.{key}": Strip(
            "table", f"nodes.thing.shape={{{{type: {name}{rest}, {key}: {{}}}}}}",
            tuple(values.split("|")),
        )
        for key, values in keys.items()
    }  # fmt: skip


def _pixels(name: str, **keys: str) -> dict[str, Strip]:
    """Keys of a pixel filter, in few pixels."""
    return {
        f"{name}.{key}": Strip(
            "material-ball", f"film.filter={{{{type: {name}, {key}: {{}}}}}}",
            tuple(values.split("|")), coarse=4, spp=512,
        )
        for key, values in keys.items()
    }  # fmt: skip


_LENS = "transform: {{look_at: {{origin: [0.35, 1.35, 6.6], target: [0.35, 0.62, 0]}}}}"
_ROW, _BALL, _BOX = "depth-of-field", "material-ball", "cornell-box"
_CHECKS = "{{type: checkerboard, color0: 0, color1: 1, scale: [16, 8]}}"
_WAVES = "{{type: noise, scale: 4}}"
_SUN = "[0.3, 0.1, 0.3]|[0.3, 0.3, 0.3]|[0.3, 0.9, 0.3]"
#: A tetrahedron, and seven points of a strand.
_FACES = (
    "vertices: [[0, 1, 0], [0.9, -0.5, 0.5], [-0.9, -0.5, 0.5], [0, -0.5, -1]],"
    " faces: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]"
)
_NORMALS = "normals: [[0, 1, 0], [0.8, -0.4, 0.4], [-0.8, -0.4, 0.4], [0, -0.4, -0.9]]"
_STRAND = (
    "points: [[-1, -0.8, 0], [-0.7, 0.9, 0], [-0.3, -0.6, 0], [0, 0.9, 0], [0.3, -0.6, 0],"
    " [0.7, 0.9, 0], [1, -0.8, 0]], radii: [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]"
)
_PALETTE = (
    "pixels: [[[0.8, 0.1, 0.05], [0.9, 0.8, 0.2]], [[0.1, 0.3, 0.7], [0.1, 0.5, 0.2]]],"
    " to_uv: {{scale: [6, 3]}}"
)
_SKY = "pixels: [[[0.2, 0.4, 1], [0.2, 0.4, 1], [4, 3, 2], [0.2, 0.4, 1]], [[0.2, 0.2, 0.2]" + (
    ", [0.2, 0.2, 0.2]" * 3 + "]]"
)
_SLIDE = "pixels: [[[3, 0, 0], [3, 3, 0]], [[0, 0, 3], [0, 3, 0]]], scale: 12"
_PROFILE = "vertical_angles: [0, 10, 20, 30, 40, 90], horizontal_angles: [0], scale: 40"

STRIPS: dict[str, Strip] = {
    # ------------------------------------------------------------------ the scene itself
    "scene.integrator": Strip(
        _BOX, "integrator={}", ("{type: ambient_occlusion}", "{type: direct}", "{type: path}")
    ),
    "film.size": Strip(_BALL, "film.size={}", ("[14, 10]", "[28, 21]", "[112, 84]"), spp=128),
    "film.filter": Strip(
        _BALL, "film.filter={}", ("{type: box}", "{type: gaussian}", "{type: mitchell}"),
        coarse=4, spp=512,
    ),
    # ------------------------------------------------------------------ cameras
    "pinhole.fov": Strip(
        _ROW, f"camera={{{{type: pinhole, fov: {{}}, {_LENS}}}}}", ("15", "27", "60")
    ),
    "pinhole.fov_axis": Strip(
        _ROW, f"camera={{{{type: pinhole, fov: 27, fov_axis: {{}}, {_LENS}}}}}",
        ("x", "y", "diagonal"),
    ),
    "pinhole.shutter": Strip(
        "motion-blur", "camera.shutter={}", ("[0, 0.05]", "[0, 0.3]", "[0, 1]")
    ),
    "thin_lens.aperture_radius": Strip(_ROW, "camera.aperture_radius={}", ("0.02", "0.2", "0.6")),
    "thin_lens.focus_distance": Strip(_ROW, "camera.focus_distance={}", ("4", "6.6", "14")),
    "orthographic.height": Strip(
        _ROW, f"camera={{{{type: orthographic, height: {{}}, {_LENS}}}}}", ("1.5", "3", "6")
    ),
    # ------------------------------------------------------------------ pixel filters
    **_pixels("box", radius="0.5|1|2"),
    **_pixels("tent", radius="1|2|4"),
    **_pixels("gaussian", stddev="0.3|0.5|1"),
    # ------------------------------------------------------------------ shapes
    **_shape("sphere", radius="0.5|0.8|1.1", center="[-1, 0, 0]|[0, 0, 0]|[1, 0, 0]"),
    "rectangle.flip_normals": Strip(
        "stage", "nodes.lamp={{shape: {{type: rectangle, flip_normals: {}}}, light: {{type: area,"
        " radiance: 5}}, transform: [{{scale: 0.5}}, {{translate: [-0.6, 1.6, -1]}}]}}",
        ("false", "true"),
    ),
    **_shape("cylinder", "p0: [0, -1, 0], p1: [0, 0.6, 0]", radius="0.2|0.5|0.9"),
    **_shape("mesh", f"{_FACES}, {_NORMALS}", face_normals="false|true"),
    **_shape(
        "mesh", f"{_FACES}, displacement: {_WAVES}, displacement_edge: 0.05",
        displacement_scale="0|0.3|0.8",
    ),
    **_shape("curves", _STRAND, basis="linear|bezier|b_spline|catmull_rom"),
    # ------------------------------------------------------------------ lights
    **_lamp("point", intensity="10|30|90"),
    **_lamp("directional", irradiance="0.5|1.5|4"),
    "area.radiance": Strip(
        "stage", "nodes.lamp={{shape: rectangle, light: {{type: area, radiance: {}}},"
        " transform: [{{scale: 0.8}}, {{look_at: {{origin: [-2, 3.6, 2], target: [-4, 6, 4]}}}}]}}",
        ("3", "10", "[10, 5, 2]"),
    ),
    **_around("constant", radiance="0.2|0.6|[0.4, 0.6, 1]"),
    **_lamp(
        "spot", "intensity: 60", cutoff_angle="6|12|24",
        falloff="linear|smooth|quadratic|quartic",
    ),
    **_lamp("spot", "intensity: 60, cutoff_angle: 16", beam_width="2|8|16"),
    **_around("environment", _SKY, rotate="0|90|180", scale="0.3|1|3"),
    **_around("sky", exposure=-4.5, sun_direction=_SUN),
    **_around(
        "sky", "sun_direction: [0.3, 0.3, 0.3]", -4.5, turbidity="2|5|10",
    ),
    **_around("sun", "scale: 0.015", sun_direction=_SUN),
    **_around("sun", "scale: 0.015, sun_direction: [0.3, 0.5, 0.3]", diameter="0.5|6|25"),
    **_around("sunsky", exposure=-6.0, sun_direction=_SUN),
    **_around(
        "sunsky", "sun_direction: [0.3, 0.5, 0.3]", -6.0, turbidity="2|5|10",
        diameter="0.5|6|25",
    ),
    **_lamp(
        "ies", _PROFILE,
        candela="[[900, 600, 100, 0, 0, 0]]|[[600, 600, 600, 600, 600, 300]]"
        "|[[100, 100, 900, 100, 0, 0]]",
    ),
    **_lamp("projector", _SLIDE, fov="15|30|45", aspect="0.5|1|2", cutoff_angle="6|10|16"),
    # ------------------------------------------------------------------ media
    "homogeneous.sigma_t": Strip("fog", "media.fog.sigma_t={}", ("0.03", "0.12", "0.4"), spp=160),
    "homogeneous.albedo": Strip(
        "fog", "media.fog.albedo={}", ("0.3", "0.95", "[0.5, 0.8, 0.95]"), spp=160
    ),
    "homogeneous.phase": Strip(
        "fog", "media.fog.phase={}",
        ("{type: rayleigh}", "{type: isotropic}", "{type: henyey_greenstein, g: 0.6}"), spp=160,
    ),
    "henyey_greenstein.g": Strip("fog", "media.fog.phase.g={}", ("-0.5", "0", "0.8"), spp=160),
    "grid.sigma_t": Strip("cloud", "media.cloud.sigma_t={}", ("3", "22", "80"), spp=48),
    "grid.albedo": Strip(
        "cloud", "media.cloud.albedo={}", ("0.5", "0.95", "0.998"), spp=48
    ),
    # ------------------------------------------------------------------ integrators
    "path.max_depth": Strip(_BOX, "integrator={{type: path, max_depth: {}}}", ("1", "2", "3", "8")),
    "path.hide_emitters": Strip(
        _BOX, "integrator={{type: path, hide_emitters: {}}}", ("false", "true")
    ),
    "path.light_sampling": Strip(
        "veach-plates", "integrator.light_sampling={}", ("mis", "bsdf", "emitter"), spp=8
    ),
    "volpath.max_depth": Strip("cloud", "integrator.max_depth={}", ("2", "5", "100"), spp=48),
    "ambient_occlusion.distance": Strip(
        _BOX, "integrator={{type: ambient_occlusion, distance: {}}}", ("0.2", "0.6", "3")
    ),
    # ------------------------------------------------------------------ textures
    **_texture("constant", color="0.2|[0.6, 0.1, 0.1]|[0.2, 0.6, 0.1]"),
    **_texture("checkerboard", scale="[4, 2]|[16, 8]|[32, 4]"),
    **_texture("checkerboard", "scale: [8, 4]", offset="[0, 0]|[0.5, 0]|[0.5, 0.5]"),
    **_texture("bitmap", _PALETTE, interpolation="bilinear|nearest", wrap="repeat|mirror|clamp"),
    **_texture("noise", scale="1|4|16"),
    **_texture(
        "noise", "scale: 3", octaves="1|3|8", gain="0.2|0.5|0.9", pattern="fbm|turbulence"
    ),
    **_texture("multiply", f"a: {_CHECKS}", b="0.2|[0.8, 0.3, 0.1]|{type: noise, scale: 6}"),
    **_texture("add", "a: {{type: noise, scale: 6, color1: 0.5}}", b="0|[0.3, 0, 0]|[0, 0, 0.4]"),
    **_texture("mix", "a: [0.7, 0.1, 0.1], b: [0.1, 0.2, 0.6]", weight="0|0.5|1"),
    **_texture("channel", f"texture: {{{{type: bitmap, {_PALETTE}}}}}", channel="r|g|b"),
    **_texture("threshold", "texture: {{type: noise, scale: 6}}", cutoff="0.4|0.5|0.6"),
    **_texture("clamp", "texture: {{type: noise, scale: 6}}", high="0.3|0.5|0.7"),
    # ------------------------------------------------------------------ materials
    **_ball("diffuse", reflectance="0.2|0.8|[0.75, 0.3, 0.12]"),
    **_ball("phong", "diffuse: [0.06, 0.2, 0.45], specular: 0.4", exponent="3|30|300"),
    **_ball("phong", "diffuse: [0.06, 0.2, 0.45]", specular="0|0.2|0.5"),
    **_ball("conductor", metal="silver|gold|copper"),
    **_ball("dielectric", int_ior="1.1|bk7|diamond", dispersion="0|30|8"),
    **_ball("dielectric", "attenuation_color: [0.2, 0.7, 0.4]", attenuation_distance="4|1|0.3"),
    **_ball("rough_conductor", "metal: copper", alpha="0.03|0.2|0.6"),
    **_ball("rough_conductor", "metal: copper, alpha: 0.3", distribution="ggx|beckmann"),
    **_ball("rough_conductor", "metal: copper, alpha_v: 0.1", alpha_u="0.02|0.1|0.5"),
    **_ball("rough_dielectric", alpha="0.02|0.15|0.5"),
    **_ball("thin_dielectric", int_ior="1.1|bk7|diamond"),
    **_ball("plastic", "diffuse_reflectance: [0.7, 0.2, 0.1]", nonlinear="false|true"),
    **_ball("plastic", "diffuse_reflectance: [0.7, 0.2, 0.1]", int_ior="1.1|1.5|2.5"),
    **_ball("rough_plastic", "diffuse_reflectance: [0.05, 0.35, 0.12]", alpha="0.03|0.2|0.6"),
    **_ball("oren_nayar", "reflectance: [0.75, 0.3, 0.12]", sigma="0|30|90"),
    **_ball("eon", "reflectance: [0.75, 0.3, 0.12]", roughness="0|0.5|1"),
    **_ball("diffuse_transmission", "reflectance: 0.1", transmittance="0|0.4|[0.2, 0.8, 0.1]"),
    **_ball("principled", "base_color: [0.7, 0.4, 0.1]",
            metallic="0|0.5|1", roughness="0.1|0.4|0.8", specular="0|0.5|1",
            transmission="0|0.5|1", clearcoat="0|0.5|1", sheen_color="0|0.5|[0.2, 0.4, 1]"),
    **_ball("principled", "base_color: [0.7, 0.4, 0.1], metallic: 1, roughness: 0.4",
            anisotropy="0|0.5|1", iridescence="0|0.5|1"),
    **_ball("principled", "base_color: [0.7, 0.4, 0.1], metallic: 1, iridescence: 1",
            iridescence_thickness="200|400|700"),
    **_ball("principled", "base_color: [0.7, 0.4, 0.1], clearcoat: 1",
            clearcoat_roughness="0|0.3|0.8"),
    **_ball("burley", "base_color: [0.05, 0.2, 0.4]", roughness="0.1|0.4|0.8", sheen="0|0.5|1",
            flatness="0|0.5|1", clearcoat="0|0.5|1"),
    **_ball("burley_thin", "base_color: [0.9, 0.85, 0.6]", spec_trans="0|0.5|1",
            through="0|0.5|1"),
    **_ball("blend", "bsdfs: [{{type: rough_conductor, metal: gold}}, {{type: plastic}}]",
            weight="0|0.5|{type: checkerboard, color0: 0, color1: 1, scale: [16, 8]}"),
    **_ball("mask", "bsdf: {{type: diffuse, reflectance: [0.12, 0.4, 0.5]}}",
            opacity="0.1|0.5|{type: checkerboard, color0: 0, color1: 1, scale: [16, 8]}"),
    **_ball("bump_map", "texture: {{type: noise, scale: 8}}, bsdf: {{type: plastic,"
            " diffuse_reflectance: [0.05, 0.25, 0.1]}}", scale="0|0.05|0.2"),
    **_ball("coated_conductor", "metal: copper", alpha="0.02|0.2|0.6", coat_alpha="0.001|0.1|0.4",
            thickness="0|0.3|1.5"),
    **_ball("subsurface", "color: [0.85, 0.6, 0.45]", radius="0.02|0.1|0.5"),
    **_ball("subsurface", "radius: [0.2, 0.07, 0.04]", color="0.3|0.8|[0.2, 0.7, 0.4]"),
}  # fmt: skip
