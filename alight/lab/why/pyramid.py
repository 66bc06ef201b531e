r"""Paths from both ends: what each technique (s, t) adds to the picture, and to its variance.

Every technique estimates all light of its path length k = s + t - 1 that it can find, so that the
unweighted pictures of one length are alike but for their noise and for what some of them miss;
weighted, they add up to the picture. Shares of the variance are those of `alight.lab.why.shares`.

Source: Veach 1997, Robust Monte Carlo methods for light transport simulation, figure 10.2.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from alight.compiled.scene import compile_scene
from alight.integrators.strategies import DEEPEST, LONGER, ROWS, row_of
from alight.lab.why.shares import (
    BATCHES,
    PILOT,
    REPLICATES,
    Part,
    Share,
    Shares,
    relative_weights,
)
from alight.laws.scene.pictures import small
from alight.options.laboratory import WhyOptions
from alight.rendering.resources import usable_processors
from alight.rendering.tracing.strategy_recorder import StrategyRecorder, Told
from alight.scene import Scene, flatten


class Technique(NamedTuple):
    """What one technique does; all paths of more than `DEEPEST` edges have s and t None.

    Attributes
    ----------
    s, t : int or None
        Vertices of the light path and of the camera path.
    light : float
        Part of the picture's light that it adds, weighted.
    unweighted : float
        What it finds by itself, over the picture's light; 0 where it finds nothing.
    variance : Share
        Its share of the variance.
    """

    s: int | None
    t: int | None
    light: float
    unweighted: float
    variance: Share

    def __str__(self) -> str:
        """Its name."""
        return "longer" if self.s is None else f"({self.s}, {self.t})"


@dataclass(frozen=True)
class Pyramid:
    """A picture by techniques.

    Attributes
    ----------
    techniques : tuple of Technique
        Those that have found light, by path length, then by s.
    shares : Shares
        The same division of the variance as for other integrators.
    weighted, unweighted : (rows, h, w, 3) float64
        Means, rows as in `alight.integrators.strategies`; the first add up to the picture.
    """

    techniques: tuple[Technique, ...]
    shares: Shares
    weighted: np.ndarray = field(repr=False)
    unweighted: np.ndarray = field(repr=False)

    def lines(self) -> Iterator[str]:
        """A table for people."""
        yield "by technique (s, t), vertices from the light and from the camera:"
        yield "   (s, t)     light   alone  variance"
        for one in self.techniques:
            share = f"{100 * one.variance.value:5.1f} % ± {100 * one.variance.error:.1f}"
            yield f"  {one!s:>7} {100 * one.light:7.2f} % {one.unweighted:7.4f}  {share}"

    def to_dict(self) -> list[dict[str, Any]]:
        """All numbers, ready for JSON."""
        return [
            {
                "s": one.s, "t": one.t, "part_of_light": one.light, "unweighted": one.unweighted,
                "variance": one.variance.value, "standard_error": one.variance.error,
            }
            for one in self.techniques
        ]  # fmt: skip


def lengths_of(row: int) -> tuple[int, int] | None:
    """(s, edges) of a row; None of the last."""
    if row == LONGER:
        return None
    return next((s, k) for k in range(1, DEEPEST + 1) for s in range(k + 1) if row_of(s, k) == row)


def pyramid_of(scene: Scene, *, size: int = 128, spp: int = 64, seed: int = 0) -> Pyramid:
    """Divide up the picture of a scene with the bidirectional integrator.

    Parameters
    ----------
    scene, size, spp, seed
        As for `alight.lab.why.shares.shares_of`.
    """
    WhyOptions.of({"size": size, "spp": spp})
    compiled = compile_scene(flatten(small(scene, size=size)), threads=usable_processors())
    recorder, each = StrategyRecorder(compiled), spp // (BATCHES * REPLICATES)
    count = BATCHES * REPLICATES
    seeds = np.random.SeedSequence((seed, 5)).generate_state(count + 1).tolist()
    weights = relative_weights(recorder.run(PILOT, seeds[-1]).picture)
    sums = _Sums(weights, each)
    with ThreadPoolExecutor(min(usable_processors(), REPLICATES)) as pool:
        # Batch by batch: each replicate holds pictures of all techniques.
        for first in range(0, count, REPLICATES):
            own = seeds[first : first + REPLICATES]
            sums.add(list(pool.map(lambda one: recorder.run(each, one), own)))
    return sums.result()


class _Sums:
    """Adds batch after batch."""

    def __init__(self, weights: np.ndarray, spp: int) -> None:
        self.weights, self.spp = weights, spp
        shape = (ROWS, *weights.shape)
        self.weighted, self.unweighted = np.zeros(shape), np.zeros(shape)
        self.maps, self.rows = np.zeros(shape[:3]), list[np.ndarray]()

    def add(self, batch: list[Told]) -> None:
        """The replicates of one batch."""
        mean = sum(told.weighted for told in batch) / REPLICATES
        # Covariance of one sample: that of means of N samples, times N.
        scale = self.spp / (REPLICATES - 1) * self.weights
        maps = np.zeros(self.maps.shape)
        for told in batch:
            deviation = told.weighted - mean
            maps += np.sum(deviation * (deviation.sum(axis=0) * scale), axis=-1)
            self.weighted += told.weighted / (BATCHES * REPLICATES)
            self.unweighted += told.unweighted / (BATCHES * REPLICATES)
        self.maps += maps / BATCHES
        self.rows.append(maps.sum(axis=(1, 2)))

    def result(self) -> Pyramid:
        """Everything that was added."""
        weighted, unweighted = self.weighted, self.unweighted
        found = [row for row in range(ROWS) if unweighted[row].any()]
        names = [lengths_of(row) for row in found]
        numerators = np.array(self.rows)[:, found]
        shares = Shares(
            parts=tuple(_part(name) for name in names),
            numerators=numerators,
            relative_variance=float(numerators.sum() / BATCHES),
            spp=self.spp * BATCHES * REPLICATES,
            picture=weighted.sum(axis=0),
            variance=self.maps.sum(axis=0),
            maps=self.maps[found],
        )
        total = max(float(weighted.sum()), 1e-30)
        variances = shares.by("depth", "technique")
        techniques = tuple(
            Technique(
                None if name is None else name[0],
                None if name is None else name[1] + 1 - name[0],
                float(weighted[row].sum()) / total,
                float(unweighted[row].sum()) / total,
                variances[part],
            )
            for row, name, part in zip(found, names, shares.parts, strict=True)
        )
        return Pyramid(techniques, shares, weighted, unweighted)


def _part(name: tuple[int, int] | None) -> Part:
    if name is None:
        return Part(DEEPEST + 1, "found by longer paths")
    s, edges = name
    return Part(edges, f"found by (s, t) = ({s}, {edges + 1 - s})")
