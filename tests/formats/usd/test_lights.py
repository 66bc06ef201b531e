"""OpenUSD: units of lights, the place of the sky, lenses of cameras."""

import math

import numpy as np
import pytest

import alight
from alight.lights import sun
from alight.scene import flatten
from tests.formats.usd.stage import SQUARE, usd_loader

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


def light_of(load, text):
    scene = load(f'def Mesh "m" {{{SQUARE}}}\n{text}')
    return next(node for _, _, node in scene.walk() if node.light is not None)


def test_area_lights_have_radiance_by_intensity_and_exposure(load):
    light = (
        "float inputs:intensity = 3; float inputs:exposure = 2; color3f inputs:color = (1, 0.5, 0)"
    )
    node = light_of(load, f'def RectLight "l" {{ {light} }}')
    assert node.light.radiance == (12.0, 6.0, 0.0)
    normalised = (
        f"{light}; bool inputs:normalize = 1; float inputs:width = 2; float inputs:height = 3"
    )
    node = light_of(load, f'def RectLight "l" {{ {normalised} }}')
    assert node.light.radiance == (2.0, 1.0, 0.0)
    # It shines along its -z.
    normal = node.transform.apply_normal([0.0, 0.0, 1.0])
    assert normal[2] < 0.0


@pytest.mark.parametrize(
    ("text", "area"),
    [
        ('SphereLight "l" { float inputs:radius = 2', 16 * math.pi),
        ('DiskLight "l" { float inputs:radius = 2', 4 * math.pi),
        ('CylinderLight "l" { float inputs:radius = 2; float inputs:length = 3', 12 * math.pi),
    ],
)
def test_normalised_lights_have_the_power_of_one_square_metre(load, text, area):
    node = light_of(load, f"def {text}; float inputs:intensity = 5; bool inputs:normalize = 1 }}")
    assert node.light.radiance[0] == pytest.approx(5.0 / area)


def test_a_distant_light_gives_its_irradiance(load):
    text = 'def DistantLight "l" {{ float inputs:intensity = 4; float inputs:angle = 60; {} }}'
    node = light_of(load, text.format(""))
    assert node.light.diameter == 60.0
    seen = math.pi * math.sin(math.radians(30)) ** 2
    numbers = sun.place(node.light, node.transform.matrix)[1] * [1, 1, 1, 1, *node.light.scale]
    # Of the disk's radiance, and from where it comes.
    np.testing.assert_allclose(numbers[4:7], 4.0)
    np.testing.assert_allclose(numbers[:3], [0.0, 0.0, 1.0], atol=1e-12)
    node = light_of(load, text.format("bool inputs:normalize = 1"))
    numbers = sun.place(node.light, node.transform.matrix)[1] * [1, 1, 1, 1, *node.light.scale]
    np.testing.assert_allclose(numbers[4:7], 4.0 / seen)


def test_distant_lights_without_a_size_or_in_a_skewed_space_are_parallel(load):
    text = 'def DistantLight "l" {{ float inputs:intensity = 4; float inputs:angle = {}; {} }}'
    assert light_of(load, text.format(0, "")).light.irradiance[0] == 4.0
    skewed = 'double3 xformOp:scale = (1, 2, 1); uniform token[] xformOpOrder = ["xformOp:scale"]'
    node = light_of(load, text.format(60, skewed))
    assert node.light.irradiance[0] == pytest.approx(4 * math.pi * math.sin(math.radians(30)) ** 2)
    assert light_of(load, text.format(90, "")).light.diameter == 60.0


def test_a_small_sphere_far_away_is_as_bright_as_its_point(load):
    text = 'def SphereLight "l" {{ float inputs:intensity = 8; float inputs:radius = {}; {} }}'
    point = light_of(load, text.format(0.1, "bool treatAsPoint = 1")).light
    # Radiance times the disk that is seen.
    assert point.intensity[0] == pytest.approx(8 * math.pi * 0.01)


def test_a_dome_is_the_environment_and_turns_with_its_prim(load, tmp_path):
    alight.outputs.write_image(tmp_path / "sky.exr", np.ones((4, 8, 3)))
    scene = load("""
def DomeLight "sky" {
    asset inputs:texture:file = @sky.exr@
    float inputs:intensity = 2
    float xformOp:rotateY = 30
    uniform token[] xformOpOrder = ["xformOp:rotateY"]
}""")
    sky = scene.environment
    assert (sky.file, sky.scale) == ("sky.exr", (2.0, 2.0, 2.0))
    assert sky.rotate == pytest.approx(30.0)
    plain = load('def DomeLight "sky" { float inputs:intensity = 2 }').environment
    assert (plain.type, plain.radiance) == ("constant", (2.0, 2.0, 2.0))
    # A second one, turned by a parent that must not turn it again.
    scene = load("""
def DomeLight "plain" { float inputs:intensity = 2 }
def Xform "turned" {
    float xformOp:rotateY = 40
    uniform token[] xformOpOrder = ["xformOp:rotateY"]
    def DomeLight "sky" { asset inputs:texture:file = @sky.exr@ }
}""")
    assert scene.environment.type_name() == "constant"
    assert scene.nodes["dome"].light.rotate == pytest.approx(40.0)
    np.testing.assert_array_equal(scene.nodes["dome"].transform.matrix, np.eye(4))


