"""Laws of the metrics: units, symmetry or its absence, orientation, and plain definitions."""

import importlib.util
import math

import numpy as np
import pytest
from scipy import ndimage

from alight.metrics import mse, relmse, relrmse, smape, ssim
from alight.metrics.epsilon import LITERATURE_EPSILON, default_epsilon
from alight.metrics.flip import flip
from alight.metrics.planes import (
    box,
    over_replicates,
    planes_of,
    same_everywhere,
    squares,
    weighted,
)
from alight.metrics.ssim import ssim_map


def pictures(seed=1, shape=(17, 23, 3)):
    rng = np.random.default_rng(seed)
    reference = rng.gamma(2.0, 0.3, shape)
    return reference * (1.0 + 0.3 * rng.standard_normal(shape)), reference


FIGURES = {"mse": mse, "relmse": relmse, "relrmse": relrmse, "smape": smape}


@pytest.mark.parametrize("name", FIGURES)
def test_figures_do_not_depend_on_orientation_or_the_order_of_channels(name):
    figure, (image, reference) = FIGURES[name], pictures()
    value = figure(image, reference)
    for moved in (
        lambda x: x.transpose(1, 0, 2), lambda x: x[::-1], lambda x: x[:, ::-1],
        lambda x: x[..., [2, 0, 1]], lambda x: np.tile(x, (2, 3, 1)),
    ):  # fmt: skip
        assert figure(moved(image), moved(reference)) == pytest.approx(value)
    assert figure(reference, reference) == 0.0


@pytest.mark.parametrize("name", FIGURES)
def test_figures_have_their_units(name):
    figure, (image, reference) = FIGURES[name], pictures()
    power = 2.0 if name == "mse" else 0.0
    more = {"epsilon": 0.08} if name == "smape" else {}
    assert figure(8.0 * image, 8.0 * reference, **more) == pytest.approx(
        8.0**power * figure(image, reference)
    )
    # Half the difference: a quarter of the square.
    half = reference + 0.5 * (image - reference)
    if name != "smape":
        smaller = 0.5 if name == "relrmse" else 0.25
        assert figure(half, reference) == pytest.approx(smaller * figure(image, reference))


def test_which_figures_tell_the_picture_from_the_reference():
    image, reference = pictures()
    assert mse(image, reference) == mse(reference, image)
    assert smape(image, reference) == pytest.approx(smape(reference, image))
    # 2 for 1 is an error of 1 over 1.01; 1 for 2 is one over 4.04.
    one, two = np.ones((4, 4, 3)), np.full((4, 4, 3), 2.0)
    assert relmse(two, one) == pytest.approx(1.0 / 1.01)
    assert relmse(one, two) == pytest.approx(1.0 / 4.04)
    assert relrmse(one, two) == pytest.approx(math.sqrt(1.0 / 4.04))
    assert relmse(two, one, epsilon=LITERATURE_EPSILON) == pytest.approx(1.0 / 1.01)
    assert relmse(one, two, epsilon=LITERATURE_EPSILON) == pytest.approx(1.0 / 4.01)


def test_figures_are_loops_over_pixels():
    image, reference = pictures(2, (3, 4, 3))
    image[0, 0] = -0.4
    pairs = list(zip(image.ravel(), reference.ravel(), strict=True))
    epsilon = (0.1 * sum(b for _, b in pairs) / len(pairs)) ** 2
    assert default_epsilon(reference) == pytest.approx(epsilon)
    for figure, term in (
        (mse, lambda a, b: (a - b) ** 2),
        (relmse, lambda a, b: (a - b) ** 2 / (b * b + epsilon)),
        (smape, lambda a, b: abs(a - b) / (abs(a) + abs(b) + 0.01)),
    ):
        assert figure(image, reference) == pytest.approx(sum(term(*p) for p in pairs) / len(pairs))


def test_bright_pictures_keep_their_small_differences():
    reference = np.full((2, 2, 3), 1e8)
    assert mse(reference + 1.0, reference) == pytest.approx(1.0)


def test_noise_of_the_reference_is_taken_out_in_the_mean_whatever_its_pattern():
    rng, (image, truth) = np.random.default_rng(3), pictures()
    image = truth * 1.05
    sigma = 0.05 * truth.mean() * (1.0 + rng.random(truth.shape))
    # The weights stay those of the truth, so that only the numerator is noisy.
    found = [
        np.mean(((image - noisy) ** 2 - sigma**2) / (truth**2 + default_epsilon(truth)))
        for noisy in truth + sigma * rng.standard_normal((100, *truth.shape))
    ]
    error = np.std(found) / 10.0
    assert np.mean(found) == pytest.approx(relmse(image, truth), abs=4.0 * error)
    noisy = truth + sigma * rng.standard_normal(truth.shape)
    expected = np.mean(((image - noisy) ** 2 - sigma**2) / (noisy**2 + default_epsilon(noisy)))
    assert relmse(image, noisy, reference_variance=sigma**2) == pytest.approx(expected)
    # More subtracted than there is: no error is left.
    assert relmse(truth, truth, reference_variance=sigma**2) < 0.0
    assert relrmse(truth, truth, reference_variance=sigma**2) == 0.0


