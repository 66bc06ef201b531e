"""What lights at a point share: the way to them, and how their light falls off."""

from __future__ import annotations

from alight.core.vec import Vec3, length_squared
from lanewise.jit import kernel
from lanewise.simd import lanes, maximum, sqrt, where

#: Square of the distance, in m^2, below which one is at the light itself. The strongest light that
#: a description may hold, 1e15 W/sr, is a float32 from there on.
NEAREST = 1e-22


@kernel
def way_to(to_light):
    """(wi, distance, 1 / distance^2) along a vector to a light at a point.

    At the light itself there is no direction: wi is any, and no light arrives.
    """
    found = length_squared(to_light)
    apart = found > NEAREST
    squared = maximum(found, NEAREST)
    distance = sqrt(squared)
    wi = where(apart, to_light * (1.0 / distance), Vec3(lanes(0.0), lanes(0.0), lanes(1.0)))
    return wi, distance, where(apart, 1.0 / squared, 0.0)
