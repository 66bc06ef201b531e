"""Decodes Draco streams in a process of its own, which may die without harm to anybody.

Run as a script; nothing of alight is imported, so that it starts fast. In: the number of bytes
that it may use beyond its start, then for each stream its length (64 bits) and its bytes. Out: an
.npz with the tables ``N/faces`` and ``N/ID`` of stream number N, ID being that of an attribute; of
a broken stream only ``N/error``, which holds a text.
"""

from __future__ import annotations

import os
import struct
import sys
from typing import Any

import DracoPy  # pyright: ignore[reportMissingImports]
import numpy as np


def _limit(more: int) -> None:
    """Bound the memory of this process, where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    try:
        with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
            now = int(file.read().split()[0]) * resource.getpagesize()
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (now + more, hard))
    except (OSError, ValueError):  # Not Linux, or a lower limit holds already.
        return


def _decode(data: bytes) -> dict[str, Any]:
    try:
        mesh = DracoPy.decode(data)
        tables = {str(item["unique_id"]): item["data"] for item in mesh.attributes}
        tables = {key: table for key, table in tables.items() if table is not None}
        return {"faces": mesh.faces, **tables} if hasattr(mesh, "faces") else {"error": "points"}
    except MemoryError:
        return {"error": "memory"}
    except Exception as error:
        # Every kind of exception that the package may raise means the same here.
        return {"error": f"broken: {error}"}


def _main() -> None:
    # The decoder itself may write to the standard output.
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    head = sys.stdin.buffer.read(8)
    _limit(*struct.unpack("<Q", head))
    found: dict[str, Any] = {}
    number = 0
    while head := sys.stdin.buffer.read(8):
        data = sys.stdin.buffer.read(*struct.unpack("<Q", head))
        found |= {f"{number}/{key}": table for key, table in _decode(data).items()}
        number += 1
    np.savez(out, **found)
    out.close()


if __name__ == "__main__":
    _main()
