"""PLY, OBJ and STL: positions, polygons, normals, texture coordinates and colours come through."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from alight.core.errors import SceneError
from alight.meshes import obj, ply, stl
from alight.meshes.triangles import MeshArrays, fan, srgb_to_linear
from tests.formats.mutate import STL, binary_stl

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
UVS = [[0, 0], [0.25, 0], [0.25, 0.5], [0, 0.5]]
COLORS = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]]


def square_ply(order):
    """Write a quad with everything, in the given byte order."""
    header = f"ply\nformat {order} 1.0\ncomment made by hand\nelement vertex 4\n"
    header += "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz", "s", "t"))
    header += "".join(f"property uchar {n}\n" for n in ("red", "green", "blue", "alpha"))
    header += "element extra 1\nproperty list uchar short values\nproperty double d\n"
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    if order == "ascii":
        rows = [
            " ".join(map(str, [*p, 0, 0, 1, *uv, *c, 255]))
            for p, uv, c in zip(SQUARE, UVS, COLORS, strict=True)
        ]
        return (header + "\n".join([*rows, "2 7 -8 0.5", "4 0 1 2 3"]) + "\n").encode()
    sign = "<" if "little" in order else ">"
    body = b""
    for p, uv, c in zip(SQUARE, UVS, COLORS, strict=True):
        body += np.array([*p, 0, 0, 1, *uv], sign + "f4").tobytes() + bytes([*c, 255])
    body += (
        b"\x02" + np.array([7, -8], sign + "i2").tobytes() + np.array(0.5, sign + "f8").tobytes()
    )
    return header.encode() + body + b"\x04" + np.array([0, 1, 2, 3], sign + "i4").tobytes()


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_brings_everything_through_in_order(order):
    mesh = ply.read(square_ply(order))
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(mesh.normals, [[0, 0, 1]] * 4)
    np.testing.assert_array_equal(mesh.uvs, UVS)
    np.testing.assert_allclose(mesh.colors[:3], np.eye(3))
    # sRGB 128 is 21.6 % of the light of 255.
    np.testing.assert_allclose(mesh.colors[3], 0.2158605, rtol=1e-5)
    assert [array.dtype.str for array in mesh[:5]] == ["<f4", "<i4", "<f4", "<f4", "<f4"]
    assert mesh.more_uvs is None


def test_ply_with_triangles_and_quads_mixed():
    text = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
    text += b"property double z\nelement face 3\nproperty uchar flags\n"
    text += b"property list int uint vertex_index\nend_header\n0 0 0 1 0 0 1 1 0 0 1 0\n"
    mesh = ply.read(text + b"9 3 0 1 2\n9 4 0 1 2 3\n9 2 0 1\n")
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 1, 2], [0, 2, 3]])


@given(
    seed=st.integers(0, 2**32 - 1),
    extras=st.tuples(st.booleans(), st.booleans(), st.booleans()),
    sets=st.integers(0, 7),
)
@settings(max_examples=30, deadline=None)
def test_saved_ply_comes_back_bit_for_bit(tmp_path_factory, seed, extras, sets):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 40))
    parts = [rng.random((count, width)).astype(np.float32) for width in (3, 2, 3)]
    normals, uvs, colors = (p if e else None for p, e in zip(parts, extras, strict=True))
    faces = rng.integers(0, count, (7, 3)).astype(np.int32)
    vertices = rng.normal(size=(count, 3)).astype(np.float32)
    more = rng.random((sets, count, 2)).astype(np.float32) if sets and uvs is not None else None
    mesh = MeshArrays(vertices, faces, normals, uvs, colors, more)
    path = tmp_path_factory.mktemp("ply") / "mesh.ply"
    ply.save(path, mesh)
    for before, after in zip(mesh, ply.read(path.read_bytes()), strict=True):
        assert (before is None) == (after is None)
        assert before is None or np.array_equal(before, after)


def test_obj_keeps_the_order_of_plain_vertices():
    mesh = obj.read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 4 3 2 1\n")
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces, [[3, 2, 1], [3, 1, 0]])
    assert mesh.normals is None
    assert mesh.uvs is None


def test_obj_splits_vertices_at_seams():
    text = b"""# two triangles that share an edge, but not its texture coordinates
    v 0 0 0
    v 1 0 0
    v 1 1 0
    v 0 1 0
    vt 0 0
    vt 1 0
    vt 0.5 0.5
    vn 0 0 1
    vn 0 1 0
    f 1/1/1 2/2/1 3/3/1
    f -4/2/2 -2/3/2 \\
      -1/1/2
    """
    mesh = obj.read(text)
    corners = mesh.vertices[mesh.faces]
    np.testing.assert_array_equal(corners[0], [SQUARE[0], SQUARE[1], SQUARE[2]])
    np.testing.assert_array_equal(corners[1], [SQUARE[0], SQUARE[2], SQUARE[3]])
    np.testing.assert_array_equal(mesh.uvs[mesh.faces[0]], [[0, 0], [1, 0], [0.5, 0.5]])
    np.testing.assert_array_equal(mesh.uvs[mesh.faces[1]], [[1, 0], [0.5, 0.5], [0, 0]])
    np.testing.assert_array_equal(mesh.normals[mesh.faces[0]], [[0, 0, 1]] * 3)
    np.testing.assert_array_equal(mesh.normals[mesh.faces[1]], [[0, 1, 0]] * 3)


def test_obj_vertex_colours():
    mesh = obj.read(b"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\n")
    np.testing.assert_allclose(mesh.colors, [[1, 0, 0], [0, 1, 0], [0.2140411] * 3], rtol=1e-5)


@pytest.mark.parametrize("kind", ["ascii", "binary"])
def test_ply_strips_turn_every_other_triangle_around(kind):
    """A row of quads in two strips, one of them joined by -1 and by corners that come twice."""
    points = np.array([(x, y, 0) for x in range(6) for y in range(2)], "<f4")
    strip = [1, 0, 3, 2, 5, 4, -1, 5, 4, 7, 6, 6, 7, 7, 6, 9, 8], [9, 8, 11, 10]
    kinds = {"ascii": "ascii 1.0", "binary": "binary_little_endian 1.0"}
    head = f"""ply
