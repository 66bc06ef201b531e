"""The noise as a picture: where it is, and where the largest parts of it are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from alight.lab.panels import encoded, heat, sheet_of
from alight.lab.why.shares import Part, Shares
from alight.outputs.atomic import replacing


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
    panels = [(encoded(shares.picture / white), "picture")]
    panels.append((heat(shares.variance, scale), "standard deviation, relative"))
    panels += [(heat(shares.map_of(part), scale), str(part)) for part in parts]
    return sheet_of(panels)
