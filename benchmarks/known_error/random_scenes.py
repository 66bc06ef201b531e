"""Error bars on random scenes: of pictures, of pixels, and promises, in one command.

python benchmarks/known_error/random_scenes.py --seeds 1-99:2 --save FILE [--kinds room,...]
    [--renders 24] [--truth 8192] [--most 32768] [--sides 32,48,64]
python benchmarks/known_error/random_scenes.py --show FILE

For each scene: how often the 95 % interval of the picture's relMSE held the true one at 4, 16, 64
and 256 spp, the mean estimate over the mean truth with the standard error of this ratio (where few
pictures carry the mean, it is as large as the ratio), the share of the pixels (but the unsure ones)
inside their 95 % bars, and what became of promises, with even samples and with ``--adaptive``, to
the error that the mean picture reaches at a number of samples between 30 and 200. Where the truth's
own error is not small beside the picture's (a handful of rare bright samples), or the brightness
that divides it is in doubt (`truth`), nothing can be compared, and the case is not counted. Lines
are added to FILE as they come, so that a campaign can be stopped and continued. Constants are
chosen on even seeds; odd ones give the verdict.
"""

from __future__ import annotations

import collections
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from resumable import parser_of, run
from scenes import REPLICATES, Runner
from steered import cell_shares
from truth import Truth

from alight.core.errors import AlightError
from alight.lab.random_scenes import KINDS, random_scene
from alight.metrics.own_error import estimate_relmse
from alight.metrics.pixel_bars import pixel_bars
from alight.rendering.job import seed_of_round
from alight.rendering.schedules.adaptive import PILOT_SPP, counts_at
from alight.rendering.schedules.stopping import Promise, first_look, judge_means, next_look, word_of

#: Samples per pixel at which intervals are compared with the truth.
CHECKED = (4, 16, 64, 256)

#: Largest relMSE of the truth, over that of the pictures that are compared with it.
CLEAR = 0.1

#: Between these the oracle, who knows the truth, would stop; and the largest budget over its own.
ORACLE, BUDGET = (30.0, 200.0), 6.0


def looks(most: float) -> list[int]:
    """Samples per pixel at the looks up to a budget."""
    result = [first_look(REPLICATES)]
    while next_look(result[-1], REPLICATES) <= most:
        result.append(next_look(result[-1], REPLICATES))
    return result


