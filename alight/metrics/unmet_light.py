r"""relMSE of light that no sample has met yet, as far as the picture itself speaks of such light.

A pixel that no bright sample has reached is dark in all of its replicates, and they agree: no
product of their errors tells. But if its events are expected K times, a picture without any of them
has the probability :math:`e^{-K}`. Events of all such pixels together that were not met have to be
expected less than

.. math:: L = -\log 0.025 = 3.7

times, with a confidence of 97.5 %. That holds for events of any size, and the picture's own pixels
tell how large they can be: a pixel's light m with the squared error SE^2 came in about m^2 / SE^2
events, of size n SE if it was one. Where a pixel expects more than L events, not even a single
pixel like it would have been overlooked, so only pixels of fewer events count; light below epsilon
does not matter. With the largest size c, the light x_p that pixels p of n_p samples miss has a sum
:math:`\sum n_p x_p` of at most L c, and adds at most

.. math:: \max \sum_p \frac{x_p^2}{(m_p + x_p)^2 + \epsilon}

to the sum of relative squared errors; :math:`m_p + x_p` is then the true brightness. The term per
missing light is largest at :math:`x_p^2 = m_p^2 + \epsilon`, so the darkest pixels are filled that
far, one after the other. The more pixels a picture has, the less a few of them matter.
"""

from __future__ import annotations

import math

import numpy as np

from alight.metrics.planes import over_replicates
from alight.metrics.survey import Survey

#: Events that are expected this often are all missed with a probability of 2.5 %.
EVENTS = -math.log(0.025)

#: Above this number of pixels one of four rows is enough.
_LARGE = 2**16


def unmet_light(seen: Survey, epsilon: float) -> float:
    """Bound the relMSE of light that no sample has met, with a confidence of 97.5 %.

    Parameters
    ----------
    seen : Survey
    epsilon : float
        > 0.

    Returns
    -------
    float
        0 where no pixel owes its light to so few events.
    """
    step = 4 if seen.known.size > _LARGE and seen.known[::4].any() else 1
    known = seen.known[::step]
    share = float(known.sum()) / max(float(seen.known.sum()), 1.0)
    counts = seen.counts[::step] if len(seen.counts) > 1 else seen.counts
    # Where all pixels are known, planes need no copies.
    some = (lambda plane, mask: plane.ravel()) if seen.known.all() else (lambda p, mask: p[mask])
    n = some(np.broadcast_to(over_replicates(counts, np.add), known.shape), known)
    n = n.astype(np.float32)
    samples = some(
        np.broadcast_to(over_replicates(seen.counts, np.add), seen.known.shape), seen.known
    )
    total = 0.0
    for c in range(3):
        picture, variance = some(seen.picture[c], seen.known), some(seen.variance[c], seen.known)
        few = np.flatnonzero(
            variance * np.float32(EVENTS) > picture * picture + np.float32(epsilon)
        )
        if few.size:
            # One event alone makes the error c / n, and K of them its root of K times.
            size = (samples.take(few) * np.sqrt(variance.take(few))).max()
            budget = EVENTS * float(size) * share
            lit = np.maximum(some(seen.picture[c, ::step], known), 0.0)
            total += _filled(lit, n, epsilon, budget)
    return total / (3.0 * max(int(known.sum()), 1))


def _filled(m: np.ndarray, n: np.ndarray, epsilon: float, budget: float) -> float:
    """Largest sum of x^2 / ((m + x)^2 + epsilon) with sum of n x within the budget."""
    root = np.sqrt(m * m + np.float32(epsilon))
    price, cost = n * (m + root), n * root
    # More pixels than this the budget cannot pay.
    most = int(budget / float(cost.min())) + 1
    order = np.argpartition(price, most)[:most] if most < len(price) else np.arange(len(price))
    order = order[np.argsort(price[order])]
    spent = np.cumsum(cost[order], dtype=np.float64)
    gain = 0.5 * root[order] / (m[order] + root[order])
    share = np.clip((budget - (spent - cost[order])) / cost[order], 0.0, 1.0)
    return float((gain * share).sum(dtype=np.float64))
