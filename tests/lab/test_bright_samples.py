"""Advice that a few bright samples would decide is none."""

from types import SimpleNamespace

import numpy as np
import pytest

from alight.lab.statistics.intervals import log_mean
from alight.lab.why import trials
from alight.lab.why.bright_samples import FEW, Squares, decided, squares_of
from alight.lab.why.trials import BATCHES, LEVEL, try_alternatives
from alight.lab.why.words import trial_lines

#: The alternative.
OTHER = SimpleNamespace(integrator=None)


def spiky(rng, rate):
    """Renders pictures of even noise, a sample in `rate` of which is a million times as bright."""

    def of(seed, spp, replicates):
        sums = rng.normal(spp / replicates, 1.0, (8, 8, replicates, 1)).repeat(3, axis=3)
        sparks = rng.poisson(spp / replicates * rate, (8, 8, replicates, 1))
        return np.abs(sums) + 1e6 * sparks

    return SimpleNamespace(of=of, scene=None)


def zero(_):
    return 0.0


def knows_nothing(monkeypatch):
    """Paths from the lamps have found no rare light."""
    monkeypatch.setattr(trials, "_small", lambda scene: scene)
    monkeypatch.setattr(trials, "rare_noises", lambda _, own, others, __: [0.0, *map(zero, others)])


def tried(monkeypatch, own, other):
    monkeypatch.setattr(trials, "alternatives", lambda scene, cause: {"a=b": OTHER})
    monkeypatch.setattr(trials, "_sums_of", lambda scene: other if scene is OTHER else own)
    knows_nothing(monkeypatch)
    ((trial,), _) = try_alternatives("own")
    return trial


def test_sparks_that_one_arm_has_not_met_by_chance_are_no_advice(monkeypatch):
    """Both arms are the same: two of a trial's million samples are bright."""
    rng, times, rate = np.random.default_rng(1), 80, 2.0 / (64 * 8 * 64)
    # The pilot takes its share of the seeds, not of the sparks.
    found = [tried(monkeypatch, spiky(rng, rate), spiky(rng, rate)) for _ in range(times)]
    assert sum(trial.p_value < trials.LEVEL for trial in found) <= trials.LEVEL * times
    words = [next(iter(trial_lines([trial], []))) for trial in found if trial.bright]
    assert words


def test_many_sparks_are_advice(monkeypatch):
    rng, rate = np.random.default_rng(2), 40.0 / (64 * 8 * 64)
    assert tried(monkeypatch, spiky(rng, rate), spiky(rng, 0.0)).helps


def test_a_bright_sample_is_one():
    sums = np.zeros((4, 4, 8, 3))
    sums[1, 2, 3] = 5.0
    batch = squares_of(sums, np.full((4, 4, 3), 2.0))
    assert batch.total == pytest.approx(2.0 * 3 * 5.0**2 * (1.0 - 1.0 / 8.0))
    assert decided([batch], [batch]).samples == 2


def test_what_few_samples_decide_is_a_binomial_tail():
    quiet, loud = Squares(np.array([1e-9]), 1e-9), Squares(np.full(5, 1.0), 5.0)
    assert decided([loud], [quiet]) == (5, 2 / 32)
    assert decided([quiet], [loud]) == (5, 2 / 32)
    assert decided([loud], [loud]).p_value == 1.0
    # Three batches of one, and all sparks in them: no wonder.
    assert decided([loud, quiet, quiet], [quiet]) == (5, 2 * 0.75**5)
    even = Squares(np.full(FEW, 1.0), 10.0 * FEW)
    assert decided([even], [loud]) == (0, 0.0)
    assert decided([Squares(np.zeros(3), 0.0)] * 2, [Squares(np.zeros(3), 0.0)]) == (0, 0.0)


def test_what_a_later_trial_has_met_counts_in_the_first(monkeypatch):
    # Twelve sparks of the first alternative; the scene as it is meets as many, but in the second.
    quiet = [Squares(np.full(64, 1e-9), 1e-7)] * BATCHES
    sparks = [Squares(np.ones(2), 2.0)] * 6 + quiet[:2]
    own, other = iter([quiet, sparks]), iter([sparks, quiet])
    jitter = np.linspace(0.99, 1.01, BATCHES)
    few, many = log_mean(jitter), log_mean(100.0 * jitter[::-1])

    def measured(arms, weights, seeds):
        return [(few, few), (many, few)], [next(own), next(other)]

    monkeypatch.setattr(trials, "alternatives", lambda scene, cause: dict.fromkeys("ab", OTHER))
    monkeypatch.setattr(
        trials,
        "_sums_of",
        lambda scene: SimpleNamespace(of=lambda *_: np.ones((1, 1, 1)), scene=None),
    )
    monkeypatch.setattr(trials, "_measured", measured)
    knows_nothing(monkeypatch)
    tried, _ = try_alternatives("own")
    (first,) = [trial for trial in tried if trial.change == "a"]
    # Nine tenths of the noise are 22 of the 24 sparks.
    assert first.p_value > LEVEL and first.bright == 22
