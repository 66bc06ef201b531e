"""Laws of block statistics, of bias and variance, and of figures: truth known, noise planted."""

import math

import numpy as np
import pytest
from scipy import stats

from alight.lab.figures import Figures
from alight.lab.results import BIASED, DIFFERENT, UNBIASED
from alight.lab.statistics.block_means import (
    BlockMoments,
    _skewness,
    block_row,
    block_size,
    compare_with_reference,
    exact_statistics,
    joined_statistics,
    judge,
)
from alight.lab.statistics.decomposition import Moments, decompose, reference_spread
from alight.metrics import flip, mse, relmse, smape

WIDTH, HEIGHT = 48, 32


def truth(width=WIDTH, height=HEIGHT, seed=1):
    """A picture brighter than 0 and other than 1, of three different channels."""
    rng = np.random.default_rng(seed)
    return (0.3 + 0.2 * rng.random((height, width, 3))) * np.array([1.0, 0.6, 0.3])


def seeds(rng, count, picture, sigma, shared=True):
    """Pictures whose pixels err by `sigma`: channels together, or each on its own."""
    shape = (count, *picture.shape[:2], 1 if shared else 3)
    return (picture + sigma * rng.standard_normal(shape)).astype(np.float32)


# ---------------------------------------------------------------------------- blocks


