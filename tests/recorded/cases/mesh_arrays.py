"""Meshes: readers of files, polygons, subdivision, surfaces of other formats."""

import struct
import zlib

import numpy as np

from alight.meshes import loop, obj, ply, polygons, serialized, stl, strips, surfaces
from alight.meshes.concave import cut_polygons
from alight.meshes.face_colors import with_face_colors
from alight.meshes.normals import vertex_normals
from alight.meshes.volume import enclosed_volume, has_inside
from tests.recorded.cases.trees import ends_of

#: Corners of a box, slanted, and its faces: two of them triangles.
POINTS = np.array([
    [0, 0, 0], [2, 0.1, 0], [2.1, 1.5, 0.2], [0.1, 1.4, -0.1],
    [0.3, 0.2, 1.1], [1.9, 0.3, 1.3], [2.2, 1.6, 1.2], [0.2, 1.3, 1],
])  # fmt: skip
FACES = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4], [3, 4, 7]]
#: A polygon with a notch, in a plane askew.
NOTCHED = np.array([[0, 0], [3, 0.2], [2.9, 2], [2, 0.9], [1.2, 2.2], [0.1, 1.8]]) @ np.array(
    [[0.8, 0.3, 0.5], [-0.2, 0.9, 0.4]]
)

PLY = b"""ply
format ascii 1.0
comment of no meaning
element vertex 5
property float x
property double y
property float z
property float nx
property float ny
property float nz
property float s
property float t
property uchar red
property uchar green
property uchar blue
element face 2
property uchar flags
property list uchar int vertex_indices
end_header
0 0 0.1 0 0 1 0.1 0.2 255 10 20
1 0.1 0 0 0.1 1 0.9 0.1 30 200 40
1.1 1 0.2 0.1 0 1 0.8 0.7 50 60 250
0.1 0.9 0 0 0.2 1 0.3 0.9 90 120 70
-0.5 0.4 0.3 0.2 0 1 -0.2 0.5 11 99 180
1 4 0 1 2 3
0 3 0 3 4
"""
OBJ = b"""# a sheet
mtllib none.mtl
v 0 0 0.1
v 1 0.1 0
v 1.1 1 0.2 0.5 0.25 0.75
v 0.1 0.9 0
v -0.5 0.4 0.3
vt 0.1 0.2
vt 0.9 0.1
vt 0.8 0.7
vn 0 0.1 1
vn 0.2 0 1
o sheet
usemtl paper
s 1
f 1/1/1 2/2/1 3/3/2 4/1/2
f -5//1 -2//2 \\
  -1//2
"""
STL = b"""solid sheet
 facet normal 0 0 1
  outer loop
   vertex 0 0 0.1
   vertex 1 0.1 0
   vertex 1.1 1 0.2
  endloop
 endfacet
 facet normal 0 0 1
  outer loop
   vertex 0 0 0.1
   vertex 1.1 1 0.2
   vertex 0.1 0.9 0
  endloop
 endfacet
endsolid sheet
"""


def arrays(mesh: object) -> dict[str, object]:
    """The arrays of a mesh that it has."""
    fields = mesh._asdict() if hasattr(mesh, "_asdict") else vars(mesh)
    return {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}


def binary_ply(order: str) -> bytes:
    """Vertices with a list beside them, and faces."""
    words = {"<": "little", ">": "big"}[order]
    head = f"""ply
format binary_{words}_endian 1.0
element vertex 4
property short u
property list uint8 float32 extra
property float x
property float y
property double z
element face 1
property list int32 uint16 vertex_index
end_header
"""
    rows = [
        struct.pack(f"{order}hB{'f' * (i % 3)}ffd", 3 * i, i % 3, *[0.5] * (i % 3), *point)
        for i, point in enumerate([(0, 0, 0.1), (1, 0.1, 0), (1.1, 1, 0.2), (0.1, 0.9, 0)])
    ]
    return head.encode() + b"".join(rows) + struct.pack(f"{order}i4H", 4, 2, 3, 0, 1)


def serialized_mesh(version: int, doubles: bool) -> bytes:
    """A file of two meshes, the second one without coordinates."""
    parts, offsets = [], []
    for flags in (0x0001 | 0x0002 | 0x0008, 0x0010):
        kind = "d" if doubles else "f"
        body = struct.pack("<I", flags | (0x2000 if doubles else 0x1000))
        body += b"name\0" if version == 4 else b""
        body += struct.pack("<QQ", 4, 2) + struct.pack(f"<12{kind}", *POINTS[:4].ravel())
        for bit, columns in ((0x1, 3), (0x2, 2), (0x8, 3)):
            if flags & bit:
                numbers = 0.1 + 0.07 * np.arange(4 * columns)
                body += struct.pack(f"<{4 * columns}{kind}", *numbers)
        body += struct.pack("<6I", 0, 1, 2, 0, 2, 3)
        offsets.append(sum(map(len, parts)))
        parts.append(struct.pack("<HH", 0x041C, version) + zlib.compress(body))
    ends = struct.pack("<2Q" if version == 4 else "<2I", *offsets) + struct.pack("<I", 2)
    return b"".join(parts) + ends


