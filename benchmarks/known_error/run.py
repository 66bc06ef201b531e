"""The campaigns behind docs/known-error.md, in one command.

python benchmarks/known_error/run.py [--only coverage,bias,gain,plan,replicates] [--runs 1000]
    [--truth 7600] [--scenes cornell-box,...] [--save FILE]

``coverage`` prints, scene by scene, how often the 95 % interval held the true error at three
numbers of samples (with the exact binomial p-values of coverage below 93 % and above 98 %), how
often the stop rule said ``met``, how often that was true, and at how many times the samples of an
oracle. ``bias`` is the mean of adaptive pictures and of Cycles' rule where bright samples are rare,
``gain`` adaptive against even pictures at equal processor time, ``plan`` how often a predicted cost
was right, ``replicates`` what independent scrambles cost.
"""

from __future__ import annotations

import argparse
import collections
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import steered
from intervals import CHECKED, mean_error, run_once
from scenes import ORDINARY, TEXTS, UNEVEN, Runner
from truth import Truth


def binomial_tail(hits: int, runs: int, p: float, upper: bool) -> float:
    """P(X >= hits) or P(X <= hits) of a binomial distribution."""
    terms = range(hits, runs + 1) if upper else range(hits + 1)
    log_p, log_q = math.log(p), math.log1p(-p)
    return math.fsum(
        math.exp(
            math.lgamma(runs + 1) - math.lgamma(k + 1) - math.lgamma(runs - k + 1)
            + k * log_p + (runs - k) * log_q
        )
        for k in terms
    )  # fmt: skip


def report(name: str, results: list[dict[str, Any]]) -> None:
    """Print the line of one scene."""
    runs = len(results)
    for spp, hits in zip(CHECKED, np.sum([r["within"] for r in results], axis=0), strict=True):
        low = binomial_tail(int(hits), runs, 0.93, upper=False)
        high = binomial_tail(int(hits), runs, 0.98, upper=True)
        print(f"{name}: interval at {spp} spp {hits / runs:.1%} (p {low:.2g} and {high:.2g})")
    words = collections.Counter(r["word"] for r in results)
    met = [r for r in results if r["word"] == "met"]
    kept = sum(r["true"] <= r["asked"] for r in met)
    waste = np.mean([r["spp"] / r["oracle"] for r in met]) if met else math.nan
    energy = [r["energy"] for r in results]
    error = np.std(energy) / math.sqrt(runs)
    print(
        f"{name}: {dict(words)}, kept {kept} of {len(met)}, {waste:.2f} times the oracle's spp, "
        f"energy {np.mean(energy) - 1.0:+.3%} +- {error:.3%}",
        flush=True,
    )


def main() -> None:
    """Run all scenes, each until its runs are done."""
    parser = argparse.ArgumentParser(description="Campaigns on a picture's known error.")
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--truth", type=int, default=100 * CHECKED[-1])
    parser.add_argument("--scenes", default=",".join(TEXTS))
    parser.add_argument("--only", default="coverage,bias,gain,plan,replicates")
    parser.add_argument("--save", type=Path, help="JSON lines, one a run of coverage")
    options = parser.parse_args()
    only, names = options.only.split(","), options.scenes.split(",")
    if "coverage" in only:
        coverage(names, options.runs, options.truth, options.save)
    if "bias" in only:
        steered.bias(min(options.runs, 300))
    if "gain" in only:
        steered.gain(UNEVEN, min(options.runs, 12), options.truth)
    if "plan" in only:
        steered.plans(ORDINARY, min(options.runs, 50))
    if "replicates" in only:
        steered.replicates(("cornell-box", "environment"), min(options.runs, 16), options.truth)


def coverage(names: Sequence[str], runs: int, truth_spp: int, save: Path | None) -> None:
    """Intervals and promises of all scenes, a batch of each in turn."""
    made = {}
    for name in names:
        runner = Runner(name)
        truth = Truth(runner, truth_spp)
        made[name] = runner, truth, mean_error(runner, truth, range(500_000, 500_004))
    results: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    for seed in range(1000, 1000 + runs):
        for name, (runner, truth, curve) in made.items():
            results[name].append(run_once(runner, truth, curve, name, seed))
            if save:
                with save.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(results[name][-1]) + "\n")
    for name, found in results.items():
        report(name, found)
    met = [r for n in names if n in ORDINARY for r in results[n] if r["word"] == "met"]
    if met:
        kept = sum(r["true"] <= r["asked"] for r in met)
        print(f"ordinary scenes: kept {kept} of {len(met)} met")


if __name__ == "__main__":
    main()
