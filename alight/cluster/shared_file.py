"""What tasks share, once in the memory of a machine: a file that all of its workers map.

An object is pickled with its arrays apart, so that they are read where they lie. The pages of a
mapped file are the same memory in every process; a process that writes to one gets a copy of it.
"""

from __future__ import annotations

import hashlib
import mmap
import os
import pickle
import struct
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

#: Arrays begin at multiples of this many bytes, for aligned loads.
_ALIGNMENT = 64

#: Seconds after which a file is nobody's: its worker was killed before it could remove it.
_STALE = 86400.0

_PREFIX = "alight-"
_HEAD = struct.Struct("<Q")


def packed(thing: Any) -> bytes:
    """Pickle an object: the lengths of all parts, its pickle, and the bytes of its arrays."""
    buffers: list[pickle.PickleBuffer] = []
    parts: list[Any] = [pickle.dumps(thing, protocol=5, buffer_callback=buffers.append)]
    parts += [buffer.raw() for buffer in buffers]
    head = [len(parts), *(len(part) for part in parts)]
    data = bytearray(b"".join(map(_HEAD.pack, head)))
    for part in parts:
        data += bytes(-len(data) % _ALIGNMENT)
        data += part
    return bytes(data)


def unpacked(data: Any) -> Any:
    """Make the object of `packed` again; its arrays are views of `data`."""
    view, size = memoryview(data), _HEAD.size
    (count,) = _HEAD.unpack_from(view)
    parts, at = [], size * (1 + count)
    for number in range(count):
        (length,) = _HEAD.unpack_from(view, size * (1 + number))
        at += -at % _ALIGNMENT
        parts.append(view[at : at + length])
        at += length
    return pickle.loads(parts[0], buffers=parts[1:])


def mapped(folder: Path, digest: str, data: bytes) -> Any:
    """Give the same bytes in memory that is shared with the other processes of this machine.

    Parameters
    ----------
    folder : Path
        The same one for all of them.
    digest : str
        SHA-256 of `data`.
    data : bytes

    Returns
    -------
    mmap or bytes
        `data` itself where the folder cannot be used.
    """
    path = folder / (_PREFIX + digest)
    try:
        if not path.exists():
            _write(path, data)
        with path.open("rb") as file:
            found = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)
            ours = not hasattr(os, "getuid") or os.fstat(file.fileno()).st_uid == os.getuid()
    except (OSError, ValueError):
        return data
    # Whoever can write to the folder could have been first.
    if not ours or hashlib.sha256(found).hexdigest() != digest:
        return data
    return found


def forget(folder: Path, digest: str) -> None:
    """Remove the file; processes that have mapped it keep its memory until they end."""
    with suppress(OSError):
        (folder / (_PREFIX + digest)).unlink()


def _write(path: Path, data: bytes) -> None:
    """Write a file that is there whole or not at all; another process may be faster."""
    number, name = tempfile.mkstemp(dir=path.parent, prefix=_PREFIX)
    try:
        with os.fdopen(number, "wb") as file:
            file.write(data)
        _remove_stale(path.parent, Path(name).stat().st_mtime)
        with suppress(FileExistsError):
            os.link(name, path)
    finally:
        Path(name).unlink()


def _remove_stale(folder: Path, now: float) -> None:
    for path in folder.glob(_PREFIX + "*"):
        with suppress(OSError):
            if now - path.stat().st_mtime > _STALE:
                path.unlink()
