"""NumPy's own format: the linear picture as float32, shape (h, w, 3)."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from alight.outputs.display import Development
from alight.outputs.picture import Picture, as_picture

SUFFIXES = (".npy",)
IS_DISPLAY = False
KEEPS_LAYERS = False


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write the picture; `display` does not apply to linear formats."""
    # Through memory: NumPy's own writing to files reports a full disk without the reason.
    encoded = io.BytesIO()
    np.save(encoded, picture.image, allow_pickle=False)
    path.write_bytes(encoded.getvalue())


def read(path: Path) -> np.ndarray:
    """Read the picture that is stored."""
    return as_picture(np.load(path, allow_pickle=False)).image
