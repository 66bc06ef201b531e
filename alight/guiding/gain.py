r"""What a guide gains: the noise of guided paths beside that which paths without it would have.

Both follow from the records of the same guided paths. Vertex k of a path drew its direction with
the density :math:`p_k`; the BSDF alone would have had :math:`b_k`. So without the guide the path is
:math:`P_k = \prod_{j \le k} p_j / b_j` times as rare as far as it goes, and what it brings from
there weighs as much more; and its multiple importance sampling has the weights of :math:`b_k`, not
of :math:`p_k`. With :math:`T_k`, what the sample gathers by these weights after vertex k, and
:math:`L`, all that it gathers, the second moment without the guide is

.. math:: \operatorname E_b[L^2] = \operatorname E_p\Bigl[
    L^2 + \sum_k T_k^2\, (P_k - P_{k-1}) \Bigr], \qquad P_{-1} = 1 .

This finds what a comparison of two pictures would miss: the light that paths without a guide do
not meet in so few samples. It leaves out that evenly distributed samples help unguided paths more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from alight.guiding.tables import Log

#: As of relMSE(0.01): added to squared means.
EPSILON = 0.01


def moments_without(log: Log) -> NDArray[np.float64]:
    """Each sample's part of the second moment without the guide.

    Parameters
    ----------
    log : Log
        Of finished samples; the vertices of a sample are in their order.

    Returns
    -------
    ndarray of float64, shape (samples,)
    """
    ends = log.unguided.array.astype(np.float64)
    rows, moments = log.rows.shaped, ends**2
    if not len(rows):
        return moments
    number = rows[:, 11].copy().view(np.uint32).astype(np.int64)
    order = np.argsort(number, kind="stable")
    rows, number = rows[order].astype(np.float64), number[order]
    pdf, of_bsdf, before = rows[:, 6], rows[:, 7], rows[:, 12]
    # What a BSDF never draws is light that it does not scatter.
    ratio = np.log(np.where(of_bsdf > 0.0, pdf / np.where(of_bsdf > 0.0, of_bsdf, 1.0), 1.0))
    first = np.diff(number, prepend=-1) != 0
    earlier = np.cumsum(ratio) - ratio
    earlier -= earlier[first][np.cumsum(first) - 1]
    with np.errstate(all="ignore"):
        more = (ends[number] - before) ** 2 * np.exp(earlier) * np.expm1(ratio)
    np.add.at(moments, number, np.where(np.isfinite(more), more, 0.0))
    return moments


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
