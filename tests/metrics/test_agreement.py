"""The test of two pictures with their errors: calibrated, and it finds a bias of 1 %."""

import math

import numpy as np
import pytest

from alight.metrics import Measured
from alight.metrics.agreement import compare_measured
from alight.metrics.statistics import t_to_z

SHAPE = (96, 128, 3)


def measured(seed, scale=1.0, noise=0.2, replicates=4, spread=0.0):
    """A picture as a film makes it: mean and standard error over a few replicates.

    `spread` gives pixels very different noise: 0 all the same.
    """
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]] / 128
    truth = np.stack([0.5 + x, 0.3 + y, 1.2 - 0.5 * x], axis=-1)
    sigma = noise * np.exp(spread * np.random.default_rng(99).normal(size=SHAPE))
    seeds = truth * scale + sigma * rng.normal(size=(replicates, *SHAPE))
    error = seeds.std(axis=0, ddof=1) / math.sqrt(replicates)
    return Measured(seeds.mean(axis=0), error, replicates)


@pytest.mark.parametrize("spread", [0.0, 1.0], ids=["even", "uneven"])
@pytest.mark.parametrize("replicates", [2, 4, 16])
def test_z_is_standard_normal_for_equal_pictures(replicates, spread):
    a, b = (measured(s, replicates=replicates, spread=spread) for s in (1, 2))
    found = compare_measured(a, b)
    assert found.passed, found.reasons
    z = found.z[np.isfinite(found.z)]
    assert z.size == 3 * (96 // found.block) * (128 // found.block)
    # Four times the standard deviations of mean and of rms over so many.
    assert abs(z.mean()) < 4 / math.sqrt(z.size)
    assert abs(math.sqrt((z**2).mean()) - 1) < 4 / math.sqrt(2 * z.size)


@pytest.mark.parametrize("bias", [1.0, 1.05])
def test_the_figures_beside_a_verdict_are_those_of_its_blocks_and_pictures(bias):
    a, b = measured(1, spread=1.0), measured(2, scale=bias)
    a.error[0, 0] = np.nan
    found = compare_measured(a, b, block=8)
    assert found.largest == np.nanmax(np.abs(found.z))
    np.testing.assert_allclose(found.rms, np.sqrt(np.nanmean(found.z**2, axis=(0, 1))))
    both = np.isfinite(a.error)
    for side, said in ((a, found.mean_a), (b, found.mean_b)):
        np.testing.assert_allclose(said, np.mean(side.mean, axis=(0, 1), where=both), rtol=1e-6)


@pytest.mark.parametrize("scale", [0.0, 0.3, 1.0])
def test_p_values_are_probabilities(scale):
    """Also where pictures are closer to each other than chance would bring them."""
    a, b = measured(1), measured(2)
    near = Measured(a.mean + scale * (b.mean - a.mean), a.error, a.replicates)
    for p in compare_measured(a, near, block=8).p_values.values():
        assert 0.0 <= p <= 1.0


def test_false_alarms_are_as_rare_as_promised():
    failed = sum(
        not compare_measured(measured(2 * s + 10), measured(2 * s + 11), block=8).passed
        for s in range(40)
    )
    # 1 % by Holm: 4 of 40 has a probability below 0.1 %.
    assert failed < 4


def test_a_bias_of_one_percent_is_found_and_named():
    found = compare_measured(measured(1), measured(2, scale=1.01))
    assert not found.passed
    assert {"mean R", "mean G", "mean B"} <= {reason.split(":")[0] for reason in found.reasons}
    assert found.mean_b[0] / found.mean_a[0] == pytest.approx(1.01, abs=0.002)


def test_a_difference_in_one_block_is_found():
    b = measured(2)
    b.mean[40:48, 64:72, 1] += 0.3
    found = compare_measured(measured(1), b, block=8)
    assert "largest |z|" in [reason.split(":")[0] for reason in found.reasons]
    assert not any("mean" in reason for reason in found.reasons)
    y, x, c = np.unravel_index(np.nanargmax(np.abs(found.z)), found.z.shape)
    assert (y, x, c) == (5, 8, 1)


def test_understated_errors_fail_and_shared_noise_is_only_odd():
    a, b = measured(1), measured(2)
    small = Measured(b.mean, 0.5 * b.error, b.replicates)
    assert any("rms" in reason for reason in compare_measured(a, small).reasons)
    same = compare_measured(a, Measured(a.mean, b.error, 4))
    assert same.passed
    assert len(same.remarks) == 3


def test_one_side_may_be_exact_and_of_another_precision():
    a = measured(1)
    y, x = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]] / 128
    truth = np.stack([0.5 + x, 0.3 + y, 1.2 - 0.5 * x], axis=-1)
    assert compare_measured(a, Measured(truth.astype(np.float32))).passed
    assert not compare_measured(Measured(1.01 * truth), a).passed


