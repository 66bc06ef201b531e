"""What the renderer takes from the file of a pixel filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.registry import Kernel, Record, Records


@dataclass(frozen=True, eq=False, kw_only=True)
class FilterModel(Record):
    """A pixel filter.

    Attributes
    ----------
    pack : (spec) -> (n,) float
        Table of its kernel.
    sample : kernel ``(table, u2) -> (dx, dy, weight)``
        Offset from the pixel's centre, pixels; weights have the mean 1.
    profile : kernel ``(table, x)``
        Of a filter f(x, y) = g(x) g(y): g, with the integral 1, pixels. Without it no light path
        is splatted.
    reach : kernel ``(table)``
        g is 0 beyond, pixels; uniform.
    value : (spec, float64, float64) -> float64
        The filter itself at offsets from the centre, pixels, up to a factor.
    """

    pack: Callable[[Any], Sequence[float]]
    sample: Kernel
    value: Callable[[Any, np.ndarray, np.ndarray], np.ndarray]
    profile: Kernel | None = None
    reach: Kernel | None = None


#: All filters, by name.
FILTERS = Records("filters", FilterModel)
