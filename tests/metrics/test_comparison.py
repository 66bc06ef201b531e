"""The picture comparison passes equal pictures and finds small faults."""

from dataclasses import replace

import numpy as np
import pytest

from alight.metrics import PictureStatistics, compare_pictures
from alight.metrics.comparison import STORED_LUMINANCE


def reference_picture():
    y, x = np.mgrid[0:64, 0:64] / 64
    return np.stack([0.2 + x, 0.3 + 0.5 * y, 0.1 + x * y], axis=-1)


def renders(seed, seeds=32, scale=1.0, spread=1.0):
    """Pictures with skewed noise, as of path tracing: channels of a pixel share their paths."""
    rng = np.random.default_rng(seed)
    noise = rng.gamma(4.0, 0.25, (seeds, 64, 64, 1))
    return reference_picture() * scale * (1 + spread * (noise - 1))


def test_equal_pictures_pass():
    results = [compare_pictures(renders(2 * i), renders(2 * i + 1)) for i in range(8)]
    assert all(result.passed for result in results), [r.reasons for r in results]
    assert results[0].z.shape == (32, 32)
    assert bool(results[0])


def test_pictures_of_different_noise_pass():
    assert compare_pictures(renders(1, seeds=48), renders(2, spread=3.0)).passed


@pytest.mark.parametrize("scale", [1.01, 0.99])
def test_one_percent_more_or_less_light_is_found(scale):
    result = compare_pictures(renders(1), renders(2, scale=scale))
    assert not result.passed
    assert any("mean" in reason for reason in result.reasons)


def test_one_percent_in_one_channel_is_found():
    b = renders(2)
    b[..., 2] *= 1.01
    result = compare_pictures(renders(1), b)
    assert any(reason.startswith("mean B differs") for reason in result.reasons)


def test_a_fault_in_one_block_is_found():
    b = renders(2)
    b[:, 10:12, 20:22] *= 1.6
    result = compare_pictures(renders(1), b)
    assert any("largest |z|" in reason for reason in result.reasons)
    assert np.nanargmax(np.abs(result.z)) == 5 * 32 + 10


@pytest.mark.parametrize("factor", [0.6, 1.7])
def test_a_misstated_variance_is_found(factor):
    a, b = PictureStatistics.of(renders(1)), PictureStatistics.of(renders(2))
    wrong = replace(
        a, block_variance=a.block_variance * factor, channel_variance=a.channel_variance * factor
    )
    right, result = compare_pictures(a, b), compare_pictures(wrong, b)
    assert right.passed
    assert any(reason.startswith("rms(z)") for reason in result.reasons)