def test_structural_similarity_is_symmetric_and_turns_with_the_picture():
    a, b = (np.clip(0.5 * one[..., 0], 0.0, 1.0) for one in pictures())
    assert ssim(a, b) == pytest.approx(ssim(b, a))
    np.testing.assert_allclose(ssim_map(a.T, b.T), ssim_map(a, b).T)
    np.testing.assert_allclose(ssim_map(a[::-1], b[::-1]), ssim_map(a, b)[::-1])
    # Of flat pictures only brightness is left: (2 m n + C1) / (m^2 + n^2 + C1).
    flat = ssim(np.full((12, 12), 0.2), np.full((12, 12), 0.6))
    assert flat == pytest.approx((2 * 0.12 + 1e-4) / (0.04 + 0.36 + 1e-4))


# ---------------------------------------------------------------------------- FLIP


needs_flip = pytest.mark.skipif(
    importlib.util.find_spec("flip_evaluator") is None, reason="flip-evaluator is not installed"
)


def bright_and_dark():
    """The picture shows a lamp that the reference does not have, and the other way round."""
    pair = pictures(4, (24, 32, 3))
    image, reference = (np.maximum(one, 0.0).astype(np.float32) for one in pair)
    image[4:8, 4:8] += 30.0
    return image, reference


@needs_flip
def test_flip_shows_exposures_of_the_reference():
    """Which exposures matter the reference says: swapped, the figure is another one."""
    import flip_evaluator

    image, reference = bright_and_dark()
    expected, mean, _ = flip_evaluator.evaluate(reference, image, "HDR", applyMagma=False)
    found = flip(image, reference)
    assert found.mean == pytest.approx(mean, rel=1e-6)
    np.testing.assert_allclose(found.error, np.asarray(expected)[..., 0], rtol=1e-6)
    assert flip(reference, image).mean != pytest.approx(mean, rel=0.02)


@needs_flip
@pytest.mark.parametrize("dynamic_range", ["ldr", "hdr"])
def test_flip_turns_with_the_picture_and_cuts_what_no_display_shows(dynamic_range):
    image, reference = bright_and_dark()
    found = flip(image, reference, dynamic_range)
    assert found.error.shape == (24, 32)
    assert found.error[4:8, 4:8].mean() > 2.0 * found.error[14:, 14:].mean()
    turned = flip(*(one.transpose(1, 0, 2) for one in (image, reference)), dynamic_range)
    np.testing.assert_allclose(turned.error, found.error.T, atol=1e-4)
    below = image.copy()
    below[0, 0] = -3.0
    dark = np.maximum(below, 0.0)
    assert flip(below, reference, dynamic_range).mean == flip(dark, reference, dynamic_range).mean
    # Colours are not alike to an eye.
    other = flip(image[..., ::-1], reference[..., ::-1], dynamic_range)
    assert other.mean != pytest.approx(found.mean, rel=1e-3)


@needs_flip
def test_flip_of_a_display_is_cut_at_white_and_of_black_there_is_no_exposure():
    image, reference = bright_and_dark()
    white = np.minimum(image, 1.0)
    assert flip(image, reference, "ldr").mean == flip(white, reference, "ldr").mean
    assert flip(image, reference, "hdr").mean != flip(white, reference, "hdr").mean
    black = np.zeros_like(reference)
    for pair in ((black, reference), (reference, black)):
        assert flip(*pair).mean == flip(*pair, "ldr").mean > 0.0


# ---------------------------------------------------------------------------- planes of replicates


def replicates():
    rng = np.random.default_rng(5)
    return rng.random((5, 7, 4, 3)), rng.integers(1, 6, (5, 7, 4))


def test_planes_are_the_replicates_turned():
    means, counts = replicates()
    m, k = planes_of(means, counts)
    for r in range(4):
        np.testing.assert_array_equal(k[r, 0], counts[:, :, r].astype(np.float32))
        for c in range(3):
            np.testing.assert_array_equal(m[r, c], means[:, :, r, c].astype(np.float32))


def test_means_and_squares_are_weighted_by_samples():
    means, counts = replicates()
    counts[0, 0], means[0, 0] = 0, 0.0
    m, k = planes_of(means, counts)
    n = np.maximum(counts.sum(axis=2), 1)[..., None]
    mean = (means * counts[..., None]).sum(axis=2) / n
    np.testing.assert_allclose(weighted(m, k), mean.transpose(2, 0, 1), rtol=1e-5, atol=1e-7)
    deviations = (counts[..., None] * (means - mean[:, :, None]) ** 2).sum(axis=2)
    found = squares(m, k, weighted(m, k))
    np.testing.assert_allclose(found, deviations.transpose(2, 0, 1), rtol=1e-4, atol=1e-6)


def test_counts_that_are_the_same_everywhere_are_told_from_those_that_are_not():
    _, counts = replicates()
    assert same_everywhere(counts) is counts
    by_replicate = np.broadcast_to([4, 4, 3, 3], (5, 7, 4))
    np.testing.assert_array_equal(same_everywhere(by_replicate), [[[4, 4, 3, 3]]])
    np.testing.assert_array_equal(same_everywhere(np.full((5, 7, 4), 6)), [[[6, 6, 6, 6]]])
    np.testing.assert_array_equal(over_replicates(counts, np.add), counts.sum(axis=2))
    np.testing.assert_array_equal(over_replicates(counts, np.minimum), counts.min(axis=2))


def test_the_box_repeats_the_border():
    planes = np.random.default_rng(6).random((3, 6, 9)).astype(np.float32)
    expected = ndimage.uniform_filter(planes, size=(1, 3, 3), mode="nearest")
    np.testing.assert_allclose(box(planes), expected, rtol=1e-5)
    np.testing.assert_allclose(box(planes[0, :1, :1]), planes[0, :1, :1], rtol=1e-6)
