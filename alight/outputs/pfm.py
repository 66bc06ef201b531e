"""Portable float map: a text header, then float32 rows from the bottom up.

After Debevec's description; a negative scale means little-endian.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from alight.outputs.picture import Picture
from alight.outputs.tone_mapping import Display

SUFFIXES = (".pfm",)
IS_DISPLAY = False
KEEPS_LAYERS = False


def write(path: Path, picture: Picture, display: Display) -> None:
    """Write the picture; `display` does not apply to linear formats."""
    h, w = picture.image.shape[:2]
    header = f"PF\n{w} {h}\n-1.0\n".encode("ascii")
    path.write_bytes(header + picture.image[::-1].astype("<f4").tobytes())


def read(path: Path) -> np.ndarray:
    """Read colour (PF) or grey (Pf) maps of either byte order; float32, shape (h, w, 3)."""
    data = path.read_bytes()
    # Exactly one white space ends the header; the pixels may begin with more of them.
    header = re.match(rb"(PF|Pf)\s+(\d{1,6})\s+(\d{1,6})\s+(-?[\d.]+(?:[eE][-+]?\d+)?)\s", data)
    if header is None:
        raise ValueError("not a PFM file")
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