def test_blocks_are_about_64_and_grow_with_the_picture():
    for width, height in [(64, 64), (128, 32), (32, 128), (96, 60), (640, 480)]:
        block = block_size((width, height))
        assert 45 <= (width // block) * (height // block) <= 90
        assert block_size((height, width)) == block
        assert block_size((4 * width, 4 * height)) == pytest.approx(4 * block, abs=3)
    # Small or narrow pictures: two pixels on a side, if there are as many.
    assert [block_size(size) for size in [(8, 8), (1, 9), (9, 1), (3, 400)]] == [2, 1, 1, 3]


def test_a_row_is_channel_means_and_luminances_of_blocks():
    picture = truth(50, 35)
    block, row = block_size((50, 35)), block_row(picture)
    assert row[:3] == pytest.approx(picture.mean(axis=(0, 1)))
    weights = np.array([0.212671, 0.715160, 0.072169])
    expected = [
        [picture[y : y + block, x : x + block].mean(axis=(0, 1)) @ weights
         for x in range(0, 50 - block + 1, block)]
        for y in range(0, 35 - block + 1, block)
    ]  # fmt: skip
    assert row[3:] == pytest.approx(np.ravel(expected))
    turned = block_row(picture.transpose(1, 0, 2))
    assert turned[3:].reshape(np.transpose(expected).shape) == pytest.approx(np.transpose(expected))


def test_moments_of_blocks_are_numpys_with_rows_and_columns_as_in_the_picture():
    pictures = seeds(np.random.default_rng(2), 6, truth(), 0.1, shared=False)
    rows = np.stack([block_row(one) for one in pictures])
    found = BlockMoments.of(rows, (WIDTH, HEIGHT)).statistics
    block = block_size((WIDTH, HEIGHT))
    shape = (HEIGHT // block, WIDTH // block)
    assert (found.block, found.count) == (block, 6)
    assert found.block_mean == pytest.approx(rows[:, 3:].mean(axis=0).reshape(shape))
    assert found.block_variance == pytest.approx(rows[:, 3:].var(axis=0, ddof=1).reshape(shape))
    assert found.channel_mean == pytest.approx(rows[:, :3].mean(axis=0))
    assert found.channel_variance == pytest.approx(rows[:, :3].var(axis=0, ddof=1))


def test_the_skewness_of_a_mean_is_scipys_of_one_picture_over_the_root_of_the_seeds():
    for count in (3, 8, 40):
        x = np.random.default_rng(count).gamma(1.0, size=count)
        expected = stats.skew(x, bias=False) / math.sqrt(count)
        assert _skewness(7.0 * x[:, None, None]) == pytest.approx(expected)
        assert _skewness(-x[:, None, None]) == pytest.approx(-expected)
    assert _skewness(np.random.default_rng(1).gamma(1.0, size=(2, 4, 4))) == 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("rate", "joined"), [(30.0, 1), (1.0, 2), (0.2, 4)])
def test_skewed_blocks_are_joined_bright_or_dark_until_they_are_calm(sign, rate, joined):
    """Sums of Poisson numbers: a block's mean over the seeds has the skewness of 1 / root n."""
    rng = np.random.default_rng(3)
    size, shape = (352, 192), (6, 11)
    assert block_size(size) == 32
    blocks = 1.0 + sign * 0.1 * (rng.poisson(rate, (16, *shape)) / rate - 1.0)
    rows = [np.concatenate([np.ones(3), one.ravel()]) for one in blocks]
    found = BlockMoments.calm(rows, size).statistics
    assert found.block == 32 * joined
    down, across = shape[0] // joined, shape[1] // joined
    inner = blocks[:, : down * joined, : across * joined]
    means = inner.reshape(16, down, joined, across, joined).mean(axis=(2, 4))
    assert found.block_mean == pytest.approx(means.mean(axis=0))
    assert found.block_variance == pytest.approx(means.var(axis=0, ddof=1))


@pytest.mark.parametrize("factor", [1, 2, 3])
def test_joined_blocks_have_the_mean_and_the_variance_of_larger_blocks(factor):
    picture, sigma = truth(96, 96), 0.05 + 0.1 * truth(96, 96, 2)
    fine = exact_statistics(picture, sigma**2)
    found = joined_statistics(fine, factor * fine.block)
    side = factor * fine.block
    count = 96 // side
    pixels = (sigma @ [0.212671, 0.715160, 0.072169]) ** 2 / side**4
    cut = pixels[: count * side, : count * side].reshape(count, side, count, side)
    assert found.block == side
    assert found.block_variance / found.count == pytest.approx(cut.sum(axis=(1, 3)))
    measured = picture @ [0.212671, 0.715160, 0.072169]
    cut = measured[: count * side, : count * side].reshape(count, side, count, side)
    assert found.block_mean == pytest.approx(cut.mean(axis=(1, 3)))


@pytest.mark.parametrize("size", [(16, 16), (48, 32), (96, 64)])
def test_the_variance_of_an_exact_reference_is_that_of_its_noise(size):
    """Whatever the block: over 300 pictures of that noise the blocks vary as the statistics say."""
    picture = truth(*size)
    sigma = 0.02 * (1.0 + picture[..., :1])
    rng, variance = np.random.default_rng(4), np.broadcast_to(sigma**2, picture.shape)
    rows = np.stack([block_row(one) for one in seeds(rng, 300, picture, sigma)])
    found = exact_statistics(picture.astype(np.float32), variance)
    measured = rows.var(axis=0, ddof=1)
    # A variance of 300 numbers is right to 8.2 %; the mean over blocks is much better.
    ratio = found.block_variance.ravel() / found.count / measured[3:]
    assert ratio.mean() == pytest.approx(1.0, abs=4.0 * 0.082 / math.sqrt(ratio.size))
    assert found.channel_variance / found.count == pytest.approx(measured[:3], rel=0.33)
    # Known exactly: it takes no degrees of freedom.
    assert found.count > 1e4


# ---------------------------------------------------------------------------- tests of bias


def sides(rng, shift=0.0, count=12, own=0.1, reference=0.08):
    """An arm of `count` pictures, too bright by `shift`, and a reference of known noise."""
    picture = truth()
    noisy = seeds(rng, 1, picture, reference)[0]
    rows = [block_row(one) for one in seeds(rng, count, picture * (1.0 + shift), own)]
    known = exact_statistics(noisy, np.full(picture.shape, reference**2))
    return BlockMoments.of(rows, (WIDTH, HEIGHT)).statistics, known


def one_test(rng, shift=0.0, **options):
    """What is said of such an arm."""
    return compare_with_reference(*sides(rng, shift, **options))


def test_without_a_bias_z_is_standard_normal_and_the_level_is_kept():
    """The reference is as noisy as the arm's mean: too much noise would hide every bias."""
    rng = np.random.default_rng(5)
    raw = [one_test(rng) for _ in range(60)]
    squares = np.array([one.test.z_rms**2 for one in raw])
    blocks = raw[0].test.blocks
    assert blocks == 54
    # Mean squares of 54 normal numbers; 60 of them.
    assert squares.mean() == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / blocks / 60))
    held = sum(one.test.z_low <= one.test.z_rms <= one.test.z_high for one in raw)
    assert held >= 54
    assert all(0.0 <= one.test.z_low < 1.0 < one.test.z_high for one in raw)
    # Bonferroni over six tests, some of which nearly are one: 5 % at most.
    alarms = sum(one.p_value < 0.05 for one in raw)
    assert alarms <= 9
    differences = [one.test.difference[c] for one in raw for c in range(3)]
    missed = sum(not e.low <= 0.0 <= e.high for e in differences)
    # Three channels that err together: 60 independent ones.
    assert 0.0 < missed / 3 < 3.0 + 4.0 * math.sqrt(3.0)


