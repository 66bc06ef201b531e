"""relMSE, SMAPE, and a picture's own error from its replicates."""

import math

import numpy as np
import pytest

from alight.metrics import relmse, relrmse, smape
from alight.metrics.epsilon import LITERATURE_EPSILON, default_epsilon
from alight.metrics.own_error import estimate_relmse


def test_relmse_is_its_formula():
    reference = np.array([[[1.0, 2.0, 3.0]]])
    image = reference + np.array([0.1, -0.2, 0.0])
    epsilon = (0.1 * 2.0) ** 2
    expected = (0.01 / (1 + epsilon) + 0.04 / (4 + epsilon)) / 3
    assert relmse(image, reference) == pytest.approx(expected)
    assert relrmse(image, reference) == pytest.approx(math.sqrt(expected))
    literature = (0.01 / 1.01 + 0.04 / 4.01) / 3
    assert relmse(image, reference, epsilon=LITERATURE_EPSILON) == pytest.approx(literature)


@pytest.mark.parametrize("exposure", [1e-6, 1e6])
def test_default_epsilon_does_not_depend_on_the_exposure(exposure):
    rng = np.random.default_rng(1)
    reference = rng.uniform(0, 1, (8, 8, 3))
    image = reference + rng.normal(0, 0.1, (8, 8, 3))
    scaled = relmse(image * exposure, reference * exposure)
    assert scaled == pytest.approx(relmse(image, reference))


def test_noise_of_the_reference_is_subtracted():
    rng = np.random.default_rng(2)
    truth = np.full((256, 256, 3), 0.5)
    noise = 0.05**2
    image = truth + rng.normal(0, 0.1, truth.shape)
    noisy = truth + rng.normal(0, 0.05, truth.shape)
    exact = relmse(image, truth, epsilon=0.01)
    assert relmse(image, noisy, epsilon=0.01) > 1.15 * exact
    corrected = relmse(image, noisy, epsilon=0.01, reference_variance=np.full(truth.shape, noise))
    # The noisy reference also stands in the denominator: (noise / ref)^2 = 1 % of bias remains.
    assert corrected == pytest.approx(exact, rel=0.04)


def test_smape_lies_between_0_and_1_and_is_symmetric():
    rng = np.random.default_rng(3)
    a, b = rng.uniform(0, 2, (2, 8, 8, 3))
    assert smape(a, a) == 0.0
    assert smape(a, b) == pytest.approx(smape(b, a))
    assert smape(a, np.zeros_like(a)) == pytest.approx(np.mean(a / (a + 0.01)))


@pytest.mark.parametrize("metric", [relmse, smape])
def test_pictures_of_different_shape_are_refused(metric):
    with pytest.raises(ValueError, match="one shape"):
        metric(np.zeros((4, 4, 3)), np.zeros((4, 5, 3)))


def test_undefined_figures_are_refused():
    with pytest.raises(ValueError, match="undefined"):
        relmse(np.zeros((1, 1, 3)), np.zeros((1, 1, 3)))
    with pytest.raises(ValueError, match="epsilon"):
        smape(np.zeros((1, 1, 3)), np.zeros((1, 1, 3)), epsilon=0.0)


# ---------------------------------------------------------------------------- own error


def scene_picture():
    """Smooth shading, edges, a bright lamp and a dark corner."""
    y, x = np.mgrid[0:48, 0:48] / 48
    picture = 0.3 + 0.4 * x + 0.2 * np.sin(6 * y)
    picture[20:30, 5:15] = 0.05
    picture[0:3, 20:28] = 15.0
    return picture[..., None] * np.array([1.0, 0.7, 0.4])


NOISES = {
    "gaussian": lambda rng, shape: 1 + rng.normal(size=shape),
    "log-normal": lambda rng, shape: np.exp(1.2 * rng.normal(size=shape) - 0.72),
    "two-valued": lambda rng, shape: 0.8 + 10.0 * (rng.random(shape) < 0.02),
}


