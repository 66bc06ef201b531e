"""Serialized meshes of Mitsuba: several compressed meshes in one file.

A file is a row of meshes, each 2 bytes 0x041C, 2 bytes version (3 or 4), and a zlib stream with
flags (4 bytes), in version 4 a name that ends with a zero byte, the numbers of vertices and of
triangles (8 bytes each), and the tables: positions, and if the flags say so normals, texture
coordinates and colours, all float32 or float64; then the indices, 4 bytes each. At the end stand
the offsets of all meshes (4 bytes each in version 3, 8 in version 4) and their number (4 bytes).
All is little-endian.

Source: the documentation of Mitsuba 0.6, section 8.1.4 (serialized mesh loader).
"""

from __future__ import annotations

import struct
import zlib
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.meshes.triangles import MeshArrays, broken

MAGIC = 0x041C
VERSIONS = (3, 4)
NORMALS, UVS, COLORS, FACE_NORMALS, SINGLE, DOUBLE = 0x1, 0x2, 0x8, 0x10, 0x1000, 0x2000
_KNOWN = NORMALS | UVS | COLORS | FACE_NORMALS | SINGLE | DOUBLE

MOST_BYTES = 2**31
MOST_MESHES = 2**20
#: What zlib can make of one byte, at most.
MOST_GROWTH = 1032
_LONGEST_NAME = 2**16


class SerializedMesh(NamedTuple):
    """What a file holds: arrays, and whether vertex normals must not be computed for it."""

    arrays: MeshArrays
    face_normals: bool


def read(data: bytes, index: int = 0) -> SerializedMesh:
    """Read one mesh of a file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    index : int, default 0
        Which mesh, counted from 0.

    Raises
    ------
    SceneError
        If there is none, or the file is broken.
    """
    start, stop = _find(data, index)
    if stop - start < 4:
        raise broken(f"ends too early: mesh {index} has no header")
    magic, version = struct.unpack_from("<HH", data, start)
    _check_header(magic, version)
    stream = _Stream(data[start + 4 : stop])
    (flags,) = struct.unpack("<I", stream.take(4))
    if flags & ~_KNOWN or bool(flags & SINGLE) == bool(flags & DOUBLE):
        raise broken(f"mesh {index} has flags that make no sense: 0x{flags:x}")
    if version == 4:
        stream.skip_name()
    vertices, triangles = struct.unpack("<QQ", stream.take(16))
    _check_size(vertices, triangles, flags, len(stream.data))
    return _tables(stream, vertices, triangles, flags)


def _check_header(magic: int, version: int) -> None:
    if magic != MAGIC:
        raise broken(
            f"is not a serialized mesh: it must start with 0x{MAGIC:04X}, got 0x{magic:04X}"
        )
    if version not in VERSIONS:
        raise broken(f"has version {version}; versions 3 and 4 are covered")


def _find(data: bytes, index: int) -> tuple[int, int]:
    """First and last place of a mesh."""
    if len(data) < 8:
        raise broken(f"ends too early: {len(data)} bytes are no serialized mesh")
    _check_header(*struct.unpack_from("<HH", data))
    version = struct.unpack_from("<H", data, 2)[0]
    (count,) = struct.unpack_from("<I", data, len(data) - 4)
    width = 4 if version == 3 else 8
    table = len(data) - 4 - width * count
    if not 0 < count <= MOST_MESHES or table < 4:
        raise broken(f"claims {count} meshes in {len(data)} bytes")
    if not 0 <= index < count:
        raise broken(f"shape_index must be in [0, {count - 1}], got {index}")
    offsets = struct.unpack_from(f"<{count}{'I' if version == 3 else 'Q'}", data, table)
    start = offsets[index]
    stop = offsets[index + 1] if index + 1 < count else table
    if not 0 <= start < stop <= table:
        raise broken(f"says that mesh {index} lies from byte {start} to {stop} of {len(data)}")
    return start, stop


def _check_size(vertices: int, triangles: int, flags: int, compressed: int) -> None:
    numbers = 3 + 3 * bool(flags & NORMALS) + 2 * bool(flags & UVS) + 3 * bool(flags & COLORS)
    size = vertices * numbers * (8 if flags & DOUBLE else 4) + triangles * 12
    if size > min(MOST_BYTES, MOST_GROWTH * compressed + 1024):
        raise broken(f"claims {vertices} vertices and {triangles} triangles in {compressed} bytes")


class _Stream:
    """Unpacks as much as is requested, never more."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.unpacker = zlib.decompressobj()
        self.rest = data

    def take(self, size: int) -> bytes:
        """The next `size` bytes."""
        parts, missing = [], size
        while missing:
            try:
                part = self.unpacker.decompress(self.rest, missing)
            except zlib.error as error:
                raise broken(f"is damaged: {error}") from None
            self.rest = self.unpacker.unconsumed_tail
            if not part:
                raise broken(f"ends too early: {missing} of {size} bytes are missing")
            parts.append(part)
            missing -= len(part)
        return b"".join(parts)

    def skip_name(self) -> None:
        """Pass over a text that ends with a zero byte."""
        for _ in range(_LONGEST_NAME):
            if self.take(1) == b"\0":
                return
        raise broken(f"has a name of more than {_LONGEST_NAME} bytes")

    def table(self, rows: int, columns: int, dtype: str) -> NDArray[np.float32]:
        """The next table of numbers, as float32."""
        data = self.take(rows * columns * np.dtype(dtype).itemsize)
        with np.errstate(over="ignore"):
            return np.frombuffer(data, dtype).reshape(rows, columns).astype(np.float32)


def _tables(stream: _Stream, vertices: int, triangles: int, flags: int) -> SerializedMesh:
    dtype = "<f8" if flags & DOUBLE else "<f4"
    positions = stream.table(vertices, 3, dtype)
    normals = stream.table(vertices, 3, dtype) if flags & NORMALS else None
    uvs = stream.table(vertices, 2, dtype) if flags & UVS else None
    if flags & COLORS:
        # Nothing in a scene of Mitsuba can refer to them.
        stream.table(vertices, 3, dtype)
    indices = np.frombuffer(stream.take(12 * triangles), "<u4").reshape(triangles, 3)
    if triangles and int(indices.max()) >= vertices:
        raise broken(f"faces must index vertices 0 to {vertices - 1}, got {int(indices.max())}")
    faces = indices.astype(np.int32)
    return SerializedMesh(
        MeshArrays(positions, faces, normals, uvs, None), bool(flags & FACE_NORMALS)
    )
