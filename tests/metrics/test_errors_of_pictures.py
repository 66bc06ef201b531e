"""relMSE, SMAPE, and a picture's own error from its replicates."""

import math

import numpy as np
import pytest

from alight.metrics import relmse, relrmse, smape
from alight.metrics.relmse import LITERATURE_EPSILON, default_epsilon, estimate_relmse


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
    """Mean and standard error of a noisy picture from 4 replicates."""
    rng, truth = np.random.default_rng(seed), scene_picture()
    factors = NOISES[noise](rng, (4, samples // 4, 48, 48, 1)).mean(axis=1)
    replicates = truth * factors
    mean = replicates.mean(axis=0)
    return mean, np.sqrt(((replicates - mean) ** 2).sum(axis=0) / 12)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("samples", [16, 64, 256])
def test_the_interval_holds_the_true_error(noise, samples):
    truth, held, held_literature = scene_picture(), 0, 0
    for seed in range(20):
        mean, error = rendered(noise, samples, seed)
        estimate = estimate_relmse(mean, error, 4)
        held += estimate.relmse.low <= relmse(mean, truth) <= estimate.relmse.high
        own = relmse(mean, truth, epsilon=LITERATURE_EPSILON)
        held_literature += estimate.relmse_literature.low <= own <= estimate.relmse_literature.high
    # 95 % of 20 is 19; fewer than 16 has a probability of 0.3 %.
    assert held >= 16
    assert held_literature >= 16


@pytest.mark.parametrize("noise", NOISES)
def test_the_estimate_is_near_the_true_error_and_its_interval_is_narrow(noise):
    mean, error = rendered(noise, 256, 1)
    estimate = estimate_relmse(mean, error, 4)
    assert estimate.relmse.value == pytest.approx(relmse(mean, scene_picture()), rel=0.1)
    assert estimate.relmse.high / estimate.relmse.low < 1.5
    assert estimate.epsilon == pytest.approx(default_epsilon(scene_picture()), rel=0.02)
    assert estimate.relrmse.value == pytest.approx(math.sqrt(estimate.relmse.value))


def test_pixels_of_unknown_error_are_left_out():
    mean, error = rendered("gaussian", 64, 1)
    whole = estimate_relmse(mean, error, 4)
    error[:12] = np.nan
    half = estimate_relmse(mean, error, 4)
    assert half.known == 0.75
    assert half.relmse.value == pytest.approx(whole.relmse.value, rel=0.3)


def test_nothing_known_is_unknown_not_zero():
    mean = np.ones((4, 4, 3))
    assert math.isnan(estimate_relmse(mean, np.full_like(mean, np.nan), 4).relmse.value)
    # A black picture: no light was found, which says nothing about the error.
    black = estimate_relmse(np.zeros((4, 4, 3)), np.zeros((4, 4, 3)), 4)
    assert math.isnan(black.relmse.value)
    assert math.isnan(black.relrmse.value)
