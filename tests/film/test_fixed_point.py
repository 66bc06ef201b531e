"""Fixed-point sums against Python's fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alight.films import fixed_point
from alight.films.fixed_point import MAX_SAMPLES, carry, split, to_float, to_limbs, total
from alight.films.statistics import pixel_mean

UNIT = Fraction(1, 2**48)


def exact(limbs):
    """The value that limbs stand for."""
    return Fraction(int(limbs[0]), 2**8) + int(limbs[1]) * UNIT


def nearest_multiple(value):
    """The multiple of 2^-48 nearest to a float, ties to even (as Python rounds fractions)."""
    return round(Fraction(float(value)) / UNIT) * UNIT


floats = st.floats(-(2.0**36), 2.0**36, width=32)


@given(st.lists(floats, min_size=1, max_size=50))
def test_a_sample_is_rounded_to_the_nearest_multiple_of_the_resolution(values):
    sums, invalid, saturated = to_limbs(np.array(values, np.float32))
    assert [exact(s) for s in sums] == [nearest_multiple(v) for v in values]
    assert not invalid.any()
    assert not saturated.any()


@pytest.mark.parametrize(
    ("value", "units"),
    [
        (2.0**-49, 0),  # ties go to the even unit
        (3 * 2.0**-49, 2),
        (5 * 2.0**-49, 2),
        (-(2.0**-49), 0),
        (-3 * 2.0**-49, -2),
        (-(2.0**-48), -1),
        (2.0**-50, 0),
        (1e-40, 0),
    ],
)
def test_rounding_of_the_smallest_values_is_to_nearest_even(value, units):
    sums, _, _ = to_limbs(np.array([value], np.float32))
    assert exact(sums[0]) == units * UNIT


def test_values_of_at_least_2_to_the_minus_25_are_kept_exactly():
    rng = np.random.default_rng(1)
    exponents = rng.integers(-25, 36, 20_000)
    values = np.ldexp(rng.uniform(0.5, 1, 20_000) * 2, exponents).astype(np.float32)
    values = np.minimum(values, np.float32(2.0**36)) * rng.choice([-1, 1], 20_000)
    values = values.astype(np.float32)
    sums, _, _ = to_limbs(values)
    assert all(exact(s) == Fraction(float(v)) for s, v in zip(sums, values, strict=True))


@given(st.lists(floats, min_size=1, max_size=40), st.randoms())
def test_sums_do_not_depend_on_order_or_grouping(values, random):
    limbs, _, _ = to_limbs(np.array(values, np.float32))
    forwards = limbs.sum(axis=0)
    carry(forwards)
    order = list(range(len(values)))
    random.shuffle(order)
    cut = random.randrange(len(values) + 1)
    parts = [limbs[order[:cut]].sum(axis=0), limbs[order[cut:]].sum(axis=0)]
    for part in parts:
        carry(part)
    grouped = parts[0] + parts[1]
    carry(grouped)
    assert (forwards == grouped).all()
    assert exact(forwards) == sum((nearest_multiple(v) for v in values), Fraction(0))


@given(st.integers(-(2**60), 2**60), st.integers(-(2**62), 2**62))
def test_the_canonical_form_is_unique_and_keeps_the_value(hi, lo):
    sums = np.array([hi, lo], np.int64)
    before = exact(sums)
    carry(sums)
    assert exact(sums) == before
    assert 0 <= sums[1] < 2**40


@given(st.integers(-(2**62), 2**62), st.integers(0, 2**40 - 1))
def test_to_float_is_within_two_units_in_the_last_place(hi, lo):
    sums = np.array([hi, lo], np.int64)
    value, truth = float(to_float(sums)), exact(sums)
    assert abs(Fraction(value) - truth) <= 2 * Fraction(float(np.spacing(abs(float(truth)))))


@given(st.lists(st.tuples(st.integers(-(2**63), 2**63 - 1), st.integers(0, 2**40 - 1)), max_size=8))
def test_total_holds_sums_that_an_int64_would_not(rows):
    sums = np.array(rows, np.int64).reshape(-1, 2)
    value, truth = float(total(sums, axis=0)), sum((exact(s) for s in sums), Fraction(0))
    assert abs(Fraction(value) - truth) <= 3 * Fraction(float(np.spacing(abs(float(truth)))))


def test_nan_and_infinity_add_nothing_and_are_counted():
    sums, invalid, saturated = to_limbs(np.array([np.nan, np.inf, -np.inf, 1.0], np.float32))
    assert invalid.tolist() == [True, True, True, False]
    assert not saturated.any()
    assert [exact(s) for s in sums] == [0, 0, 0, 1]


def test_values_beyond_the_range_saturate_and_are_counted():
    limit = np.float32(2.0**36)
    values = np.array([limit, np.nextafter(limit, np.float32(np.inf)), -1e30, -limit], np.float32)
    sums, invalid, saturated = to_limbs(values)
    assert saturated.tolist() == [False, True, True, False]
    assert not invalid.any()
    assert [exact(s) for s in sums] == [2**36, 2**36, -(2**36), -(2**36)]


def test_the_kernel_gives_whole_numbers_in_float32():
    rng = np.random.default_rng(2)
    values = (rng.normal(size=1000) * 10.0 ** rng.integers(-12, 10, 1000)).astype(np.float32)
    limbs = split(values)
    for limb in (limbs.hi, limbs.lo):
        assert limb.dtype == np.float32
        assert (limb == np.rint(limb)).all()


def test_full_range_samples_fit_into_the_limbs():
    top = 2**44 * fixed_point.MAX_SAMPLES + fixed_point.MAX_SAMPLES
    assert top < 2**63 <= 2**44 * (fixed_point.MAX_SAMPLES + 1)


@pytest.mark.parametrize("samples", [MAX_SAMPLES // 4, MAX_SAMPLES])
def test_the_mean_of_a_pixel_is_the_exact_total_over_its_samples(samples):
    """Sums as large as so many samples can make them, of both signs, in 4 replicates."""
    rng = np.random.default_rng(samples)
    sums = np.zeros((7, 9, 4, 3, 2), np.int64)
    sums[..., 0] = rng.integers(-(2**44), 2**44, sums.shape[:-1]) * samples
    sums[0, :, :, :, 0] = 2**44 * samples
    sums[1, :, :, :, 0] = -(2**44) * samples
    sums[2, :, :, :, 0] = rng.integers(-1, 2, sums.shape[1:-1])
    sums[..., 1] = rng.integers(0, 2**40, sums.shape[:-1])
    counts = np.full(sums.shape[:3], samples)
    mean = pixel_mean(sums, counts)
    for at in np.ndindex(7, 9, 3):
        parts = sums[at[0], at[1], :, at[2]].tolist()
        whole = Fraction(sum(hi * 2**40 + lo for hi, lo in parts), 2**48 * 4 * samples)
        assert mean[at] == pytest.approx(float(whole), rel=1e-15)
    np.testing.assert_array_equal(mean, total(sums, 2) / (4 * samples))