def test_faults_that_cancel_in_the_mean_are_found():
    pattern = np.where((np.mgrid[0:64, 0:64] // 2).sum(axis=0) % 2, 1.04, 0.96)[..., None]
    result = compare_pictures(renders(1, spread=0.3), renders(2, spread=0.3) * pattern)
    assert any(reason.startswith("rms(z)") for reason in result.reasons)


def spikes(seed, rate, seeds=12):
    """Pictures in which few pixels meet something bright."""
    rng = np.random.default_rng(seed)
    met = rng.poisson(rate, (seeds, 64, 64, 1)) / rate
    return reference_picture() * (0.9 + 0.1 * met + 0.01 * rng.standard_normal(met.shape))


def test_noise_that_is_skewed_on_one_side_is_judged_on_larger_blocks():
    """Blocks that no spike of the noisy side hit are too dark and too quiet."""
    found = [compare_pictures(spikes(2 * i, 0.003), spikes(2 * i + 1, 3.0)) for i in range(10)]
    # 1 % of 10; three have a probability of 1e-4.
    assert sum(not one.passed for one in found) < 3
    assert min(one.block for one in found) > 2
    assert compare_pictures(spikes(1, 3.0, 32), spikes(2, 3.0, 32)).block == 2


def test_few_seeds_against_many_keep_the_level():
    """Three seeds look calm by chance: Welch's degrees of freedom are then those of the others."""
    failures = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        sides = [1.0 + s * rng.standard_normal((n, 24, 24, 3)) for n, s in ((3, 0.3), (32, 0.1))]
        failures += not compare_pictures(*sides).passed
    # 1 % of 60; five have a probability of 4e-4.
    assert failures < 5


def test_few_seeds_find_a_small_change_of_all_the_light():
    """Three pictures have hardly a spread of their own, but their blocks know their noise."""
    rng = np.random.default_rng(1)
    a, b = 1.0 + 0.2 * rng.standard_normal((2, 3, 48, 48, 1)) * np.ones(3)
    assert compare_pictures(a, b).passed
    # 0.4 % of the whole is 2 % of a pixel's noise: its z is 6.8.
    found = compare_pictures(1.02 * a, b)
    assert [reason.split(" differs")[0] for reason in found.reasons] == ["mean luminance"]


def test_stored_statistics_give_the_same_result(tmp_path):
    a, b = renders(1), renders(2)
    PictureStatistics.of(a).save(tmp_path / "a.npz")
    stored = compare_pictures(PictureStatistics.load(tmp_path / "a.npz"), b)
    direct = compare_pictures(a, b)
    np.testing.assert_array_equal(stored.z, direct.z)
    assert stored.p_values == direct.p_values


def test_black_blocks_are_not_judged_but_light_in_them_is():
    a, b = renders(1), renders(2)
    a[:, :8], b[:, :8] = 0, 0
    result = compare_pictures(a, b)
    assert np.isnan(result.z[:4]).all()
    assert result.passed
    b[:, 0, 0] = 0.5
    assert not compare_pictures(a, b).passed


def test_failures_can_be_looked_at(tmp_path):
    result = compare_pictures(renders(1), renders(2, scale=1.05))
    folder = result.dump(tmp_path / "failed")
    assert {file.name for file in folder.iterdir()} == {"a.npy", "b.npy", "z.npy", "report.txt"}
    assert "1024 blocks of 2x2 pixels: rms(z)" in (folder / "report.txt").read_text()
    assert np.load(folder / "a.npy").shape == (64, 64, 3)


@pytest.mark.parametrize(
    ("pictures", "message"),
    [
        (np.zeros((1, 4, 4, 3)), "S >= 2"),
        (np.zeros((2, 4, 4)), "S >= 2"),
        (np.zeros((2, 5, 4, 3)), "4x5 pixels do not divide"),
        (np.full((2, 4, 4, 3), np.nan), "NaN"),
    ],
)
def test_what_is_no_set_of_pictures_is_refused(pictures, message):
    with pytest.raises(ValueError, match=message):
        PictureStatistics.of(pictures)


def test_different_sizes_are_refused():
    with pytest.raises(ValueError, match="blocks of"):
        compare_pictures(renders(1), renders(2)[:, :32])


def test_pictures_without_noise_are_refused():
    with pytest.raises(ValueError, match="nothing to judge"):
        compare_pictures(np.ones((3, 4, 4, 3)), np.ones((3, 4, 4, 3)))


def test_the_bounds_of_a_report_are_around_one():
    """Of n blocks alike, rms(z) varies by 1 / sqrt(2 n): three times that, on either side."""
    result = compare_pictures(renders(1), renders(2))
    margin = 3.0 / np.sqrt(2.0 * np.isfinite(result.z).sum())
    assert (result.rms_low, result.rms_high) == pytest.approx((1.0 - margin, 1.0 + margin))
    assert f"in [{1.0 - margin:.4f}, {1.0 + margin:.4f}], largest" in result.report()


def test_statistics_of_pictures_are_means_and_unbiased_variances():
    """Of blocks of luminance, and of whole channels."""
    pictures = renders(5, seeds=3)
    found = PictureStatistics.of(pictures, 16)
    channels = pictures.mean(axis=(1, 2))
    blocks = (pictures @ STORED_LUMINANCE).reshape(3, 4, 16, 4, 16).mean(axis=(2, 4))
    assert (found.count, found.block) == (3, 16)
    for name, values in (("channel", channels), ("block", blocks)):
        mean = values.sum(axis=0) / 3
        np.testing.assert_allclose(getattr(found, f"{name}_mean"), mean)
        variance = ((values - mean) ** 2).sum(axis=0) / 2
        np.testing.assert_allclose(getattr(found, f"{name}_variance"), variance)
