"""A law of shapes: rays need not have directions of length 1."""

from __future__ import annotations

import numpy as np

from alight.laws.bodies import Body, margin_of, placed_everywhere, rows_of
from alight.laws.report import demand, demand_close

#: Lines that are tried.
_LINES = 2000


@placed_everywhere
def distances_are_in_lengths_of_the_direction(body: Body) -> None:
    """A longer direction meets the same point at a smaller t, as instances need it."""
    o, d = (v[:, :_LINES] for v in body.lines(9))
    everywhere = np.ones(_LINES, bool)
    hit, surface = body.hit(o, d, everywhere)
    facing = np.abs(np.sum(rows_of(surface.ng, _LINES) * d, axis=0))
    for length in (0.125, 3.0):
        other, _ = body.hit(o, (length * d).astype(np.float32), everywhere)
        both = np.isfinite(hit.t) & np.isfinite(other.t)
        demand((both == np.isfinite(hit.t)).mean() > 0.99, f"{length:g} d misses what d meets")
        # At an edge the one may pass what the other meets.
        both &= (hit.shape == other.shape) & (hit.prim == other.prim)
        near, far = (np.where(both, t, 0.0) for t in (length * other.t, hit.t))
        off = np.abs(near - far) * facing
        demand_close(
            off, 0.0, f"metres between hits of {length:g} d", atol=2.0 * margin_of(body, o)
        )
