"""Errors in equal times: between numbers of samples that samplers are made for."""

from itertools import islice, pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from alight.core.registry import Models
from alight.lab.arm_plan import Plan
from alight.lab.statistics.equal_time import (
    AtTime,
    Bracket,
    bracket,
    compared,
    is_natural,
    natural_counts,
    product,
)
from alight.lab.statistics.intervals import bootstrap_ratio, log_ratio
from alight.samplers.sobol import Sobol
from alight.samplers.state import sampler_state
from alight.samplers.stratified import Stratified

SAMPLERS = [example for module in Models("samplers").values() for example in module.EXAMPLES]
COUNT = 16


def _name(spec):
    return f"{spec.type_name()}-{spec.block}"


@pytest.mark.parametrize("spec", SAMPLERS, ids=_name)
def test_a_block_is_one_whole(spec):
    """Its numbers fill as many equal intervals, each once; twice the block fills them twice."""
    parameters = spec.model_dump(exclude={"type"})
    get_1d, _ = Models("samplers")[spec.type_name()].make_kernels(*parameters.values())
    for doubled in (1, 2, 4):
        index = np.arange(doubled * spec.block, dtype=np.uint32)
        zero = np.zeros_like(index)
        with np.errstate(over="ignore"):
            u = get_1d(sampler_state(zero + 3, zero + 5, index, zero, zero + 7), zero + 9)
        counts = np.bincount((u * spec.block).astype(int), minlength=spec.block)
        assert (counts == doubled).all()


@pytest.mark.parametrize("replicates", [1, 3, 4])
@pytest.mark.parametrize("spec", SAMPLERS, ids=_name)
def test_natural_counts_are_doubled_blocks_of_every_replicate(spec, replicates):
    whole = spec.block * replicates
    counts = list(islice(natural_counts(spec, replicates), 40))
    assert counts == sorted(set(counts))
    assert counts[0] == 1
    first = counts.index(whole)
    assert counts[first:] == [whole << k for k in range(len(counts) - first)]
    # Below, random points: any number will do, and twice is near enough.
    assert all(b <= 2 * a for a, b in pairwise(counts))


@pytest.mark.parametrize("replicates", [1, 4])
@pytest.mark.parametrize("spec", [Sobol(), Stratified(strata=7)], ids=_name)
def test_a_bracket_holds_the_wanted_number(spec, replicates):
    for wanted in np.geomspace(1.01, 5000.0, 400):
        found = bracket(wanted, spec, replicates)
        assert is_natural(found.low, spec, replicates)
        counts = natural_counts(spec, replicates)
        assert next(n for n in counts if n > found.low) == found.high
        # A little beyond is cheaper than twice the samples.
        assert found.low <= wanted <= 1.05 * found.high
        assert not found.low <= wanted <= found.low * 1.05 or found.low == 1
        nearest = min((found.low, found.high), key=lambda n: abs(np.log(n / wanted)))
        assert found.shown == nearest
    assert bracket(0.3, spec, replicates) == Bracket(1, 1, 1)


def test_the_command_line_s_default_is_natural_for_the_default_sampler():
    assert [n for n in range(40, 80) if is_natural(n, Sobol(), 4)] == [64]


def _figures(counts, error, rate, noise=0.0, seed=0):
    """Replicates whose mean squared errors and seconds follow these laws, with relative noise."""
    rng = np.random.default_rng(seed)
    # The time of a replicate is long or short as a whole; errors of one picture are akin.
    slow, bad = np.exp(noise * rng.standard_normal((2, COUNT, 1)))
    bad = bad * np.exp(0.3 * noise * rng.standard_normal((COUNT, len(counts))))
    return {
        n: {"mse": error(n) * bad[:, k], "seconds": n * rate * slow[:, 0]}
        for k, n in enumerate(counts)
    }


def test_a_power_law_is_met_exactly():
    where = bracket(47.0, Sobol(), 4)
    figures = _figures((where.low, where.high), lambda n: 5.0 * n**-1.3, 0.01)
    at = AtTime.of(figures, where, 0.47)
    assert at.spp == 47
    assert at.slope == pytest.approx(-1.3)
    assert at.statistic("mse").value == pytest.approx(np.log(5.0 * 47**-1.3))
    assert at.sensitivity == pytest.approx(
        (1 - at.weight) * 32**1.3 / 5.0 + at.weight * 64**1.3 / 5.0
    )
    assert (figures[32]["mse"] >= at.linear("mse")).all()
    assert (at.linear("mse") >= figures[64]["mse"]).all()


@pytest.mark.parametrize("base_spp", [64, 50])
def test_a_speed_up_is_the_ratio_of_errors_in_one_time(base_spp):
    """An arm twice as fast, with errors that fall faster; the baseline at a round number or not."""
    own = Bracket.at(64) if base_spp == 64 else bracket(50.0, Sobol(), 4)
    base = _figures({own.low, own.high, base_spp}, lambda n: 2.0 * n**-1.2, 0.02)
    clock = base[base_spp]["seconds"]
    where = bracket(2.0 * base_spp, Sobol(), 4)
    other = _figures({where.low, where.high}, lambda n: 7.0 * n**-1.7, 0.01)
    seconds = float(clock.mean())
    above, below = compared(AtTime.of(base, own, seconds), clock, AtTime.of(other, where, seconds))
    expected = 2.0 * base_spp**-1.2 / (7.0 * (2 * base_spp) ** -1.7)
    found = log_ratio(product(above), product(below)).estimate.value
    assert found == pytest.approx(expected)


