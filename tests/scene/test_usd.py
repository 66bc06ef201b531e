"""OpenUSD: units, axes, geometry, instances, lights, cameras, and what is refused."""

import zipfile

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import SceneError
from alight.scene.flatten import flatten
from tests.scene.usd_stage import MATERIAL, SQUARE, shapes, stage_text, usd_loader, world_points

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


def extreme_points(item):
    """World points of a shape that reach as far as it does along the axes."""
    unit = np.vstack([np.eye(3), -np.eye(3)])
    points = {
        "mesh": lambda s: s.vertices,
        "sphere": lambda s: s.radius * unit,
        "cube": lambda s: np.sign(np.indices((2, 2, 2)).reshape(3, 8).T - 0.5),
        "rectangle": lambda s: np.array([[x, y, 0.0] for x in (-1, 1) for y in (-1, 1)]),
    }[item.shape.type](item.shape)
    return points @ item.to_world[:3, :3].T + item.to_world[:3, 3]


# ---------------------------------------------------------------------------- geometry


def test_axes_and_units_become_ours(load):
    scene = load(f'def Mesh "m" {{{SQUARE}}}', up="Z", unit=0.01)
    points = world_points(scene)
    # Centimetres; what is up (z) there is y here, and y goes away from the viewer.
    assert np.abs(points - [0, 0, 0]).max() == pytest.approx(0.02)
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.02, 0.0, 0.01], atol=1e-9)
    assert points[:, 2].min() == pytest.approx(-0.01)


