"""Meshes in Draco streams -> accessors that are read like all others.

The C++ decoder runs in a process of its own, with bounded memory and time: what a broken stream
does to it is one message here. Files that hold their meshes twice, compressed and not, are read
without it, so that a picture does not depend on what is installed.

Source: Khronos Group, KHR_draco_mesh_compression; Draco bitstream specification 2.2, section 4.
"""

from __future__ import annotations

import importlib.util
import io
import os
import struct
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import SceneError
from alight.core.extras import install_command
from alight.formats.gltf.accessors import COMPONENTS, view_bytes
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item

NAME = "KHR_draco_mesh_compression"
WAY_OUT = "write the file without it: gltf-transform copy IN OUT"
#: Bytes of memory for the decoder, and more for each byte of a file's streams. Meshes of two
#: million triangles take some 150 for each triangle, which has at least half a byte in the stream.
MEMORY, MEMORY_PER_BYTE = 2**30, 256
#: Triangles or vertices that a stream may announce, and more for each of its bytes.
MOST, MOST_PER_BYTE = 2**20, 1024
#: Seconds, and more for each byte.
SECONDS, SECONDS_PER_BYTE = 60.0, 1e-4
_EDGEBREAKER = 1
_WORKER = Path(__file__).with_name("draco_worker.py")
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_WHY = {
    "points": "holds points, no triangles",
    "memory": "asks for more memory than a stream of its size may",
    "broken": "is no Draco mesh, or a broken one",
}


@dataclass(frozen=True)
class _Mesh:
    """A primitive and its stream."""

    primitive: Item
    extension: Item
    data: memoryview


def unpack_draco(document: Document) -> None:
    """Decode all Draco streams of a file into buffers and accessors beside its own.

    Parameters
    ----------
    document : Document
        Primitives with streams then name the new accessors.

    Raises
    ------
    SceneError
        If a stream is broken, or the package that decodes is missing.
    """
    document.list("accessors")
    required = NAME in document.root.value.get("extensionsRequired", [])
    meshes = []
    for mesh in document.root.objects("meshes"):
        for primitive in mesh.objects("primitives"):
            extension = primitive.extension(NAME)
            if extension is None:
                continue
            if not required and _is_there_twice(document, primitive):
                document.report.drop(f"{NAME}: the file holds the same meshes without it")
                continue
            data, _ = view_bytes(document, extension, "bufferView")
            _check(extension, data)
            meshes.append(_Mesh(primitive, extension, data))
    if not meshes:
        return
    if importlib.util.find_spec("DracoPy") is None:
        text = f"{NAME} needs the package DracoPy: {install_command('gltf', 'DracoPy')}"
        raise meshes[0].extension.fatal("", f"{text}; or {WAY_OUT}")
    document.report.count("Draco streams", len(meshes))
    for mesh, tables in zip(meshes, _decoded(meshes), strict=True):
        _enter(document, mesh, tables)


def _is_there_twice(document: Document, primitive: Item) -> bool:
    """Whether all that a primitive names is there without compression, too."""
    accessors = document.root.value.get("accessors", [])
    attributes = primitive.value.get("attributes", {})
    named = [*attributes.values()] if isinstance(attributes, dict) else []
    named += [primitive.value["indices"]] if primitive.has("indices") else []
    found = [accessors[i] for i in named if isinstance(i, int) and 0 <= i < len(accessors)]
    return bool(named) and all(isinstance(a, dict) and "bufferView" in a for a in found)


def _check(extension: Item, data: memoryview) -> None:
    """Refuse streams that are none, or announce more than their bytes can hold."""
    if bytes(data[:5]) != b"DRACO" or len(data) < 12:
        raise extension.fatal("bufferView", "is no Draco stream")
    kind, method, flags = data[7], data[8], struct.unpack_from("<H", data, 9)[0]
    if kind != 1:
        raise extension.fatal("bufferView", _WHY["points"])
    if flags & 0x8000:
        # Metadata come first; what follows is left to the limits of the process.
        return
    at = 11 + (method == _EDGEBREAKER)
    for _ in range(2):
        number, at = _varint(data, at)
        most = MOST + MOST_PER_BYTE * len(data)
        if number > most:
            text = f"announces {number} triangles or vertices in {len(data)} bytes"
            raise extension.fatal("bufferView", f"{text}, at most {most} are believed")


def _varint(data: memoryview, at: int) -> tuple[int, int]:
    """A number of seven bits a byte, the lowest first, and where it ends."""
    number, shift = 0, 0
    for byte in data[at : at + 5]:
        number |= (byte & 127) << shift
        shift += 7
        at += 1
        if byte < 128:
            break
    return number, at


