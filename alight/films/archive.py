"""A file of arrays and plain JSON, read back exactly or refused.

::

    16 bytes   MAGIC: no text, and spoilt by transfers as text
    32 bytes   SHA-256 of all that follows
    u32, u64   version of the format; length of the header
    header     JSON: "content", and of each array its name, shape, type and planes
    planes     bytes

Whole numbers in films are small or have few digits, so most of their bytes are equal: an array is
taken apart into planes, the first byte of every element, the second byte of every element, and so
on. A plane of equal bytes is kept as one byte, others are deflated where that pays. All numbers are
little-endian.
"""

from __future__ import annotations

import hashlib
import json
import os
import struct
import zlib
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from alight.core.errors import FilmError, OutputError, show_value
from alight.outputs.atomic import replacing

MAGIC = b"\x89alight film\r\n\x1a\n"
VERSION = 1
_HEAD = struct.Struct("<IQ")

#: Types of elements that are kept.
_TYPES = frozenset({"int64", "uint64", "int32", "uint32", "uint8", "float32", "float64", "bool"})

#: Samples of a plane are deflated to see whether all of it is worth the time: how many, their
#: bytes, and how much they must shrink. A plane of noise costs 25 ms a megabyte and gives nothing.
_TRIALS, _TRIAL_BYTES, _WORTH = 16, 4096, 0.5

#: What reading a strange header raises, or making the arrays that it describes.
_STRANGE = (
    KeyError,
    TypeError,
    ValueError,
    IndexError,
    OverflowError,
    MemoryError,
    struct.error,
    zlib.error,
)

#: Numbers looked at at a time, and threads that deflate.
_PIECE, _THREADS = 1 << 15, 4


class Archive(NamedTuple):
    """What is in a file: plain JSON and named arrays."""

    content: dict[str, Any]
    arrays: dict[str, np.ndarray]


def write_archive(
    path: str | os.PathLike[str], content: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
) -> int:
    """Write a file, whole or not at all.

    Returns
    -------
    int
        Its size in bytes.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    # Nothing here holds the interpreter's lock for long.
    with ThreadPoolExecutor(_THREADS) as pool:
        pieces = pack_archive(content, arrays, pool.map)
    with replacing(path) as beside, beside.open("wb") as file:
        file.writelines(pieces)
    return sum(map(len, pieces))


def pack_archive(
    content: Mapping[str, Any],
    arrays: Mapping[str, np.ndarray],
    map_planes: Callable[..., Iterable[tuple[str, bytes]]] = map,
) -> list[bytes]:
    """Give the bytes of a file, in pieces; `map_planes` may pack the planes on several threads."""
    taken_apart = [_planes(name, array) for name, array in arrays.items()]
    planes = [plane for _, of_array in taken_apart for plane in of_array]
    packed = list(map_planes(_pack, planes))
    pieces = iter(packed)
    described = [
        {**about, "planes": [[kind, len(piece)] for kind, piece in islice(pieces, len(of_array))]}
        for about, of_array in taken_apart
    ]
    header = json.dumps({"content": content, "arrays": described}, allow_nan=False).encode()
    parts = [_HEAD.pack(VERSION, len(header)), header, *(piece for _, piece in packed)]
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return [MAGIC, digest.digest(), *parts]


def read_archive(path: str | os.PathLike[str]) -> Archive:
    """Read a file and check every byte of it.

    Raises
    ------
    OutputError
        If it cannot be read.
    FilmError
        If it is none, damaged or cut off, or of a newer format.
    """
    if not isinstance(path, str | os.PathLike):
        text = f"must be a film or its path, each by itself; got {show_value(path)}"
        raise FilmError(text)
    name = os.fspath(path)
    try:
        data = memoryview(Path(path).read_bytes())
    except FileNotFoundError as error:
        raise OutputError(f"cannot read {name}: there is no such file") from error
    except OSError as error:
        raise OutputError(f"cannot read {name}: {error.strerror or error}") from error
    return unpack_archive(name, data)


def unpack_archive(name: str, data: memoryview) -> Archive:
    """Read the bytes of a file; messages call it `name`.

    Raises
    ------
    FilmError
        If they are none, damaged or cut off, or of a newer format.
    """
    start = len(MAGIC) + hashlib.sha256().digest_size
    if bytes(data[: len(MAGIC)]) != MAGIC[: len(data)]:
        raise FilmError(f"{name} is not a film or checkpoint of alight")
    if hashlib.sha256(data[start:]).digest() != bytes(data[len(MAGIC) : start]):
        raise FilmError(f"{name} is damaged or truncated: its checksum is wrong")
    try:
        return _decode(name, data[start:])
    except FilmError:
        raise
    except _STRANGE as error:
        # The checksum is right, so somebody made it so.
        raise FilmError(f"{name} holds no readable film: {error!r}") from error


def _planes(name: str, array: np.ndarray) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Take an array apart: its description, and the bytes of each plane."""
    array = np.ascontiguousarray(array)
    if array.dtype.name not in _TYPES:
        raise TypeError(f"arrays of type {array.dtype} are not kept")
    size = array.dtype.itemsize
    octets = array.astype(array.dtype.newbyteorder("<"), copy=False).reshape(-1).view(np.uint8)
    differing = _differing_bytes(octets.view(f"<u{size}"))
    octets = octets.reshape(-1, size)
    planes = [octets[:, i] if differing[i] else octets[:1, i] for i in range(size)]
    return {"name": name, "type": array.dtype.name, "shape": array.shape}, planes


def _differing_bytes(numbers: np.ndarray) -> bytes:
    """Bits in which any of some unsigned little-endian numbers differs from the first."""
    found = np.zeros(1, numbers.dtype)
    # Piece by piece: what is in the cache is read once.
    for at in range(0, numbers.size, _PIECE):
        found |= np.bitwise_or.reduce(numbers[at : at + _PIECE] ^ numbers[0])
    return found.tobytes()


def _pack(plane: np.ndarray) -> tuple[str, bytes]:
    """Choose how a plane of bytes is kept: "equal", "deflated" or "raw"."""
    raw = plane.tobytes()
    if len(raw) <= 1:
        return "equal", raw
    # From all over the plane: the sky of a picture shrinks well, what is below it does not.
    step = max(len(raw) // _TRIALS, _TRIAL_BYTES)
    trial = b"".join(raw[at : at + _TRIAL_BYTES] for at in range(0, len(raw), step))
    if len(zlib.compress(trial, 1)) < _WORTH * len(trial):
        return "deflated", zlib.compress(raw, 1)
    return "raw", raw


def _decode(name: str, data: memoryview) -> Archive:
    version, length = _HEAD.unpack_from(data)
    if version != VERSION:
        raise FilmError(
            f"{name} has format {version}, and this version of alight knows format {VERSION}: "
            "use the version that wrote it"
        )
    header = json.loads(bytes(data[_HEAD.size : _HEAD.size + length]))
    at = _HEAD.size + length
    arrays = {}
    for described in header["arrays"]:
        array = np.zeros(described["shape"], np.dtype(described["type"]).newbyteorder("<"))
        octets = array.reshape(-1).view(np.uint8).reshape(-1, array.dtype.itemsize)
        for i, (kind, size) in enumerate(described["planes"]):
            # One byte fills a whole plane.
            octets[:, i] = _unpack(kind, data[at : at + size])
            at += size
        arrays[described["name"]] = array.astype(described["type"], copy=False)
    return Archive(header["content"], arrays)


def _unpack(kind: str, piece: memoryview) -> np.ndarray:
    return np.frombuffer(zlib.decompress(piece) if kind == "deflated" else piece, np.uint8)