def test_without_a_time_between_efficiencies_are_compared():
    base = _figures((64,), lambda n: 0.1, 0.02)
    other = _figures((64,), lambda n: 0.05, 0.03)
    at = Bracket.at(64)
    above, below = compared(
        AtTime.of(base, at, 0.0), base[64]["seconds"], AtTime.of(other, at, 0.0)
    )
    found = log_ratio(product(above), product(below)).estimate.value
    assert found == pytest.approx(0.1 * 0.02 / (0.05 * 0.03))


@pytest.mark.parametrize(
    ("times", "seconds", "expected"),
    [
        ({32: 1.0, 64: 2.0}, 1.4, (32, 64)),
        # A little beyond.
        ({32: 1.0, 64: 2.0}, 2.2, (32, 64)),
        ({32: 1.0, 64: 2.0}, 0.9, (32, 64)),
        # The pilot was wrong.
        ({32: 1.0, 64: 2.0}, 3.5, (64, 64)),
        ({32: 1.0, 64: 2.0}, 0.5, (32, 32)),
        # An arm that has enough long before.
        ({32: 1.0, 64: 1.01}, 1.2, (64, 64)),
        ({32: 1.0, 64: 0.99}, 0.9, (32, 32)),
    ],
)
def test_where_there_is_nothing_to_interpolate_over(times, seconds, expected):
    figures = {n: {"seconds": np.full(COUNT, t), "mse": np.ones(COUNT)} for n, t in times.items()}
    found = AtTime.of(figures, Bracket(32, 64, 64), seconds)
    assert (found.bracket.low, found.bracket.high) == expected
    assert found.seconds == (times[expected[0]] if found.is_single else seconds)


def _sobol(n):
    """The error of a sequence that is worse by half between powers of two."""
    return n**-1.5 * (1.0 if n & (n - 1) == 0 else 1.5)


def _null(seed, natural=True, noise=0.1):
    """Both sides of a comparison of two arms that differ in nothing, and whether they are equal."""
    base = _figures((32, 64), _sobol, 0.01, noise, 2 * seed)
    # The pilot thinks that the arm is a little faster or slower.
    rate = np.exp(0.05 * np.random.default_rng(seed).standard_normal())
    where = bracket(64.0 * rate, Sobol(), 4) if natural else Bracket.at(round(64.0 * rate))
    other = _figures((where.low, where.high), _sobol, 0.01, noise, 2 * seed + 1)
    clock = base[64]["seconds"]
    at = AtTime.of(other, where, float(clock.mean()))
    return compared(AtTime.of(base, Bracket.at(64), 0.0), clock, at)


def test_identical_arms_differ_at_the_level():
    """p-values are uniform, and intervals hold 1 as often as they say, with noise of both kinds."""
    p_values, missed = [], np.zeros(2)
    for seed in range(1, 601, 2):
        above, below = _null(seed)
        found = log_ratio(product(above), product(below))
        p_values.append(found.p_value)
        missed[0] += not found.estimate.low <= 1.0 <= found.estimate.high
        if seed % 6 == 1:
            (upper, a), (lower, b) = (zip(*side, strict=True) for side in (above, below))
            boot = bootstrap_ratio(upper, lower, seed, powers=(a, b))
            missed[1] += 3 * (not boot.low <= 1.0 <= boot.high)
    assert stats.kstest(p_values, "uniform").pvalue > 0.01
    # Three standard errors of a share of 300, and of 100.
    assert abs(missed[0] / 300 - 0.05) < 0.038
    assert abs(missed[1] / 300 - 0.05) < 0.066


def test_any_number_of_samples_would_make_equal_arms_differ():
    """Why there are brackets: the same arms, at whatever number fits the time."""
    false = 0
    for seed in range(1, 61, 2):
        above, below = _null(seed, natural=False, noise=0.05)
        false += log_ratio(product(above), product(below)).p_value < 0.05
    assert false > 20


@pytest.mark.parametrize("times", [(100,), (5, 300)])
def test_arms_that_are_timed_stop_at_the_same_steps_up_to_their_last(times):
    arm = SimpleNamespace(spec=SimpleNamespace(options={}))
    brackets = tuple(Bracket.at(spp) for spp in times)
    ladder = Plan(arm, "arm", (16, 64), brackets, None, False).ladder
    last = max(64, *times)
    assert {2**k for k in range(3, 12) if 2**k <= last} | {16, 64, *times} == set(ladder)
    assert list(ladder) == sorted(ladder)
    assert Plan(arm, "arm", (16, 64), (), None, False).ladder == (16, 64)
