"""Promises of whole renders on random scenes: ``--error`` as users give it.

python benchmarks/known_error/kept_promises.py --seeds 1-9:2 --save FILE [--kinds room,...]
    [--errors 0.03,0.05,0.1] [--most 1024] [--truth 4096] [--sides 24]
python benchmarks/known_error/kept_promises.py --show FILE

For each scene, error asked, and even or adaptive samples one render by `alight.render`, pilots
included, compared with the truth of `random_scenes`. What is not clear (the truth's own error is
more than a tenth of what was asked, squared, or its brightness is in doubt) is not counted. Lines
are added to FILE as they come.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from random_scenes import CLEAR
from resumable import parser_of, run
from scenes import Runner
from truth import Truth

import alight
from alight.core.errors import AlightError
from alight.lab.random_scenes import KINDS, random_scene


def measure(
    seed: int, kind: str, side: int, errors: list[float], truth_spp: tuple[int, int], most: int
) -> dict[str, Any]:
    """Render one scene to each error, with even and with adaptive samples."""
    scene = random_scene(seed, kind, (side, side))
    truth = Truth(Runner(scene), *truth_spp)
    if not truth.mean.any():
        raise AlightError("black: there is nothing to compare")
    row: dict[str, Any] = {"seed": seed, "kind": kind, "doubt": truth.doubt, "promises": []}
    for number, asked in enumerate(errors):
        for adaptive in (False, True):
            film = alight.render(
                scene, error=asked, max_spp=most, adaptive=adaptive, threads=1,
                seed=1000 * seed + 2 * number + adaptive,
            )  # fmt: skip
            row["promises"].append({
                "asked": asked, "adaptive": adaptive, "word": film.stats["verdict"]["word"],
                "true": truth.relrmse(np.asarray(film.mean, np.float64)), "spp": film.spp,
                "clear": bool(truth.sure and truth.noise < CLEAR * asked**2),
            })  # fmt: skip
    return row


def show(rows: Iterable[dict[str, Any]]) -> None:
    """Print, by kind and by error asked, how many were met and how many of these were kept."""
    rows = list(rows)
    for kind in (*sorted({row["kind"] for row in rows}), "all"):
        some = [row for row in rows if kind in ("all", row["kind"])]
        parts = []
        for adaptive in (False, True):
            for asked in sorted({p["asked"] for row in some for p in row["promises"]}):
                mine = [
                    p for row in some for p in row["promises"]
                    if p["clear"] and p["asked"] == asked and p["adaptive"] == adaptive
                ]  # fmt: skip
                met = [p for p in mine if p["word"] == "met"]
                kept = sum(p["true"] <= asked for p in met)
                parts.append(f"{asked:.0%}: {kept} of {len(met)} met, {len(mine)} clear")
        print(f"{kind:11s} {len(some)} scenes | " + " | ".join(parts))


def main() -> None:
    """Measure, or show what was measured."""
    parser = parser_of(__doc__, KINDS)
    parser.add_argument("--errors", default="0.03,0.05,0.1")
    parser.add_argument("--truth", type=int, default=4096)
    parser.add_argument("--longest-truth", type=int, default=16384)
    parser.add_argument("--most", type=int, default=1024)
    options = parser.parse_args()
    errors = [float(error) for error in options.errors.split(",")]
    truths = options.truth, options.longest_truth

    def measured(seed: int, kind: str, side: int) -> dict[str, Any]:
        return measure(seed, kind, side, errors, truths, options.most)

    def said(row: dict[str, Any]) -> str:
        told = [f"{p['word']} {p['true']:.3f}/{p['asked']}" for p in row["promises"]]
        return f"{', '.join(told)}, doubt {row['doubt']:.2g}"

    run(options, measured, said, show)


if __name__ == "__main__":
    main()
