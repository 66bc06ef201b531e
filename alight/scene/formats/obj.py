"""Wavefront OBJ meshes: positions, texture coordinates, normals, vertex colours, polygons.

As a mesh of a scene it has no materials: the scene gives it one BSDF. Opened by itself it is read
by `alight.scene.formats.obj_scene`. A vertex that appears with different texture coordinates or
normals is stored once for each, because kernels index all arrays alike.

Source: Wavefront Technologies, Object files (.obj), appendix B1 of the Advanced Visualizer manual.
"""

from __future__ import annotations

import codecs
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import quote
from alight.scene.formats.concave import cut_polygons
from alight.scene.formats.triangles import MeshArrays, broken, srgb_to_linear

LARGEST_INDEX = 2**31 - 1


def read(data: bytes) -> MeshArrays:
    """Read an OBJ file.

    Parameters
    ----------
    data : bytes
        Content of the file.

    Returns
    -------
    MeshArrays
        Polygons are cut into triangles. Colours behind positions (an extension of many
        programs) are taken as sRGB and made linear.

    Raises
    ------
    SceneError
        If the file is broken; messages name the line.
    """
    content = parse(data)
    return assemble(content.tables, content.corners, content.sizes)


class Statement(NamedTuple):
    """A line that is neither a vertex nor a face: its words, line number, and faces before it."""

    words: list[bytes]
    line: int
    faces: int


@dataclass
class Content:
    """What a file says.

    Attributes
    ----------
    tables : dict
        ``v``, ``vt`` and ``vn``: rows of numbers.
    corners : list of (int, int, int)
        Rows of the three tables, of all faces one after the other; -1 where there is none.
    sizes : list of int
        Corners of each face.
    statements : list of Statement
        The rest, in order.
    """

    tables: dict[bytes, list[list[float]]] = field(
        default_factory=lambda: {b"v": [], b"vt": [], b"vn": []}
    )
    corners: list[tuple[int, int, int]] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)


def parse(data: bytes) -> Content:
    """Split a file into its statements.

    Raises
    ------
    SceneError
        If a vertex or a face is broken; messages name the line.
    """
    content = Content()
    tables = content.tables
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", "replace").encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    text = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        if words[0] in tables:
            tables[words[0]].append(_parse_row(words, number))
        elif words[0] == b"f":
            counts = (len(tables[b"v"]), len(tables[b"vt"]), len(tables[b"vn"]))
            content.corners.extend(_parse_corner(word, counts, number) for word in words[1:])
            content.sizes.append(len(words) - 1)
        else:
            content.statements.append(Statement(words, number, len(content.sizes)))
    return content


def _parse_row(words: list[bytes], number: int) -> list[float]:
    least = 2 if words[0] == b"vt" else 3
    if len(words) <= least:
        kind = words[0].decode()
        raise broken(f"line {number}: {kind} needs {least} numbers, got {len(words) - 1}")
    try:
        return [float(word) for word in words[1:8]]
    except ValueError:
        shown = quote(b" ".join(words).decode("latin-1"))
        raise broken(f"line {number}: holds a word that is no number: {shown}") from None


def _parse_corner(word: bytes, counts: tuple[int, int, int], number: int) -> tuple[int, int, int]:
    """Read ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``; zero-based, -1 where there is none."""
    parts = word.split(b"/")
    if len(parts) > 3 or not parts[0]:
        raise broken(f"line {number}: is no corner of a face: {quote(word.decode('latin-1'))}")
    result = [-1, -1, -1]
    for i, part in enumerate(parts):
        if not part:
            continue
        digits = part[1:] if part[:1] in b"+-" else part
        if not digits.isdigit() or len(digits) > 10:
            raise broken(f"line {number}: is no corner of a face: {quote(word.decode('latin-1'))}")
        index = int(part)
        # Positive indices count from 1, negative ones back from the last row so far.
        result[i] = index - 1 if index > 0 else counts[i] + index
        if index == 0 or result[i] < 0 or result[i] > LARGEST_INDEX:
            kind = ("v", "vt", "vn")[i]
            raise broken(f"line {number}: {kind} index must be in [1, {counts[i]}], got {index}")
    return result[0], result[1], result[2]


def assemble(
    tables: dict[bytes, list[list[float]]], corners: list[tuple[int, int, int]], sizes: list[int]
) -> MeshArrays:
    """Make arrays of some faces.

    Raises
    ------
    SceneError
        If a face uses rows that are not there.
    """
    # A row per distinct (v, vt, vn), in the order of v, so that plain files keep their order.
    keys = np.array(corners, np.int64).reshape(-1, 3)
    _check_indices(tables, keys)
    use_uvs, use_normals = bool(len(keys)), bool(len(keys))
    use_uvs &= bool((keys[:, 1] >= 0).all())
    use_normals &= bool((keys[:, 2] >= 0).all())
    if not use_uvs:
        keys[:, 1] = -1
    if not use_normals:
        keys[:, 2] = -1
    positions = _table(tables[b"v"], 3)
    colors = None
    if tables[b"v"] and all(len(row) >= 6 for row in tables[b"v"]):
        colors = srgb_to_linear(np.clip(_table([row[3:] for row in tables[b"v"]], 3), 0, 1))
    if use_uvs or use_normals:
        rows, inverse = np.unique(keys, axis=0, return_inverse=True)
        inverse = inverse.reshape(-1)
    else:
        rows = np.stack([np.arange(len(positions))] * 3, axis=1)
        inverse = keys[:, 0]
    triangles, _ = cut_polygons(positions[keys[:, 0]], np.array(sizes, np.int64))
    faces = inverse[triangles].astype(np.int32).reshape(-1, 3)
    return MeshArrays(
        positions[rows[:, 0]],
        faces,
        _table(tables[b"vn"], 3)[rows[:, 2]] if use_normals else None,
        _table(tables[b"vt"], 2)[rows[:, 1]] if use_uvs else None,
        colors[rows[:, 0]] if colors is not None else None,
    )


def _check_indices(tables: dict[bytes, list[list[float]]], keys: NDArray[np.int64]) -> None:
    for column, kind in enumerate((b"v", b"vt", b"vn")):
        largest = int(keys[:, column].max(initial=-1))
        if largest >= len(tables[kind]):
            raise broken(
                f"a face uses {kind.decode()} number {largest + 1}, "
                f"the file holds {len(tables[kind])}"
            )


def _table(rows: list[list[float]], columns: int) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        table = np.array([row[:columns] for row in rows], np.float64).reshape(-1, columns)
        return table.astype(np.float32)