def measure(
    seed: int, kind: str, side: int, renders: int, truth_spp: int, most: int
) -> dict[str, Any]:
    """Render one scene again and again, and compare it with the truth."""
    runner = Runner(random_scene(seed, kind, (side, side)))
    truth = Truth(runner, truth_spp, most)
    if not truth.mean.any():
        raise AlightError("black: there is nothing to compare")
    row: dict[str, Any] = {
        "seed": seed, "kind": kind, "side": side, "truth": truth.spp, "doubt": truth.doubt,
        "spp": {}, "promises": [], "adaptive": [],
    }  # fmt: skip
    curve: dict[int, list[float]] = collections.defaultdict(list)
    checks: dict[int, list[list[float]]] = collections.defaultdict(list)
    for render in range(renders):
        sums, first = 0.0, 0
        for spp in CHECKED:
            sums, first = sums + runner.sums(1000 + render, first, spp - first), spp
            means = (sums / (spp / REPLICATES)).astype(np.float32)
            checks[spp].append(_check(means, spp, truth))
            curve[spp].append(checks[spp][-1][0])
    for spp, found in checks.items():
        true, value, low, high, inside, unsure = np.array(found).T
        row["spp"][spp] = {
            "held": float(np.mean((low <= true) & (true <= high))),
            "below": float(np.mean(true < low)),
            "above": float(np.mean(high < true)),
            "ratio": float(value.mean() / true.mean()) if true.mean() > 0.0 else math.nan,
            "ratio error": _ratio_error(value, true),
            "width": float(np.median(np.log(np.maximum(high, 1e-30) / np.maximum(low, 1e-30)))),
            "pixels": float(np.nanmean(inside)) if np.isfinite(inside).any() else math.nan,
            "unsure": float(unsure.mean()),
            # Rare bright samples in the truth are no fault of the picture's.
            "clear": bool(truth.sure and truth.noise < CLEAR * true.mean()),
            "pictures": [[float(f"{x:.5g}") for x in one[:4]] for one in found],
        }
    errors = [math.sqrt(max(float(np.mean(curve[spp])), 1e-12)) for spp in CHECKED]
    for render in range(max(renders // 4, 1)):
        for adaptive, name in ((False, "promises"), (True, "adaptive")):
            made = _promise(runner, truth, errors, (seed, 5000 + render), adaptive)
            row[name].append(made)
    return row


def _ratio_error(value: np.ndarray, true: np.ndarray) -> float:
    """Standard error of the ratio of two means, both of the same pictures."""
    if not true.mean() > 0.0:
        return math.nan
    rest = value - true * (value.mean() / true.mean())
    return float(rest.std(ddof=1) / (math.sqrt(len(rest)) * true.mean())) if len(rest) > 1 else 1.0


def _check(means: np.ndarray, spp: int, truth: Truth) -> list[float]:
    counts = np.full(means.shape[:3], spp // REPLICATES)
    interval = estimate_relmse(means, counts, literature=False).relmse
    bars = pixel_bars(means, counts)
    # The truth is not exact either.
    play = 1.96 * np.sqrt(truth.variance) + 1e-6 * truth.mean
    inside = (bars.low - play <= truth.mean) & (truth.mean <= bars.high + play)
    sure = ~bars.unsure
    return [
        truth.relmse(means.mean(axis=2, dtype=np.float64)), *interval,
        float(inside[sure].mean()) if sure.any() else math.nan, bars.unsure_share,
    ]  # fmt: skip


def _promise(
    runner: Runner, truth: Truth, errors: list[float], seeds: tuple[int, int], adaptive: bool
) -> dict[str, Any]:
    """Ask for an error, and look until it is said to be met or the budget is spent.

    The oracle has even samples in either case; the pilot of adaptive ones counts as samples.
    """
    oracle = float(np.exp(np.random.default_rng(seeds).uniform(*np.log(ORACLE))))
    logs = np.interp(math.log(oracle), np.log(CHECKED), np.log(errors))
    asked = min(max(float(np.exp(logs)), 1e-4), 10.0)
    h, w = truth.mean.shape[:2]
    shares = np.ones((-(-h // 8), -(-w // 8)))
    if adaptive:
        shares = cell_shares(runner.means(seed_of_round(seeds[1], 1), PILOT_SPP))
    sums, held = 0.0, np.zeros(shares.shape, np.int64)
    for spp in looks(BUDGET * oracle):
        goal = counts_at(shares, spp, REPLICATES) if adaptive else np.full(shares.shape, spp)
        sums, held = sums + runner.sums(seeds[1], held, goal - held), goal
        counts = np.kron(held, np.ones((8, 8), np.int64))[:h, :w, None] // REPLICATES
        counts = np.repeat(counts, REPLICATES, axis=2)
        means = (sums / counts[..., None]).astype(np.float32)
        judgement = judge_means(means, counts, Promise(asked))
        if judgement.met:
            break
    true = truth.relrmse(means.mean(axis=2, dtype=np.float64))
    return {
        "asked": asked, "oracle": oracle, "word": word_of(judgement), "true": true,
        "spp": REPLICATES * float(counts[..., 0].mean()) + (PILOT_SPP if adaptive else 0),
        "clear": bool(truth.sure and truth.noise < CLEAR * asked**2),
    }  # fmt: skip


def show(rows: Iterable[dict[str, Any]]) -> None:
    """Print the tables of both halves of the seeds."""
    rows = list(rows)
    for name, parity in (("even seeds (to choose by)", 0), ("odd seeds (the verdict)", 1)):
        own = [row for row in rows if row["seed"] % 2 == parity]
        if not own:
            continue
        print(f"\n{name}: {len(own)} scenes, seeds {own[0]['seed']} to {own[-1]['seed']}")
        for kind in (*sorted({row["kind"] for row in own}), "all"):
            some = [row for row in own if kind in ("all", row["kind"])]
            print(_line(kind, some))


def _line(kind: str, rows: list[dict[str, Any]]) -> str:
    """One kind: coverage, estimate over truth (median, mean +- error), width; and the rest."""
    parts = []
    for spp in map(str, CHECKED):
        clear = [row["spp"][spp] for row in rows if row["spp"][spp]["clear"]]
        if not clear:
            parts.append("    no truth    ")
            continue
        held, ratio, width = ([cell[key] for cell in clear] for key in ("held", "ratio", "width"))
        errors = np.array([cell.get("ratio error", math.nan) for cell in clear])
        error = math.sqrt(float((errors**2).sum())) / len(errors)
        ratios = f"{np.nanmedian(ratio):5.2f} {np.nanmean(ratio):5.2f}+-{error:.2f}"
        parts.append(f"{np.mean(held):6.1%} {ratios} {np.median(width):4.2f}")
    every = [cell for row in rows for cell in row["spp"].values()]
    cells = [cell for cell in every if cell["clear"]]
    if not cells:
        return f"{kind:11s} {len(rows):3d} scenes, none with a truth that is sure enough"
    held = np.mean([cell["held"] for cell in cells])
    pixels = np.nanmean([cell["pixels"] for cell in cells])
    unsure = np.mean([cell["unsure"] for cell in cells])
    return (
        f"{kind:11s} {len(rows):3d} scenes, {len(cells)} of {len(every)} clear, held {held:6.1%} | "
        f"{' | '.join(parts)} | pixels {pixels:.1%} (unsure {unsure:.0%}) | "
        f"{_kept(rows, 'promises')} | adaptive: {_kept(rows, 'adaptive')}"
    )


def _kept(rows: list[dict[str, Any]], name: str) -> str:
    """What became of the promises."""
    promises = [p for row in rows for p in row.get(name, ()) if p["clear"]]
    met = [p for p in promises if p["word"] == "met"]
    kept = sum(p["true"] <= p["asked"] for p in met)
    cost = np.median([p["spp"] / p["oracle"] for p in met]) if met else math.nan
    doubts = sum(p["word"] == "not certifiable" for p in promises)
    return (
        f"met {len(met)} of {len(promises)}, kept {kept}, {cost:.2f} x oracle, "
        f"not certifiable {doubts}"
    )


def main() -> None:
    """Measure, or show what was measured."""
    parser = parser_of(__doc__, KINDS)
    parser.add_argument("--renders", type=int, default=24)
    parser.add_argument("--truth", type=int, default=8192)
    parser.add_argument("--most", type=int, default=32768)
    options = parser.parse_args()

    def measured(seed: int, kind: str, side: int) -> dict[str, Any]:
        return measure(seed, kind, side, options.renders, options.truth, options.most)

    def said(row: dict[str, Any]) -> str:
        held = [cell["held"] for cell in row["spp"].values()]
        return f"held {held}, truth of {row['truth']} spp, doubt {row['doubt']:.2g}"

    run(options, measured, said, show)


if __name__ == "__main__":
    main()
