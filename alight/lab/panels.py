"""Small pictures side by side, each above its caption."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import OptionError
from alight.core.srgb import encode_srgb
from alight.outputs.atomic import check_folder

#: Pixels of a panel's width, of its caption's height, and between panels.
_WIDTH, _CAPTION, _GAP = 360, 44, 12
#: Colours of maps from nothing to the most, as 8-bit sRGB; what is negative is blue.
_HEAT = np.array([[12, 10, 30], [90, 25, 110], [190, 55, 80], [245, 140, 40], [250, 245, 170]])
_COLD = np.array([90, 160, 250])


def check_sheet(path: Path) -> None:
    """Refuse a file for a sheet before any time is spent.

    Raises
    ------
    OptionError
        If it is no PNG file.
    OutputError
        If it cannot be written.
    """
    if path.suffix.lower() != ".png":
        raise OptionError(f"the maps are a .png file, got {path}", "output")
    check_folder(path)


def heat(squares: np.ndarray, scale: float) -> np.ndarray:
    """Colours (h, w, 3) in [0, 255] of signed squares: roots, over `scale`."""
    level = np.clip(np.sqrt(np.abs(squares)) / scale, 0.0, 1.0)
    place = np.linspace(0.0, 1.0, len(_HEAT))
    warm = np.stack([np.interp(level, place, _HEAT[:, c]) for c in range(3)], axis=-1)
    cold = _HEAT[0] + level[..., None] * (_COLD - _HEAT[0])
    return np.where(squares[..., None] < 0.0, cold, warm)


def encoded(picture: np.ndarray) -> np.ndarray:
    """Colours (h, w, 3) in [0, 255] of linear ones in [0, 1]."""
    return 255.0 * encode_srgb(np.clip(picture, 0.0, 1.0))


def sheet_of(panels: Sequence[tuple[np.ndarray, str]]) -> Any:
    """The panels and their captions in rows of three, as a picture of Pillow."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = panels[0][0].shape[:2]
    times = max(1, round(_WIDTH / width))
    width, height = max(width * times, _WIDTH // 2), height * times
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    size = (columns * (width + _GAP) + _GAP, rows * (height + _CAPTION + _GAP) + _GAP)
    sheet = Image.new("RGB", size, "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(13)
    for k, (panel, caption) in enumerate(panels):
        x = _GAP + k % columns * (width + _GAP)
        y = _GAP + k // columns * (height + _CAPTION + _GAP)
        image = Image.fromarray(np.rint(panel).astype(np.uint8))
        sheet.paste(
            image.resize((panel.shape[1] * times, height), Image.Resampling.NEAREST), (x, y)
        )
        text = "\n".join(textwrap.wrap(caption.replace("`", ""), width // 7)[:2])
        draw.text((x, y + height + 6), text, fill="black", font=font)
    return sheet
