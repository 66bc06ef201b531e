"""Intervals of pictures whose pixels share paths: errors that depend on each other."""

import numpy as np

from alight.metrics.own_error import relmse_of
from alight.metrics.shared_paths import SharedPaths
from alight.metrics.survey import survey

REPLICATES, SIZE, SPP = 16, 24, 4


def correlated(rng, modes):
    """Replicate means of a grey picture whose errors are a few patterns of random strength."""
    patterns = rng.normal(size=(modes, SIZE, SIZE, 3)) / np.sqrt(modes)
    strengths = rng.normal(size=(REPLICATES, modes))
    noise = np.einsum("rm,mhwc->hwrc", strengths, patterns)
    return (1.0 + 0.05 * noise).astype(np.float32)


def covered(modes, shares_paths, trials=80):
    """How often the 95 % interval holds the relMSE that the picture has."""
    rng, hits = np.random.default_rng(71), 0
    counts = np.full((SIZE, SIZE, REPLICATES), SPP)
    for _ in range(trials):
        means = correlated(rng, modes)
        true = np.mean((means.mean(axis=2) - 1.0) ** 2) / 1.01
        found = relmse_of(survey(means, counts, shares_paths), literature=False).relmse
        hits += found.low <= true <= found.high
    return hits / trials


def test_the_interval_holds_where_patterns_are_shared():
    # 0.95 less three standard deviations of 80 trials.
    assert covered(20, True) > 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / 80)
    assert covered(20, False) < 0.8


def test_the_spread_is_that_of_the_covariance():
    rng, found, modes = np.random.default_rng(5), [], 12
    weights = rng.uniform(0.5, 2.0, (3, SIZE, SIZE))
    patterns = rng.normal(size=(modes, 3, SIZE, SIZE))
    for _ in range(1600):
        means = np.einsum("rm,mchw->rchw", rng.normal(size=(REPLICATES, modes)), patterns)
        shared = SharedPaths(REPLICATES)
        for rows in (slice(0, 10), slice(10, SIZE)):
            shared.add(means[:, :, rows], weights[:, rows])
        found.append(shared.spread)
    gram = np.einsum("mchw,nchw,chw->mn", patterns, patterns, weights) / REPLICATES
    z = (np.mean(found) - np.sum(gram**2)) / (np.std(found) / np.sqrt(len(found)))
    assert abs(z) < 4.0
    # A mean that is 5 % off would be found.
    assert 0.05 * np.sum(gram**2) > 5.0 * np.std(found) / np.sqrt(len(found))
