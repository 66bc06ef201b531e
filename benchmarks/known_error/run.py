"""The campaigns behind docs/known-error.md, in one command.

python benchmarks/known_error/run.py [--runs 1000] [--truth 7600] [--scenes cornell-box,...]

Prints, scene by scene, how often the 95 % interval held the true error at three numbers of samples
(with the exact binomial p-values of coverage below 93 % and above 98 %), how often the stop rule
said ``met``, how often that was true, and at how many times the samples of an oracle.
"""

from __future__ import annotations

import argparse
import collections
import math
from typing import Any

import numpy as np
from intervals import CHECKED, mean_error, run_once
from scenes import ORDINARY, TEXTS, Runner, Truth


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
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--truth", type=int, default=100 * CHECKED[-1])
    parser.add_argument("--scenes", default=",".join(TEXTS))
    options = parser.parse_args()
    total = kept = 0
    for name in options.scenes.split(","):
        runner = Runner(name)
        truth = Truth(runner, options.truth)
        curve = mean_error(runner, truth, range(500_000, 500_004))
        results = [
            run_once(runner, truth, curve, name, 1000 + seed) for seed in range(options.runs)
        ]
        report(name, results)
        if name in ORDINARY:
            met = [r for r in results if r["word"] == "met"]
            total, kept = total + len(met), kept + sum(r["true"] <= r["asked"] for r in met)
    if total:
        print(f"ordinary scenes: kept {kept} of {total} met")


if __name__ == "__main__":
    main()
