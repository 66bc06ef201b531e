"""OpenUSD: units, axes, geometry, instances, lights and cameras."""

import numpy as np
import pytest

from alight.scene.flatten import flatten
from tests.formats.bare import load as bare
from tests.formats.usd.stage import SQUARE, shapes, usd_loader, world_points

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


#: Two squares side by side: six points, two faces, eight corners.
TWO_SQUARES = """
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 5, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]
    uniform token subdivisionScheme = "none"
"""
CORNERS = [0, 1, 2, 3], [1, 4, 5, 2]


@pytest.mark.parametrize(
    ("how", "values", "number"),
    [
        ("constant", 1, lambda face, point: 0),
        ("uniform", 2, lambda face, point: face),
        ("varying", 6, lambda face, point: point),
        ("vertex", 6, lambda face, point: point),
        ("faceVarying", 8, lambda face, point: 4 * face + CORNERS[face].index(point)),
    ],
)
def test_values_belong_to_what_their_interpolation_names(load, how, values, number):
    """Table "Interpolation of Geometric Primitive Variables" of UsdGeom, written once more."""
    rows = ", ".join(f"({n}, {10 * n})" for n in range(values))
    text = f'texCoord2f[] primvars:st = [{rows}] (interpolation = "{how}")'
    (node,) = shapes(load(f'def Mesh "m" {{{TWO_SQUARES}{text}}}')).values()
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)]
    assert node.shape.uvs is not None
    for triangle in node.shape.faces:
        at = node.shape.vertices[triangle, :2]
        face = int(at[:, 0].mean() > 1.0)
        expected = [number(face, points.index((round(x), round(y)))) for x, y in at.tolist()]
        np.testing.assert_allclose(node.shape.uvs[triangle, 0], expected)
        np.testing.assert_allclose(node.shape.uvs[triangle, 1], np.multiply(10, expected))


def test_a_stage_that_names_no_unit_is_in_centimetres(tmp_path):
    (tmp_path / "a.usda").write_text(f'#usda 1.0\ndef Mesh "m" {{{SQUARE}}}\n')
    points = world_points(bare(tmp_path / "a.usda"))
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.02, 0.01, 0.0], atol=1e-9)


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


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_cones_point_along_their_axis(load, axis):
    scene = load(f'def Cone "s" {{ double radius = 1; double height = 5; token axis = "{axis}" }}')
    points, along = world_points(scene), "XYZ".index(axis)
    around = np.linalg.norm(np.delete(points, along, axis=1), axis=1)
    top = points[:, along] > 2.49
    assert top.any() and around[top].max() < 1e-6
    assert around[points[:, along] < -2.49].max() == pytest.approx(1.0, abs=1e-5)


def test_a_primvar_of_normals_counts_more_than_the_attribute(load):
    """UsdGeomPointBased: "if both are specified, the primvar has precedence"."""
    attribute = "normal3f[] normals = [(1, 0, 0), (1, 0, 0), (1, 0, 0), (1, 0, 0)]"
    primvar = attribute.replace("normals", "primvars:normals", 1).replace("(1, 0, 0)", "(0, 0, 1)")
    for text, expected in ((attribute, [1, 0, 0]), (f"{attribute}\n    {primvar}", [0, 0, 1])):
        text = text.replace("primvars:normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]",
                            "primvars:normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]"
                            ' (interpolation = "vertex")')  # fmt: skip
        (node,) = shapes(load(f'def Mesh "m" {{{SQUARE}\n    {text}\n}}')).values()
        np.testing.assert_allclose(node.shape.normals, [expected] * len(node.shape.normals))


def test_invisible_and_helping_geometry_is_left_out_and_said(load):
    scene = load(f"""
def Mesh "shown" {{{SQUARE}; uniform token model:drawMode = "cards" }}
def Mesh "hidden" {{{SQUARE} token visibility = "invisible" }}
def Mesh "helper" {{{SQUARE} uniform token purpose = "guide" }}
def Points "dots" {{ }}
""")
    assert list(shapes(scene)) == ["shown"]
    notes = "\n".join(scene.source.remarks.notes)
    assert "/hidden: invisible" in notes
    assert "/helper: guide geometry" in notes
    assert "model:drawMode: models are shown as they are" in scene.warnings
    assert "/dots: no points" in notes


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