def test_the_p_value_is_six_times_the_smallest_of_six():
    rng = np.random.default_rng(6)
    for shift in (0.0, 0.01, 0.02):
        arm, known = sides(rng, shift)
        raw = compare_with_reference(arm, known)
        blocks = raw.test.blocks
        chi = stats.chi2.sf(blocks * raw.test.z_rms**2, blocks)
        largest = blocks * 2.0 * stats.norm.sf(raw.test.z_largest)
        # Channel means by the 11 degrees of freedom of the arm's twelve pictures.
        noise = np.sqrt(arm.channel_variance / arm.count + known.channel_variance / known.count)
        channels = 2.0 * stats.t.sf(np.abs(arm.channel_mean - known.channel_mean) / noise, 11)
        # The whole by the noise of all blocks: 600 degrees of freedom.
        difference = (arm.block_mean - known.block_mean).sum()
        spread = (arm.block_variance / arm.count + known.block_variance / known.count).sum()
        whole = 2.0 * stats.norm.sf(abs(difference) / math.sqrt(spread))
        expected = min(1.0, 6.0 * min(chi, largest, whole, *channels))
        assert raw.p_value == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("z", [0.7, 1.2, 1.4])
def test_many_small_biases_are_found_by_their_chi_square(z):
    """Blocks by turns too bright and too dark: no block is far off, and no channel."""
    block, sigma = block_size((WIDTH, HEIGHT)), 0.1
    y, x = np.mgrid[:HEIGHT, :WIDTH] // block
    # The luminance of a block has a standard error of sigma / block.
    picture, step = truth(), z * sigma / block * np.where((x + y) % 2, 1.0, -1.0)[..., None]
    arm = exact_statistics(picture + step, np.full(picture.shape, sigma**2))
    raw = compare_with_reference(arm, exact_statistics(picture, None))
    assert raw.test.z_rms == pytest.approx(z, rel=1e-3)
    expected = min(1.0, 6.0 * stats.chi2.sf(54 * z**2, 54))
    assert raw.p_value == pytest.approx(expected, rel=0.03)


def test_a_planted_bias_is_found_with_its_size_and_sign():
    for shift in (-0.08, 0.08):
        raw = one_test(np.random.default_rng(7), shift, own=0.05, reference=0.02)
        assert raw.p_value < 1e-6
        for channel in raw.test.difference:
            # Relative to the reference, whatever the brightness.
            assert channel.low < shift < channel.high
            assert abs(channel.value) > 5.0 * (channel.high - channel.low) / 3.92


def test_differences_of_channels_are_relative_to_the_reference():
    """0.25 against 0.5 is -50 %, not +100 %; the width scales with both noises."""
    one = exact_statistics(np.full((8, 8, 3), 0.25, np.float32), np.full((8, 8, 3), 9e-4))
    two = exact_statistics(np.full((8, 8, 3), 0.50, np.float32), np.full((8, 8, 3), 16e-4))
    for a, b, value in ((one, two, -0.5), (two, one, 1.0)):
        found = compare_with_reference(a, b).test.difference
        width = 1.959964 * 0.05 / 8.0 / float(b.channel_mean[0])
        for channel in found:
            assert channel == pytest.approx((value, value - width, value + width), rel=1e-3)


