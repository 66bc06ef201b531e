"""JPEG: sRGB, quality 95, colour not subsampled. For mail and web pages, not for measurements."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from alight.outputs.display import Development
from alight.outputs.picture import Picture
from alight.outputs.png import read_with_pillow

SUFFIXES = (".jpg", ".jpeg")
IS_DISPLAY = True
KEEPS_LAYERS = False
KEEPS_ALPHA = False
KEEPS_DPI = True

_QUALITY = 95


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write the tone-mapped picture."""
    from PIL import Image

    pixels = np.rint(display.apply(picture.image) * 255.0).astype(np.uint8)
    # Through memory: Pillow reports a full disk without the reason.
    encoded = io.BytesIO()
    dots = {} if display.dpi is None else {"dpi": (round(display.dpi), round(display.dpi))}
    Image.fromarray(pixels).save(encoded, format="JPEG", quality=_QUALITY, subsampling=0, **dots)
    path.write_bytes(encoded.getvalue())


def read(path: Path) -> np.ndarray:
    """Read linear values, shape (h, w, 3)."""
    return read_with_pillow(path)