def test_transforms_are_nested_and_can_be_reset(load):
    scene = load(f"""
def Xform "a" {{
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "turned" {{ {SQUARE}
        float xformOp:rotateZ = 90
        uniform token[] xformOpOrder = ["xformOp:rotateZ"]
    }}
    def Mesh "reset" {{ {SQUARE}
        double3 xformOp:translate = (0, 0, 5)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
    }}
}}""")
    points = world_points(scene)
    np.testing.assert_allclose(points[:4].max(axis=0), [1.0, 2.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(points[4:].min(axis=0), [0.0, 0.0, 5.0], atol=1e-6)


def test_left_handed_faces_are_turned_around(load):
    def normal(extra):
        (node,) = shapes(load(f'def Mesh "m" {{{SQUARE}{extra}}}')).values()
        a, b, c = node.shape.vertices[node.shape.faces[0]]
        return np.cross(b - a, c - a)[2]

    assert normal("") > 0.0 > normal('uniform token orientation = "leftHanded"')


def test_holes_and_lone_edges_are_left_out(load):
    (node,) = shapes(
        load("""
def Mesh "m" {
    int[] faceVertexCounts = [3, 2, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 1, 0, 2, 3]
    int[] holeIndices = [0]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
}""")
    ).values()
    assert len(node.shape.faces) == 1
    np.testing.assert_allclose(node.shape.vertices.max(axis=0), [2, 1, 0])


def test_meshes_are_subdivided_unless_they_say_otherwise(load):
    text = f'def Mesh "m" {{{SQUARE}}}'
    assert len(next(iter(shapes(load(text)).values())).shape.faces) == 2
    scene = load(text.replace("none", "catmullClark"))
    assert len(next(iter(shapes(scene).values())).shape.faces) == 32
    assert any("Catmull" in line for line in scene.warnings)
    assert len(next(iter(shapes(load(text.replace("none", "bilinear"))).values())).shape.faces) == 2


@pytest.mark.parametrize(
    ("how", "values"),
    [
        ("faceVarying", "[(0, 0), (1, 0), (1, 1), (0, 1)]"),
        ("vertex", "[(0, 0), (1, 0), (1, 1), (0, 1)]"),
    ],
)
def test_texture_coordinates_follow_the_points(load, how, values):
    text = f'texCoord2f[] primvars:st = {values} (interpolation = "{how}")'
    (node,) = shapes(load(f'def Mesh "m" {{{SQUARE}{text}}}')).values()
    np.testing.assert_allclose(node.shape.uvs, node.shape.vertices[:, :2] / [2, 1])


@pytest.mark.parametrize(
    ("prim", "extent"),
    [
        ('def Sphere "s" { double radius = 2 }', [4, 4, 4]),
        ('def Cube "s" { double size = 3 }', [3, 3, 3]),
        ('def Cylinder "s" { double radius = 1; double height = 5; token axis = "X" }', [5, 2, 2]),
        ('def Cone "s" { double radius = 1; double height = 5; token axis = "Y" }', [2, 5, 2]),
        ('def Capsule "s" { double radius = 1; double height = 5; token axis = "Z" }', [2, 2, 7]),
        ('def Plane "s" { double width = 3; double length = 4; token axis = "Z" }', [3, 4, 0]),
    ],
)
def test_solids_have_their_size(load, prim, extent):
    points = [extreme_points(item) for item in flatten(load(prim)).shapes]
    np.testing.assert_allclose(np.ptp(np.concatenate(points), axis=0), extent, atol=0.01)


def test_invisible_and_helping_geometry_is_left_out_and_said(load):
    scene = load(f"""
def Mesh "shown" {{{SQUARE}; uniform token model:drawMode = "cards" }}
def Mesh "hidden" {{{SQUARE} token visibility = "invisible" }}
def Mesh "helper" {{{SQUARE} uniform token purpose = "guide" }}
def BasisCurves "hair" {{ int[] curveVertexCounts = [4] }}
""")
    assert list(shapes(scene)) == ["shown"]
    notes = "\n".join(scene.source.remarks.notes)
    assert "/hidden: invisible" in notes
    assert "/helper: guide geometry" in notes
    assert "model:drawMode: models are shown as they are" in scene.warnings
    assert "/hair: BasisCurves is not covered" in notes


# ---------------------------------------------------------------------------- instances


def test_instances_share_what_they_show(load):
    scene = load(f"""
class "_thing" {{ def Mesh "m" {{{SQUARE}}} }}
def Xform "a" (instanceable = true; inherits = </_thing>) {{
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def Xform "b" (instanceable = true; inherits = </_thing>) {{ }}
""")
    assert len(scene.prototypes) == 1
    assert {node.instance for node in scene.nodes.values()} == set(scene.prototypes)
    assert sorted(item.to_world[0, 3] for item in flatten(scene).shapes) == [0.0, 10.0]


def test_point_instancers_place_their_prototypes(load):
    scene = load(f"""
def PointInstancer "p" {{
    rel prototypes = [</p/one>, </p/two>]
    int[] protoIndices = [0, 1, 0]
    point3f[] positions = [(0, 0, 1), (0, 0, 2), (0, 0, 3)]
    float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1)]
    int64[] invisibleIds = [2]
    def Mesh "one" {{{SQUARE}}}
    def Xform "two" {{ def Sphere "s" {{ }} }}
}}""")
    placed = [
        (type(item.shape).__name__, item.to_world[2, 3], item.to_world[0, 0])
        for item in flatten(scene).shapes
    ]
    assert sorted(placed) == [("Mesh", 1.0, 1.0), ("Sphere", 2.0, 2.0)]


# ---------------------------------------------------------------------------- packages, mistakes


def test_pictures_inside_of_packages_are_read(tmp_path):
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "p.png")
    text = "color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>"
    (tmp_path / "a.usda").write_text(stage_text(MATERIAL % (text, SQUARE)))
    with zipfile.ZipFile(tmp_path / "a.usdz", "w", zipfile.ZIP_STORED) as package:
        for name in ("a.usda", "p.png"):
            data = (tmp_path / name).read_bytes()
            info = zipfile.ZipInfo(name)
            # The format wants the data at multiples of 64 bytes.
            start = package.fp.tell() + 30 + len(name) + 4
            info.extra = b"\x86\x19" + ((-start) % 64).to_bytes(2, "little") + bytes((-start) % 64)
            package.writestr(info, data)
    (tmp_path / "p.png").unlink()
    scene = alight.load(tmp_path / "a.usdz")
    texels = scene.bsdfs["m"].bsdf.base_color.b.pixels
    assert (texels.width, texels.height) == (2, 2)


PICTURE = MATERIAL % ("color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>", SQUARE)
MISTAKES = {
    "type": ('def Cube "c" { token size = "x" }', "/c size must be of type double, got string"),
    "unknown type": ('def Cube "c" { uble size = 1 }', "/c size must be of type double"),
    "transform": (
        (
            'def Xform "x" { float xformOp:translate = 1\n'
            'uniform token[] xformOpOrder = ["xformOp:translate"] }'
        ),
        "OpenUSD: Invalid combination of opType (TypeTranslate)",
    ),
    "axis": ('def Plane "p" { uniform token axis = "W" }', '/p unknown axis "W"'),
    "list": ('def Sphere "s" { double[] radius = [1] }', "radius must be of type double, got"),
    "indices": (
        f'def Mesh "m" {{{SQUARE}}}'.replace("2, 3]", "2, 9]"),
        "/m faceVertexIndices must be points, 0 to 3, got 9",
    ),
    "counts": (
        f'def Mesh "m" {{{SQUARE}}}'.replace("[4]", "[5]"),
        "/m faceVertexIndices must have 5 numbers, got 4",
    ),
    "points": (
        f'def Mesh "m" {{{SQUARE}}}'.replace("(2, 1, 0)", "(2, nan, 0)"),
        "/m points must be finite",
    ),
    "not finite": (
        'def Camera "c" { float verticalAperture = nan }',
        "/c verticalAperture must be finite, got nan",
    ),
    "syntax": ("def Mesh {", "is no OpenUSD stage"),
    "reference": ('def "m" (references = @gone.usda@) { }', "does not fit together"),
    "reach": ('def "m" (references = @../out.usda@) { }', "outside of its own folder: out.usda"),
    "picture": (PICTURE, '/m/picture no such picture: "p.png"'),
    "kind of an input": (
        PICTURE.replace("float4 inputs:scale = (0.5, 0.5, 0.5, 1)", "float inputs:scale = 2"),
        "/m/picture inputs:scale must be 4 numbers, got 2.0",
    ),
    "text for a number": (
        PICTURE.replace("float2 inputs:scale = (2, 3)", 'string inputs:rotation = "x"'),
        '/m/place inputs:rotation must be a number, got "x"',
    ),
    "unknown type of an input": (
        PICTURE.replace("float4 inputs:scale", "flota4 inputs:scale"),
        "/m/picture inputs:scale is of a type that OpenUSD does not know",
    ),
    "prototype": (
        'def PointInstancer "p" { int[] protoIndices = [3]; point3f[] positions = [(0, 0, 0)] }',
        "/p protoIndices must be in",
    ),
}


@pytest.mark.parametrize(("text", "message"), MISTAKES.values(), ids=MISTAKES.keys())
def test_mistakes_are_refused_with_their_prim(tmp_path, text, message):
    folder = tmp_path / "scene"
    folder.mkdir()
    (tmp_path / "out.usda").write_text(stage_text('def "x" { }'))
    if text != PICTURE:
        Image.new("RGB", (2, 2)).save(folder / "p.png")
    (folder / "a.usda").write_text(stage_text(text))
    with pytest.raises(SceneError) as caught:
        alight.load(folder / "a.usda")
    assert message in " ".join(str(caught.value).split())


@pytest.mark.parametrize("unit", ["inf", "nan", "0", "-1"])
def test_units_that_are_no_lengths_are_refused(unit, tmp_path):
    (tmp_path / "a.usda").write_text(stage_text('def Sphere "s" { }', unit=unit))
    with pytest.raises(SceneError, match="metersPerUnit\n  must be > 0 and at most 1e\\+12"):
        alight.load(tmp_path / "a.usda")


@pytest.mark.parametrize("kind", ["string[]", "coler3f[]"])
def test_primvars_without_numbers_are_left_out_and_said(load, kind):
    color = f'{kind} primvars:displayColor = ["a", "b", "c", "d"]' if kind[0] == "s" else ""
    color = color or f"{kind} primvars:displayColor = [(0, 0, 1)]"
    scene = load(f'def Mesh "m" {{{SQUARE}{color} (interpolation = "vertex")}}')
    (bsdf,) = scene.bsdfs.values()
    assert bsdf.bsdf.reflectance == pytest.approx((0.18, 0.18, 0.18))
    assert any("primvars:displayColor holds no rows of" in line for line in scene.warnings)


def test_the_command_line_says_what_was_read(tmp_path):
    (tmp_path / "a.usda").write_text(stage_text(f'def Mesh "m" {{{SQUARE}}}'))
    result = CliRunner().invoke(app, ["info", str(tmp_path / "a.usda")])
    assert result.exit_code == 0, result.output
    assert "the file has no light" in result.output
    assert "the file has no camera" in result.output