@pytest.mark.parametrize(("counts", "sigmas"), [((3, 20), (0.4, 0.1)), ((20, 3), (0.4, 0.1))])
def test_intervals_of_channels_are_welchs(counts, sigmas):
    """Of few and many pictures, of which one kind is noisier."""
    rng = np.random.default_rng(17)
    rows = [
        np.stack([block_row(one) for one in seeds(rng, n, truth(), sigma, shared=False)])
        for n, sigma in zip(counts, sigmas, strict=True)
    ]
    sides = [BlockMoments.of(side, (WIDTH, HEIGHT)).statistics for side in rows]
    found = compare_with_reference(*sides).test.difference
    arm, reference = (side[:, :3] for side in rows)
    interval = stats.ttest_ind(arm, reference, equal_var=False).confidence_interval(0.95)
    widths = (interval.high - interval.low) / reference.mean(axis=0)
    # Degrees of freedom are told to two digits.
    assert [one.high - one.low for one in found] == pytest.approx(widths, rel=0.03)


def test_blocks_of_the_arm_may_be_larger_than_the_references():
    rng = np.random.default_rng(8)
    picture = truth()
    reference = exact_statistics(picture.astype(np.float32), np.full(picture.shape, 1e-4))
    rows = [block_row(one) for one in seeds(rng, 8, picture, 0.1)]
    arm = BlockMoments.of(rows, (WIDTH, HEIGHT)).statistics
    larger = joined_statistics(arm, 2 * arm.block)
    raw = compare_with_reference(larger, reference)
    # So few blocks do not tell how skewed they are: four become one.
    assert (raw.test.block, raw.test.blocks) == (4 * arm.block, 4)
    assert 0.5 < raw.test.z_rms < 1.5


def test_verdicts_are_at_one_percent_over_the_arms():
    raw = one_test(np.random.default_rng(9))
    tests = [type(raw)(raw.test, p) for p in (0.002, 0.004, 0.03, 0.9)]
    verdicts = [one.verdict for one in judge(tests, [False, False, False, False])]
    assert verdicts == [BIASED, UNBIASED, UNBIASED, UNBIASED]
    verdicts = [one.verdict for one in judge(tests, [True, True, False, True])]
    assert verdicts == [DIFFERENT, UNBIASED, UNBIASED, UNBIASED]
    for p, verdict in ((0.0099, BIASED), (0.0101, UNBIASED)):
        assert judge([type(raw)(raw.test, p)], [False])[0].verdict == verdict


# ---------------------------------------------------------------------------- bias and variance


@pytest.mark.parametrize("bias", [0.0, 0.2])
@pytest.mark.parametrize("noisy_reference", [False, True])
def test_bias_and_variance_are_unbiased_and_the_interval_is_as_wide_as_the_estimate_varies(
    bias, noisy_reference
):
    """Channels err together, as paths do; the spread is that of 600 studies."""
    rng, picture, found = np.random.default_rng(10), truth(8, 8), []
    own, reference = 0.15, 0.05 * noisy_reference
    for _ in range(600):
        moments = Moments()
        for one in seeds(rng, 5, picture + bias, own):
            moments.add(one)
        noisy = seeds(rng, 1, picture, reference)[0]
        known = np.full(picture.shape, reference**2) if noisy_reference else None
        found.append(decompose(moments, noisy, known))
    values = np.array([one.bias2.value for one in found])
    error = values.std() / math.sqrt(600)
    assert values.mean() == pytest.approx(bias**2, abs=4.0 * error)
    assert np.mean([one.variance for one in found]) == pytest.approx(own**2, rel=0.02)
    widths = np.array([(one.bias2.high - one.bias2.low) / 3.92 for one in found])
    # A deviation of 600 numbers is right to 3 %; the noise's own estimate makes it a little larger.
    assert widths.mean() == pytest.approx(values.std(), rel=0.15)
    assert all(one.bias2.high - one.bias2.value == pytest.approx(
        one.bias2.value - one.bias2.low) for one in found)  # fmt: skip
    held = sum(one.bias2.low <= bias**2 <= one.bias2.high for one in found)
    assert 0.91 <= held / 600 <= 0.985


