"""OpenUSD: displacement of preview surfaces and of networks of MaterialX."""

import numpy as np
import pytest
from PIL import Image

from alight.formats.geometry.bounds import Bounds
from alight.formats.geometry.displacement import Heights, Lifting
from alight.formats.reading.report import Report
from alight.scene.flatten import flatten
from alight.shapes.mesh import Mesh
from tests.formats.bare import load
from tests.formats.usd.stage import SQUARE, shapes, stage_text

pytest.importorskip("pxr")

UVS = 'texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")'
MESH = """def Mesh "m" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ {square}
    rel material:binding = </look>
    {more}
}}
"""
PREVIEW = """def Material "look" {
    token outputs:surface.connect = </look/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        %s
        token outputs:surface
    }
    def Shader "t" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @p.png@
        float4 inputs:scale = (9, 0.5, 9, 9)
        float4 inputs:bias = (9, -0.1, 9, 9)
        float outputs:g
    }
}
"""
NETWORK = """def Material "look" {
    token outputs:mtlx:surface.connect = </look/s.outputs:out>
    token outputs:mtlx:displacement.connect = </look/d.outputs:out>
    def Shader "s" {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        token outputs:out
    }
    def Shader "d" {
        uniform token info:id = "ND_displacement_float"
        %s
        float inputs:scale = 0.5
        token outputs:out
    }
    def Shader "t" {
        uniform token info:id = "ND_image_float"
        asset inputs:file = @p.png@
        float outputs:out
    }
}
"""
OF_PICTURE = "float inputs:displacement.connect = </look/t.outputs:%s>"


@pytest.fixture
def mesh_of(tmp_path):
    """The flat mesh of a material, and what is said."""
    Image.fromarray(np.full((2, 2, 3), (255, 51, 0), np.uint8)).save(tmp_path / "p.png")

    def read(material, more=UVS):
        text = material + MESH.format(square=SQUARE, more=more)
        (tmp_path / "a.usda").write_text(stage_text(text))
        scene = load(tmp_path / "a.usda")
        (node,) = shapes(scene).values()
        flatten(scene)
        return node.shape, scene

    return read


def height_at(scene, mesh, texel):
    """How far a point moves where the picture has a value."""
    value = mesh.displacement
    if isinstance(value, str):
        assert scene.textures[value].type_name() in ("bitmap", "channel")
        value = texel
    return mesh.displacement_scale * (value - mesh.displacement_midlevel)


def test_a_number_lifts_a_preview_surface(mesh_of):
    mesh, scene = mesh_of(PREVIEW % "float inputs:displacement = -0.25")
    assert height_at(scene, mesh, None) == pytest.approx(-0.25)
    assert not any("displacement" in text for text in scene.warnings)


def test_a_channel_of_a_picture_lifts_a_preview_surface(mesh_of):
    mesh, scene = mesh_of(PREVIEW % (OF_PICTURE % "g"))
    assert scene.textures[mesh.displacement].channel == "g"
    assert scene.textures[mesh.displacement].texture.color_space == "linear"
    assert height_at(scene, mesh, 0.2) == pytest.approx(0.5 * 0.2 - 0.1, abs=1e-6)
    assert height_at(scene, mesh, 1.0) == pytest.approx(0.4)


@pytest.mark.parametrize(("given", "wanted"), [("float inputs:displacement = 0.4", 0.2),
                                               (OF_PICTURE % "out", 0.1)])  # fmt: skip
def test_a_network_of_materialx_lifts_a_surface(given, wanted, mesh_of):
    mesh, scene = mesh_of(NETWORK % given)
    assert height_at(scene, mesh, 0.2) == pytest.approx(wanted)
    assert not any("displacement" in text for text in scene.warnings)


def test_a_surface_at_rest_is_not_cut(mesh_of):
    for text in ("", "float inputs:displacement = 0"):
        mesh, _ = mesh_of(PREVIEW % text)
        assert mesh.displacement is None


def test_a_mesh_without_coordinates_stays_where_it_is(mesh_of):
    mesh, scene = mesh_of(PREVIEW % (OF_PICTURE % "g"), more="")
    assert mesh.displacement is None
    assert any("without texture coordinates" in text for text in scene.warnings)


def test_solids_stay_as_they_are(tmp_path):
    text = PREVIEW % "float inputs:displacement = 0.5"
    text += 'def Sphere "m" (prepend apiSchemas = ["MaterialBindingAPI"]) {'
    (tmp_path / "a.usda").write_text(stage_text(text + " rel material:binding = </look> }\n"))
    said = load(tmp_path / "a.usda").warnings
    assert any("displacement is left out of what is no mesh" in line for line in said)


def test_the_camera_sees_what_is_lifted(mesh_of):
    """The square is 2 m by 1 m; 3 m above it is as much to be seen."""
    origins = []
    for height in (0.0, 3.0):
        _, scene = mesh_of(PREVIEW % f"float inputs:displacement = {height}")
        origins.append(scene.camera.transform.matrix[:3, 3])
    assert np.linalg.norm(origins[1]) > np.linalg.norm(origins[0]) + 2.0


def test_needles_and_many_triangles_are_not_cut_too_fine():
    """A mesh never has more than the budget, however long and thin its triangles are."""
    lifting = Lifting(Report(), {})
    n = 20_000
    x = np.arange(n, dtype=np.float32)
    vertices = np.stack([0 * x, x, 0 * x, 0 * x + 1e4, x, 0 * x, 0 * x, x + 1e-3, 0 * x], 1)
    mesh = Mesh(
        vertices=vertices.reshape(-1, 3), faces=np.arange(3 * n, dtype=np.int32).reshape(-1, 3)
    )
    lifted = lifting.lift(mesh, Heights(1.0, 2.0), Bounds(), np.eye(4))
    assert lifted.displacement_edge > np.sqrt(2.0) * 2e4 / 256
    assert lifting.count <= 150_000


@pytest.mark.parametrize("scale", [float("inf"), float("nan"), 1e300])
def test_heights_that_are_no_lengths_are_left_out(scale):
    report = Report()
    mesh = Mesh(vertices=np.eye(3, dtype=np.float32), faces=np.array([[0, 1, 2]], np.int32))
    lifted = Lifting(report, {}).lift(mesh, Heights(1.0, scale), Bounds(), np.eye(4))
    assert lifted is mesh
    assert report.warnings
