"""Tables of scenes in motion as paths see them: each at a time of its own."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

#: Tables of a scene in which something moves (`alight.compiled.scene`), seen at the times of the
#: lanes; the same with media.
AtTimes = namedtuple("AtTimes", "shapes materials lights accel camera filter motions time")
AtTimesInMedia = namedtuple(
    "AtTimesInMedia", "shapes materials lights accel camera filter media motions time"
)


def tables_at(tables: Any, times: np.ndarray) -> Any:
    """What kernels are given of a scene in motion, seen at these times: for the NumPy twin.

    Parameters
    ----------
    tables : MovingScene or MovingWithMedia
        `alight.compiled.scene.CompiledScene.tables`.
    times : (n,) float32
        From 0 (the shutter opens) to 1.
    """
    fields = tables._asdict()
    fields["time"] = times
    return (AtTimesInMedia if "media" in fields else AtTimes)(**fields)
