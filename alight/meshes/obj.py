"""Wavefront OBJ meshes: positions, texture coordinates, normals, vertex colours, polygons.

As a mesh of a scene it has no materials: the scene gives it one BSDF. A vertex that appears with
different texture coordinates or normals is stored once for each, because kernels index all arrays
alike.

Source: Wavefront Technologies, Object files (.obj), appendix B1 of the Advanced Visualizer manual.
"""

from __future__ import annotations

import codecs
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import quote
from alight.meshes.concave import cut_polygons
from alight.meshes.triangles import MeshArrays, broken, srgb_to_linear

LARGEST_INDEX = 2**31 - 1
_KINDS = ("points", "texture coordinates", "normals")
_IS_UV = np.array([False, True, False])
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


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
    for index, line in content.absent.values():
        raise broken(f"line {line}: {index}")
    return content.mesh()


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
        Of ``v``, ``vt`` and ``vn``: (n, 3), (n, 2) and (n, 3) float32.
    colors : (n, 3) float32 or None
        Linear, of the rows of ``v``, if any has one; NaN for those that have none.
    corners : (c, 3) int64
        Rows of the three tables, of all faces one after the other; -1 where there is none.
    sizes : (f,) int64
        Corners of each face.
    statements : list of Statement
        The rest, in order.
    absent : dict of str to (str, int)
        "texture coordinates" or "normals" -> what first names a row of a table without rows, and
        its line; such corners have none.
    """

    tables: dict[bytes, NDArray[np.float32]]
    colors: NDArray[np.float32] | None
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    statements: list[Statement]
    absent: dict[str, tuple[str, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Sum up the sizes, to find the corners of a face."""
        self._starts = np.concatenate([[0], np.cumsum(self.sizes)])

    def partly(self, faces: list[tuple[int, int]]) -> list[str]:
        """What only some corners of these faces have."""
        keys = np.concatenate([self.corners[self._starts[a] : self._starts[b]] for a, b in faces])
        lacks = {_KINDS[i]: keys[:, i] < 0 for i in (1, 2)}
        return [name for name, corners in lacks.items() if corners.any() and not corners.all()]

    def mesh(self, faces: list[tuple[int, int]] | None = None) -> MeshArrays:
        """Make arrays of some faces.

        Corners without texture coordinates among others with them are at (0, 0), as most programs
        read them. Normals count only where every corner has one.

        Parameters
        ----------
        faces : list of (int, int), optional
            Ranges of them; then only the vertices that they use are kept. All by default.
        """
        keys, sizes = self.corners, self.sizes
        if faces is not None:
            keys = np.concatenate([keys[self._starts[a] : self._starts[b]] for a, b in faces])
            sizes = np.concatenate([sizes[a:b] for a, b in faces])
        triangles = cut_polygons(self.tables[b"v"][keys[:, 0]], sizes)[0].reshape(-1)
        use_uvs = len(keys) > 0 and keys[:, 1].max() >= 0
        use_normals = len(keys) > 0 and keys[:, 2].min() >= 0
        uvs = self.tables[b"vt"]
        if use_uvs and keys[:, 1].min() < 0:
            keys = np.where((keys < 0) & _IS_UV, len(uvs), keys)
            uvs = np.concatenate([uvs, np.zeros((1, 2), np.float32)])
        kept = [0, *([1] if use_uvs else []), *([2] if use_normals else [])]
        if faces is None and kept == [0]:
            rows, inverse = np.arange(len(self.tables[b"v"]))[:, None], keys[:, 0]
        else:
            # Corners of faces that make no triangle count only in a whole file.
            used = np.arange(len(keys)) if faces is None else triangles
            rows, found = _distinct(keys[used][:, kept])
            inverse = np.zeros(len(keys), np.int64)
            inverse[used] = found
        columns = dict(zip(kept, rows.T, strict=True))
        return MeshArrays(
            self.tables[b"v"][columns[0]],
            inverse[triangles].astype(np.int32).reshape(-1, 3),
            self.tables[b"vn"][columns[2]] if use_normals else None,
            uvs[columns[1]] if use_uvs else None,
            None if self.colors is None else _filled(self.colors[columns[0]]),
        )


