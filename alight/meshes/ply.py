"""PLY meshes: ascii and binary, polygons, normals, texture coordinates, vertex colours.

A reader of our own: docs/decisions/0014-mesh-files.md says why. Counts in the header are compared
with the size of the file before memory is asked for.

Source: Turk, The PLY polygon file format (1994).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import quote
from alight.core.uv_sets import MOST_SETS
from alight.meshes.concave import cut_polygons
from alight.meshes.face_colors import with_face_colors
from alight.meshes.ply_header import Element, Property, parse_header
from alight.meshes.strips import triangles_of
from alight.meshes.triangles import MeshArrays, broken, fan, srgb_to_linear

NAMES = {
    "normals": (("nx", "ny", "nz"),),
    "uvs": (("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texture_s", "texture_t")),
    "colors": (("red", "green", "blue"), ("r", "g", "b")),
}
#: Further sets of texture coordinates, as `save` writes them.
MORE_UVS = tuple((f"u{number}", f"v{number}") for number in range(1, MOST_SETS))


@dataclass(frozen=True)
class Ragged:
    """A column of lists: all values one after another, and the length of each list."""

    values: NDArray[Any]
    sizes: NDArray[np.int64]


Table = dict[str, "NDArray[Any] | Ragged"]


def read(data: bytes) -> MeshArrays:
    """Read a PLY file.

    Parameters
    ----------
    data : bytes
        Content of the file.

    Returns
    -------
    MeshArrays
        Polygons are cut into triangles; 8-bit colours are taken as sRGB and made linear, colours
        in floats are taken as linear.

    Raises
    ------
    SceneError
        If the file is broken.
    """
    order, elements, start = parse_header(data)
    tables: dict[str, Table] = {}
    if order:
        position = start
        for element in elements:
            tables[element.name], position = _read_binary(data, position, element, order)
    else:
        words = data[start:].split()
        position = 0
        for element in elements:
            tables[element.name], position = _read_ascii(words, position, element)
    if "vertex" not in tables:
        raise broken("has no element vertex")
    return _assemble(tables["vertex"], tables.get("face", {}), tables.get("tristrips", {}))


def _read_binary(data: bytes, at: int, element: Element, order: str) -> tuple[Table, int]:
    """Read one element's rows from position `at`; return its table and the position after."""
    if not element.properties or element.count == 0:
        return {}, at
    if not element.has_lists:
        dtype = np.dtype([(f"{i}", order + p.kind) for i, p in enumerate(element.properties)])
        end = at + dtype.itemsize * element.count
        if end > len(data):
            raise _truncated(element, (len(data) - at) // dtype.itemsize)
        rows = np.frombuffer(data, dtype, element.count, at)
        return {p.name: rows[f"{i}"] for i, p in enumerate(element.properties)}, end
    uniform = _read_uniform_lists(data, at, element, order)
    return uniform or _read_ragged_rows(data, at, element, order)


def _read_uniform_lists(
    data: bytes, at: int, element: Element, order: str
) -> tuple[Table, int] | None:
    """Read rows whose lists are all as long as those of the first row (triangles), at once."""
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    offset = at
    lengths: dict[int, int] = {}
    for i, column in enumerate(element.properties):
        if column.length:
            size = np.dtype(column.length).itemsize
            if offset + size > len(data):
                raise _truncated(element, 0)
            lengths[i] = int(np.frombuffer(data, order + column.length, 1, offset)[0])
            if not 0 <= lengths[i] <= len(data):
                return None
            fields += [(f"n{i}", order + column.length)]
            fields += [(f"{i}", order + column.kind, (lengths[i],))]
            offset += size + lengths[i] * np.dtype(column.kind).itemsize
        else:
            fields += [(f"{i}", order + column.kind)]
            offset += np.dtype(column.kind).itemsize
    row_bytes = offset - at
    if at + row_bytes * element.count > len(data):
        return None
    rows = np.frombuffer(data, np.dtype(fields), element.count, at)
    if any((rows[f"n{i}"] != length).any() for i, length in lengths.items()):
        return None
    table: Table = {}
    for i, column in enumerate(element.properties):
        values = rows[f"{i}"]
        if i in lengths:
            sizes = np.full(element.count, lengths[i], np.int64)
            table[column.name] = Ragged(values.reshape(-1), sizes)
        else:
            table[column.name] = values
    return table, at + row_bytes * element.count


def _read_ragged_rows(data: bytes, at: int, element: Element, order: str) -> tuple[Table, int]:
    """Read rows with lists of different lengths, row by row."""
    scalars: dict[str, list[Any]] = {p.name: [] for p in element.properties}
    sizes: dict[str, list[int]] = {p.name: [] for p in element.properties}
    for row in range(element.count):
        for column in element.properties:
            count = 1
            if column.length:
                size = np.dtype(column.length).itemsize
                if at + size > len(data):
                    raise _truncated(element, row)
                count = int(np.frombuffer(data, order + column.length, 1, at)[0])
                at += size
            end = at + count * np.dtype(column.kind).itemsize
            if count < 0 or end > len(data):
                raise _truncated(element, row)
            scalars[column.name].append(np.frombuffer(data, order + column.kind, count, at))
            sizes[column.name].append(count)
            at = end
    table: Table = {}
    for column in element.properties:
        values = np.concatenate(scalars[column.name])
        lengths = np.array(sizes[column.name], np.int64)
        table[column.name] = Ragged(values, lengths) if column.length else values
    return table, at


def _read_ascii(words: list[bytes], at: int, element: Element) -> tuple[Table, int]:
    """Read one element's rows from word `at`; return its table and the position after."""
    if not element.properties or element.count == 0:
        return {}, at
    if not element.has_lists:
        width = len(element.properties)
        end = at + width * element.count
        if end > len(words):
            raise _truncated(element, (len(words) - at) // width)
        rows = _numbers(words[at:end], element).reshape(element.count, width)
        return {p.name: _typed(rows[:, i], p) for i, p in enumerate(element.properties)}, end
    taken: dict[str, list[bytes]] = {p.name: [] for p in element.properties}
    sizes: dict[str, list[int]] = {p.name: [] for p in element.properties}
    for row in range(element.count):
        for column in element.properties:
            count = 1
            if column.length:
                if at >= len(words):
                    raise _truncated(element, row)
                if not words[at].isdigit() or len(words[at]) > 9:
                    raise broken(
                        f"element {element.name} row {row}: no list length: "
                        f"{quote(words[at].decode('latin-1'))}"
                    )
                count = int(words[at])
                at += 1
            if at + count > len(words):
                raise _truncated(element, row)
            taken[column.name] += words[at : at + count]
            sizes[column.name].append(count)
            at += count
    table: Table = {}
    for column in element.properties:
        values = _typed(_numbers(taken[column.name], element), column)
        lengths = np.array(sizes[column.name], np.int64)
        table[column.name] = Ragged(values, lengths) if column.length else values
    return table, at


def _numbers(words: list[bytes], element: Element) -> NDArray[np.float64]:
    try:
        return np.array(words, dtype="S").astype(np.float64) if words else np.zeros(0)
    except ValueError:
        bad = next(word for word in words if not _is_number(word))
        shown = quote(bad.decode("latin-1"))
        raise broken(f"element {element.name} holds {shown}, which is not a number") from None


def _typed(values: NDArray[np.float64], column: Property) -> NDArray[Any]:
    """Give numbers read from text the whole-number type of their column, where they fit."""
    whole = column.kind[0] in "iu" and bool((np.abs(values) < 2**53).all())
    return values.astype(np.int64) if whole and (values == np.floor(values)).all() else values


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _truncated(element: Element, found: int) -> Exception:
    return broken(
        f"ends too early: element {element.name} should have {element.count} rows, "
        f"the file holds {max(found, 0)}"
    )


def _assemble(vertex: Table, face: Table, strips: Table) -> MeshArrays:
    vertices = _columns(vertex, ("x", "y", "z"))
    if vertices is None:
        raise broken("element vertex has no x, y, z")
    indices, in_strips, faces = _lists(face), _lists(strips), np.zeros((0, 3), np.int32)
    polygons = np.zeros(0, np.int64)
    if indices is not None:
        corners, polygons = fan(indices.sizes)
        faces = _to_indices(indices.values[corners], len(vertices))
        if indices.sizes.max(initial=0) > 3:
            # Corners of what is too small for a triangle have not been looked at.
            known = np.clip(indices.values, 0, len(vertices) - 1).astype(np.int64)
            corners, polygons = cut_polygons(vertices[known], indices.sizes)
            faces = _to_indices(indices.values[corners], len(vertices))
    if in_strips is not None:
        more = triangles_of(in_strips.values, in_strips.sizes)
        faces = np.concatenate([faces, _to_indices(more, len(vertices))])
    found = {
        name: next((c for c in (_columns(vertex, n) for n in names) if c is not None), None)
        for name, names in NAMES.items()
        if name != "colors"
    }
    more = None if found["uvs"] is None else _more_uvs(vertex)
    colors = _colors(vertex)
    mesh = MeshArrays(vertices, faces, found["normals"], found["uvs"], colors, more)
    of_faces = _colors(face) if colors is None and in_strips is None else None
    if of_faces is None or not len(faces):
        return mesh
    return with_face_colors(mesh, of_faces[polygons])


def _colors(table: Table) -> NDArray[np.float32] | None:
    """Linear colours of vertices or faces."""
    for names in NAMES["colors"]:
        colors = _columns(table, names)
        if colors is not None:
            column = table[names[0]]
            is_whole = isinstance(column, np.ndarray) and column.dtype.kind in "ui"
            return srgb_to_linear(colors / np.float32(255.0)) if is_whole else colors
    return None


def _lists(table: Table) -> Ragged | None:
    """The vertices of faces or strips."""
    indices = next((table[n] for n in ("vertex_indices", "vertex_index") if n in table), None)
    if indices is not None and not isinstance(indices, Ragged):
        raise broken("vertex_indices must be a list")
    return indices


def _more_uvs(vertex: Table) -> NDArray[np.float32] | None:
    found: list[NDArray[np.float32]] = []
    for names in MORE_UVS:
        table = _columns(vertex, names)
        if table is None:
            break
        found.append(table)
    return np.stack(found) if found else None


def _columns(table: Table, names: tuple[str, ...]) -> NDArray[np.float32] | None:
    columns = [column for column in map(table.get, names) if isinstance(column, np.ndarray)]
    if len(columns) < len(names):
        return None
    # float64 values beyond float32 become infinite here and are reported with their row.
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(np.stack(columns, axis=1), dtype=np.float32)


def _to_indices(values: NDArray[Any], count: int) -> NDArray[np.int32]:
    bad = ~((values >= 0) & (values < count))
    if values.dtype.kind == "f":
        bad |= values != np.floor(values)
    if bad.any():
        row = int(bad.any(axis=1).argmax())
        value = values[bad][0]
        raise broken(f"faces must index vertices 0 to {count - 1}, got {value} in triangle {row}")
    return np.ascontiguousarray(values, dtype=np.int32)


def save(path: str | Path, mesh: MeshArrays) -> None:
    """Write a binary PLY file; float32 values come back bit for bit.

    Parameters
    ----------
    path : str or Path
        File to write.
    mesh : MeshArrays
        Arrays; optional ones are left out where they are None.
    """
    parts: list[tuple[tuple[str, ...], NDArray[np.float32]]] = [(("x", "y", "z"), mesh.vertices)]
    for name in ("normals", "uvs", "colors"):
        table = getattr(mesh, name)
        if table is not None:
            parts.append((NAMES[name][0], table))
    if mesh.more_uvs is not None:
        parts += zip(MORE_UVS, mesh.more_uvs, strict=False)
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.vertices)}"]
    header += [f"property float {column}" for names, _ in parts for column in names]
    header += [f"element face {len(mesh.faces)}", "property list uchar int vertex_indices"]
    rows = np.concatenate([table for _, table in parts], axis=1).astype("<f4")
    faces = np.zeros(len(mesh.faces), np.dtype([("n", "u1"), ("i", "<i4", (3,))]))
    faces["n"], faces["i"] = 3, mesh.faces
    text = "\n".join([*header, "end_header", ""]).encode()
    Path(path).write_bytes(text + rows.tobytes() + faces.tobytes())
