"""Tensor files: named arrays one after another, with a table of them at the start.

All numbers are little-endian. The head is ``tensor_file`` and a zero byte, two bytes of version (1,
0), and the number of fields (u32). Of each field follow the length of its name (u16), the name, the
number of its dimensions (u16), the type of its numbers (u8), the offset of its data in the file
(u64) and the length of each dimension (u64).

Source: Dupuy and Jakob 2018, An adaptive parameterization for efficient material acquisition and
rendering, and the files of its database (https://rgl.epfl.ch/materials).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from math import prod

import numpy as np
from numpy.typing import NDArray

_MAGIC = b"tensor_file\0"
_VERSION = (1, 0)
#: Numbers of the types, from 1.
_TYPES = ("u1", "i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f2", "<f4", "<f8")
_MOST_FIELDS, _MOST_DIMENSIONS = 256, 16

Arrays = dict[str, NDArray]


def parse_tensors(data: bytes) -> Arrays:
    """Read all fields.

    Parameters
    ----------
    data : bytes
        The file.

    Returns
    -------
    dict of str to array
        Views of the data, read-only.

    Raises
    ------
    ValueError
        If it is no tensor file, or an incomplete one; the text says what is wrong.
    """
    if not data.startswith(_MAGIC):
        raise ValueError("is no tensor file: it must begin with tensor_file")
    take = _Cursor(data, len(_MAGIC))
    version = take("2B")
    if version != _VERSION:
        raise ValueError(f"has version {version[0]}.{version[1]}, only 1.0 is known")
    (count,) = take("I")
    if count > _MOST_FIELDS:
        raise ValueError(f"must have at most {_MOST_FIELDS} fields, got {count}")
    found: Arrays = {}
    for _ in range(count):
        (length,) = take("H")
        name = take(f"{length}s")[0].decode("utf-8", "replace")
        dimensions, kind, offset = take("HBQ")
        if dimensions > _MOST_DIMENSIONS or not 1 <= kind <= len(_TYPES):
            raise ValueError(f"field {name!r} has {dimensions} dimensions of the type {kind}")
        shape = take(f"{dimensions}Q")
        dtype = np.dtype(_TYPES[kind - 1])
        # Python's numbers: products of lengths of a broken file do not wrap around.
        if offset + prod(shape) * dtype.itemsize > len(data):
            raise ValueError(f"field {name!r} reaches beyond the end of the file")
        found[name] = np.frombuffer(data, dtype, prod(shape), offset).reshape(shape)
    return found


class _Cursor:
    """Takes numbers from bytes, one after another."""

    def __init__(self, data: bytes, at: int) -> None:
        self.data, self.at = data, at

    def __call__(self, form: str) -> tuple:
        form = f"<{form}"
        end = self.at + struct.calcsize(form)
        if end > len(self.data):
            raise ValueError("ends within its table of fields")
        values = struct.unpack_from(form, self.data, self.at)
        self.at = end
        return values


def write_tensors(arrays: Mapping[str, NDArray]) -> bytes:
    """Make a tensor file of arrays whose types it knows."""
    names = [name.encode() for name in arrays]
    sizes = [
        2 + len(name) + 11 + 8 * array.ndim
        for name, array in zip(names, arrays.values(), strict=True)
    ]
    at = len(_MAGIC) + 6 + sum(sizes)
    head, body = [_MAGIC, struct.pack("<2BI", *_VERSION, len(names))], []
    for name, array in zip(names, arrays.values(), strict=True):
        dtype = array.dtype.newbyteorder("<")
        kind = [np.dtype(known) for known in _TYPES].index(dtype) + 1
        text = np.ascontiguousarray(array, dtype).tobytes()
        head += [struct.pack("<H", len(name)), name]
        head.append(struct.pack(f"<HBQ{array.ndim}Q", array.ndim, kind, at, *array.shape))
        body.append(text)
        at += len(text)
    return b"".join([*head, *body])
