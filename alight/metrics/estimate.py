"""A value that was measured, with its interval."""

from __future__ import annotations

from typing import NamedTuple


class Estimate(NamedTuple):
    """A value with its 95 % interval; NaN means unknown."""

    value: float
    low: float
    high: float