def test_rounding_of_pixels_without_noise_is_no_difference():
    """A lamp seen directly has no noise, and renderers round it differently."""
    a, b = measured(1), measured(2)
    for side, factor in ((a, 1.0), (b, 1.0 + 3e-7)):
        side.mean[:16] = 10.0 * factor
        side.error[:16] = 0.0
    found = compare_measured(a, b, block=8)
    assert found.passed, found.reasons
    assert np.isnan(found.z[:2]).all()
    b.mean[:16] *= 1.0001
    assert not compare_measured(a, b, block=8).passed


def test_unknown_errors_are_left_out():
    a, b = measured(1), measured(2)
    b.error[:48] = np.nan
    b.mean[:48] += 1.0
    found = compare_measured(a, b)
    assert found.passed, found.reasons
    assert np.isnan(found.z[: 48 // found.block]).all()


@pytest.mark.parametrize(
    ("size", "replicates", "block"),
    [(8, 4, 4), (70, 4, 4), (300, 4, 16), (32, 64, 1), (70, 64, 4), (70, 2, 8), (300, 2, 16)],
)
def test_blocks_are_at_most_1024_but_are_large_enough_for_few_replicates(size, replicates, block):
    rng = np.random.default_rng(1)
    mean, error = rng.random((size, size, 3)), np.full((size, size, 3), 0.1)
    few, exact = Measured(mean, error, replicates), Measured(mean)
    assert compare_measured(few, exact).block == block
    # What knows its error better changes nothing, on either side.
    many = Measured(mean, error, 256)
    assert compare_measured(few, many).block == compare_measured(many, few).block == block


def test_what_cannot_be_judged_is_refused():
    flat = np.ones((8, 8, 3))
    with pytest.raises(ValueError, match="nothing to judge"):
        compare_measured(Measured(flat), Measured(flat))
    with pytest.raises(ValueError, match="one shape"):
        compare_measured(Measured(flat, flat, 4), Measured(flat[1:]))


def test_one_pixel_is_students_t_with_one_freedom_less_than_replicates():
    """The formula of the pooled freedom is exact for a block of one pixel."""
    mean, error = np.full((2, 2, 3), 1.3), np.full((2, 2, 3), 0.1)
    found = compare_measured(Measured(mean, error, 4), Measured(np.ones((2, 2, 3))), block=1)
    assert np.allclose(found.z, t_to_z(np.array(3.0), np.array(3.0)), rtol=1e-5)


# ------------------------------------------------------------------- noise that is not normal


def rendered(seed, spp, replicates=4, rate=0.002, value=20.0, scale=1.0, shape=(48, 64)):
    """A picture of `spp` samples, some of which meet something bright, as few as `rate` says."""
    rng = np.random.default_rng(seed)
    each = spp // replicates
    met = rng.poisson(rate * each, (replicates, *shape, 1)) / each
    plain = 0.5 + 0.1 * rng.standard_normal((replicates, *shape, 3)) / math.sqrt(each)
    means = scale * (plain + value * met)
    error = means.std(axis=0, ddof=1) / math.sqrt(replicates)
    return Measured(means.mean(axis=0), error, replicates, float(spp))


@pytest.mark.parametrize(("few", "many"), [(4, 4), (4, 256), (16, 4096), (64, 1024)])
@pytest.mark.parametrize("rate", [0.0001, 0.002])
def test_equal_pictures_of_bright_samples_are_not_called_different(few, many, rate):
    """Blocks that met no bright sample are too dark, and say that they know it well."""
    found = [
        compare_measured(rendered(2 * s, few, rate=rate), rendered(2 * s + 1, many, rate=rate))
        for s in range(15)
    ]
    # 1 % of 15; three have a probability of 4e-4.
    assert sum(not one.passed for one in found) < 3


def test_without_the_other_pictures_noise_the_darker_one_would_be_called_different():
    """What `samples` are for: 4 samples a pixel hardly meet what 4 096 have met."""
    a, b = rendered(1, 4, rate=2e-5, value=100.0), rendered(2, 1024, rate=2e-5, value=100.0)
    found = compare_measured(a, b)
    assert found.passed
    assert found.doubts
    alone = [Measured(side.mean, side.error, side.replicates) for side in (a, b)]
    assert not compare_measured(*alone).passed


def edges(seed, spp, replicates):
    """Dark noise, and one pixel in 40 that each sample sees full of light or without, by chance."""
    rng = np.random.default_rng(seed)
    each, shape = spp // replicates, (48, 64, 1)
    lit = np.random.default_rng(7).random(shape) < 1 / 40
    met = rng.binomial(each, 0.5, (replicates, *shape)) / each
    plain = 0.1 + 0.01 * rng.standard_normal((replicates, *shape[:2], 3)) / math.sqrt(each)
    means = plain + 5.0 * lit * met
    error = means.std(axis=0, ddof=1) / math.sqrt(replicates)
    return Measured(means.mean(axis=0), error, replicates, float(spp))


@pytest.mark.parametrize(("few", "many", "replicates"), [(2, 2, 2), (8, 64, 2), (4, 1024, 4)])
def test_replicates_that_met_the_same_are_no_proof_that_there_is_no_noise(few, many, replicates):
    """Of two samples at an edge both meet the light in a quarter of the cases: no spread at all."""
    found = [
        compare_measured(edges(2 * s, few, replicates), edges(2 * s + 1, many, replicates), block=8)
        for s in range(15)
    ]
    # 1 % of 15; three have a probability of 4e-4.
    assert sum(not one.passed for one in found) < 3


@pytest.mark.parametrize(("few", "many"), [(16, 16), (16, 256), (64, 1024)])
def test_two_percent_more_light_are_found_through_bright_samples(few, many):
    """The z-score of the difference of the means is 6."""
    shape, rate, value = (128, 128), 0.01, 2.0
    mean = 0.5 + rate * value
    variance = (rate * value**2 + 0.1**2) * (1 / few + 1 / many) / (shape[0] * shape[1])
    scale = 1.0 + 6.0 * math.sqrt(variance) / mean
    options = {"rate": rate, "value": value, "shape": shape}
    found = [
        compare_measured(rendered(2 * s, few, scale=scale, **options),
                         rendered(2 * s + 1, many, **options))
        for s in range(10)
    ]  # fmt: skip
    # Each fails to be found with a probability of 0.3 %.
    assert sum(not one.passed for one in found) >= 9


def test_one_family_level_holds_for_all_tests_together():
    found = compare_measured(measured(1), measured(2))
    names = {"mean R", "mean G", "mean B", "largest |z|", "rms z R", "rms z G", "rms z B"}
    assert set(found.p_values) == names
    assert found.level == 0.01
    # The smallest p-value alone decides whether anything fails.
    smallest = min(found.p_values.values())
    assert compare_measured(measured(1), measured(2), level=6.9 * smallest).passed
    assert not compare_measured(measured(1), measured(2), level=7.1 * smallest).passed
