r"""Integration itself: integrals of 1 to 6 dimensions with known answers, and no scene.

Two integrands on the unit cube: a smooth one, a product of sines with the integral 1, and the
indicator of a ball, an edge that no rule can be aligned with. Samplers give pairs of dimensions as
integrators ask them; `jittered` is a grid of N = k^d cells with one point in each; midpoint,
Simpson and Gauss-Legendre are product rules of N = k^d nodes.

Root mean square errors fall as N^-1/2 for independent points, whatever the dimension. Jittered
points gain a factor N^(-1/d) where the integrand is smooth and N^(-1/(2 d)) where it has an edge;
the scrambled (0, 2)-sequence comes to N^-3/2 for smooth integrands of up to two dimensions. A
product rule whose error is h^p has N^(-p/d): the curse of dimension.

Source: Owen, Monte Carlo theory, methods and examples (2013), chapters 7, 10 and 17; Mitchell,
Consequences of stratified sampling in graphics, SIGGRAPH 1996, for the edge.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from alight.compiled.program import Program
from alight.core.spec import Sampler
from alight.lab.arms import seed_of
from alight.lab.replicates.session import Session, StudyProgress
from alight.lab.results import Curve, CurveResult, TableResult
from alight.lab.statistics.intervals import fit_slope, log_slope, positive_interval
from alight.metrics.estimate import Estimate
from alight.samplers.model import SAMPLERS, SamplerModel
from alight.samplers.sampling import get_1d, get_2d, sampler_key, sampler_state
from lanewise.jit import instantiate

#: Dimensions of the integrals; nodes or samples at most, without and with ``--quick``.
DIMENSIONS, MOST, QUICK_MOST = (1, 2, 3, 4, 6), 4096, 1024

#: Independent repetitions of random rules, without and with ``--quick``.
REPLICATES, QUICK_REPLICATES = 64, 32

#: Radius of the ball: the unit cube cuts off none of its first orthant.
RADIUS = 0.9

#: Slopes are fitted from this N on, where the law of large N begins to hold.
_FIRST = 16


def smooth(x: np.ndarray) -> np.ndarray:
    """Product of (pi / 2) sin(pi x_i); integral 1. x: (..., d)."""
    return np.prod(0.5 * np.pi * np.sin(np.pi * x), axis=-1)


def edge(x: np.ndarray) -> np.ndarray:
    """1 within a ball around the origin, over its volume; integral 1. x: (..., d)."""
    inside = (x**2).sum(axis=-1) < RADIUS**2
    return inside / orthant_volume(x.shape[-1])


def orthant_volume(d: int) -> float:
    """Volume of the part of the ball of radius `RADIUS` with positive coordinates."""
    return math.pi ** (d / 2.0) / math.gamma(d / 2.0 + 1.0) * (RADIUS / 2.0) ** d


#: Rate of the squared error of smooth integrals by a scrambled net.
NET_RATE = -3.0

INTEGRANDS: dict[str, Callable[[np.ndarray], np.ndarray]] = {"smooth": smooth, "edge": edge}


def sequences() -> dict[str, SamplerModel]:
    """Samplers of any number of samples, by name."""
    return {name: m for name, m in SAMPLERS.items() if m.EXAMPLES[0].block == 1}


def sampler_points(sampler: Sampler, count: int, d: int, replicates: int, seed: int) -> np.ndarray:
    """Points of a sampler, (replicates, count, d): each replicate is a pixel of its own."""
    program = Program(sampler=sampler_key(sampler))
    pair = instantiate(get_2d, program, compiled=False)
    single = instantiate(get_1d, program, compiled=False)
    pixel = np.repeat(np.arange(replicates, dtype=np.uint32), count)
    index = np.tile(np.arange(count, dtype=np.uint32), replicates)
    with np.errstate(over="ignore"):
        state = sampler_state(pixel, pixel * np.uint32(0), index, 0, seed)
        columns = [u for k in range(0, d - 1, 2) for u in pair(state, k)]
        if d % 2:
            columns.append(single(state, d - 1))
    return np.stack(columns, axis=-1).reshape(replicates, count, d).astype(np.float64)


def jittered_points(k: int, d: int, replicates: int, rng: np.random.Generator) -> np.ndarray:
    """One point in each of the k^d cells of a grid, (replicates, k^d, d)."""
    cells = np.stack(np.meshgrid(*[np.arange(k)] * d, indexing="ij"), axis=-1).reshape(-1, d)
    return (cells + rng.random((replicates, len(cells), d))) / k


def product_rule(name: str, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on [0, 1]: "midpoint", "simpson" (k odd) or "gauss".

    Examples
    --------
    >>> [round(float(w), 4) for w in product_rule("simpson", 3)[1]]
    [0.1667, 0.6667, 0.1667]
    """
    if name == "midpoint":
        return (np.arange(k) + 0.5) / k, np.full(k, 1.0 / k)
    if name == "simpson":
        weights = np.ones(k)
        weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
        return np.linspace(0.0, 1.0, k), weights / (3.0 * (k - 1))
    nodes, weights = np.polynomial.legendre.leggauss(k)
    return (nodes + 1.0) / 2.0, weights / 2.0


