"""OpenEXR: float32, lossless, with the error, AOVs and sample counts as layers.

Channels ``R G B`` are the picture, premultiplied by ``A`` where it has coverage,
``standard_error.R`` and so on the layers. A crop is written
with the full film as display window. Provenance is in the header as strings ``alight.<key>``.
"""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from alight.outputs.display import Development
from alight.outputs.picture import Picture

SUFFIXES = (".exr",)
IS_DISPLAY = False
KEEPS_LAYERS = True
KEEPS_ALPHA = True
KEEPS_DPI = True

_MAGIC = b"\x76\x2f\x31\x01"


def write(path: Path, picture: Picture, display: Development) -> None:
    """Write all layers; `display` does not apply to linear formats."""
    import OpenEXR

    h, w = picture.image.shape[:2]
    x, y = picture.offset
    full_w, full_h = picture.full_size
    header: dict[str, Any] = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "dataWindow": ((x, y), (x + w - 1, y + h - 1)),
        "displayWindow": ((0, 0), (full_w - 1, full_h - 1)),
    }
    header |= {f"alight.{key}": value for key, value in picture.attributes.items()}
    header |= picture.header
    channels = {c: np.ascontiguousarray(picture.image[..., i]) for i, c in enumerate("RGB")}
    if picture.opacity is not None:
        channels["A"] = np.ascontiguousarray(picture.opacity, np.float32)
    if display.dpi is not None:
        header["xDensity"] = float(display.dpi)
    for name, plane in picture.layers.items():
        kind = np.uint32 if plane.dtype.kind == "u" else np.float32
        channels[name] = np.ascontiguousarray(plane, kind)
    try:
        with OpenEXR.File(header, channels) as file:
            file.write(str(path))
    except RuntimeError as error:
        # The library reports a full disk as a RuntimeError with the system's words at its end.
        reason = str(error).rstrip(".").rpartition(". ")[2]
        raise OSError(_errno_of(reason), reason) from error


def _errno_of(reason: str) -> int:
    codes = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EACCES, errno.EROFS)
    return next((code for code in codes if os.strerror(code) == reason), errno.EIO)


def read(path: Path) -> np.ndarray:
    """Read the channels R, G, B (or Y alone as grey); float32, shape (h, w, 3)."""
    channels, _ = read_layers(path)
    if "Y" in channels and "R" not in channels:
        return np.repeat(channels["Y"][..., None], 3, axis=2)
    missing = [c for c in "RGB" if c not in channels]
    if missing:
        raise ValueError(f"no channel {missing[0]}; it has {', '.join(sorted(channels))}")
    return np.stack([channels[c] for c in "RGB"], axis=-1)


def read_layers(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Read all channels of the first part, and the provenance.

    Returns
    -------
    channels : dict of str to ndarray, shape (h, w)
    attributes : dict of str to str
        The header's ``alight.<key>`` strings, by key.

    Raises
    ------
    OSError, ValueError
        If the file is missing or no OpenEXR.
    """
    _check_magic(path)
    import OpenEXR

    try:
        with _silence(), OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: channel.pixels for name, channel in file.channels().items()}
            header = dict(file.header())
    except (RuntimeError, ValueError) as error:
        raise ValueError(f"broken OpenEXR file ({error})") from error
    prefix = "alight."
    named = {k[len(prefix) :]: v for k, v in header.items() if k.startswith(prefix)}
    return channels, named


def read_header(path: str | Path) -> dict[str, Any]:
    """The header of the first part, read without the pixels.

    Raises
    ------
    OSError, ValueError
        If the file is missing or no OpenEXR.
    """
    _check_magic(path)
    import OpenEXR

    try:
        with _silence(), OpenEXR.File(str(path), header_only=True) as file:
            return dict(file.header())
    except (RuntimeError, ValueError) as error:
        raise ValueError(f"broken OpenEXR file ({error})") from error


class Window(NamedTuple):
    """A window of pixels: its upper left corner (x, y) and its size (width, height)."""

    low: tuple[int, int]
    size: tuple[int, int]


def read_windows(path: str | Path) -> tuple[Window, Window, int]:
    """Data window, display window and number of channels of the first part, without the pixels."""
    header = read_header(path)
    try:
        data, display = (_window(header[name]) for name in ("dataWindow", "displayWindow"))
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"broken OpenEXR file ({error})") from error
    return data, display, len(header["channels"])


def _window(corners: Any) -> Window:
    low, high = corners
    left, top, right, bottom = (int(c[i]) for c in (low, high) for i in (0, 1))
    return Window((left, top), (right - left + 1, bottom - top + 1))


def read_size(path: str | Path) -> tuple[int, int, int]:
    """Width, height and number of channels of the first part, read without the pixels."""
    data, _, channels = read_windows(path)
    return *data.size, channels


@contextmanager
def _silence() -> Iterator[None]:
    """Hide what the library prints about broken files: the user gets one message.

    Its C++ writes to stderr, its Python layer prints to stdout, where results may be read by
    programs.
    """
    with Path(os.devnull).open("wb") as nowhere, redirect_stdout(io.StringIO()):
        kept = os.dup(2)
        try:
            os.dup2(nowhere.fileno(), 2)
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)


def _check_magic(path: str | Path) -> None:
    with Path(path).open("rb") as file:
        if file.read(4) != _MAGIC:
            raise ValueError("not an OpenEXR file")
