"""APNG: pictures one after the other in a PNG file (PNG, third edition, 2025, section 11.3.6).

The encoder is our own because Pillow's keeps all frames until the end, counts time in whole
milliseconds, and makes one frame of those that are alike.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from itertools import count
from pathlib import Path

import numpy as np

from alight.outputs.png import SIGNATURE, chunk, compressed, header


def write(path: Path, frames: Iterable[np.ndarray], fps: int, length: int) -> None:
    """Write frames as they come, each whole and of the same length in time.

    Parameters
    ----------
    path : Path
    frames : iterable of ndarray of uint8, shape (h, w, 3)
    fps : int
        At most 65535.
    length : int
        Number of frames; the file holds it before the first one.
    """
    numbers = count()
    with path.open("wb") as file:
        for index, frame in enumerate(frames):
            h, w, channels = frame.shape
            if not index:
                file.write(SIGNATURE + header(frame.shape, 8))
                file.write(chunk(b"acTL", struct.pack(">II", length, 0)))
            # For 1 / fps seconds, from the upper left corner, over whatever was there.
            control = struct.pack(">IIIIIHHBB", next(numbers), w, h, 0, 0, 1, fps, 0, 0)
            file.write(chunk(b"fcTL", control))
            data = compressed(frame.reshape(h, -1), channels)
            # The first frame is what programs see that know nothing of APNG.
            kind, number = (b"fdAT", struct.pack(">I", next(numbers))) if index else (b"IDAT", b"")
            file.write(chunk(kind, number + data))
        file.write(chunk(b"IEND", b""))
