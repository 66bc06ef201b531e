"""A value that was measured, with its interval."""

from __future__ import annotations

import math
from typing import NamedTuple


class Estimate(NamedTuple):
    """A value with its 95 % interval; NaN means unknown."""

    value: float
    low: float
    high: float

    def to_dict(self) -> dict[str, float | None]:
        """For JSON: what is not finite is None."""
        return {name: x if math.isfinite(x) else None for name, x in self._asdict().items()}
