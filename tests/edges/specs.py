"""Descriptions at the edges of what they may hold: every field at both ends of its range."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from alight.core.errors import SceneError
from alight.core.fields import LARGEST, Interval, NumberOrTexture, Numbers
from alight.core.spec import Spec
from alight.textures.checkerboard import Checkerboard

#: What stands for an end that is not given: descriptions take no larger number.
FAR = LARGEST
#: Distance from a bound that is excluded, relative to 1.
INSIDE = 1e-6


def ends_of(interval: Interval) -> tuple[float, ...]:
    """The ends of a range that a number may take."""
    low = interval.low if math.isfinite(interval.low) else -FAR
    high = interval.high if math.isfinite(interval.high) else FAR
    if interval.open_ends:
        low += INSIDE if math.isfinite(interval.low) else 0.0
        high -= INSIDE * abs(high) if math.isfinite(interval.high) else 0.0
    return (int(low), int(high)) if interval.integer else (low, high)


def values_of(spec: type[Spec], name: str) -> Iterator[Any]:
    """Both ends of a field, and a texture that has both; nothing where it holds no numbers."""
    for marker in spec.model_fields[name].metadata:
        textured = bool(getattr(marker, "other", ()))
        if isinstance(marker, Interval):
            yield from ends_of(marker)
        elif isinstance(marker, NumberOrTexture):
            yield from ends_of(marker.interval)
            yield from (_both_ends(marker.interval),) if textured else ()
        elif isinstance(marker, Numbers):
            for end in ends_of(marker.interval):
                yield (end,) * marker.count
            yield from (_both_ends(marker.interval),) if textured else ()


def _both_ends(interval: Interval) -> Checkerboard:
    low, high = (min(max(end, 0.0), 1.0) for end in ends_of(interval))
    return Checkerboard(color0=low, color1=high)


def at_the_edges(spec: Spec) -> list[Spec]:
    """The description with each field at each end, and with all fields at the same end."""
    fields = {name: list(values_of(type(spec), name)) for name in type(spec).model_fields}
    fields = {name: values for name, values in fields.items() if values}
    found = [changed(spec, {name: value}) for name, values in fields.items() for value in values]
    for end in range(max(map(len, fields.values()), default=0)):
        everywhere = spec
        for name, values in fields.items():
            everywhere = changed(everywhere, {name: values[min(end, len(values) - 1)]})
        found.append(everywhere)
    return [spec, *found]


def changed(spec: Spec, changes: dict[str, Any]) -> Spec:
    """The description with some fields changed; as it was where they do not go together."""
    try:
        return spec.replaced(**changes)
    except SceneError:
        return spec
