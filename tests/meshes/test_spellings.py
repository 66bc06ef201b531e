"""PLY and OBJ files spelled in all ways that the formats allow: they hold the same mesh."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.meshes import obj, ply

#: Numbers of PLY files by both of their names, as its author and later programs spell them.
TYPES = {
    "i1": ("char", "int8"), "u1": ("uchar", "uint8"), "i2": ("short", "int16"),
    "u2": ("ushort", "uint16"), "i4": ("int", "int32"), "u4": ("uint", "uint32"),
    "f4": ("float", "float32"), "f8": ("double", "float64"),
}  # fmt: skip
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def opened(read, data):
    """What is read, and why it is not; one of the two is None."""
    try:
        return read(data), None
    except SceneError as error:
        return None, str(error)


def packed(value, kind, order):
    return f"{value:g} ".encode() if not order else np.array(value, order + kind).tobytes()


def ply_file(rng, tables, order, newline):
    """Elements by name: (property, kind, kind of its length or None) -> a value for each row."""
    form = next(name for name, sign in FORMATS.items() if sign == order)
    lines, body = ["ply", "comment element vertex 7", f"format {form} 1.0"], []
    lines += ["obj_info property float x", "", "comment"]
    for name, (columns, rows) in tables.items():
        lines.append(f"element {name} {len(rows)}")
        for column, kind, length in columns:
            words = [str(rng.choice(TYPES[k])) for k in (length, kind) if k]
            lines.append(" ".join(["property", *(["list"] if length else []), *words, column]))
        for row in rows:
            for value, (_, kind, length) in zip(row, columns, strict=True):
                numbers = value if length else [value]
                body += [packed(len(value), length, order)] if length else []
                body += [packed(number, kind, order) for number in numbers]
            body += [b"\n"] if not order else []
    head = newline.join([*lines, "end_header\n"]).encode()
    return head + b"".join(body)


def some_tables(rng):
    """A mesh among columns and elements that mean nothing, and what it is."""
    points = rng.integers(-100, 100, (9, 3))
    extra = [("quality", "i2", None), ("links", "u4", "u2"), ("flags", "u1", None)]
    coordinates = [(axis, "f8" if axis == "y" else "f4", None) for axis in "xyz"]
    columns = [extra[0], coordinates[0], extra[1], *coordinates[1:], extra[2]]
    rows = [(-7, x, list(range(i % 3)), y, z, 250) for i, (x, y, z) in enumerate(points.tolist())]
    # The first face is a triangle, the second is not: rows are not alike.
    sizes = [3, *rng.permutation([2, 3, 3, 1, 3, 0]).tolist()]
    faces = [rng.permutation(9)[:size].tolist() for size in sizes]
    of_faces = [("material", "i1", None), ("vertex_indices", "i4", "u1"), ("weight", "f4", None)]
    strip = rng.permutation(9)[:5].tolist()
    tables = {
        "camera": ([("id", "i4", None)], [(70_000,), (-1,)]),
        "vertex": (columns, rows),
        "edge": ([("v", "i2", "i4")], [([3, -4, 5],)]),
        "tristrips": ([("vertex_indices", "i4", "i4")], [([*strip, -1, *strip[:3]],)]),
        "face": (of_faces, [(-1, face, 0.5) for face in faces]),
    }
    strips = [strip[0:3], [strip[2], strip[1], strip[3]], strip[2:5], strip[:3]]
    return tables, points, [face for face in faces if len(face) == 3] + strips


def turned(faces):
    """Triangles that begin at their smallest corner: where they begin does not matter."""
    return [tuple(np.roll(face, -int(np.argmin(face)))) for face in np.asarray(faces).tolist()]


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"], ids=["LF", "CR LF", "CR"])
@pytest.mark.parametrize("order", ["", "<", ">"], ids=FORMATS)
def test_ply_files_hold_what_was_put_into_them(order, newline):
    rng = np.random.default_rng(109)
    for _ in range(4):
        tables, points, faces = some_tables(rng)
        mesh, problem = opened(ply.read, ply_file(rng, tables, order, newline))
        assert problem is None
        np.testing.assert_array_equal(mesh.vertices, points)
        assert turned(mesh.faces) == turned(faces)
        assert mesh.normals is mesh.uvs is mesh.colors is None


VERTEX = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("format ascii 1.0\nelement vertex 1 2\n", "line 3 makes no sense"),
        ("format ascii 1.0\nelement vertex\n", "line 3 makes no sense"),
        ("format ascii 1.0\nelement vertex -1\n", "line 3 makes no sense"),
        ("format ascii 1.0\nelement vertex 1\nproperty float\n", "line 4 makes no sense"),
        ("format ascii 1.0\nelement vertex 1\nproperty float x y\n", "line 4 makes no sense"),
        (f"format ascii 1.0\n{VERTEX}property list uchar x\n", "line 7 makes no sense"),
        (f"format ascii 1.0\n{VERTEX}property list uchar int x y\n", "line 7 makes no sense"),
        (f"format ascii 1.0\n{VERTEX}property list float int x\n", "must be a whole number type"),
        (f"format ascii 1.0\n{VERTEX}property list uchar real x\n", 'type "real"'),
        ("format ascii 1.0\nproperty float x\n", "line 3 makes no sense"),
        ("format text 1.0\n", 'format "text"'),
        (VERTEX, "names no format"),
        ("format ascii 1.0\nelement vertex 999\n", "claims 999 vertex rows"),
        ("format ascii 1.0\n", "no element vertex"),
    ],
)
def test_headers_that_make_no_sense_are_refused(header, says):
    _, problem = opened(ply.read, f"ply\n{header}end_header\n0 0 0\n".encode())
    assert says in str(problem)


def test_lists_of_floats_may_be_counted_by_whole_numbers():
    """What they hold means nothing to us; the rows behind it do."""
    text = f"ply\nformat ascii 1.0\n{VERTEX}property list uchar float w\n"
    text += "element face 1\nproperty list uchar int vertex_index\nend_header\n"
    mesh, problem = opened(ply.read, f"{text}1 2 3 2 0.5 0.25\n3 0 0 0\n".encode())
    assert problem is None
    assert mesh.vertices.tolist() == [[1, 2, 3]]


def test_corners_of_obj_files_count_from_the_start_or_from_the_end():
    """Tables of different lengths grow between faces: -1 is another row each time."""
    rng = np.random.default_rng(109)
    for _ in range(8):
        counts, forward, backward = [0, 0, 0], [], []
        for _ in range(5):
            for kind, (name, width) in enumerate((("v", 3), ("vt", 2), ("vn", 3))):
                for _ in range(int(rng.integers(3, 6)) if kind == 0 else int(rng.integers(1, 4))):
                    numbers = " ".join(map(str, rng.integers(1, 99, width)))
                    forward.append(f"{name} {numbers}")
                    backward.append(forward[-1])
                    counts[kind] += 1
            for _ in range(2):
                corners = np.stack([rng.permutation(n)[[0, -1, n // 2]] for n in counts], axis=1)
                ends = corners - counts
                forward.append("f " + " ".join("/".join(map(str, c + 1)) for c in corners))
                backward.append("f " + " ".join("/".join(map(str, c)) for c in ends))
        files = ["\n".join(lines).encode() for lines in (forward, backward)]
        (one, _), (other, problem) = (opened(obj.read, data) for data in files)
        assert problem is None
        for a, b in zip(one[:4], other[:4], strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("kind", TYPES)
def test_every_type_reaches_to_both_of_its_ends(kind, form):
    """By both of its names; small numbers are the same in all types of a width."""
    whole = np.iinfo(kind) if kind[0] in "iu" else np.finfo("f4")
    ends = [float(np.float32(end)) if kind[0] == "f" else end for end in (whole.min, whole.max)]
    for name in TYPES[kind]:
        lines = ["ply", f"format {form} 1.0", "element vertex 2"]
        lines += [f"property {name} {axis}" for axis in "xyz"]
        body = b"".join(
            f"{end!r} ".encode()
            if form == "ascii"
            else np.array(end, FORMATS[form] + kind).tobytes()
            for end in ends
            for _ in "xyz"
        )
        mesh = ply.read("\n".join([*lines, "end_header", ""]).encode() + body)
        np.testing.assert_array_equal(mesh.vertices, np.float32([[end] * 3 for end in ends]))
