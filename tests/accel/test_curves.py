"""Curves in lists, the tree and the twin: one formula, the same numbers, and nothing missed."""

import numpy as np

from alight.accel.primitives import Many
from alight.shapes import curves
from tests.accel.tracing import World

STRANDS = 40


def hair(seed: int, basis: str = "b_spline") -> curves.Curves:
    """Wavy strands of 6 or 7 points that go in all directions from the origin."""
    rng = np.random.default_rng(seed)
    n = 7 if basis == "bezier" else 6
    d = rng.normal(size=(STRANDS, 1, 3))
    along = np.linspace(0.0, 1.0, n)[:, None]
    points = along * d / np.linalg.norm(d, axis=2, keepdims=True)
    points = points + 0.06 * rng.normal(size=points.shape)
    radii = np.broadcast_to(0.03 * (1.0 - 0.7 * along[:, 0]), (STRANDS, n))
    counts = np.full(STRANDS, n)
    return curves.Curves(
        points=points.reshape(-1, 3), radii=radii.ravel(), counts=counts, basis=basis
    )


def worlds(spec: curves.Curves) -> tuple[World, World, np.ndarray]:
    rows = curves.pack(spec, np.eye(4))
    low, high = (side.astype(np.float32) for side in curves.extremes(rows, np.eye(3)))
    many = [Many("curves", 3, 0, rows.shape[1], low, high)]
    listed, tree = (
        World(None, [], [], [], [], [], many, data=rows.ravel(), structure=structure)
        for structure in ("list", "bvh")
    )
    return listed, tree, rows


def rays(seed: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    """From around the strands to points among them."""
    rng = np.random.default_rng(seed)
    o, target = rng.normal(size=(n, 3)), 0.5 * rng.normal(size=(n, 3))
    o = 2.0 * o / np.linalg.norm(o, axis=1, keepdims=True)
    return o.astype(np.float32), (target - o).astype(np.float32)


def test_lists_the_tree_and_the_twin_see_the_same_strands():
    for basis in ("b_spline", "linear"):
        listed, tree, _ = worlds(hair(1, basis))
        o, d = rays(2, 4096)
        a, b = listed.trace(o, d), tree.trace(o, d)
        assert np.isfinite(a.t).sum() > 1000
        for one, other in zip(a, b, strict=True):
            np.testing.assert_array_equal(one, other)
        twin = listed.trace(o[:64], d[:64], compiled=False)
        for one, other in zip(a, twin, strict=True):
            np.testing.assert_array_equal(one[:64], other)


def oracle(rows: np.ndarray, o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Where each ray enters one of many frusta of cones, in float64."""
    u = np.linspace(0.0, 1.0, 65)[:, None] ** np.arange(4)
    found = np.full(len(o), np.inf)
    cubics = np.einsum("ku,nuc->nkc", u, rows[:, :16].reshape(-1, 4, 4).astype(np.float64))
    a, b = cubics[:, :-1].reshape(-1, 4), cubics[:, 1:].reshape(-1, 4)
    for i in range(len(o)):
        found[i] = _first_frustum(a, b, o[i].astype(float), d[i].astype(float))
    return found


def _first_frustum(a, b, o, d):
    """The least t at which a ray enters one of the frusta between circles a and b (m, 4).

    They overlap by some of their heights, as circles of neighbours lie at an angle to each other.
    """
    axis, slope = b[:, :3] - a[:, :3], b[:, 3] - a[:, 3]
    length = np.sum(axis * axis, axis=1)
    q = o - a[:, :3]
    # |q + t d|^2 - h^2 L = (r + s h)^2 with the height h = h0 + t h1 in parts of the axis.
    h0, h1 = np.sum(q * axis, axis=1) / length, axis @ d / length
    aa = d @ d - h1 * h1 * length - (slope * h1) ** 2
    bb = q @ d - h0 * h1 * length - slope * h1 * (a[:, 3] + slope * h0)
    cc = np.sum(q * q, axis=1) - h0 * h0 * length - (a[:, 3] + slope * h0) ** 2
    inside = bb * bb - aa * cc
    with np.errstate(invalid="ignore", divide="ignore"):
        t = (-bb - np.sqrt(inside)) / aa
    h = h0 + t * h1
    met = (inside >= 0.0) & (t > 0.0) & (h >= -0.3) & (h <= 1.3)
    return t[met].min() if met.any() else np.inf


def test_hits_are_those_of_fine_frusta():
    _, tree, rows = worlds(hair(3))
    o, d = rays(4, 1500)
    hits = tree.trace(o, d)
    expected = oracle(rows, o, d)
    both = np.isfinite(hits.t) & np.isfinite(expected)
    assert both.sum() > 300
    # Open ends of the oracle's frusta reach a little farther.
    assert (np.isfinite(hits.t) != np.isfinite(expected)).sum() <= 3
    assert (np.abs(hits.t[both] - expected[both]) > 1e-3).sum() <= 3
