r"""The largest value that a sample of a scene can have, where that follows from its description.

Let Le be the largest radiance that any light emits, W the largest weight f cos / pdf of a sampled
direction, and b_d the largest throughput after d scatterings: b_0 is the weight of the pixel
filter, b_d = W b_{d-1}, and from the first roulette on b_d = max(1, W b_{d-1} / 0.95), because a
path survives with the smaller of its throughput and 0.95. Light that the path comes upon at depth d
has an MIS weight of 1 at most. Light that is sampled at the same place brings

.. math:: b_{d-1} L_e \frac{f \cos}{p_l} w_l \le b_{d-1} L_e\, W\, h, \qquad
    h = \max \frac{p_b}{p_l} w_l = \begin{cases} \tfrac12 & \text{power heuristic} \\
    1 & \text{balance heuristic} \end{cases}

whatever the lights' density p_l is, since :math:`f \cos \le W p_b`. Without MIS it would be
unbounded next to a light, and for a light at a point it is. So for paths of at most D edges

.. math:: c_{\max} = L_e \sum_{d=1}^{D} b_{d-1} + L_e\, W\, h \sum_{d=1}^{D-1} b_{d-1} .

Paths without a cap are cut for the bound where what is left has a mean below `_REST` of Le.

Source: Veach and Guibas, Optimally combining sampling techniques, SIGGRAPH 1995, for the weights.
"""

from __future__ import annotations

import math

from alight.integrators.options import PathTracing
from alight.integrators.roulette import MAX_SURVIVAL

#: Mean light, over Le, beyond the depth at which the bound of an unlimited path ends.
_REST = 1e-4


def largest_of_paths(
    options: PathTracing, share: float, radiance: float, weight: float, start: float
) -> float | None:
    """The bound of the formula above; None where the sum does not end.

    Parameters
    ----------
    options : PathTracing
    share : float
        h, by the heuristic.
    radiance, weight, start : float
        Le, W and b_0.
    """
    depth = options.max_depth
    if depth is None:
        if not 0.0 < weight < 1.0:
            return None if weight else start * radiance
        depth = math.ceil(math.log(_REST * (1.0 - weight)) / math.log(weight))
    plays = options.russian_roulette == "throughput"
    total, throughput = 0.0, start
    for d in range(1, depth + 1):
        total += throughput * (1.0 + (weight * share if d < depth else 0.0))
        throughput *= weight
        if plays and d >= options.rr_depth:
            throughput = max(1.0, throughput / MAX_SURVIVAL)
        if not total * radiance < 1e30:
            return None
    return total * radiance
