"""Campaigns on one picture's error: whether the interval holds it and the promise is kept.

One run gives both: samples are added look by look; the interval is compared with the true error at
three of the looks, and the stop rule, asked for an error that the mean picture reaches somewhere
between two looks, says when it would have stopped.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scenes import ORDINARY, REPLICATES, Runner
from truth import Truth

from alight.metrics.own_error import estimate_relmse
from alight.rendering.schedules.stopping import Promise, first_look, judge_means, next_look, word_of

#: Samples per pixel at which intervals are compared with the truth: three of the looks.
CHECKED = (36, 48, 76)

#: Between these the oracle, who knows the truth, would stop: log-uniform.
ORACLE = (30.0, 52.0)

#: The largest budget of a run, in looks.
LOOKS = 9


def looks() -> list[int]:
    """Samples per pixel at the looks of one run."""
    result = [first_look(REPLICATES)]
    while len(result) < LOOKS:
        result.append(next_look(result[-1], REPLICATES))
    return [spp for spp in result if spp <= CHECKED[-1]]


def mean_error(runner: Runner, truth: Truth, seeds: range) -> np.ndarray:
    """Root of the mean relMSE at each look, from pictures that are not in the campaign."""
    return np.sqrt([
        np.mean([truth.relmse(runner.means(seed, spp).mean(axis=2)) for seed in seeds])
        for spp in looks()
    ])  # fmt: skip


def run_once(
    runner: Runner, truth: Truth, curve: np.ndarray, name: str, seed: int
) -> dict[str, Any]:
    """One picture: its intervals, and where the stop rule ends it."""
    rng = np.random.default_rng(seed)
    oracle = float(np.exp(rng.uniform(*np.log(ORACLE))))
    # Error against samples is a straight line in logarithms between two looks.
    asked = float(np.exp(np.interp(np.log(oracle), np.log(looks()), np.log(curve + 1e-300))))
    asked = max(asked, 1e-4)
    result: dict[str, Any] = {"scene": name, "asked": asked, "oracle": oracle, "word": ""}
    sums, first, true, within = 0.0, 0, 0.0, []
    for spp in looks():
        sums, first = sums + runner.sums(seed, first, spp - first), spp
        means = (sums / (spp / REPLICATES)).astype(np.float32)
        counts = np.full(means.shape[:3], spp // REPLICATES)
        true = truth.relrmse(means.mean(axis=2, dtype=np.float64))
        if spp in CHECKED:
            low, high = estimate_relmse(means, counts).relrmse[1:]
            within.append(bool(low <= true <= high))
        # A look that is certain to say "go on" is not worth its time.
        if not result["word"] and (name not in ORDINARY or true < 1.3 * asked):
            judgement = judge_means(means, counts, Promise(asked))
            if judgement.met or spp == looks()[-1]:
                result |= {"word": word_of(judgement), "spp": spp, "true": true}
                result |= {"energy": float(means.mean(dtype=np.float64) / truth.mean.mean())}
    if not result["word"]:
        result |= {"word": "not met", "spp": first, "true": true, "energy": 1.0}
    return result | {"within": within}