def test_units_and_sizes_of_the_bias():
    rng, picture = np.random.default_rng(11), truth(8, 8)
    pictures = seeds(rng, 4, picture + 0.1, 0.1).astype(np.float64)
    parts = []
    for scale, times in ((1.0, 1), (2.0, 1), (1.0, 2)):
        moments = Moments()
        for one in pictures:
            moments.add(scale * np.tile(one, (times, times, 1)))
        reference = scale * np.tile(picture, (times, times, 1))
        parts.append(decompose(moments, reference, np.full(reference.shape, scale**2 * 1e-3)))
    one, brighter, larger = ([*part.bias2, part.variance] for part in parts)
    assert brighter == pytest.approx([4.0 * v for v in one])
    assert (larger[0], larger[3]) == pytest.approx((one[0], one[3]))
    # Four times the pixels, half the width.
    assert larger[2] - larger[1] == pytest.approx((one[2] - one[1]) / 2.0)


@pytest.mark.parametrize("count", [2, 4, 16])
def test_the_spread_of_a_reference_is_how_its_noise_moves_every_error(count):
    """What is left of its squared error when the noise that it says it has is subtracted."""
    rng, size = np.random.default_rng(count), (8, 6)
    sigma = 0.1 + 0.2 * rng.random((*size, 1)) * np.ones(3)
    errors = rng.standard_normal((6000, count, *size, 1)) * sigma[..., :1]
    noise = errors.var(axis=1, ddof=1) / count
    left = (errors.mean(axis=1) ** 2 - noise).mean(axis=(1, 2, 3))
    found = reference_spread(sigma**2 / count, count)
    # The variance of 6000 numbers is right to 2 to 3 %.
    assert found == pytest.approx(left.var(), rel=0.1)
    assert reference_spread(4.0 * sigma**2 / count, count) == pytest.approx(16.0 * found)
    # Over what a variance that is known exactly would give: 1 + 1 over its degrees of freedom.
    exact = reference_spread(sigma**2, math.inf)
    for blocks in (2, 3, 5, 16):
        assert reference_spread(sigma**2, blocks) / exact == pytest.approx(1.0 + 1.0 / (blocks - 1))


# ---------------------------------------------------------------------------- figures


def test_figures_subtract_the_references_noise_pixel_by_pixel():
    rng = np.random.default_rng(12)
    image = rng.random((9, 7, 3)).astype(np.float32)
    # Noise where it is dark: its mean over that of the weights would be another number.
    noise = 0.05 * (1.0 - image.astype(np.float64)) ** 4
    picture = (image + rng.normal(0.0, 0.2, image.shape)).astype(np.float32)
    found = Figures(image, noise).of(picture)
    assert found["mse"] == pytest.approx(mse(picture, image) - noise.mean(), rel=1e-5)
    for name, epsilon in (("relmse", None), ("relmse_literature", 0.01)):
        expected = relmse(picture, image, epsilon=epsilon, reference_variance=noise)
        assert found[name] == pytest.approx(expected, rel=1e-4)
    # The picture has negative pixels, as filters make them.
    assert picture.min() < -0.1
    assert found["smape"] == pytest.approx(smape(picture, image), rel=1e-5)
    assert Figures(picture, noise).of(image)["relmse"] != pytest.approx(found["relmse"], rel=0.05)


def test_a_black_reference_has_errors():
    found = Figures(np.zeros((4, 4, 3), np.float32), np.zeros((4, 4, 3)))
    assert found.of(np.zeros((4, 4, 3), np.float32))["relmse"] == 0.0
    assert math.isfinite(found.of(np.ones((4, 4, 3), np.float32))["relmse"])


def test_flip_of_the_figures_is_that_of_a_display():
    if flip.missing():
        pytest.skip("flip-evaluator is not installed")
    image = truth(24, 16).astype(np.float32)
    picture = (2.0 * image**1.5).astype(np.float32)
    figures = Figures(image, np.zeros(image.shape))
    assert figures.of(picture)["flip"] is None
    found = figures.of(picture, slow=True)["flip"]
    assert found == flip.flip(picture, image, "ldr").mean
    assert found != pytest.approx(flip.flip(picture, image, "hdr").mean, rel=0.01)
