"""Metrics, error bars and the tests behind them, of fixed awkward pictures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from alight.metrics import block_sums, planes, surroundings
from alight.metrics import statistics as tests_of_pictures
from alight.metrics.agreement import compare_measured
from alight.metrics.block_sums import Measured
from alight.metrics.comparison import PictureStatistics, compare_pictures
from alight.metrics.model import METRICS, Pair, label_of, shown_of
from alight.metrics.noisy_pixels import class_of, effective, poisson_tail
from alight.metrics.own_error import estimate_relmse
from alight.metrics.pixel_bars import pixel_bars
from alight.metrics.ssim import ssim_map
from tests.recorded.making import described, film_of, outcome


def pictures() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Pairs of pictures: a picture and what it should be."""
    draw = np.random.default_rng(127)
    truth = draw.random((9, 14, 3)) ** 2 * [1.0, 0.4, 2.5] + [0.0, 0.05, 0.3]
    noisy = truth * (0.4 + 1.2 * draw.random(truth.shape))
    signed = noisy - 0.4
    broken = noisy.copy()
    broken[2, 3, 1], broken[4, 5, 0] = math.nan, math.inf
    bright = noisy.copy()
    bright[6, 7] = [90.0, 0.1, 2.0]
    large = draw.random((23, 31, 3))
    return {
        "equal": (truth, truth),
        "noisy": (noisy, truth),
        "exchanged": (truth, noisy),
        "signed": (signed, truth),
        "broken": (broken, truth),
        "bright": (bright, truth),
        "black": (np.zeros_like(truth), truth),
        "against black": (truth, np.zeros_like(truth)),
        "one pixel": (noisy[:1, :1], truth[:1, :1]),
        "one row": (noisy[:1], truth[:1]),
        "single": (noisy.astype(np.float32), truth.astype(np.float32)),
        "larger": (large, large[::-1] * 0.9),
    }


def of_pairs() -> dict[str, Any]:
    """Every metric of every pair."""
    found: dict[str, Any] = {}
    for name, model in METRICS.items():
        if model.missing():
            continue
        found[name] = {}
        for words, (image, reference) in pictures().items():
            if words == "broken" and name not in ("mse", "relmse"):
                continue
            if model.SLOW and words not in ("noisy", "larger", "bright"):
                continue
            pair = Pair(image, reference)
            value = outcome(model.evaluate, model.example, pair)
            answer = [value, label_of(name, pair)]
            if isinstance(value, float):
                answer.append(shown_of(name, value))
                answer.append(
                    outcome(model.evaluate, model.example, Pair(image, reference, 1.5).shown())
                )
            if model.weight:
                answer.append(outcome(model.weight, model.example, reference))
            if model.error_map:
                answer.append(outcome(model.error_map, model.example, pair))
            found[name][words] = answer
    found["facts"] = {
        name: [m.LABEL, m.SLOW, m.BOUNDED, m.IN_STUDIES, repr(m.example)]
        for name, m in METRICS.items()
    }
    a, b = pictures()["larger"]
    found["map of ssim"] = described(ssim_map(a[..., 1], b[..., 0]))
    return found


def distributions() -> dict[str, Any]:
    """Tails and quantiles."""
    t = np.array([-40.0, -2.5, -0.1, 0.0, 0.3, 1.0, 7.0, 1e3])
    return {
        "student": [tests_of_pictures.student_t_tail(t, d) for d in (0.5, 1, 3, 8, 41.5, 1e4, 1e9)],
        "quantiles of student": [
            tests_of_pictures.student_t_quantile(p, d)
            for p in (1e-9, 0.02, 0.5, 0.975)
            for d in (0.7, 3, 50)
        ],
        "fisher": [
            tests_of_pictures.f_quantile(p, a, b)
            for p in (1e-4, 0.3, 0.95)
            for a in (1, 7.5, 60, 200)
            for b in (2, 51, 90)
        ],
        "gamma": [
            tests_of_pictures.upper_gamma(a, x)
            for a in (0.3, 1, 5, 80)
            for x in (-1, 0, 0.2, 4, 90)
        ],
        "chi": [tests_of_pictures.chi_square_tail(x, d) for x in (0.1, 3, 40) for d in (1, 6, 30)],
        "squares": [
            tests_of_pictures.sum_of_squares_tails(z) for z in (t[1:6], t[1:2], 1 + t[2:7])
        ],
        "z": tests_of_pictures.t_to_z(t, np.array([1, 2, 3, 4, 5, 6, 7, 8.0])),
        "welch": tests_of_pictures.welch(
            np.array([1, 2, 3, 3.0]),
            np.array([0.2, 0.0, 0, 3.0]),
            5,
            np.array([1.3, 2.0, 4, 1.0]),
            np.array([0.1, 0.0, 0, 1e-3]),
            9,
        ),
        "holm": [
            tests_of_pictures.holm(p, level)
            for p in ([0.01, 0.04, 0.03, 0.005], [math.nan, 0.2], [0.02, 0.021, 0.9])
            for level in (0.05, 0.01)
        ],
        "poisson": [poisson_tail(k, mean) for k in (0, 1, 5, 40) for mean in (0.0, 0.3, 4.0, 60.0)],
        "effective": [
            effective(np.array(v)) for v in ([1.0, 1, 1], [5.0, 0.1, 0], [0.0, 0.0], [2.5])
        ],
    }


def _sides(seeds: tuple[int, int], bias: float, skew: bool) -> list[np.ndarray]:
    draw = np.random.default_rng([12, *seeds])
    truth = draw.random((12, 18, 3)) + 0.2
    sides = []
    for number, count in enumerate(seeds):
        noise = draw.random((count, *truth.shape))
        noise = noise**8 * 9 if skew and number else noise * 2
        sides.append(truth * (1.0 + 0.3 * (noise - 1.0) + bias * number))
    return sides