def rendered(noise, samples, seed):
    """Means of 4 replicates of a noisy picture, and their counts."""
    rng, truth = np.random.default_rng(seed), scene_picture()
    factors = NOISES[noise](rng, (4, samples // 4, 48, 48, 1)).mean(axis=1)
    means = np.moveaxis(truth * factors, 0, 2)
    return means, np.full((48, 48, 4), samples // 4)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("samples", [16, 64, 256])
def test_the_interval_holds_the_true_error(noise, samples):
    truth, held, held_literature = scene_picture(), 0, 0
    for seed in range(20):
        means, counts = rendered(noise, samples, seed)
        mean, estimate = means.mean(axis=2), estimate_relmse(means, counts)
        held += estimate.relmse.low <= relmse(mean, truth) <= estimate.relmse.high
        own = relmse(mean, truth, epsilon=LITERATURE_EPSILON)
        held_literature += estimate.relmse_literature.low <= own <= estimate.relmse_literature.high
    # 95 % of 20 is 19; fewer than 16 has a probability of 0.3 %.
    assert held >= 16
    assert held_literature >= 16


@pytest.mark.parametrize("noise", NOISES)
def test_the_estimate_is_near_the_true_error_and_its_interval_is_narrow(noise):
    means, counts = rendered(noise, 256, 1)
    estimate = estimate_relmse(means, counts)
    truth = relmse(means.mean(axis=2), scene_picture())
    assert estimate.relmse.value == pytest.approx(truth, rel=0.1)
    # A twelfth of the log-normal error is in two pixels at the lamp's edge.
    assert estimate.relmse.high / estimate.relmse.low < (1.38 if noise == "log-normal" else 1.25)
    assert estimate.epsilon == pytest.approx(default_epsilon(scene_picture()), rel=0.02)
    assert estimate.relrmse.value == pytest.approx(math.sqrt(estimate.relmse.value))


def test_pixels_of_unknown_error_are_left_out():
    means, counts = rendered("gaussian", 64, 1)
    whole = estimate_relmse(means, counts)
    counts[:12, :, 2] = 0
    half = estimate_relmse(means, counts)
    assert half.known == 0.75
    assert half.relmse.value == pytest.approx(whole.relmse.value, rel=0.3)


def test_one_replicate_or_one_sample_says_nothing_of_the_error():
    means, counts = rendered("gaussian", 64, 1)
    for m, k in ((means[:, :, :1], counts[:, :, :1]), (means, np.where(np.arange(4) < 1, 1, 0))):
        # A claim is what fails here, not a warning on the way to it.
        with np.errstate(all="ignore"):
            estimate = estimate_relmse(m, np.broadcast_to(k, m.shape[:3]))
        assert estimate.known == 0.0
        for figure in (estimate.relmse, estimate.relmse_literature):
            assert math.isnan(figure.value)
            assert math.isnan(figure.high)


@pytest.mark.parametrize("replicates", [2, 3, 4, 5, 8, 9])
def test_every_number_of_replicates_gives_the_same_error(replicates):
    rng = np.random.default_rng(replicates)
    means = 1.0 + rng.normal(0.0, 0.05 * replicates**0.5, (128, 128, replicates, 3))
    estimate = estimate_relmse(means.astype(np.float32), np.full(means.shape[:3], 4))
    truth = relmse(means.mean(axis=2), np.ones((128, 128, 3)))
    assert estimate.relmse.value == pytest.approx(truth, rel=0.05)
    if replicates < 4:
        # There are no two halves with a spread of their own.
        assert math.isnan(estimate.relmse.high)
        return
    assert estimate.relmse.low <= truth <= estimate.relmse.high
    # The channels are independent here, so that there are three terms a pixel.
    spread = math.sqrt(2.0 * replicates / (replicates - 1) / (3 * 128**2))
    width = math.log(estimate.relmse.high / estimate.relmse.low) / 3.92
    assert width == pytest.approx(spread, rel=0.05)


def test_replicates_of_unequal_counts_are_weighted():
    rng = np.random.default_rng(5)
    counts = np.broadcast_to([4, 4, 2, 1], (96, 96, 4))
    means = 1.0 + rng.normal(0.0, 0.2, (96, 96, 4, 1)) / np.sqrt(counts[..., None])
    means = np.repeat(means, 3, axis=3)
    estimate = estimate_relmse(means.astype(np.float32), counts)
    picture = (means * counts[..., None]).sum(axis=2) / 11
    assert estimate.relmse.low <= relmse(picture, np.ones((96, 96, 3))) <= estimate.relmse.high


def test_a_large_picture_is_estimated_by_bands_to_the_same_figure():
    rng = np.random.default_rng(6)
    means = (1.0 + rng.normal(0.0, 0.1, (512, 160, 4, 3))).astype(np.float32)
    estimate = estimate_relmse(means, np.full(means.shape[:3], 1))
    truth = relmse(means.mean(axis=2), np.ones((512, 160, 3)))
    assert estimate.relmse.value == pytest.approx(truth, rel=0.02)


def test_nothing_known_is_unknown_not_zero():
    ones = np.ones((4, 4, 4, 3), np.float32)
    assert math.isnan(estimate_relmse(ones, np.zeros((4, 4, 4), int)).relmse.value)
    # A black picture: no light was found, which says nothing about the error.
    black = estimate_relmse(0.0 * ones, np.ones((4, 4, 4), int))
    assert math.isnan(black.relmse.value)
    assert math.isnan(black.relrmse.value)