def files() -> dict[str, object]:
    """What readers find."""
    answer = {
        "ply": arrays(ply.read(PLY)), "obj": arrays(obj.read(OBJ)), "stl": arrays(stl.read(STL)),
        "little": arrays(ply.read(binary_ply("<"))), "big": arrays(ply.read(binary_ply(">"))),
    }  # fmt: skip
    triangle = np.array([[0, 0, 1], [0, 0, 0.1], [1, 0.1, 0], [1.1, 1, 0.2]], "<f4")
    binary = b"\0" * 80 + struct.pack("<I", 1) + triangle.tobytes() + b"\0\0"
    answer["stl, binary"] = arrays(stl.read(binary))
    for version, doubles in ((3, False), (4, True)):
        data = serialized_mesh(version, doubles)
        for index in range(2):
            found = serialized.read(data, index)
            answer[f"serialized {version}.{index}"] = arrays(found.arrays) | {
                "flat": found.face_normals
            }
    return answer


def box() -> polygons.Polygons:
    """The slanted box with a crease, a pinned corner and values."""
    counts = np.array([len(face) for face in FACES])
    corners = np.concatenate(FACES)
    values = {"uv": np.stack([np.arange(corners.size) % 5, np.arange(corners.size) % 3], 1) / 4.0}
    return polygons.Polygons(
        POINTS, counts, corners, values, np.arange(len(FACES)), np.array([[0, 1], [1, 2], [5, 6]]),
        np.array([1.5, 3.0, 0.6]), np.array([7]),
    )  # fmt: skip


def cut() -> dict[str, object]:
    """Polygons cut, refined, and with normals."""
    mesh = box()
    fine = polygons.subdivided(mesh, 1)
    sizes = np.array([6, 4, 2, 3])
    points = np.concatenate([NOTCHED, POINTS[:4], POINTS[:2], POINTS[4:7]])
    return {
        "triangulated": arrays(polygons.triangulated(mesh)),
        "normals": polygons.vertex_normals(mesh),
        "refined": {name: ends_of(value) for name, value in arrays(fine).items()},
        "twice": ends_of(polygons.subdivided(mesh, 2).points),
        "values": {name: ends_of(value) for name, value in fine.values.items()},
        "concave": list(cut_polygons(points, sizes)),
        "strips": [
            strips.triangles_of(np.array([0, 1, 2, 3, -1, 4, 5, 6, 6, 7]), np.array([6, 4]))
        ],
    }


def triangles() -> dict[str, object]:
    """Triangles refined, coloured, with normals and a volume."""
    octahedron = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    )
    vertices = np.array(
        [[1, 0, 0.1], [-1, 0.1, 0], [0, 1, -0.1], [0.1, -1, 0], [0, 0.1, 1], [0, 0, -1.0]]
    )
    open_one = octahedron[:6]
    limit = loop.subdivide(vertices, octahedron, 1)
    edge = loop.subdivide(vertices, open_one, 2)
    painted = np.float32([[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [0.9, 0.2, 0.4], [0.9, 0.2, 0.4]])
    sheet = stl.read(STL)
    return {
        "limit": list(limit), "border": [ends_of(table) for table in edge],
        "normals": vertex_normals(vertices.astype(np.float32), octahedron.astype(np.int32)),
        "volume": enclosed_volume(vertices.astype(np.float32), octahedron.astype(np.int32)),
        "painted": arrays(with_face_colors(sheet, painted[1:3])),
        "closed": [has_inside(sheet)],
    }  # fmt: skip


def curved() -> dict[str, object]:
    """Surfaces of other formats as meshes."""
    corners = np.array([[0, 0, 0.1], [1, 0.1, 0], [0.1, 0.9, 0.3], [1.2, 1.1, -0.4]])
    uvs = np.array([[0, 0.1], [0.9, 0], [0.1, 1], [1, 0.8]])
    bent, is_exact = surfaces.patch(corners, uvs, None)
    parts = {
        "sphere": surfaces.sphere(1.3, -0.7, 0.9, 4.1), "disk": surfaces.disk(1.2, 0.3, 0.4, 3.7),
        "cylinder": surfaces.cylinder(0.8, -0.5, 1.1, 5.2), "patch": bent,
    }  # fmt: skip
    answer = {
        name: {key: ends_of(value) for key, value in keys.items()} for name, keys in parts.items()
    }
    joined = surfaces.joined([parts["sphere"], parts["disk"]])
    own = surfaces.own_corners(parts["cylinder"])
    return answer | {
        "exact": is_exact,
        "joined": {key: ends_of(value) for key, value in joined.items()},
        "own": {key: ends_of(value) for key, value in own.items()},
    }


CASES = {"files": files, "polygons": cut, "triangles": triangles, "surfaces": curved}
