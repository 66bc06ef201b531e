"""A .glb file in the making: its JSON, its bytes, and what it cannot hold."""

from __future__ import annotations

import errno
import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Json = dict[str, Any]
#: Bytes of a file, which says its length in 32 bits.
MOST_BYTES = 2**32 - 1


@dataclass
class Store:
    """Tables of a file.

    Attributes
    ----------
    json : dict
        The document.
    data : bytearray
        Its one buffer.
    lost : dict of str to None
        What it does not hold, or not quite, in the order in which it was met.
    used : set of str
        Extensions.
    """

    json: Json = field(default_factory=lambda: {"asset": {"version": "2.0", "generator": "alight"}})
    data: bytearray = field(default_factory=bytearray)
    lost: dict[str, None] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)

    def lose(self, text: str) -> None:
        """Say once what is not as it was."""
        self.lost[text] = None

    def put(self, key: str, value: Json) -> int:
        """Append to a table of the document; the index there."""
        table = self.json.setdefault(key, [])
        table.append(value)
        return len(table) - 1

    def extension(self, owner: Json, name: str, content: Json) -> None:
        """Give an object an extension."""
        self.used.add(name)
        owner.setdefault("extensions", {})[name] = content

    def view(self, data: bytes) -> int:
        """Append bytes; the index of their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        self.data += data
        return self.put("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data)})

    def accessor(self, table: np.ndarray, component: int, kind: str) -> int:
        """Append a table; the index of its accessor."""
        item: Json = {
            "bufferView": self.view(np.ascontiguousarray(table).tobytes()),
            "componentType": component, "count": len(table), "type": kind,
        }  # fmt: skip
        if kind == "VEC3":
            item |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        return self.put("accessors", item)

    def bytes(self) -> bytes:
        """The file.

        Raises
        ------
        OSError
            If it is too large for the format.
        """
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["buffers"] = [{"byteLength": max(len(self.data), 4)}]
        count = len(self.json.get("nodes", []))
        self.json |= {"scene": 0, "scenes": [{"nodes": list(range(count))} if count else {}]}
        if self.used:
            self.json["extensionsUsed"] = sorted(self.used)
        data = bytes(self.data) or b"\0" * 4
        text = json.dumps(self.json, allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        length = 28 + len(text) + len(data)
        if length > MOST_BYTES:
            text = f"a .glb file holds at most {MOST_BYTES} bytes, this would be {length}"
            raise OSError(errno.EFBIG, text)
        head = struct.pack("<4sII", b"glTF", 2, length)
        json_chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
        return head + json_chunk + struct.pack("<II", len(data), 0x004E4942) + data
