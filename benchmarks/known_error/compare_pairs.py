"""Level and power of `alight compare` on random scenes, every true pair of seeds of its own.

python benchmarks/known_error/compare_pairs.py --seeds 1-99:2 --save FILE [--kinds room,...]
    [--sides 32,48,64] [--rounds 1] [--seconds 60]
python benchmarks/known_error/compare_pairs.py --show FILE

In each round a scene gives one true pair for each pair of numbers of samples, in one of four scenes
with two different samplers; the number of replicates is drawn for each side. The same pair with 2 %
more light on one side, and one whose noisier side is rendered with albedos that are 1 % lower, are
the changed ones. The z-score of a change is that of the means of the whole picture, in the channel
where it is largest: the difference between all pictures of the scene, over the root of the mean
squared error of the round's pictures of that many samples.
``builtin`` among the kinds is one of the package's scenes, by the seed. Lines are added to FILE as
they come, so that a campaign can be stopped and continued. Constants are chosen on even seeds; odd
ones give the verdict.
"""

from __future__ import annotations

import collections
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from resumable import parser_of, run
from scenes import Runner
from scipy import stats

from alight.core.errors import AlightError
from alight.formats import builtin_names
from alight.lab.random_scenes import KINDS
from alight.metrics import Measured, compare_measured

sys.path.append(str(Path(__file__).parents[2]))
from benchmarks.harness import print_table
from benchmarks.picture_agreement.scenes import RANDOM, SAMPLERS, load_scene

#: Samples of the two pictures of a pair.
PAIRS = (
    (4, 4), (16, 16), (64, 64), (256, 256), (4, 16), (4, 64), (16, 64), (4, 256), (16, 256),
    (64, 256), (4, 1024), (64, 1024),
)  # fmt: skip

LIGHT, DARKER = 1.02, 0.99

#: Share of the scenes whose two pictures have different samplers.
MIXED = 0.25

LEVEL = 0.01

#: Replicates of a side, but never more than samples.
REPLICATES = (2, 4, 4, 8, 16)


class Picture(NamedTuple):
    """One picture of so many samples, and its channel means with their squared errors."""

    seen: Measured
    spp: int
    mean: np.ndarray
    square: np.ndarray


def picture(runner: Runner, seed: int, spp: int, replicates: int) -> Picture:
    """Render with a seed."""
    replicates = min(replicates, spp)
    means = runner.means(seed, spp, replicates)
    mean, square = means.mean(axis=2), means.var(axis=2, ddof=1) / replicates
    seen = Measured(
        mean.astype(np.float32), np.sqrt(square).astype(np.float32), replicates, float(spp)
    )
    return Picture(seen, spp, mean.mean(axis=(0, 1)), square.mean(axis=(0, 1)) / mean[..., 0].size)


def brighter(one: Picture) -> Picture:
    """The same picture in more light."""
    seen = one.seen
    error = None if seen.error is None else seen.error * np.float32(LIGHT)
    return one._replace(
        seen=Measured(seen.mean * np.float32(LIGHT), error, seen.replicates, seen.samples),
        mean=LIGHT * one.mean, square=LIGHT**2 * one.square,
    )  # fmt: skip


def overall(pictures: list[Picture]) -> np.ndarray:
    """Channel means of all pictures together."""
    return np.average([one.mean for one in pictures], axis=0, weights=[one.spp for one in pictures])


def noise(pictures: list[Picture], spp: int) -> np.ndarray:
    """Mean squared error of the channel means of a picture of so many samples."""
    return np.mean([one.square for one in pictures if one.spp == spp], axis=0)


def z_of(difference: np.ndarray, variance: np.ndarray) -> float:
    """How clear a change of the channel means is, where it is clearest."""
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.abs(difference) / np.sqrt(variance)
    return float(np.where(np.isfinite(z), z, 0.0).max())


def verdict(a: Picture, b: Picture) -> dict[str, Any] | None:
    """What is said of two pictures; None where nothing varies."""
    try:
        found = compare_measured(a.seen, b.seen, level=LEVEL)
    except ValueError:
        return None
    return {
        "reasons": found.reasons, "doubts": found.doubts, "block": found.block,
        "least": min(found.p_values.values()) * len(found.p_values),
    }  # fmt: skip