def product_error(f: Callable, name: str, k: int, d: int) -> float:
    """Absolute error of a product rule of k^d nodes."""
    nodes, weights = product_rule(name, k)
    x = np.stack(np.meshgrid(*[nodes] * d, indexing="ij"), axis=-1).reshape(-1, d)
    w = np.prod(np.stack(np.meshgrid(*[weights] * d, indexing="ij"), axis=-1), axis=-1).ravel()
    return abs(float(f(x) @ w) - 1.0)


def sides(d: int, most: int, odd: bool = False) -> list[int]:
    """Nodes on a side with k^d <= most: about a factor 2 in N apart."""
    found = [k for k in range(3 if odd else 2, most + 1) if k**d <= most]
    if odd:
        found = [k for k in found if k % 2]
    kept: list[int] = []
    for k in found:
        if not kept or k**d >= 1.9 * kept[-1] ** d:
            kept.append(k)
    return kept


def run_integrals(session: Session) -> tuple[list[CurveResult], list[TableResult]]:
    """All diagrams of the study, and a table of the slopes."""
    begin = time.process_time()
    most = QUICK_MOST if session.quick else MOST
    replicates = QUICK_REPLICATES if session.quick else REPLICATES
    panels, done = [], 0
    for integrand in INTEGRANDS:
        for d in DIMENSIONS:
            text = f"{integrand} integrand in {d} dimensions"
            session.progress(StudyProgress(text, done, len(INTEGRANDS) * len(DIMENSIONS)))
            panels.append(_panel(session.study.seed, integrand, d, most, replicates))
            done += 1
    session.seconds["render"] += time.process_time() - begin
    return panels, [_slopes(panels)]


def _panel(seed: int, integrand: str, d: int, most: int, replicates: int) -> CurveResult:
    f = INTEGRANDS[integrand]
    counts = [2**k for k in range(1, most.bit_length()) if 2**k <= most]
    curves = []
    for name, model in sequences().items():
        seeds = seed_of(seed, integrand, d, name)
        points = sampler_points(model.EXAMPLES[0], most, d, replicates, seeds)
        values = f(points)
        squared = np.stack([(values[:, :n].mean(axis=1) - 1.0) ** 2 for n in counts])
        curves.append(_random_curve(name, counts, squared, _of_sampler(model, integrand, d)))
    rng = np.random.default_rng(seed_of(seed, integrand, d, "jittered"))
    grid = sides(d, most)
    squared = np.stack(
        [(f(jittered_points(k, d, replicates, rng)).mean(axis=1) - 1.0) ** 2 for k in grid]
    )
    expected = -0.5 - 1.0 / d if integrand == "smooth" else -0.5 - 0.5 / d
    curves.insert(1, _random_curve("jittered", [k**d for k in grid], squared, expected))
    for name in ("midpoint", "simpson", "gauss"):
        nodes = sides(d, most, odd=name == "simpson")
        errors = [product_error(f, name, k, d) for k in nodes]
        curves.append(_exact_curve(name, [k**d for k in nodes], errors))
    what = "a product of sines" if integrand == "smooth" else "a ball's indicator"
    return CurveResult(
        f"{integrand}-{d}d", f"{what.capitalize()}, {d}-dimensional",
        f"Root mean square error of the integral of {what} over the unit cube; the answer is 1.",
        "samples N", "RMSE", curves,
    )  # fmt: skip


def _random_curve(
    name: str, counts: list[int], squared: np.ndarray, expected: float | None
) -> Curve:
    intervals = [positive_interval(row) for row in squared]
    roots = [Estimate(*(math.sqrt(max(v, 0.0)) for v in one)) for one in intervals]
    late = np.array(counts) >= min(_FIRST, counts[-2])
    x = np.repeat(np.array(counts, np.float64)[:, None], squared.shape[1], axis=1)
    slope = log_slope(x[late], squared[late])
    return Curve(
        name, name, [float(n) for n in counts], [e.value for e in roots],
        [e.low for e in roots], [e.high for e in roots],
        None if math.isnan(slope.value) else Estimate(*(v / 2.0 for v in slope)), expected,
    )  # fmt: skip


def _exact_curve(name: str, counts: list[int], errors: list[float]) -> Curve:
    # Below this only the rounding of float64 is left.
    seen = [i for i, error in enumerate(errors) if error > 1e-14]
    x, y = [float(counts[i]) for i in seen], [errors[i] for i in seen]
    slope = None
    if len(x) >= 3:
        value = float(fit_slope(np.log(x), np.log(y)))
        slope = Estimate(value, value, value)
    return Curve(name, name, x, y, list(y), list(y), slope)


def _of_sampler(model: SamplerModel, integrand: str, d: int) -> float | None:
    """Slope of the RMSE that theory predicts, where it does."""
    if model.EXAMPLES[0].independent:
        return -0.5
    # The rate of scrambled nets (Owen 1997); that of other sequences is a bound, not a slope.
    if integrand == "smooth" and d <= 2 and model.EXPECTED_RATE[d - 1] == NET_RATE:
        return NET_RATE / 2.0
    return None


def _slopes(panels: list[CurveResult]) -> TableResult:
    rows = []
    for panel in panels:
        for curve in panel.curves:
            if curve.slope is not None:
                expected = "" if curve.expected_slope is None else round(curve.expected_slope, 3)
                rows.append([panel.name, curve.label, list(curve.slope), expected])
    return TableResult(
        "slopes", "Slopes of RMSE over N",
        "Fitted from N = 16 on, with 95 % intervals; product rules have no randomness.",
        ["integral", "rule", "slope", "expected"], rows,
    )  # fmt: skip
