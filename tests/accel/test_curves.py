"""Curves in lists, the tree and the twin: one formula, the same numbers, and nothing missed."""

import numpy as np

from alight.accel import intersect_closest
from alight.accel.primitives import Many
from alight.core.vec import Vec3
from alight.shapes import curves
from alight.shapes.hit import spawn_origin
from alight.shapes.strand_places import error_of, place_at
from alight.shapes.strand_rows import STRIDE
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, fma, lanes, load_lanes, store_lanes, where
from lanewise.view import View
from tests.accel.tracing import Program, World

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


@kernel(strict=True)
def look_through(scene, rays, results, n, most):
    """How many surfaces each of n rays meets that goes straight on behind each, up to `most`."""
    data = scene.shapes.data
    for i in range(0, n, LANES):
        o = Vec3(load_lanes(rays, i), load_lanes(rays, n + i), load_lanes(rays, 2 * n + i))
        d = Vec3(
            load_lanes(rays, 3 * n + i), load_lanes(rays, 4 * n + i), load_lanes(rays, 5 * n + i)
        )
        met, going = lanes(0.0), lanes(0.0) == 0.0
        for _ in range(most):
            hit = intersect_closest(scene, o, d, lanes(np.inf), going)
            going = going & (hit.t < np.inf)
            row = where(going, STRIDE * hit.prim, 0)
            near = Vec3(fma(hit.t, d.x, o.x), fma(hit.t, d.y, o.y), fma(hit.t, d.z, o.z))
            place = place_at(data, row, hit.u, near)
            o = where(going, spawn_origin(place.p, error_of(data, row, place.n), place.n, d), o)
            met = met + where(going, 1.0, 0.0)
        store_lanes(results, i, met)


def surfaces(world: World, o: np.ndarray, d: np.ndarray, most: int = 40) -> np.ndarray:
    counted = np.zeros(len(o), np.float32)
    columns = np.concatenate([o.T, d.T]).astype(np.float32).copy()
    run = instantiate(look_through, Program(world.plan))
    run(world.scene, View(columns), View(counted), len(o), most)
    return counted


def test_rays_that_go_straight_on_leave_strands_that_fold():
    # Thicker than their bends are wide; of the first it was seen that rays met it for ever.
    points = [[-1, 0, 0], [-0.33, 0.6, 0], [0.33, -0.5, 0.4], [1, 0, 0]]
    others = np.random.default_rng(5).uniform(-1.0, 1.0, (60, 3))
    radii = [0.1, 0.2, 0.2, 0.05] * 16
    spec = curves.Curves(
        points=np.concatenate([points, others]), radii=radii, counts=[4] * 16, basis="bezier"
    )
    o, d = rays(6, 1 << 16)
    counted = surfaces(worlds(spec)[1], o, d)
    assert counted.max() < 40


def test_joints_of_straight_lines_are_met_where_tubes_leave_a_gap():
    # The same straight strand in 1 and in 20 pieces is one surface, without balls inside.
    o, d = rays(7, 4096)
    ends = np.array([[-1.0, -0.2, 0.1], [1.0, 0.3, 0.0]])
    many = np.linspace(0.0, 1.0, 21)[:, None] * (ends[1] - ends[0]) + ends[0]
    one, other = (
        worlds(curves.Curves(points=points, radii=0.2, basis="linear")) for points in (ends, many)
    )
    a, b = surfaces(one[1], o, d), surfaces(other[1], o, d)
    assert a.max() == 1
    assert (a == b).mean() > 0.999
    np.testing.assert_allclose(curves.area(other[2]), curves.area(one[2]), rtol=1e-4)
    # At a corner neither a ray within a lane of the gap is lost nor is the gap a whole ball.
    corner = curves.Curves(points=[[-1, 0, 0], [0, 0, 0], [0, 1, 0]], radii=0.1, basis="linear")
    _, tree, rows = worlds(corner)
    tubes, ball = 2.0 * 2.0 * np.pi * 0.1, 4.0 * np.pi * 0.01
    np.testing.assert_allclose(curves.area(rows), tubes + 1.25 * ball, rtol=1e-5)
    met = tree.trace(
        np.array([[0.05, -1.0, 0.0], [0.0, 0.0, 1.0]]), np.array([[0, 1, 0], [0, 0, -1.0]])
    )
    np.testing.assert_allclose(met.t, [1.0 - 0.1 * np.sqrt(0.75), 0.9], rtol=1e-5)
