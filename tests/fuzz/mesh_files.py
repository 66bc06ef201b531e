"""Scenes with a broken mesh: PLY, OBJ and Mitsuba's serialized files, mutated byte by byte."""

from __future__ import annotations

import random
import struct
import zlib
from collections.abc import Iterator

import numpy as np

from tests.formats.mutate import (
    OBJ,
    STL,
    Mutation,
    binary_stl,
    mesh_file,
    mesh_scene,
    mutate_bytes,
)

_XML = """<scene version="3.0.0">
<sensor type="perspective"><transform name="to_world"><translate z="4"/></transform></sensor>
<emitter type="constant"/>
<shape type="serialized">
<string name="filename" value="mesh.serialized"/><integer name="shape_index" value="1"/>
</shape></scene>
"""
#: Flags of a serialized mesh: single precision, normals, texture coordinates.
_FLAGS = 0x1000 | 0x1 | 0x2


def meshes(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` scenes, each with the content of its mesh file."""
    rng = random.Random(seed)
    plain = [("mesh.ply", mesh_file(order)) for order in ("", "<", ">")]
    plain += [("mesh.obj", OBJ), ("mesh.stl", STL), ("mesh.stl", binary_stl())]
    for _ in range(n):
        kind = rng.randrange(len(plain) + 2)
        if kind < len(plain):
            name, data = plain[kind]
            yield Mutation(mesh_scene(name), name, _damaged(data, rng))
        else:
            # Damage before the compression passes the checksum, damage after it seldom.
            inside = kind == len(plain)
            parts = [_serialized(rng if inside and i else None) for i in range(2)]
            table = struct.pack("<QQI", 0, len(parts[0]), 2)
            data = b"".join(parts) + table
            yield Mutation(_XML, "mesh.serialized", data if inside else mutate_bytes(data, rng))


def _damaged(data: bytes, rng: random.Random) -> bytes:
    """Half of the files keep their length: numbers change, and most can still be read."""
    if rng.random() < 0.5:
        return mutate_bytes(data, rng)
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 3))):
        changed[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(changed)


def _serialized(rng: random.Random | None) -> bytes:
    """One tetrahedron in Mitsuba's format, version 4; mutated below the compression by `rng`."""
    rows = np.random.default_rng(0).random((4, 8)).astype("<f4")
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], "<u4")
    body = struct.pack("<I", _FLAGS) + b"tetrahedron\0" + struct.pack("<QQ", 4, 4)
    tables = (rows[:, :3], rows[:, 3:6], rows[:, 6:])
    body += b"".join(np.ascontiguousarray(table).tobytes() for table in tables) + faces.tobytes()
    if rng is not None:
        body = _damaged(body, rng)
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(body)