def measure(seed: int, kind: str, side: int, rounds: int, seconds: float) -> dict[str, Any]:
    """All pairs of one scene."""
    rng = np.random.default_rng([seed, *kind.encode()])
    names = sorted(builtin_names())
    name = names[seed // 2 % len(names)] if kind == "builtin" else f"{RANDOM}{kind}:{seed}"
    samplers = [str(one) for one in rng.choice(SAMPLERS, size=2, replace=False)]
    if rng.random() >= MIXED:
        samplers[1] = samplers[0]

    def runner(sampler: str, darker: float = 1.0) -> Runner:
        return Runner(load_scene(name, (side, side), sampler, 4, darker))

    left = runner(samplers[0])
    left.means(1, 4)
    start = time.process_time()
    if not left.means(2, 16).any():
        raise AlightError("black: there is nothing to compare")
    samples = rounds * sum(2 * few + many for few, many in PAIRS)
    cost = (time.process_time() - start) / 16 * samples
    if cost > seconds:
        raise AlightError(f"would take {cost:.0f} s")
    right = left if samplers[1] == samplers[0] else runner(samplers[1])
    dark = runner(samplers[0], DARKER)
    replicates = rng.choice(REPLICATES, size=(rounds, 2)).tolist()
    # Seeds differ between all pictures of a scene.
    made = [
        (
            [picture(left, 1000 * n + 100 + i, few, own) for i, (few, _) in enumerate(PAIRS)],
            [picture(right, 1000 * n + 200 + i, many, other) for i, (_, many) in enumerate(PAIRS)],
            [picture(dark, 1000 * n + 300 + i, few, own) for i, (few, _) in enumerate(PAIRS)],
        )
        for n, (own, other) in enumerate(replicates)
    ]
    mean = overall([one for a, b, _ in made for one in (*a, *b)])
    loss = overall([one for _, _, darker in made for one in darker]) - mean
    return {
        "seed": seed, "kind": kind, "side": side, "name": name, "samplers": samplers,
        "pairs": [pair for one in made for pair in _verdicts(*one, mean, loss)],
    }  # fmt: skip


def _verdicts(
    a: list[Picture],
    b: list[Picture],
    darker: list[Picture],
    mean: np.ndarray,
    loss: np.ndarray,
) -> list[dict[str, Any]]:
    """What is said of the pairs of one round, and how clear their changes are."""
    pairs = []
    for i, (few, many) in enumerate(PAIRS):
        variance, dark_variance = (noise(side, few) for side in (a, darker))
        other = noise(b, many)
        pairs.append({
            "spp": [few, many],
            "replicates": [a[i].seen.replicates, b[i].seen.replicates],
            "true": verdict(a[i], b[i]),
            "light": verdict(brighter(a[i]), b[i]),
            "light z": z_of((LIGHT - 1.0) * mean, LIGHT**2 * variance + other),
            "albedo": verdict(darker[i], b[i]),
            "albedo z": z_of(loss, dark_variance + other),
        })  # fmt: skip
    return pairs


def show(rows: Iterable[dict[str, Any]]) -> None:
    """Print level and power of both halves of the seeds."""
    rows = list(rows)
    for name, parity in (("even seeds (to choose by)", 0), ("odd seeds (the verdict)", 1)):
        own = [row for row in rows if row["seed"] % 2 == parity]
        if not own:
            continue
        print(f"\n{name}: {len(own)} scenes, seeds {own[0]['seed']} to {own[-1]['seed']}\n")
        titles = (("true pairs, spp", _spp), ("kind", _kind), ("samplers", _samplers),
                  ("replicates", _replicates))  # fmt: skip
        for title, key in titles:
            counts = _count((key(row, pair), pair["true"]) for row in own for pair in row["pairs"])
            _print(title, counts)
        changes = (
            (f"{change}, {_clear(pair[f'{change} z'])}", pair[change])
            for change in ("light", "albedo") for row in own for pair in row["pairs"]
        )  # fmt: skip
        _print("change", _count(changes), total=False)
        for row in own:
            for pair in row["pairs"]:
                if pair["true"] and pair["true"]["reasons"]:
                    print(row["kind"], row["seed"], row["samplers"], pair["spp"],
                          pair["replicates"], pair["true"])  # fmt: skip


def _spp(_: dict[str, Any], pair: dict[str, Any]) -> str:
    few, many = pair["spp"]
    return f"{few} against {many}" if few < many else "equal"


def _kind(row: dict[str, Any], _: dict[str, Any]) -> str:
    return row["kind"]


def _samplers(row: dict[str, Any], _: dict[str, Any]) -> str:
    first, second = row["samplers"]
    return f"both {first}" if first == second else "two different ones"


def _replicates(_: dict[str, Any], pair: dict[str, Any]) -> str:
    return "{} and {}".format(*sorted(pair["replicates"]))


def _clear(z: float) -> str:
    return "z at least 5" if z >= 5.0 else "z 3 to 5" if z >= 3.0 else "z below 3"


def _count(found: Iterable[tuple[str, dict[str, Any] | None]]) -> dict[str, list[int]]:
    """Pairs, those called different, and those of which nothing can be told."""
    counts: dict[str, list[int]] = collections.defaultdict(lambda: [0, 0, 0])
    for name, said in found:
        counts[name][0] += 1
        counts[name][1] += bool(said and said["reasons"])
        counts[name][2] += bool(said and said["doubts"])
    return counts


def _print(title: str, counts: dict[str, list[int]], total: bool = True) -> None:
    lines = dict(sorted(counts.items()))
    if total:
        lines["all"] = [sum(column) for column in zip(*counts.values(), strict=True)]
    rows = []
    for name, (pairs, different, unsure) in lines.items():
        rows.append({
            title: name, "pairs": pairs, "different": different, "share": different / pairs,
            "cannot tell": unsure,
        })  # fmt: skip
        if total:
            # How likely so many or more are, if one in a hundred is called different.
            rows[-1]["p"] = float(stats.binom.sf(different - 1, pairs, LEVEL))
    print_table(rows)
    print()


def main() -> None:
    """Measure, or show what was measured."""
    parser = parser_of(__doc__, (*KINDS, "builtin"))
    parser.add_argument("--rounds", type=int, default=1, help="pairs for each pair of samples")
    parser.add_argument("--seconds", type=float, default=60.0, help="processor time of a scene")
    options = parser.parse_args()

    def measured(seed: int, kind: str, side: int) -> dict[str, Any]:
        return measure(seed, kind, side, options.rounds, options.seconds)

    def said(row: dict[str, Any]) -> str:
        pairs = [pair["true"] for pair in row["pairs"]]
        wrong = sum(bool(one and one["reasons"]) for one in pairs)
        return f"{row['name']}: {wrong} of {len(pairs)} true pairs called different"

    run(options, measured, said, show)


if __name__ == "__main__":
    main()
