"""What a guide knows at a point, as disks of directions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from alight.lab.panels import encoded, heat, sheet_of
from alight.outputs.atomic import replacing

if TYPE_CHECKING:
    from alight.lab.guide.sides import Side

#: Percentiles of arriving light that is white, and of densities that are brightest.
_WHITE, _BRIGHTEST = 99.0, 99.5
#: Colour outside the disks.
_PAPER = 255.0


def write_disks(path: Path, sides: Sequence[Side]) -> Path:
    """Write the disks as PNG, whole or not at all.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as beside:
        draw_disks(sides).save(beside, format="PNG")
    return path


def draw_disks(sides: Sequence[Side]) -> Any:
    """Draw light, lobe and densities of each side of the surface, as a picture of Pillow.

    All densities have one scale, that of the ideal one; brightness is the root of the density.
    """
    white = max(max(float(np.percentile(side.light, _WHITE)) for side in sides), 1e-30)
    scale = max(max(float(np.percentile(side.ideal, _BRIGHTEST)) for side in sides), 1e-30)
    panels = []
    for side in sides:
        # Only a surface that transmits has another side.
        where = f" ({side.name})" if len(sides) > 1 else ""
        panels.append((_coloured(side, side.light / white), f"arriving light{where}"))
        for values, caption in (
            (side.ideal, "ideal density: f cos times light"),
            (side.of_bsdf, "the BSDF's density"),
            (side.of_guide, "the guide's density"),
            (side.of_mixture, "density of the mixture"),
        ):
            shown = heat(values / scale, 1.0)
            panels.append((side.disk.picture(shown, _PAPER), caption + where))
        weight = heat(side.weight / 4.0, 1.0)
        panels.append((side.disk.picture(weight, _PAPER), "ideal density over mixture's, to 4"))
    return sheet_of(panels)


def _coloured(side: Side, light: np.ndarray) -> np.ndarray:
    return side.disk.picture(encoded(light), _PAPER)
