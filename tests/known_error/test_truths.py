"""Laws of the truths that the campaigns compare with."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.known_error.truth import FILMS, Truth

#: Brightness of a sample that meets a lamp; the pixels beside have the brightness 1 and no noise.
LAMP = 2000.0


class Lamps:
    """Pixels of which every eighth is black, but for a lamp that `share` of its samples meet."""

    def __init__(self, share: float, side: int = 32, noise: float = 0.0) -> None:
        self.share, self.noise = share, noise
        self.grazed = np.zeros((side, side), bool)
        self.grazed[::4, ::2] = True

    def sums(self, seed: int, first: int, count: int) -> np.ndarray:
        """As a runner's, with four replicates and the same in each channel."""
        rng = np.random.default_rng((seed, first))
        each = count / 4
        shape = (*self.grazed.shape, 4)
        plain = each * (1.0 + self.noise / np.sqrt(each) * rng.normal(size=shape))
        lit = LAMP * rng.poisson(self.share * each, shape)
        return np.repeat(np.where(self.grazed[..., None], lit, plain)[..., None], 3, axis=-1)

    def relmse(self, spp: int) -> float:
        """The expected one of a picture, in closed form."""
        mean = np.where(self.grazed, LAMP * self.share, 1.0)
        variance = np.where(self.grazed, LAMP**2 * self.share, self.noise**2)
        return float((variance / spp / (mean**2 + (0.1 * mean.mean()) ** 2)).mean())


def told(source: Lamps, truth: Truth, spp: int) -> float:
    """relMSE of pictures, on average."""
    pictures = [source.sums(seed, 0, spp).sum(axis=2) / spp for seed in range(200)]
    return float(np.mean([truth.relmse(picture) for picture in pictures]))


@pytest.mark.parametrize("hits", [0.3, 1.0, 4.0])
def test_a_truth_that_a_few_samples_carry_is_not_sure(hits):
    # By the same denominators nothing is seen: its own noise is small beside a picture's.
    source = Lamps(hits / 8192)
    truth = Truth(source, 8192)
    assert truth.noise < 0.1 * told(source, truth, 64)
    assert not truth.sure


@pytest.mark.parametrize("hits", [60.0, 200.0, 1000.0])
def test_a_truth_that_is_sure_tells_the_error_of_pictures(hits):
    source = Lamps(hits / 8192)
    truth = Truth(source, 8192)
    assert truth.sure
    # 200 pictures, 128 pixels, hits / 128 samples each that meet a lamp.
    margin = 3.0 * np.sqrt((2.0 + 128.0 / hits) / (200 * 128)) + 0.01
    assert told(source, truth, 64) == pytest.approx(source.relmse(64), rel=margin)


def test_the_noise_of_denominators_brings_no_bias():
    # A truth of 40 samples a pixel: 1 / T^2 alone would be 3 / 40 too large.
    source = Lamps(40.0 / 8192)
    found = np.mean([told(source, Truth(source, 8192, seed=10**6 + 99 * i), 64) for i in range(4)])
    assert found == pytest.approx(source.relmse(64), rel=0.035)


def test_doubt_falls_as_one_over_the_samples():
    for hits in (50.0, 200.0):
        doubts = [Truth(Lamps(hits / 8192), 8192, seed=99 * i).doubt for i in range(12)]
        # A half has half of them.
        assert np.mean(doubts) == pytest.approx(2.0 / (0.5 * hits), rel=0.35)


def test_plain_noise_leaves_no_doubt():
    truth = Truth(Lamps(0.0, noise=3.0), 8192)
    assert truth.doubt < 0.01
    black = Truth(Lamps(0.0, side=2), 64)
    assert black.doubt == 0.0


def test_a_truth_goes_on_until_it_is_sure_or_may_not():
    few, enough = (Truth(Lamps(share / 4096), 4096, most=16384) for share in (2.0, 25.0))
    assert (few.spp, few.sure) == (16384, False)
    assert enough.spp in (8192, 16384) and enough.sure
    assert Truth(Lamps(0.5), 4096, most=16384).spp == 4096


def test_a_truth_that_went_on_holds_all_its_samples_once():
    source = Lamps(5.0 / 1024, side=8)
    truth = Truth(source, 1024, most=2048)
    assert truth.spp == 2048
    parts = [source.sums(10**6 + i, first, 64) for i in range(FILMS) for first in (0, 64)]
    assert truth.mean == pytest.approx(np.sum(parts, axis=(0, 3)) / 2048)