def parse(data: bytes) -> Content:
    """Split a file into its statements.

    Raises
    ------
    SceneError
        If a vertex or a face is broken, or a face uses rows that are not there; messages name the
        line.
    """
    if data.startswith(_UTF_16):
        data = decoded(data).encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    tables: dict[bytes, list[list[float]]] = {b"v": [], b"vt": [], b"vn": []}
    corners: list[tuple[int, int, int]] = []
    known: dict[bytes, tuple[int, int, int]] = {}
    sizes, lines = [], []
    statements: list[Statement] = []
    for number, line in _whole_lines(data):
        words = line.split()
        if not words or words[0].startswith(b"#"):
            continue
        is_text = words[0] != b"f" and words[0] not in tables
        if not is_text and b"#" in line:
            # In names a # is part of them.
            ends = [i for i, word in enumerate(words) if word.startswith(b"#")]
            words = words[: ends[0]] if ends else words
        if words[0] in tables:
            tables[words[0]].append(_parse_row(words, number))
        elif words[0] == b"f":
            counts = (len(tables[b"v"]), len(tables[b"vt"]), len(tables[b"vn"]))
            for word in words[1:]:
                corner = known.get(word)
                if corner is None:
                    corner = _parse_corner(word, counts, number)
                    # What is counted from the end is another row each time.
                    if b"-" not in word:
                        known[word] = corner
                corners.append(corner)
            sizes.append(len(words) - 1)
            lines.append(number)
        else:
            statements.append(Statement(words, number, len(sizes)))
    colors = None
    if any(len(row) >= 6 for row in tables[b"v"]):
        lacking = [np.nan] * 3
        rows = [row[3:] if len(row) >= 6 else lacking for row in tables[b"v"]]
        colors = srgb_to_linear(np.clip(_table(rows, 3), 0, 1))
    content = Content(
        {kind: _table(rows, 2 if kind == b"vt" else 3) for kind, rows in tables.items()},
        colors,
        np.array(corners, np.int64).reshape(-1, 3),
        np.array(sizes, np.int64),
        statements,
    )
    _check_indices(content, lines)
    return content


def decoded(data: bytes) -> str:
    """Text of a file that does not say how it is encoded; any bytes are one."""
    if data.startswith(_UTF_16):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _whole_lines(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Numbers and contents of lines; those that end in a backslash continue on the next one."""
    if b"\\" not in data:
        yield from enumerate(data.splitlines(), 1)
        return
    first, begun = 0, b""
    for number, line in enumerate(data.splitlines(), 1):
        if line.endswith(b"\\"):
            first, begun = first or number, begun + line[:-1] + b" "
            continue
        yield first or number, begun + line
        first, begun = 0, b""
    yield first, begun


def _parse_row(words: list[bytes], number: int) -> list[float]:
    least = 2 if words[0] == b"vt" else 3
    if words[0] == b"vt" and len(words) == 2:
        # Of a curve; v is 0 then.
        words = [*words, b"0"]
    if len(words) <= least:
        kind = words[0].decode()
        raise broken(f"line {number}: {kind} needs {least} numbers, got {len(words) - 1}")
    try:
        return [float(word) for word in words[1:8]]
    except ValueError:
        shown = quote(b" ".join(words).decode("latin-1"))
        raise broken(f"line {number}: holds a word that is not a number: {shown}") from None


def _parse_corner(word: bytes, counts: tuple[int, int, int], number: int) -> tuple[int, int, int]:
    """Read ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``; zero-based, -1 where there is none."""
    parts = word.split(b"/")
    if len(parts) > 3 or not parts[0]:
        raise broken(f"line {number}: is not a corner of a face: {quote(word.decode('latin-1'))}")
    result = [-1, -1, -1]
    for i, part in enumerate(parts):
        if not part:
            continue
        digits = part[1:] if part[:1] in b"+-" else part
        if not digits.isdigit() or len(digits) > 10:
            raise broken(
                f"line {number}: is not a corner of a face: {quote(word.decode('latin-1'))}"
            )
        index = int(part)
        # Positive indices count from 1, negative ones back from the last row so far.
        result[i] = index - 1 if index > 0 else counts[i] + index
        if index == 0 or result[i] < 0 or result[i] > LARGEST_INDEX:
            kind = ("v", "vt", "vn")[i]
            raise broken(f"line {number}: {kind} index must be in [1, {counts[i]}], got {index}")
    return result[0], result[1], result[2]


def _distinct(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Distinct rows in rising order, and which of them each row is."""
    # One number for a row: the columns before it by their rank, times room for the next column.
    rank, inverse = np.unique(keys[:, 0], return_inverse=True)
    rows = rank[:, None]
    for column in keys.T[1:]:
        room = int(column.max(initial=0)) + 1
        codes, inverse = np.unique(inverse * room + column, return_inverse=True)
        rows = np.concatenate([rows[codes // room], (codes % room)[:, None]], axis=1)
    return rows, inverse.reshape(-1)


def _check_indices(content: Content, lines: list[int]) -> None:
    """Refuse faces that use rows that are nowhere in the file; note tables without any."""
    for column, (kind, table) in enumerate(content.tables.items()):
        outside = np.flatnonzero(content.corners[:, column] >= len(table))
        if len(outside):
            face = int(np.searchsorted(np.cumsum(content.sizes), outside[0], side="right"))
            index = content.corners[outside[0], column] + 1
            text = f"a face uses {kind.decode()} number {index}, the file holds {len(table)}"
            if kind == b"v" or len(table):
                raise broken(f"line {lines[face]}: {text}")
            content.absent[_KINDS[column]] = text, lines[face]
            content.corners[outside, column] = -1


def _filled(colors: NDArray[np.float32]) -> NDArray[np.float32] | None:
    """Colours with white where there is none; None if there are none at all."""
    lacks = np.isnan(colors)
    return None if lacks.all() else np.where(lacks, np.float32(1.0), colors)


def _table(rows: list[list[float]], columns: int) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        table = np.array([row[:columns] for row in rows], np.float64).reshape(-1, columns)
        return table.astype(np.float32)
