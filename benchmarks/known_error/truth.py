r"""What a scene really looks like: a picture from many samples, and whether it is sure of itself.

relMSE divides by the brightness squared, so noise in the truth is harmless in a numerator, where
its variance is known and subtracted, but not in a denominator: a pixel that a tiny lamp grazes once
in a thousand samples is bright in one truth and black in the next. No comparison by the same
denominators can tell. So the truth is made of two independent halves, and each half's own variance,
which is large in just these pixels, is weighed by both halves' brightness:

.. math:: \frac{\sum_p V_a / (T_b^2 + \epsilon) + V_b / (T_a^2 + \epsilon)}
                {\sum_p V_a / (T_a^2 + \epsilon) + V_b / (T_b^2 + \epsilon)} - 1

is the *doubt*. Where k samples carry a pixel of a half it is 2 / k; where none of one half met what
the other has seen, it is as large as the denominators are wrong.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

#: Independent films that a truth is made of.
FILMS = 16

#: Largest doubt about the denominators. The whole truth has twice the samples of a half, and the
#: second-order part of what is left is taken out (see `Truth.weight`): 1 % of relMSE remains.
SURE = 0.1


class Source(Protocol):
    """What gives sums of samples, as `scenes.Runner` does."""

    def sums(self, seed: int, first: int, count: int) -> np.ndarray:
        """Sums by replicate, shape (h, w, R, 3), of samples first to first + count - 1."""
        ...


class Truth:
    """A scene's picture from many samples, with the variance of its own noise.

    Parameters
    ----------
    source : Source
    spp : int
        Samples per pixel, in 16 independent films.
    most : int, optional
        While the denominators are in doubt the samples are doubled, up to this number; by default
        they stay as many.
    seed : int
        Of the first film.

    Attributes
    ----------
    spp : int
        Samples per pixel in the end.
    mean, variance : ndarray, shape (h, w, 3)
        The picture, and its squared standard error.
    weight : ndarray, shape (h, w, 3)
        1 / (mean^2 + epsilon), the second-order bias that the noise of the mean brings taken out.
    noise : float
        relMSE of the truth itself.
    doubt : float
        About the denominators, as the head of this file says.
    """

    def __init__(
        self, source: Source, spp: int, most: int | None = None, seed: int = 10**6
    ) -> None:
        self.spp = 0
        films, more = np.zeros(()), spp // FILMS
        while True:
            held = self.spp // FILMS
            new = [source.sums(seed + i, held, more).sum(axis=2) for i in range(FILMS)]
            films = (films * held + np.stack(new)) / (held + more)
            self.spp += FILMS * more
            self._settle(films)
            if self.sure or 2 * self.spp > (most or spp):
                return
            more = self.spp // FILMS

    def _settle(self, films: np.ndarray) -> None:
        """Work out everything from the films' means, shape (16, h, w, 3)."""
        self.mean, self.variance = _mean_and_variance(films)
        epsilon = (0.1 * self.mean.mean()) ** 2
        square = self.mean**2
        plain = 1.0 / (square + epsilon)
        # f'' / 2 of f = 1 / (x^2 + epsilon) is (4 x^2 f - 1) f^2.
        bias = (4.0 * square * plain - 1.0) * self.variance * plain
        self.weight = plain / np.maximum(1.0 + bias, 0.5)
        self.noise = float((self.variance * self.weight).mean())
        halves = [_mean_and_variance(films[part::2]) for part in range(2)]
        (_, va), (_, vb) = halves
        by_a, by_b = (1.0 / (mean**2 + epsilon) for mean, _ in halves)
        own, crossed = (va * by_a + vb * by_b).sum(), (va * by_b + vb * by_a).sum()
        self.doubt = abs(float(crossed / own) - 1.0) if own > 0.0 else 0.0

    @property
    def sure(self) -> bool:
        """Whether the denominators are known well enough to compare with."""
        return self.doubt <= SURE

    def relmse(self, picture: np.ndarray) -> float:
        """relMSE of a picture, the truth's own variance subtracted."""
        return float((((picture - self.mean) ** 2 - self.variance) * self.weight).mean())

    def relrmse(self, picture: np.ndarray) -> float:
        """Square root of `relmse`."""
        return max(self.relmse(picture), 0.0) ** 0.5


def _mean_and_variance(films: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return films.mean(axis=0), films.var(axis=0, ddof=1) / len(films)