def comparisons() -> dict[str, Any]:
    """Two renderers' pictures, compared."""
    found = {}
    for name, sides in {
        "alike": _sides((9, 12), 0.0, False),
        "brighter": _sides((9, 12), 0.2, False),
        "skewed": _sides((10, 9), 0.0, True),
        "few": _sides((3, 4), 0.0, False),
    }.items():
        for block in (2, 3):
            made = outcome(compare_pictures, *sides, block=block, level=0.02)
            found[f"{name}, {block}"] = made
        report = compare_pictures(*sides).report()
        found[f"{name}, report"] = report
    a, b = _sides((5, 6), 0.0, False)
    found["sizes"] = outcome(compare_pictures, a, b[:, :-2])
    found["still"] = outcome(compare_pictures, np.ones((4, 6, 6, 3)), np.ones((4, 6, 6, 3)))
    one = PictureStatistics.of(a, 3)
    found["statistics"] = described(one)
    found["not joined"] = described(compare_pictures(a, b, join=False))
    return found


def measured() -> dict[str, Any]:
    """Two pictures with errors of their own, compared."""
    found = {}
    a, b = (film_of((24, 19), spp=8, seed=seed) for seed in (3, 4))
    darker = film_of((24, 19), spp=8, seed=5, spread=0.1)
    sides = {
        "alike": (a, b),
        "steadier": (a, darker),
        "the same": (a, a),
    }
    for name, (one, other) in sides.items():
        pair = [
            Measured(f.image.astype(np.float64), f.standard_error.astype(np.float64), f.replicates)
            for f in (one, other)
        ]
        found[name] = outcome(compare_measured, *pair)
        found[f"{name}, exact"] = outcome(compare_measured, pair[0], Measured(pair[1].mean))
        sums = block_sums.BlockSums.of(*pair, 2)
        found[f"{name}, blocks"] = [
            described(sums.z()),
            sums.skewness,
            described(sums.joined().z()),
        ]
    return found


def _means(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Means and counts of replicates."""
    words: dict[str, dict[str, Any]] = {
        "even": {},
        "two": {"replicates": 2},
        "sixteen": {"replicates": 16, "spp": 32},
        "five": {"replicates": 5, "spp": 15},
        "uneven": {"spp": 7},
        "quiet": {"spread": 0.02},
        "wild": {"spread": 6.0},
        "small": {"size": (1, 1)},
        "flat": {"size": (19, 1)},
        "large": {"size": (70, 41), "spread": 3.0},
        "one": {"replicates": 1},
    }
    film = film_of(**words[kind])
    means, counts = film.replicate_means()
    means = means.copy()
    if kind == "wild":
        means[3, 4, 1] = [900.0, 2.0, 0.0]
        means[7:9, 2:6, 2] *= 40.0
    if kind == "large":
        means[means < np.quantile(means, 0.4)] = 0.0
        means[20, 33, 3] = [0.0, 0.0, 700.0]
    return means, counts


KINDS = (
    "even",
    "two",
    "sixteen",
    "five",
    "uneven",
    "quiet",
    "wild",
    "small",
    "flat",
    "large",
    "one",
)


def own_errors() -> dict[str, Any]:
    """What pictures say of their own error."""
    found = {}
    for kind in KINDS:
        means, counts = _means(kind)
        for shares_paths in (False, True):
            name = f"{kind}, light paths" if shares_paths else kind
            answer = outcome(_estimate, means, counts, shares_paths)
            found[name] = answer
    return found


def _estimate(means: np.ndarray, counts: np.ndarray, shares_paths: bool) -> dict[str, Any]:
    from alight.metrics.own_error import relmse_of
    from alight.metrics.survey import survey

    error = relmse_of(survey(means, counts, shares_paths))
    figure = error.figure
    quantiles = [float(figure.quantile(p)) for p in (0.03, 0.5, 0.84, 0.999)]
    below = [error.relrmse_below(p) for p in (0.6, 0.95)]
    return {**described(error), "quantiles": quantiles, "below": below}


def bars() -> dict[str, Any]:
    """Intervals of pixels."""
    found: dict[str, Any] = {}
    for kind in KINDS:
        means, counts = _means(kind)
        for confidence in (0.5, 0.95):
            found[f"{kind}, {confidence}"] = outcome(pixel_bars, means, counts, confidence)
    found["wrong"] = outcome(pixel_bars, *_means("even"), 1.5)
    signed, counts = _means("even")
    signed = signed - 0.4
    found["both signs"] = outcome(pixel_bars, signed, counts)
    found["own error, both signs"] = outcome(estimate_relmse, signed, counts)
    return found


def parts() -> dict[str, Any]:
    """What errors of pictures are made of."""
    means, counts = _means("uneven")
    m, k = planes.planes_of(means, counts)
    mean = planes.weighted(m, k)
    variance = planes.squares(m, k, mean)
    brightness = np.linspace(0.0, 4.0, 12)
    return {
        "box": described(planes.box(mean)),
        "variance": described(variance),
        "around": outcome(surroundings.around, mean, variance, 0.01),
        "cells": outcome(surroundings.by_cells, mean),
        "pixels of cells": outcome(surroundings.pixels_of_cells, 13, 21),
        "neighbours": outcome(surroundings.neighbours, mean, 2),
        "classes": outcome(class_of, brightness, brightness[::-1].copy(), 0.1 + 0 * brightness),
    }


CASES = {
    "of_pairs": of_pairs,
    "distributions": distributions,
    "comparisons": comparisons,
    "measured": measured,
    "own_errors": own_errors,
    "bars": bars,
    "parts": parts,
}
