"""Meshes that are broken, concave, open or turned: what is refused, what is read."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from alight.meshes import loop, obj, ply, serialized, stl, tessellation, volume
from alight.meshes.concave import cut_polygons
from alight.meshes.triangles import MeshArrays
from alight.scene import meshes
from tests.recorded.cases.mesh_arrays import OBJ, PLY
from tests.recorded.making import described, in_folder, outcome

#: Texts that stand for others in a file of PLY.
OF_PLY = (
    (b"ply\n", b"plx\n"),
    (b"format ascii 1.0\n", b""),
    (b"ascii", b"asci"),
    (b"float x", b"flot x"),
    (b"element vertex 5", b"element vertex 9"),
    (b"element vertex 5", b"element vertex 99999999999"),
    (b"element vertex", b"element vertices"),
    (b"property float x\n", b"property x\n"),
    (b"list uchar int", b"list float int"),
    (b"float z", b"float w"),
    (b"0 3 0 3 4", b"0 3 0 3"),
    (b"0 3 0 3 4", b"0 x 0 3 4"),
    (b"0 3 0 3 4", b"0 3 0 3 5"),
    (b"0 3 0 3 4", b"0 3 0 -1 4"),
    (b"0 3 0 3 4", b"0 3 0 1.5 4"),
    (b"0 3 0 3 4", b"0 2 0 3"),
    (b"0 3 0 3 4", b"0 -3 0 3 4"),
    (b"1 0.1 0 0", b"1 a 0 0"),
    (b"1 0.1 0 0", b"nan 0.1 0 0"),
    (b"element face 2", b"element face 3"),
    (b"element face 2", b"element face 0"),
    (b"list uchar int vertex_indices", b"int vertex_indices"),
    (b"end_header", b"element\nend_header"),
    (b"uchar red", b"float red"),
    (b"uchar red", b"uchar rad"),
    (b"property uchar flags\n", b"obj_info x\nproperty uchar flags\n"),
)
#: Lines after those of a file of OBJ.
OF_OBJ = (
    b"f 1 2",
    b"f 1 2 9",
    b"f 1 2 0",
    b"f 1 2 -9",
    b"f 1 2 -1",
    b"f a b c",
    b"f 1/2/3/4 2 3",
    b"f 1/9 2/1 3/1",
    b"f 1//9 2//1 3//1",
    b"f 1// 2// 3//",
    b"f 1/1 2 3/1",
    b"v 1 2",
    b"v 1 2 x",
    b"v 1 2 3 4 5",
    b"vt",
    b"vn 1 2",
    b"vt 0.5",
    b"f 1 2 \\\n 3",
    b"f 1 2 3 # f 9",
    b"\xff\xfe",
    b"v 1e39 0 0\nf 1 2 6",
    b"f 1.5 2 3",
    b"curv 1 2",
    b"f 1//1 2/1/1 3",
)
STL = b"""solid a
 facet normal 0 0 1
  outer loop
   vertex 0 0 0
   vertex 1 0 0.5
   vertex 0 1 0.25
  endloop
 endfacet
