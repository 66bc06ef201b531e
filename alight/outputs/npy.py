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
KEEPS_ALPHA = False
KEEPS_DPI = False


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write the picture; `display` does not apply to linear formats."""
    # Through memory: NumPy's own writing to files reports a full disk without the reason.
    encoded = io.BytesIO()
    np.save(encoded, picture.image, allow_pickle=False)
    path.write_bytes(encoded.getvalue())


def read(path: Path) -> np.ndarray:
    """Read the picture that is stored."""
    return as_picture(load_array(path)).image


def load_array(path: Path, *, mapped: bool = False) -> np.ndarray:
    """Read an array.

    Parameters
    ----------
    path : Path
    mapped : bool, default False
        Leave the numbers in the file: then a header that promises too much costs no memory.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read or is broken.
    """
    try:
        return np.load(path, mmap_mode="r" if mapped else None, allow_pickle=False)
    except (OSError, ValueError):
        raise
    except Exception as error:
        # NumPy reads the header as Python text: TokenError, SyntaxError, TypeError, ...
        text = " ".join(str(part) for part in error.args)
        raise ValueError(f"is broken ({text})") from None
