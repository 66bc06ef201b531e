"""Results of a study that nobody ran: numbers of the right shape, pictures of noise."""

import math

import numpy as np

from alight.lab.results import (
    BIASED,
    DIFFERENT,
    UNBIASED,
    ArmImages,
    ArmResult,
    BiasTest,
    Curve,
    CurveResult,
    Point,
    ReferenceInfo,
    SceneResult,
    Speedup,
    StudyResult,
    TableResult,
)
from alight.metrics.estimate import Estimate

SIZE = 48


def around(value, share=0.1):
    """An interval of so much around a value."""
    return Estimate(value, value - share * abs(value), value + share * abs(value))


def point(spp, mse, seconds):
    """Errors that all follow from one MSE."""
    return Point(
        spp, around(seconds, 0.02),
        {
            "mse": around(mse), "relmse": around(4 * mse), "relmse_literature": around(3 * mse),
            "smape": around(0.05), "flip": None,
        },
        Estimate(-1e-6, -3e-6, 1e-6), around(mse),
    )  # fmt: skip


def images(reference, noise, offset, seed, spp):
    """Pictures of an arm: noise in the left half only, an offset everywhere."""
    rng = np.random.default_rng(seed)
    deviation = np.full(reference.shape, 0.1 * noise)
    deviation[:, : SIZE // 2] = noise
    example = reference + offset + rng.normal(0, 1, reference.shape) * deviation
    error = np.full(reference.shape, offset, np.float32)
    return ArmImages(
        example.astype(np.float32), reference + error, (deviation**2).astype(np.float32), error,
        np.full(reference.shape[:2], spp, np.float32), spp, 0.5,
    )  # fmt: skip


def arm(name, index, mse, reference, verdict=UNBIASED, ratio=None, p=0.001):
    """An arm whose error falls as 1 / spp."""
    speedup = ratio and Speedup(around(ratio), p, p, around(ratio, 0.11))
    off = {BIASED: 0.05}.get(verdict, 0.0)
    ladder = [point(spp, mse * 16 / spp, 0.01 * spp) for spp in (4, 16, 64)]
    gain = 1 / (ladder[-1].mse.value * ladder[-1].seconds.value)
    bias = BiasTest(8, 36, 1.02, 0.8, 1.2, 2.9, [around(off, 0.01)] * 3, 0.4, verdict)
    return ArmResult(
        name, name.title(), {"sampler.type": name}, ratio is None, verdict == DIFFERENT, 4,
        [100 * index + k for k in range(4)], ladder, ladder, around(gain), speedup,
        around(-0.5, 0.04), around(-0.5, 0.04), -0.5, bias, around(0.4), 1.5, 0.1, 0, None,
        images(reference, math.sqrt(mse), off, index, 64),
    )  # fmt: skip


def scene(arms=None, **changes):
    """A scene with a baseline, a better, a biased and a different arm."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] / SIZE
    reference = np.stack([0.2 + 0.5 * x, 0.3 + 0.3 * y, 0.5 - 0.2 * x], axis=-1).astype(np.float32)
    arms = arms or [
        arm("independent", 0, 0.004, reference),
        arm("sobol", 1, 0.001, reference, ratio=4.0),
        arm("shallow", 2, 0.002, reference, BIASED, ratio=8.0),
        arm("tent", 3, 0.008, reference, DIFFERENT, ratio=0.5, p=0.2),
    ]
    values = {
        "name": "box", "label": "A box", "size": [SIZE, SIZE], "baseline": arms[0].name,
        "paired": False, "order_seed": 5,
        "reference": ReferenceInfo("rendered", "sobol", 4096, 0.002, False, 12.0, "abc123"),
        "reference_image": reference, "reference_variance": np.full_like(reference, 1e-6),
        "arms": arms,
    }  # fmt: skip
    return SceneResult(**(values | changes))


def curve_result():
    """Two lines, one with an expected slope."""
    n = [4.0, 16.0, 64.0]
    lines = []
    for name, a, expected in (("random", 0.5, -0.5), ("net", 1.5, None)):
        y = [v**-a for v in n]
        slope = around(-a, 0.02)
        low, high = [0.9 * v for v in y], [1.1 * v for v in y]
        lines.append(Curve(name, name.title(), n, y, low, high, slope, expected))
    return CurveResult("smooth", "A smooth integral", "Its RMSE.", "N", "RMSE", lines)


def study(scenes=None, curves=None, tables=None, **changes):
    """A study with one of everything."""
    table = TableResult(
        "ratio", "Ratio", "Of variances.", ["Surface", "Measured", "Seeds"],
        [["diffuse", [2.97, 2.9, 3.04], 16], ["scatter", [1.02, 0.99, 1.05], 16]],
    )  # fmt: skip
    values = {
        "name": "samplers", "title": "Samplers", "description": "Which is best?",
        "teaches": "That nets pay.", "command": "alight study samplers --seed 7",
        "created": "2026-11-21T16:00:00", "quick": False, "replicates": 4, "seed": 7,
        "machine": {"processor": "test"}, "versions": {"alight": "0"},
        "seconds": {"render": 100.0, "statistics": 1.0},
        "scenes": [scene()] if scenes is None else scenes,
        "curves": [curve_result()] if curves is None else curves,
        "tables": [table] if tables is None else tables,
    }  # fmt: skip
    return StudyResult(**(values | changes))