endsolid a
"""
OF_STL = (
    (b"vertex 1 0 0.5\n", b""),
    (b"1 0 0.5", b"1 0"),
    (b"1 0 0.5", b"1 x 0"),
    (b" endfacet\n", b""),
    (b"solid", b"solld"),
    (b"1 0 0.5", b"1 0 0.5 7"),
    (b"solid a", b"solid"),
    (b"facet", b"fucet"),
)


def texts() -> dict[str, Any]:
    """Files of text, edited one by one."""
    found: dict[str, Any] = {}
    for old, new in OF_PLY:
        found[f"ply: {old!r} {new!r}"] = outcome(ply.read, PLY.replace(old, new, 1))
    for line in OF_OBJ:
        found[f"obj: {line!r}"] = outcome(obj.read, OBJ + b"\n" + line + b"\n")
    for old, new in OF_STL:
        found[f"stl: {old!r} {new!r}"] = outcome(stl.read, STL.replace(old, new, 1))
    utf16 = OBJ.decode("ascii").encode("utf-16")
    found["utf-16"] = described(obj.read(utf16)) == described(obj.read(OBJ))
    return found


def binaries() -> dict[str, Any]:
    """Binary files: in both orders, cut off at many places, and with numbers that lie."""
    head = (
        b"ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        b"property float z\nelement face %d\nproperty list uchar %s vertex_index\n"
        b"property uchar flag\nend_header\n"
    )
    points = np.array([[0, 0, 0], [1, 0, 0.5], [1, 1, 0.25], [0, 1, 0]], np.float32)
    found: dict[str, Any] = {}
    for name, sign in (("little", "<"), ("big", ">")):
        rows = points.astype(f"{sign}f4").tobytes()
        three = struct.pack(f"{sign}B3iB", 3, 0, 1, 2, 7)
        four = struct.pack(f"{sign}B4iB", 4, 0, 1, 2, 3, 8)
        alike = (head % (name.encode(), 2, b"int")) + rows + three * 2
        mixed = (head % (name.encode(), 3, b"int")) + rows + three + four + three
        found[name] = [outcome(ply.read, alike), outcome(ply.read, mixed)]
        for data in (alike, mixed):
            found[name] += [outcome(ply.read, data[:-cut]) for cut in (1, 2, 15, 40, 80)]
    triangle = struct.pack("<12fH", *range(12), 0)
    for count, data in ((1, triangle), (2, triangle), (1, triangle[:-3]), (0, b"")):
        whole = bytes(80) + struct.pack("<I", count) + data
        found[f"stl {count}, {len(data)}"] = outcome(stl.read, whole)
    found["stl of nothing"] = outcome(stl.read, b"so")
    return found


def _serialized(flags: int, *, count: int = 3, last: int = 2, version: int = 4) -> bytes:
    name = b"" if version == 3 else b"a\0"
    body = struct.pack("<I", flags) + name + struct.pack("<QQ", count, 1)
    kind = "d" if flags & serialized.DOUBLE else "f"
    columns = 3 + 3 * bool(flags & 1) + 2 * bool(flags & 2) + 3 * bool(flags & 8)
    body += struct.pack(f"<{3 * columns}{kind}", *np.linspace(0.0, 1.0, 3 * columns))
    body += struct.pack("<3I", 0, 1, last)
    data = struct.pack("<HH", serialized.MAGIC, version) + zlib.compress(body)
    table = struct.pack("<I" if version == 3 else "<Q", 0) + struct.pack("<I", 1)
    return data + table


def packed() -> dict[str, Any]:
    """Serialized meshes: what they may have, where they end early, and what makes no sense."""
    single, double = serialized.SINGLE, serialized.DOUBLE
    good = _serialized(single | 3)
    found = {
        f"{flags:x}, {version}": outcome(serialized.read, _serialized(flags, version=version))
        for flags in (single, double | 11, single | 8, single | 0x10, single | double, 0, 1 << 30)
        for version in (3, 4)
    }
    wrong = {
        "of five": good[:5],
        "magic": b"x" + good[1:],
        "version": good[:2] + b"\7" + good[3:],
        "no meshes": good[:-4] + bytes(4),
        "many": good[:-4] + b"\xff" * 4,
        "elsewhere": good[:-12] + struct.pack("<QI", 999, 1),
        "damaged": good[:6] + b"xx" + good[8:],
        "claims": _serialized(single, count=10**9),
        "index": _serialized(single, last=3),
        "cut": good[:20] + good[-12:],
    }
    found |= {name: outcome(serialized.read, data) for name, data in wrong.items()}
    return found | {"index 1": outcome(serialized.read, good, 1)}


def shapes() -> dict[str, Any]:
    """Polygons that are cut ear by ear, edges of open meshes, meshes that cannot be refined."""
    turn = 2.0 * np.pi * np.arange(9) / 9
    radius = np.array([1, 0.3, 0.9, 0.25, 1.1, 0.4, 0.8, 0.2, 1])
    star = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.2 * np.cos(turn)], -1)
    hook = np.array([[0, 0], [4, 0], [4, 3], [1, 3], [1, 2], [3, 2], [3, 1], [0, 1.0]])
    tilt = np.array([[0.3, 0.8, 0.5], [-0.9, 0.1, 0.4]])
    both = np.concatenate([star[:, [2, 0, 1]], hook @ tilt, hook[::-1] @ tilt[::-1]])
    points = np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.2], [0.5, 0.5, 1]], np.float32)
    faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4]], np.int32)
    seam = np.concatenate([points, points[:1]])
    kinds = {
        "fan": faces,
        "thrice": np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]]),
        "turned": np.array([[0, 1, 2], [0, 1, 3]]),
        "twice": faces[[0, 0, 1]],
    }
    mesh = MeshArrays(points, faces, points, points[:, :2], points, None)
    return {
        "cut": [one.tolist() for one in cut_polygons(both, np.array([9, 8, 8]))],
        "cut in turn": [one.tolist() for one in cut_polygons(both[::-1], np.array([8, 8, 9]))],
        "crossed": [one.tolist() for one in cut_polygons(points[[0, 2, 1, 3]], np.array([4]))],
        "open": [
            volume.open_edges(seam, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 5, 4]])),
            volume.open_edges(points, faces),
        ],
        "refined": {name: outcome(loop.subdivide, points, f, 1) for name, f in kinds.items()},
        "halved": outcome(tessellation.tessellated, mesh, 0.7, 100),
        "too many": outcome(tessellation.tessellated, mesh, 0.01, 100),
        "as it is": outcome(tessellation.tessellated, mesh, 9.0, 100),
        "apart": tessellation.welded(seam + np.float32(1e-9)),
    }


def scenes_meshes() -> dict[str, Any]:
    """What a scene checks of arrays and files of meshes, and how far a mesh reaches."""
    points = np.array([[-7, 0, 1], [2, 3, 1], [1, -4, 5]], np.float32)
    good = MeshArrays(points, np.array([[0, 1, 2]], np.int32), None, None, None, None)
    nan = points.copy()
    nan[1] = [1, np.nan, 2e15]
    two = np.zeros((3, 2), np.float32)
    changes: dict[str, dict[str, Any]] = {
        "good": {},
        "no vertices": {"vertices": points[:0]},
        "no faces": {"faces": good.faces[:0]},
        "rows": {"normals": points[:2]},
        "numbers": {"vertices": nan},
        "uvs": {"uvs": two + 1e16},
        "low": {"faces": good.faces - 1},
        "high": {"faces": good.faces + 1},
        "alone": {"more_uvs": two[None]},
        "beside": {"uvs": two, "more_uvs": two[None]},
        "second": {"uvs": two, "more_uvs": np.stack([two, two + 2e15])},
        "colors": {"colors": points},
    }
    found: dict[str, Any] = {
        name: outcome(meshes.mesh_problem, good._replace(**change))
        for name, change in changes.items()
    }
    whole = meshes.checked(good)
    found["extent"] = [whole.extent, meshes.surface_area(whole, np.diag([2.0, 3.0, 1.0, 1.0]))]
    turned = meshes.checked(good._replace(vertices=-points))
    found["extent of the other side"] = turned.extent
    files = {
        "a.obj": OBJ,
        "b.stl": b"x",
        "c.txt": b"",
        "folder.ply/x": b"",
        "d.obj": b"v 0 0 0\nf 1 2 3",
    }
    with in_folder(files):
        for name in (
            "a.obj",
            "a.obi",
            "A.obj",
            "ab.obj",
            "none/a.obj",
            "b.stl",
            "c.txt",
            "d.obj",
            "folder.ply",
            "builtin:waves",
            "builtin:wave",
            "builtin:waves/x",
        ):
            path = Path(name)
            found[f"file {name}"] = outcome(meshes.read_file, path, name)
    return found


CASES = {
    "texts": texts,
    "binaries": binaries,
    "packed": packed,
    "shapes": shapes,
    "of_scenes": scenes_meshes,
}
