"""The watertight triangle test: formulas, exact signs, neighbours, the same bits everywhere."""

from fractions import Fraction

import numpy as np
import pytest

from alight.core.vec import Vec3
from alight.shapes.triangle import (
    difference_of_products,
    intersect,
    largest_axis,
    rotated,
    shear_of,
)
from lanewise.view import View

CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)


def lanes_of(points):
    return Vec3(*(np.ascontiguousarray(c, np.float32) for c in np.asarray(points).T))


def meet(corners, o, d, t_max=np.inf):
    """t, u, v, hit of rays (n, 3) with one triangle."""
    o, d = lanes_of(o), lanes_of(d)
    with np.errstate(all="ignore"):
        shear = shear_of(d)
        data = View(np.append(np.asarray(corners, np.float32), np.float32(0)))
        return intersect(data, 0, rotated(o, shear), shear, np.float32(t_max))


def test_distance_and_barycentrics():
    t, u, v, hit = meet(CORNERS, [[0.0, 0.0, 5.0]], [[0.0, 0.0, -2.0]])
    assert hit[0]
    assert t[0] == 2.5
    b = np.array([1 - u[0] - v[0], u[0], v[0]])
    np.testing.assert_allclose(b @ CORNERS, [0, 0, 0], atol=1e-7)
    np.testing.assert_allclose([u[0], v[0]], [0.25, 0.5], atol=1e-7)


def test_barycentrics_are_those_of_the_point_from_any_side_and_along_any_axis():
    rng = np.random.default_rng(1)
    for _ in range(30):
        corners = rng.normal(size=(3, 3))
        weights = rng.dirichlet((2, 2, 2), 200)
        d = rng.normal(size=(200, 3))
        o = weights @ corners - 3.0 * d
        t, u, v, hit = meet(corners, o, d)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        steep = np.abs(d @ normal) > 0.05 * np.linalg.norm(d, axis=1) * np.linalg.norm(normal)
        assert (hit | ~steep | (weights.min(axis=1) < 1e-4)).all()
        keep = hit & steep
        np.testing.assert_allclose(t[keep], 3.0, rtol=1e-4)
        np.testing.assert_allclose(u[keep], weights[keep, 1], atol=1e-3)
        np.testing.assert_allclose(v[keep], weights[keep, 2], atol=1e-3)


@pytest.mark.parametrize(
    ("o", "d", "expected"),
    [
        ((0, 0, 1), (0, 0, -1), True),
        ((0, 0, 1), (0, 0, 1), False),  # behind
        ((2, 0, 1), (0, 0, -1), False),  # beside
        ((-1, -1, 1), (0, 0, -1), True),  # at a corner
        ((0, -1, 1), (0, 0, -1), True),  # on an edge
        ((-3, 0, 0), (1, 0, 0), False),  # in the plane
        ((0, 0, 0), (0, 0, 1), False),  # starts on it: t = 0
    ],
)
def test_hits_and_misses(o, d, expected):
    assert meet(CORNERS, [o], [d])[3][0] == expected


def test_the_interval_is_closed_above_and_open_below():
    for t_max, expected in ((2.0, True), (np.nextafter(np.float32(2), np.float32(0)), False)):
        assert meet(CORNERS, [[0, 0, 2]], [[0, 0, -1]], t_max)[3][0] == expected


def test_the_axis_of_the_largest_component():
    d = lanes_of([[3, 1, 2], [1, -3, 2], [1, 2, -3], [1, 1, 1], [2, 2, 1], [0, 0, 0]])
    assert largest_axis(d).tolist() == [0, 1, 2, 2, 1, 2]


def test_a_difference_of_products_has_the_exact_sign_and_is_accurate():
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, 20_000)).astype(np.float32)
    c = np.nextafter(a, a + np.float32(1)) if rng.random() < 0 else a.copy()
    d = b.copy()
    shift = rng.integers(-2, 3, (2, len(a)))
    c = (c.view(np.int32) + shift[0].astype(np.int32)).view(np.float32)
    d = (d.view(np.int32) + shift[1].astype(np.int32)).view(np.float32)
    found = difference_of_products(a, b, c, d)
    for w, x, y, z, r in zip(*(v.tolist() for v in (a, b, c, d, found)), strict=True):
        exact = Fraction(w) * Fraction(x) - Fraction(y) * Fraction(z)
        assert abs(Fraction(r) - exact) <= abs(exact) * Fraction(3, 2**24)


def test_neighbours_leave_no_gap_and_a_degenerate_triangle_is_never_hit():
    rng = np.random.default_rng(3)
    a, b, c, e = rng.normal(size=(4, 3)).astype(np.float32)
    share = rng.random((5000, 1))
    target = (a + share * (b - a)).astype(np.float32)
    o = target + rng.normal(size=(5000, 3)).astype(np.float32)
    # Two triangles that share the edge a b, on both sides of it as seen along d.
    d = target - o
    one, other = meet([a, b, c], o, d)[3], meet([b, a, e], o, d)[3]
    side = np.sign(np.einsum("nk,nk->n", d, np.cross(b - a, c - a)[None]))
    opposite = side != np.sign(np.einsum("nk,nk->n", d, np.cross(b - a, e - a)[None]))
    assert (one | other | ~opposite).all()
    for flat in ([a, b, b], [a, a, b], [a, a, a]):
        assert not meet(flat, o, d)[3].any()
