"""The noise as a picture: where it is, and where the largest parts of it are."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import OptionError
from alight.core.srgb import encode_srgb
from alight.lab.why.shares import Part, Shares
from alight.outputs.atomic import check_folder, replacing

#: Pixels of a panel's width, of its caption's height, and between panels.
_WIDTH, _CAPTION, _GAP = 360, 44, 12
#: Colours of the maps from no variance to the most, as 8-bit sRGB; parts that lower it are blue.
_HEAT = np.array([[12, 10, 30], [90, 25, 110], [190, 55, 80], [245, 140, 40], [250, 245, 170]])
_COLD = np.array([90, 160, 250])


def write_maps(path: Path, shares: Shares, parts: Sequence[Part]) -> Path:
    """Write the picture, the map of its variance, and those of some parts side by side.

    Parameters
    ----------
    path : Path
        PNG file, written whole or not at all.
    shares : Shares
    parts : sequence of Part
        As `Shares.by` gives them.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as beside:
        draw_maps(shares, parts).save(beside, format="PNG")
    return path


def draw_maps(shares: Shares, parts: Sequence[Part]) -> Any:
    """Draw what `write_maps` writes, as a picture of Pillow."""
    # Standard deviations, to one scale for all maps: variances would show a few pixels only.
    scale = np.sqrt(max(float(np.percentile(np.abs(shares.variance), 99.5)), 1e-30))
    white = max(float(np.percentile(shares.picture, 98)), 1e-30)
    panels = [(_shown(shares.picture / white), "picture")]
    panels.append((heat(shares.variance, scale), "standard deviation, relative"))
    panels += [(heat(shares.map_of(part), scale), str(part)) for part in parts]
    return _sheet(panels)


def check_maps(path: Path) -> None:
    """Refuse a file for maps before any time is spent.

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


def heat(variance: np.ndarray, scale: float) -> np.ndarray:
    """Colours (h, w, 3) in [0, 255] of signed variances: roots, over `scale`."""
    level = np.clip(np.sqrt(np.abs(variance)) / scale, 0.0, 1.0)
    place = np.linspace(0.0, 1.0, len(_HEAT))
    warm = np.stack([np.interp(level, place, _HEAT[:, c]) for c in range(3)], axis=-1)
    cold = _HEAT[0] + level[..., None] * (_COLD - _HEAT[0])
    return np.where(variance[..., None] < 0.0, cold, warm)


def _shown(picture: np.ndarray) -> np.ndarray:
    return 255.0 * encode_srgb(np.clip(picture, 0.0, 1.0))


def _sheet(panels: Sequence[tuple[np.ndarray, str]]):
    """The panels in rows of three, each above its caption."""
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
