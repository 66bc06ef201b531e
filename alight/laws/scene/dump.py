"""Pictures of what failed: both sides, and where they differ."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from alight.laws.scene.findings import Verdict
from alight.outputs.image import write_image

#: Pixels of the longer side of a picture, at least; |z| that is shown in full colour.
_SIDE, _FULL = 384, 6.0


def write_failures(verdict: Verdict, folder: Path) -> list[Path]:
    """Write the pictures of all findings that do not hold, as PNG.

    Parameters
    ----------
    verdict : Verdict
    folder : Path
        Made if there is something to write. Files that were there before are replaced.

    Returns
    -------
    list of Path
        A picture for each finding that has some: its sides from left to right at the same exposure,
        then the map of z, blue where the first side is darker, red where it is brighter.

    Raises
    ------
    OutputError
        If one cannot be written.
    """
    written = []
    shown: set[int] = set()
    for finding in verdict.failures:
        sides = [v for v in finding.pictures.values() if v.ndim == 3]
        # Two tests of the same pictures share them.
        if not sides or id(finding.pictures) in shown:
            continue
        shown.add(id(finding.pictures))
        folder.mkdir(parents=True, exist_ok=True)
        white = max(float(np.percentile(side, 98)) for side in sides) or 1.0
        panels = [enlarged(side / white) for side in sides]
        if "z" in finding.pictures:
            panels.append(enlarged(colored(finding.pictures["z"]), panels[0].shape[1]))
        else:
            panels.append(enlarged((sides[0] != sides[1]).any(axis=-1)[..., None] * np.ones(3)))
        height = min(len(panel) for panel in panels)
        gap = np.ones((height, 4, 3))
        row = [part for panel in panels for part in (panel[:height], gap)][:-1]
        name = re.sub(r"[^a-z0-9]+", "-", f"{finding.part} {finding.law}".lower()).strip("-")
        written.append(write_image(folder / f"{name}.png", np.concatenate(row, axis=1)))
    return written


def enlarged(picture: np.ndarray, width: int = _SIDE) -> np.ndarray:
    """Repeat pixels until the picture is about so wide."""
    times = max(1, round(width / picture.shape[1]))
    return np.asarray(picture, np.float32).repeat(times, axis=0).repeat(times, axis=1)


def colored(z: np.ndarray) -> np.ndarray:
    """White for 0, blue for negative and red for positive values, grey where there is none."""
    known = np.nan_to_num(np.clip(z / _FULL, -1.0, 1.0))
    up, down = np.maximum(known, 0.0), np.maximum(-known, 0.0)
    color = np.stack([1.0 - down, 1.0 - up - down, 1.0 - up], axis=-1)
    return np.where(np.isnan(z)[..., None], 0.2, color)
