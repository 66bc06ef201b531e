r"""What a guide gains: the noise of guided paths beside that which paths without it would have.

Both follow from the same guided paths. Vertex k of a path drew its direction with the density
:math:`p_k`, or a delta lobe with the probability :math:`p_k`; the BSDF alone would have had
:math:`b_k`. So without the guide the path is :math:`P_k = \prod_{j \le k} p_j / b_j` times as rare
as far as it goes, and what it brings from there weighs as much more; and its multiple importance
sampling has the weights of :math:`b_k`, not of :math:`p_k`. Roulette belongs to both: :math:`p_k`
is times the survival by what the guide expects, :math:`b_k` by what the path itself has left. With
:math:`c_k`, what the sample gathers by these weights after vertex k and before the next, the second
moment without the guide is

.. math:: \operatorname E_b[L^2] = \operatorname E_p\Bigl[
    \sum_k c_k \Bigl( P_k c_k + 2 \sum_{i<k} P_i c_i \Bigr) \Bigr], \qquad P_{-1} = 1 .

Of two contributions the later decides how rare both together are, and cancels one of its weights.
This finds what a comparison of two pictures would miss: the light that paths without a guide do
not meet in so few samples. It leaves out that evenly distributed samples help unguided paths more.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanewise.jit import kernel
from lanewise.simd import lanes, where

#: As of relMSE(0.01): added to squared means.
EPSILON = 0.01

#: What the same path would have without its guide. pdf: the BSDF's density of its last direction;
#: rarity: how many times as rare it would be, P; L: luminance that it gathers; square: the sample's
#: part of the second moment.
Unguided = namedtuple("Unguided", "pdf rarity L square")


@kernel
def begin_unguided():
    """Of paths that have found nothing yet."""
    return Unguided(pdf=lanes(0.0), rarity=lanes(1.0), L=lanes(0.0), square=lanes(0.0))


@kernel
def add_unguided(unguided, found, mask):
    """With more that paths find in the lanes of the mask.

    found: luminance, with the throughput of the guided path and the weights of one without a guide.
    """
    weighed = unguided.rarity * found
    square = unguided.square + found * (weighed + 2.0 * unguided.L)
    return Unguided(
        pdf=unguided.pdf,
        rarity=unguided.rarity,
        L=where(mask, unguided.L + weighed, unguided.L),
        square=where(mask, square, unguided.square),
    )


@dataclass
class Moments:
    """Sums over samples of each pixel, in luminance.

    Attributes
    ----------
    sums, squares, without : (h, w) float64
        Of values, of their squares, and of the latter without a guide.
    count : int
        Samples a pixel.
    """

    sums: NDArray[np.float64]
    squares: NDArray[np.float64]
    without: NDArray[np.float64]
    count: int = 0

    def fewer_samples(self, means: NDArray[np.float64]) -> float:
        """How many samples without the guide one with it is worth, in relMSE(0.01).

        Parameters
        ----------
        means : (h, w) float64
            Luminance around each pixel, without much noise.
        """
        weight = 1.0 / (means**2 + EPSILON)
        square = (self.sums / self.count) ** 2
        guided = float((weight * (self.squares / self.count - square)).sum())
        alone = float((weight * (self.without / self.count - square)).sum())
        return alone / guided if guided > 0.0 else 1.0

    def noise_without(self, means: NDArray[np.float64]) -> float:
        """Variance of a sample without the guide, in relMSE(0.01), the mean over all pixels."""
        variance = self.without / self.count - (self.sums / self.count) ** 2
        return float((variance / (means**2 + EPSILON)).mean())
