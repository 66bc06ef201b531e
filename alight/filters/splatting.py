r"""The pixel to which a point of the film belongs: one of those whose filters see it.

.. math::
    P(i) = \frac{|g(x - c_i)|}{\sum_k |g(x - c_k)|}, \qquad
    w = \operatorname{sign} g(x - c_i) \sum_k |g(x - c_k)|

Pixel i, with the centre :math:`c_i`, gets g(x - c_i) in the mean, which is what the filter gives
it, and no other pixel is touched: the counterpart of filter importance sampling for paths that find
their place on the film by themselves. Both axes are drawn alike.

Source: Ernst, Stamminger and Greiner 2006 (see `alight.filters.importance`), turned around.
"""

from __future__ import annotations

from alight.filters.model import FILTERS
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    absolute,
    as_float,
    as_int,
    floor,
    lanes,
    lanes_mask,
    where,
)


@specialised
def choose_pixel(program):
    """``choose_pixel(scene, x, u) -> (pixel, weight)`` along one axis; pixels are whole floats."""
    profile, reach = FILTERS[program.filter].profile, FILTERS[program.filter].reach
    assert profile is not None and reach is not None

    @kernel
    def choose_pixel(scene, x, u):
        table = scene.filter
        radius = reach(table)
        count = as_int(2.0 * radius) + 2
        first = floor(x - radius + 0.5)
        # The first candidate may lie beyond the radius by rounding, the last one always does.
        total = lanes(0.0)
        for i in range(count):
            total = total + absolute(profile(table, x - (first + as_float(i) + 0.5)))
        goal, before = u * total, lanes(0.0)
        pixel, weight, found = first, lanes(0.0), lanes_mask(False)
        for i in range(count):
            g = profile(table, x - (first + as_float(i) + 0.5))
            here = ~found & (absolute(g) > 0.0)
            pixel = where(here, first + as_float(i), pixel)
            weight = where(here, where(g < 0.0, -total, total), weight)
            before = before + absolute(g)
            found = found | (here & (before > goal))
        return pixel, weight

    return choose_pixel
