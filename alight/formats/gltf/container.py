"""The bytes of a glTF file: JSON and buffers, from .gltf with files beside it, or one .glb.

Source: Khronos Group, glTF 2.0 specification, sections 3.6 and 4.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from alight.core.errors import Issue, SceneError, quote, show_value
from alight.formats.gltf.values import Item
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report

MOST_BYTES = 2**30
MOST_JSON = 256 * 2**20
_MAGIC, _JSON, _BIN = b"glTF", 0x4E4F534A, 0x004E4942
_DATA_URI = re.compile(r"data:([^,;]*)((?:;[^,;]*)*),", re.ASCII)


@dataclass
class Document:
    """A file that has been opened.

    Attributes
    ----------
    root : Item
        The JSON object.
    chunk : bytes or None
        Binary part of a .glb file.
    reach : Reach
        Finds the files that it names.
    """

    root: Item
    chunk: memoryview | None
    reach: Reach
    _buffers: dict[int, memoryview] = field(default_factory=dict)
    _lists: dict[str, list[Item]] = field(default_factory=dict)

    def list(self, key: str) -> list[Item]:
        """The objects of one of the lists at the top."""
        if key not in self._lists:
            self._lists[key] = self.root.objects(key)
        return self._lists[key]

    @property
    def report(self) -> Report:
        """What was noticed."""
        return self.root.report

    def buffer(self, index: int) -> memoryview:
        """The bytes of a buffer.

        Raises
        ------
        SceneError
            If they cannot be had, or are fewer than the file says.
        """
        if index not in self._buffers:
            item = self.list("buffers")[index]
            length = item.integer("byteLength", 0, 1, MOST_BYTES)
            data = self._bytes(item, index)
            if len(data) < length:
                raise item.fatal("byteLength", f"must be at most {len(data)}, got {length}")
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def append(self, data: memoryview) -> int:
        """Add bytes in a buffer of their own; the index of their view."""
        buffers = self.root.value.setdefault("buffers", [])
        views = self.root.value.setdefault("bufferViews", [])
        self._buffers[len(buffers)] = data
        views.append({"buffer": len(buffers), "byteLength": len(data)})
        buffers.append({"byteLength": len(data)})
        self._lists.clear()
        return len(views) - 1

    def _bytes(self, item: Item, index: int) -> memoryview:
        if not item.has("uri"):
            if index == 0 and self.chunk is not None:
                return self.chunk
            raise item.fatal("", "needs a uri: there is no binary part that it could mean")
        found = self.resource(item, item.text("uri"))
        if isinstance(found, Path):
            try:
                return memoryview(content_of(found, MOST_BYTES))
            except OutOfReachError as error:
                raise item.fatal("uri", str(error)) from None
        return memoryview(found)

    def resource(self, item: Item, uri: str) -> bytes | Path:
        """What a URI stands for: the bytes in it, or a file beside the scene.

        Raises
        ------
        SceneError
            If it leads elsewhere, or is broken.
        """
        try:
            return self.located(item, uri)
        except OutOfReachError as error:
            raise item.fatal("uri", str(error)) from None

    def located(self, item: Item, uri: str) -> bytes | Path:
        """As `resource`; raises `OutOfReachError` for a file that cannot be had."""
        head = _DATA_URI.match(uri[:200])
        if head is not None:
            return _decoded(item, uri, head)
        if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:", uri):
            text = f"must be a file beside the scene or a data: URI, got {quote(uri)}"
            raise OutOfReachError(text)
        return self.reach.find(unquote(uri))


def _decoded(item: Item, uri: str, head: re.Match[str]) -> bytes:
    if ";base64" not in head[2]:
        raise item.fatal("uri", "data: URIs must be base64")
    try:
        return base64.b64decode(uri[head.end() :], validate=True)
    except (binascii.Error, ValueError) as error:
        raise item.fatal("uri", f"is not base64: {error}") from None


def open_document(data: bytes, name: str, reach: Reach, report: Report) -> Document:
    """Open a file.

    Parameters
    ----------
    data, name : bytes and str
        Its content, and its name for messages.
    reach : Reach
        Where the files that it names may lie.
    report : Report
        Takes what is noticed.

    Raises
    ------
    SceneError
        If it is not a glTF file.
    """
    text, chunk = _chunks(data, name) if data[:4] == _MAGIC else (data, None)
    root = Item(_parse(text, name), "", name, report)
    document = Document(root, chunk, reach)
    asset = root.object("asset")
    if asset is None:
        raise root.fatal("", "is not a glTF file: the key asset is missing")
    found = asset.value.get("version", "2.0")
    # Early files have a number.
    version = f"{found:g}" if isinstance(found, int | float) else asset.text("version", "2.0")
    if not re.fullmatch(r"2\.\d+", version):
        text = f"must be 2.0, got {quote(version)}: convert the file with a newer program"
        raise asset.fatal("version", text)
    return document


def _chunks(data: bytes, name: str) -> tuple[bytes, memoryview | None]:
    """JSON and binary part of a .glb file."""
    if len(data) < 20:
        raise _broken(name, f"is no .glb file: it has {len(data)} bytes")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise _broken(name, f"must be glTF version 2, got {version}")
    if length > len(data):
        raise _broken(name, f"is cut off: {length} bytes are announced, {len(data)} are there")
    parts: dict[int, memoryview] = {}
    view, at = memoryview(data)[:length], 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > length:
            raise _broken(name, f"is cut off in the chunk at byte {at}")
        parts.setdefault(kind, view[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON not in parts:
        raise _broken(name, "has no JSON chunk")
    return bytes(parts[_JSON]), parts.get(_BIN)


def _parse(text: bytes, name: str) -> dict[str, Any]:
    if len(text) > MOST_JSON:
        raise _broken(name, f"its JSON must be at most {MOST_JSON >> 20} MB")
    try:
        decoded = text.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _broken(name, f"must be UTF-8 text: byte {error.start} is not") from None
    try:
        found = json.loads(decoded, parse_constant=_refuse)
    except json.JSONDecodeError as error:
        raise SceneError(
            [Issue("", f"is not JSON: {error.msg}", f"{name}:{error.lineno}:{error.colno}")]
        ) from None
    except RecursionError:
        raise _broken(name, "is nested too deeply") from None
    except ValueError as error:
        raise _broken(name, f"is not JSON: {error}") from None
    if not isinstance(found, dict):
        raise _broken(name, f"must be a JSON object, got {show_value(found)}")
    return found


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is not a number")


def _broken(name: str, message: str) -> SceneError:
    return SceneError([Issue("", message, name)])
