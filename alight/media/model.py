"""What the renderer takes from the file of a medium."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.registry import Kernel, Record, Records


@dataclass(frozen=True, eq=False, kw_only=True)
class MediumModel(Record):
    """A medium: `alight.media.coefficients.Coefficients` times a density that may vary.

    Attributes
    ----------
    pack : (spec, packer) -> None
        What its kernels read beyond the coefficients; see `alight.compiled.media.MediumPacker`.
    fly : kernel ``(scene, segment, u, active) -> Flight``
        Where paths are scattered; see `alight.media.tables`.
    cross : kernel ``(scene, segment, active) -> Crossing``
        How much light comes through on the way of a shadow ray.
    density_at : (spec, (n, 3) float64) -> (n,) float64
        Factor of the coefficients at points of the world, metres.
    """

    pack: Callable[[Any, Any], None]
    fly: Kernel
    cross: Kernel
    density_at: Callable[[Any, np.ndarray], np.ndarray]


#: All media, by name.
MEDIA = Records("media", MediumModel)
