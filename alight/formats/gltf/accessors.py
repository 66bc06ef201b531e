"""Accessors: numbers in buffers, of all types, with strides, normalised and sparse.

Source: Khronos Group, glTF 2.0 specification, section 3.6.2; KHR_mesh_quantization.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import unknown_name
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item

TYPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
COMPONENTS = {
    5120: np.dtype("i1"),
    5121: np.dtype("u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
MOST_COUNT, MOST_ZEROS = 2**28, 2**22


def read_accessor(document: Document, index: int) -> NDArray[Any]:
    """Read an accessor.

    Returns
    -------
    (count, components) ndarray
        As stored, or float32 in [-1, 1] where the accessor is normalised.

    Raises
    ------
    SceneError
        If it reaches out of its buffer, or makes no sense.
    """
    item = document.list("accessors")[index]
    dtype, columns = _kind(item)
    count = item.integer("count", 0, 1, MOST_COUNT)
    if count == 0:
        raise item.fatal("count", "must be a whole number >= 1")
    if item.has("bufferView"):
        table = _view(document, item, dtype, columns, count)
    elif count > MOST_ZEROS:
        # A file of a few bytes must not ask for gigabytes.
        raise item.fatal("count", f"must be at most {MOST_ZEROS} without a bufferView, got {count}")
    else:
        table = np.zeros((count, columns), dtype)
    sparse = item.object("sparse")
    if sparse is not None:
        table = _replaced(document, sparse, table, dtype, columns)
    return _scaled(table) if item.flag("normalized") else table


def _kind(item: Item) -> tuple[np.dtype[Any], int]:
    component = item.value.get("componentType")
    if not isinstance(component, int) or component not in COMPONENTS:
        listed = ", ".join(str(number) for number in COMPONENTS)
        raise item.fatal("componentType", f"must be one of {listed}, got {component!r:.60}")
    if not item.has("type"):
        raise item.fatal("type", f"is missing  (valid: {', '.join(TYPES)})")
    kind = item.value["type"]
    if not isinstance(kind, str) or kind not in TYPES:
        raise item.fatal("type", unknown_name("accessor type", str(kind), TYPES))
    dtype = COMPONENTS[component]
    if kind in ("MAT2", "MAT3") and dtype.itemsize < 4:
        raise item.fatal("componentType", "matrices of 8 and 16 bits are not covered")
    return dtype, TYPES[kind]


def _view(
    document: Document, item: Item, dtype: np.dtype[Any], columns: int, count: int
) -> NDArray[Any]:
    """The rows of a table in a buffer view, without a copy where that can be."""
    view, stride = view_bytes(document, item, "bufferView")
    size = dtype.itemsize * columns
    stride = stride or size
    if stride < size:
        raise item.fatal("bufferView", f"has a stride of {stride} bytes for rows of {size}")
    offset = item.integer("byteOffset", 0)
    needed = offset + (count - 1) * stride + size
    if needed > len(view):
        text = f"must fit into its buffer view of {len(view)} bytes, needs {needed}"
        raise item.fatal("count", text)
    return np.ndarray((count, columns), dtype, view, offset, (stride, dtype.itemsize))


def view_bytes(document: Document, item: Item, key: str) -> tuple[memoryview, int]:
    """The bytes of the buffer view that an object names, and its stride (0: none).

    Raises
    ------
    SceneError
        If there is no such view, or it reaches out of its buffer.
    """
    views = document.list("bufferViews")
    index = item.index(key, len(views), "buffer views")
    if index is None:
        raise item.fatal(key, "must be the index of a buffer view")
    view = views[index]
    buffer_index = view.index("buffer", len(document.list("buffers")), "buffers")
    if view.extension(MESHOPT) is not None:
        _check_fallback(document, view, buffer_index)
    if buffer_index is None:
        raise view.fatal("buffer", "must be the index of a buffer")
    buffer = document.buffer(buffer_index)
    offset, length = view.integer("byteOffset", 0), view.integer("byteLength", 0)
    if length < 1 or offset + length > len(buffer):
        text = f"must fit into its buffer of {len(buffer)} bytes, needs {offset + length}"
        raise view.fatal("byteLength", text)
    return buffer[offset : offset + length], view.integer("byteStride", 0, 0, 2**16)


def _check_fallback(document: Document, view: Item, buffer: int | None) -> None:
    """Refuse a compressed view whose data are not there without compression, too."""
    held = None if buffer is None else document.list("buffers")[buffer]
    if held is None or not (held.has("uri") or (buffer == 0 and document.chunk is not None)):
        raise view.fatal("extensions", COMPRESSED[MESHOPT])
    document.report.drop(f"{MESHOPT}: the file holds the same data without it")


MESHOPT = "EXT_meshopt_compression"
#: What cannot be read, and the way out.
COMPRESSED = {
    MESHOPT: "EXT_meshopt_compression is not covered; write the file without it: "
    "gltf-transform copy IN OUT, or gltfpack -i IN -o OUT without -c",
}


def _replaced(
    document: Document, sparse: Item, table: NDArray[Any], dtype: np.dtype[Any], columns: int
) -> NDArray[Any]:
    """A table in which some rows are replaced by others."""
    count = sparse.integer("count", 0, 1, len(table))
    places, values = sparse.object("indices"), sparse.object("values")
    if count == 0 or places is None or values is None:
        raise sparse.fatal("", "needs a count >= 1, indices and values")
    component = places.value.get("componentType")
    if component not in (5121, 5123, 5125):
        text = f"must be 5121, 5123 or 5125, got {component!r:.60}"
        raise places.fatal("componentType", text)
    sparse_item = Item({**places.value, "count": count}, places.pointer, places.name, places.report)
    index = _view(document, sparse_item, COMPONENTS[component], 1, count)[:, 0].astype(np.int64)
    if index.max() >= len(table):
        raise places.fatal("", f"must be in [0, {len(table) - 1}], got {index.max()}")
    rows = Item({**values.value, "count": count}, values.pointer, values.name, values.report)
    table = table.copy()
    table[index] = _view(document, rows, dtype, columns, count)
    return table


def _scaled(table: NDArray[Any]) -> NDArray[np.float32]:
    """Whole numbers -> [0, 1] or [-1, 1], by the formulas of the specification."""
    if table.dtype.kind == "f":
        return table
    scale = np.float32(1.0 / np.iinfo(table.dtype).max)
    return np.maximum(table.astype(np.float32) * scale, np.float32(-1.0))
