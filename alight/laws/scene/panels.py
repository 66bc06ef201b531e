"""Both sides of a law that does not hold as one picture, and where they differ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

#: Pixels of the longer side of a picture, at least; |z| that is shown in full colour.
_SIDE, _FULL = 384, 6.0


def side_by_side(pictures: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """Put the pictures of a finding into a row.

    Parameters
    ----------
    pictures : mapping of str to ndarray
        Linear sides (h, w, 3), and perhaps ``z`` (h, w).

    Returns
    -------
    ndarray, shape (h, w, 3), or None
        The sides from left to right at the same exposure, then the map of z, blue where the first
        side is darker, red where it is brighter, or of the pixels that differ.
    """
    sides = [v for v in pictures.values() if v.ndim == 3]
    if not sides:
        return None
    white = max(float(np.percentile(side, 98)) for side in sides) or 1.0
    panels = [enlarged(side / white) for side in sides]
    if "z" in pictures:
        panels.append(enlarged(colored(pictures["z"]), panels[0].shape[1]))
    else:
        panels.append(enlarged((sides[0] != sides[1]).any(axis=-1)[..., None] * np.ones(3)))
    height = min(len(panel) for panel in panels)
    gap = np.ones((height, 4, 3))
    row = [part for panel in panels for part in (panel[:height], gap)][:-1]
    return np.concatenate(row, axis=1)


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
