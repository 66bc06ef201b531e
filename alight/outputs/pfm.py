"""Portable float map: a text header, then float32 rows from the bottom up.

After Debevec's description; a negative scale means little-endian.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from alight.outputs.display import Development
from alight.outputs.picture import Picture

SUFFIXES = (".pfm",)
IS_DISPLAY = False
KEEPS_LAYERS = False
KEEPS_ALPHA = False
KEEPS_DPI = False

_MOST_HEADER = 1000


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write the picture; `display` does not apply to linear formats."""
    h, w = picture.image.shape[:2]
    header = f"PF\n{w} {h}\n-1.0\n".encode("ascii")
    path.write_bytes(header + picture.image[::-1].astype("<f4").tobytes())


def read(path: Path) -> np.ndarray:
    """Read colour (PF) or grey (Pf) maps of either byte order; float32, shape (h, w, 3)."""
    data = path.read_bytes()
    header = _header(data)
    w, h, scale, start = int(header[2]), int(header[3]), float(header[4]), header.end()
    if w < 1 or h < 1:
        raise ValueError(f"PFM of {w}x{h} pixels")
    channels = 3 if header[1] == b"PF" else 1
    size = w * h * channels * 4
    if len(data) - start < size:
        raise ValueError(f"PFM ends early: {len(data) - start} bytes of pixels, not {size}")
    order = "<f4" if scale < 0 else ">f4"
    rows = np.frombuffer(data, order, w * h * channels, start).reshape(h, w, channels)[::-1]
    return np.broadcast_to(rows, (h, w, 3))


def read_size(path: Path) -> tuple[int, int]:
    """Width and height, read without the pixels."""
    with path.open("rb") as file:
        header = _header(file.read(_MOST_HEADER))
    return int(header[2]), int(header[3])


def _header(data: bytes) -> re.Match[bytes]:
    # Exactly one white space ends the header; the pixels may begin with more of them.
    number = rb"(-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    found = re.match(rb"(PF|Pf)\s+(\d{1,6})\s+(\d{1,6})\s+" + number + rb"\s", data[:_MOST_HEADER])
    if found is None:
        raise ValueError("not a PFM file")
    return found