def _decoded(meshes: list[_Mesh]) -> list[dict[str, np.ndarray]]:
    """The tables of all streams: ``faces``, and attributes by their identifiers."""
    size = sum(len(mesh.data) for mesh in meshes)
    parts = [struct.pack("<Q", MEMORY + MEMORY_PER_BYTE * size)]
    for mesh in meshes:
        parts += [struct.pack("<Q", len(mesh.data)), bytes(mesh.data)]
    # One thread: others would take memory for their stacks.
    single = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    extension = meshes[0].extension
    try:
        done = subprocess.run(
            # -P: the modules beside the script are not those that it imports.
            [sys.executable, "-P", str(_WORKER)],
            input=b"".join(parts),
            capture_output=True,
            env={**os.environ, **single},
            timeout=SECONDS + SECONDS_PER_BYTE * size,
        )
    except subprocess.TimeoutExpired:
        raise extension.fatal("", f"its decoder found no end; {WAY_OUT}") from None
    except OSError as error:
        raise extension.fatal("", f"its decoder does not start: {error.strerror}") from None
    try:
        with np.load(io.BytesIO(done.stdout), allow_pickle=False) as file:
            tables = {key: file[key] for key in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        reason = done.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2][:200]
        text = f"its decoder ended with exit code {done.returncode}"
        text += f" ({reason})" if reason else ""
        raise extension.fatal("", f"{text}; {WAY_OUT}") from None
    found: list[dict[str, np.ndarray]] = [{} for _ in meshes]
    for key, table in tables.items():
        number, _, name = key.partition("/")
        found[int(number)][name] = table
    for mesh, named in zip(meshes, found, strict=True):
        if "error" in named or not all(table.size for table in named.values()):
            why = str(named.get("error", "broken")).partition(":")[0]
            raise mesh.extension.fatal("bufferView", f"{_WHY.get(why, why)}; {WAY_OUT}")
    return found


def _enter(document: Document, mesh: _Mesh, tables: dict[str, np.ndarray]) -> None:
    """Make a primitive name accessors that hold what its stream does."""
    attributes, wanted = mesh.primitive.object("attributes"), mesh.extension.object("attributes")
    if attributes is None or wanted is None:
        raise mesh.extension.fatal("attributes", "is missing")
    faces = np.ascontiguousarray(tables["faces"], "<u4").reshape(-1, 1)
    # The list of triangles takes the place of strips, too.
    mesh.primitive.value["mode"] = 4
    mesh.primitive.value["indices"] = _accessor(document, faces, {})
    for name in wanted.value:
        if not attributes.has(name):
            continue
        identifier = wanted.integer(name, 0)
        if document.report.issues:
            raise SceneError(document.report.issues)
        if str(identifier) not in tables:
            held = ", ".join(sorted((k for k in tables if k != "faces"), key=int))
            text = f"must be the identifier of an attribute of its stream, got {identifier}"
            raise wanted.fatal(name, f"{text}  (identifiers: {held})")
        found = document.root.value.get("accessors", [])
        index = attributes.index(name, len(found), "accessors")
        said = found[index] if index is not None and isinstance(found[index], dict) else {}
        table = _storable(wanted, name, tables[str(identifier)], said)
        if said.get("count", len(table)) != len(table):
            document.report.approximate(
                f"{mesh.primitive.pointer}: {name} has {len(table)} rows in its Draco stream, "
                f"{said['count']} according to its accessor; the stream's are taken"
            )
        attributes.value[name] = _accessor(document, table, said)


def _storable(wanted: Item, name: str, table: np.ndarray, said: dict[str, Any]) -> np.ndarray:
    """An attribute in a type that accessors have: that of its own accessor, if it holds it."""
    if table.ndim != 2 or table.shape[1] not in _KINDS:
        raise wanted.fatal(name, f"must have 1 to 4 components, has {table.shape[1:]}")
    if table.dtype.kind not in "iub":
        return table.astype("<f4")
    number = said.get("componentType")
    named = COMPONENTS.get(number if isinstance(number, int) else 0, np.dtype("<u4"))
    # Encoders may store numbers wider than these are.
    return table.astype(named) if (table.astype(named) == table).all() else table.astype("<u4")


def _accessor(document: Document, table: np.ndarray, said: dict[str, Any]) -> int:
    """Append a table to the file; the index of its accessor."""
    table = np.ascontiguousarray(table)
    types = {dtype: number for number, dtype in COMPONENTS.items()}
    item: dict[str, Any] = {
        "bufferView": document.append(memoryview(table).cast("B")),
        "componentType": types[table.dtype.newbyteorder("<")],
        "count": len(table),
        "type": _KINDS[table.shape[1]],
    }
    if said.get("normalized") is True:
        item["normalized"] = True
    accessors = document.root.value.setdefault("accessors", [])
    accessors.append(item)
    return len(accessors) - 1
