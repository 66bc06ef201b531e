"""Studies whose truth is known: pictures of noise in the place of rendered ones."""

import numpy as np

from alight.lab.figures import Figures
from alight.lab.statistics.block_means import BlockMoments, block_row, compare_with_reference
from alight.lab.statistics.decomposition import Moments, decompose, reference_spread
from alight.lab.statistics.intervals import bootstrap_ratio, log_mean, log_ratio

SIZE = 16
REFERENCE_SEEDS = 16


def _spikes(rng, shape):
    """1 % of the pixels are 10 standard deviations bright: fireflies."""
    p = 0.01
    return ((rng.random(shape) < p) - p) / np.sqrt(p * (1 - p))


#: Noise of mean 0 and variance 1, with channels of a pixel that share half of it.
NOISES = {
    "gaussian": lambda rng, shape: rng.standard_normal(shape),
    "uniform": lambda rng, shape: (rng.random(shape) - 0.5) * np.sqrt(12.0),
    "exponential": lambda rng, shape: rng.standard_exponential(shape) - 1.0,
    "log-normal": lambda rng, shape: (
        (rng.lognormal(0.0, 1.0, shape) - np.exp(0.5)) / np.sqrt((np.e - 1.0) * np.e)
    ),
    "spikes": _spikes,
}
LIGHT_TAILED = ("gaussian", "uniform")


def truth(rng, size=SIZE):
    """A picture to be found, with bright and dark parts."""
    return (0.2 + rng.random((size, size, 3)) ** 2).astype(np.float32)


def pictures(rng, noise, count, picture, sigma):
    """`count` noisy pictures; sigma is relative to the brightness."""
    shape = (count, *picture.shape[:2])
    shared = NOISES[noise](rng, shape)[..., None]
    own = NOISES[noise](rng, (*shape, 3))
    return (picture * (1.0 + sigma * (shared + own) / np.sqrt(2.0))).astype(np.float32)


class SyntheticArm:
    """Replicates of one arm, worked up as the runner does it."""

    def __init__(self, rng, noise, picture, sigma, figures, count=16, seconds=1.0):
        self.moments, rows, values = Moments(), [], []
        for one in pictures(rng, noise, count, picture, sigma):
            self.moments.add(one)
            rows.append(block_row(one))
            values.append(figures.of(one)["mse"])
        self.mse = np.array(values)
        # The time of a replicate varies by 3 %.
        self.seconds = seconds * np.exp(0.03 * rng.standard_normal(count) - 0.03**2 / 2)
        self.statistics = BlockMoments.calm(rows, picture.shape[1::-1]).statistics

    @property
    def cost(self):
        return log_mean(self.mse) + log_mean(self.seconds)


class SyntheticReference:
    """A reference that is the mean of noisy pictures, with their spread."""

    def __init__(self, rng, noise, picture, sigma):
        rows, moments = [], Moments()
        for one in pictures(rng, noise, REFERENCE_SEEDS, picture, sigma):
            rows.append(block_row(one))
            moments.add(one.astype(np.float64))
        self.image = moments.mean.astype(np.float32)
        self.variance = (moments.variance / REFERENCE_SEEDS).astype(np.float32)
        self.statistics = BlockMoments.of(rows, picture.shape[1::-1]).statistics
        self.figures = Figures(self.image, self.variance)


class SyntheticStudy:
    """Two arms and a reference; the second has `ratio` times the variance of the first."""

    def __init__(self, seed, noise="gaussian", ratio=1.0, bias=0.0, size=SIZE, count=16):
        rng = np.random.default_rng(seed)
        self.picture = truth(rng, size)
        # Its noise is 5 % of an arm's, as `references.WANTED_SHARE` asks for.
        reference_sigma = 0.3 * np.sqrt(0.05 * REFERENCE_SEEDS)
        self.reference = SyntheticReference(rng, noise, self.picture, reference_sigma)
        figures = self.reference.figures
        self.a = SyntheticArm(rng, noise, self.picture, 0.3, figures, count)
        biased = (self.picture * (1.0 + bias)).astype(np.float32)
        sigma = 0.3 * np.sqrt(ratio)
        self.b = SyntheticArm(rng, noise, biased, sigma, figures, count, seconds=2.0)

    def speedup(self):
        spread = reference_spread(self.reference.variance, REFERENCE_SEEDS)
        shared = spread * (1.0 / self.a.mse.mean() - 1.0 / self.b.mse.mean()) ** 2
        return log_ratio(self.a.cost, self.b.cost, extra_variance=shared)

    def bootstrap(self, seed):
        return bootstrap_ratio([self.a.mse, self.a.seconds], [self.b.mse, self.b.seconds], seed)

    def parts(self, arm):
        return decompose(arm.moments, self.reference.image, self.reference.variance)

    def bias_test(self, arm):
        return compare_with_reference(arm.statistics, self.reference.statistics)
