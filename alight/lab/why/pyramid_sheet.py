"""The pyramid as a picture: one row for each path length, one panel for each technique."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from alight.core.srgb import encode_srgb
from alight.integrators.strategies import DEEPEST, row_of
from alight.lab.why.pyramid import Pyramid
from alight.outputs.atomic import replacing

#: Pixels of a panel's longer side at least, of the line above it, and between panels.
_SIDE, _CAPTION, _GAP = 96, 16, 6


def write_pyramid(path: Path, pyramid: Pyramid) -> Path:
    """Write the sheet as PNG, whole or not at all.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as beside:
        draw_pyramid(pyramid).save(beside, format="PNG")
    return path


def draw_pyramid(pyramid: Pyramid) -> Any:
    """Weighted pictures on the left, unweighted ones on the right, as a picture of Pillow.

    A row is brightened until all light of its length together is white: the factor stands beside
    it.
    """
    from PIL import Image, ImageDraw, ImageFont

    lengths = [k for k in range(1, DEEPEST + 1) if pyramid.unweighted[_rows(k)].any()]
    height, width = pyramid.weighted.shape[1:3]
    times = max(1, round(_SIDE / max(height, width)))
    wide, high = width * times + _GAP, height * times + _CAPTION + _GAP
    half = (max(lengths, default=0) + 1) * wide + _GAP
    sheet = Image.new("RGB", (2 * half, max(len(lengths), 1) * high + _GAP), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(11)
    for y, k in enumerate(lengths):
        white = max(float(np.percentile(pyramid.weighted[_rows(k)].sum(axis=0), 98)), 1e-30)
        for s in range(k + 1):
            for pictures, left in ((pyramid.weighted, 0), (pyramid.unweighted, half)):
                corner = (left + _GAP + s * wide, _GAP + y * high)
                own = encode_srgb(np.clip(pictures[row_of(s, k)] / white, 0.0, 1.0))
                panel = Image.fromarray(np.rint(255.0 * own).astype(np.uint8))
                panel = panel.resize((width * times, height * times), Image.Resampling.NEAREST)
                sheet.paste(panel, (corner[0], corner[1] + _CAPTION))
                factor = f"  x {1.0 / white:.3g}" if s == 0 else ""
                draw.text(corner, f"({s}, {k + 1 - s}){factor}", fill="black", font=font)
    return sheet


def _rows(edges: int) -> slice:
    return slice(row_of(0, edges), row_of(edges, edges) + 1)
