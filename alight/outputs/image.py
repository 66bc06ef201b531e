"""Writing and reading pictures; the suffix chooses the format."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from alight.core.arguments import expect_path, known_words
from alight.core.errors import OutputError, unknown_name
from alight.outputs import exr, hdr, jpeg, npy, pfm, png
from alight.outputs.atomic import check_folder, replacing
from alight.outputs.display import Display
from alight.outputs.picture import Picture, as_picture

#: The channel of the part of alpha that is shadow.
SHADOW = "shadow.A"

#: The formats. Each module has SUFFIXES, IS_DISPLAY (tone mapped, not linear),
#: KEEPS_LAYERS, KEEPS_ALPHA, KEEPS_DPI, `write` and `read`.
FORMATS: tuple[ModuleType, ...] = (exr, png, jpeg, npy, hdr, pfm)


def format_of(path: str | os.PathLike[str]) -> ModuleType:
    """Find the module that writes files of this suffix.

    Raises
    ------
    OutputError
        For an unknown suffix, with the nearest known one.
    """
    suffix = Path(expect_path(path)).suffix.lower()
    by_suffix = {s: module for module in FORMATS for s in module.SUFFIXES}
    if suffix not in by_suffix:
        problem = unknown_name("suffix", suffix, by_suffix) if suffix else "the name has no suffix"
        listed = "" if suffix else f"  (valid: {', '.join(sorted(by_suffix))})"
        raise OutputError(f"cannot write {os.fspath(path)}: {problem}{listed}")
    return by_suffix[suffix]


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse a target before any time is spent on the picture for it.

    Raises
    ------
    OutputError
        For an unknown suffix, a folder that is missing or closed, a write-protected file.
    """
    format_of(path)
    check_folder(path)


@known_words()
def write_image(
    path: str | os.PathLike[str],
    source: Any,
    *,
    exposure: float | str = 0.0,
    tone_map: str = "none",
    bits: int = 8,
    white_balance: str = "none",
    dpi: float | None = None,
) -> Path:
    """Write a film or an array, whole or not at all.

    Parameters
    ----------
    path : path
        ``.exr`` (with layers and provenance), ``.png``, ``.jpg``, ``.npy``, ``.hdr`` or ``.pfm``.
    source : film, Picture, or array of shape (h, w) or (h, w, 3)
        Linear sRGB.
    exposure, tone_map, bits, white_balance, dpi
        For display formats only: see `alight.outputs.display.Display`.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    OutputError
        If it cannot be written; a file that was there before is then untouched.
    OptionError
        For an unknown tone map or white balance, or an exposure or bits out of range.
    """
    display = Display(exposure, tone_map, bits, white_balance, dpi)
    module = format_of(path)
    picture = as_picture(source, layers=module.KEEPS_LAYERS)
    with replacing(path) as beside:
        module.write(beside, picture, display.developed(picture.straight))
    return Path(path)


def read_image(path: str | os.PathLike[str]) -> np.ndarray:
    """Read a picture as linear sRGB.

    Of OpenEXR files it gives the pixels that are there, the data window: a crop stays a crop.

    Returns
    -------
    ndarray of float32, shape (h, w, 3)

    Raises
    ------
    OutputError
        If the file is missing, broken or of an unknown format.
    """
    suffix = Path(expect_path(path)).suffix.lower()
    for module in FORMATS:
        if suffix in module.SUFFIXES:
            break
    else:
        valid = [s for module in FORMATS for s in module.SUFFIXES]
        raise OutputError(f"cannot read {os.fspath(path)}: {unknown_name('suffix', suffix, valid)}")
    try:
        image = module.read(Path(path))
    except OutputError:
        raise
    except FileNotFoundError as error:
        raise OutputError(f"cannot read {os.fspath(path)}: there is no such file") from error
    except (OSError, ValueError, EOFError) as error:
        raise OutputError(f"cannot read {os.fspath(path)}: {error}") from error
    return np.ascontiguousarray(image, np.float32)


def read_picture(path: str | os.PathLike[str]) -> Picture:
    """Read a picture with its alpha, which EXR files may hold as channel ``A``.

    Raises
    ------
    OutputError
        If the file is missing, broken or of an unknown format.
    """
    image = read_image(path)
    layers = exr.read_layers(path)[0] if format_of(path) is exr else {}
    alpha, shadow = layers.get("A"), layers.get(SHADOW)
    if alpha is None:
        return Picture(image)
    if shadow is None:
        return Picture(image, alpha=np.float32(alpha))
    covered = np.maximum(alpha - shadow, np.float32(0.0))
    return Picture(image, alpha=covered, shadow=np.float32(shadow))