def _shown_at(scene):
    """Axes of the picture of the sky in the world, (3, 3): left or right, pole, middle."""
    (sky,) = flatten(scene).environments
    turn = math.radians(sky.light.rotate)
    about_y = [[math.cos(turn), 0, math.sin(turn)], [0, 1, 0], [-math.sin(turn), 0, math.cos(turn)]]
    return sky.to_world[:3, :3] @ np.array(about_y)


#: From the space of a stage with this axis up to ours.
TO_OURS = {"Y": np.eye(3), "Z": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])}
QUARTER_ABOUT_X = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize(
    ("schema", "up", "pole", "is_on_z"),
    [
        ("DomeLight", "Y", "", False),
        ("DomeLight", "Z", "", False),
        ("DomeLight_1", "Y", "", False),
        ("DomeLight_1", "Z", "", True),
        ("DomeLight_1", "Z", "Y", False),
        ("DomeLight_1", "Y", "Z", True),
    ],
)
def test_a_dome_stands_as_its_prim_does(schema, up, pole, is_on_z, mirror, load, tmp_path):
    """UsdLux: the pole is +y of the prim, or what poleAxis says, +y turned to it about x."""
    alight.outputs.write_image(tmp_path / "sky.exr", np.ones((4, 8, 3)))
    turned = np.linalg.qr(np.random.default_rng(98_600).normal(size=(3, 3)))[0]
    turned[:, 0] *= mirror * np.linalg.det(turned)
    rows = np.eye(4)
    rows[:3, :3] = 2.5 * turned.T
    matrix = "(" + ", ".join(f"({', '.join(map(repr, row))})" for row in rows.tolist()) + ")"
    scene = load(
        f"""def {schema} "sky" {{
    asset inputs:texture:file = @sky.exr@
    {f'uniform token poleAxis = "{pole}"' if pole else ""}
    matrix4d xformOp:transform = {matrix}
    uniform token[] xformOpOrder = ["xformOp:transform"]
}}""",
        up=up,
    )
    expected = TO_OURS[up] @ turned @ (QUARTER_ABOUT_X if is_on_z else np.eye(3))
    np.testing.assert_allclose(_shown_at(scene), expected, atol=1e-6)


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_mirror_and_a_missing_turn_of_a_dome(up, load, tmp_path):
    alight.outputs.write_image(tmp_path / "sky.exr", np.ones((4, 8, 3)))
    text = """
def DomeLight "sky" {
    asset inputs:texture:file = @sky.exr@
    double3 xformOp:scale = SCALE
    uniform token[] xformOpOrder = ["xformOp:scale"]
}"""
    scene = load(text.replace("SCALE", "(-1, 1, 1)"), up=up)
    np.testing.assert_allclose(_shown_at(scene), TO_OURS[up] @ np.diag([-1, 1, 1]), atol=1e-6)
    assert any("its pole is level" in line for line in scene.warnings) == (up == "Z")
    stretched = load(text.replace("SCALE", "(1, 2, 1)"), up=up)
    assert any("is stretched" in line for line in stretched.warnings)


def test_a_camera_has_its_angle_place_and_lens(load):
    scene = load("""
def Camera "c" {
    float focalLength = 20
    float horizontalAperture = 40
    float verticalAperture = 20
    float fStop = 2
    float focusDistance = 300
    double3 xformOp:translate = (0, 0, 700)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}""", unit=0.01)  # fmt: skip
    assert scene.film.size == (1200, 600)
    (camera,) = [node for _, _, node in scene.walk() if node.camera is not None]
    assert camera.camera.fov == pytest.approx(2 * math.degrees(math.atan(0.5)))
    # In the stage's units: tenths of them for the lens.
    assert camera.camera.aperture_radius == pytest.approx(0.5)
    assert camera.camera.focus_distance == 300.0


SAID = "inside of it is no light"


@pytest.mark.parametrize(("radius", "is_said"), [(0.5, False), (5.0, True)])
@pytest.mark.parametrize("unit", [1, 0.01])
def test_a_ball_around_the_scene_shines_outwards_and_that_is_said(load, radius, is_said, unit):
    ball = f'def SphereLight "l" {{ float inputs:radius = {radius} }}'
    scene = load(f'def Mesh "m" {{{SQUARE}}}\n{ball}', unit=unit)
    assert any(SAID in line for line in scene.warnings) == is_said


def test_a_ball_around_the_camera_is_told_of(load):
    ball = 'def SphereLight "l" { float inputs:radius = 0.5 }'
    scene = load(f'def Mesh "m" {{{SQUARE}}}\n{ball}\ndef Camera "c" {{ }}')
    assert any(SAID in line for line in scene.warnings)


@pytest.mark.parametrize(("glow", "studio"), [(0.01, True), (50, False)])
def test_a_solid_that_shines_too_faintly_is_no_lamp(glow, studio, load):
    text = (
        preview_of(glow)
        + f"""def Mesh "m" {{{SQUARE}}}
    def Sphere "lamp" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    double radius = 0.1
    rel material:binding = </m0>
    }}"""
    )
    assert (load(text).environment is not None) is studio


def preview_of(glow):
    """A material that shines."""
    return f"""
    def Material "m0" {{
        token outputs:surface.connect = </m0/s.outputs:surface>
        def Shader "s" {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:emissiveColor = ({glow}, {glow}, {glow})
            token outputs:surface
        }}
    }}
    """