format {kinds[kind]}
element vertex {len(points)}
property float x
property float y
property float z
element tristrips 2
property list int int vertex_indices
end_header
"""
    if kind == "ascii":
        lines = [*points.astype(int), *([len(row), *row] for row in strip)]
        data = "\n".join(" ".join(map(str, line)) for line in lines).encode()
    else:
        rows = [np.array([len(row), *row], "<i4").tobytes() for row in strip]
        data = points.tobytes() + b"".join(rows)
    mesh = ply.read(head.encode() + data)
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    np.testing.assert_array_equal(areas, [0.5] * 10)
    # Each half of each quad once.
    assert len({frozenset(face) for face in mesh.faces.tolist()}) == 10


def test_fans_cover_polygons_once():
    corners, polygons = fan(np.array([3, 2, 5, 0, 4]))
    np.testing.assert_array_equal(polygons, [0, 2, 2, 2, 4, 4])
    np.testing.assert_array_equal(
        corners, [[0, 1, 2], [5, 6, 7], [5, 7, 8], [5, 8, 9], [10, 11, 12], [10, 12, 13]]
    )


def test_srgb_curve_at_its_ends_and_joint():
    values = np.array([0.0, 0.04045, 1.0], np.float32)
    np.testing.assert_allclose(srgb_to_linear(values), [0.0, 0.0031308, 1.0], rtol=1e-4)


def test_stl_joins_equal_corners_in_both_spellings():
    for data in (STL, binary_stl(), b"solid" + binary_stl()[5:], STL.upper(), b"\n " + STL):
        mesh = stl.read(data)
        # -0 is 0; nearly the same place is another one.
        np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
        np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
        assert mesh.normals is None and mesh.uvs is None
        assert [array.dtype.str for array in mesh[:2]] == ["<f4", "<i4"]


def test_stl_keeps_corners_that_differ_in_the_last_bit():
    near = STL.replace(b"vertex 0 1 0", b"vertex 1e-30 1 0").replace(b"-0 0 0", b"1e-30 0 0")
    assert len(stl.read(near).vertices) == 5


@pytest.mark.parametrize("count", range(8))
def test_facets_of_stl_have_three_vertices(count):
    vertices = "".join(f"vertex {i} {i * i} 0\n" for i in range(count))
    text = f"solid s\nfacet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\nendsolid s\n"
    try:
        faces = len(stl.read(text.encode()).faces)
    except SceneError as error:
        assert count != 3
        assert f"must have 3 vertices, got {count}" in str(error)
    else:
        assert (count, faces) == (3, 1)
