"""Newton's method on a tube: its order, where the tube bends and tapers."""

import numpy as np

from alight.shapes.tube import PIECES, Search, Tube, take_step
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3


def tubes(n, seed, bends, tapers):
    """Tubes across the ray, at 0 to 0.3 of their radius from it."""
    rng = np.random.default_rng(seed)
    turn, lean = rng.uniform(0.0, 2.0 * np.pi, n), rng.uniform(-0.5, 0.5, n)
    along = np.stack([np.cos(turn), np.sin(turn), lean])
    beside = np.stack([-np.sin(turn), np.cos(turn), 0.0 * turn])
    c0 = rng.uniform(0.0, 0.12, n) * beside - 0.5 * along + [[0.0], [0.0], [3.0]]
    bend = bends * rng.uniform(-0.1, 0.1, (2, 3, n))
    taper = tapers * rng.uniform(0.2, 0.5, n) * rng.choice([-1.0, 1.0], n)
    zero = np.zeros(n)
    return Tube(*(Vec3(*c) for c in (c0, along, *bend)), 0.4 - 0.5 * taper, taper, zero, zero, zero)


def left_after_a_step(tube, sizes):
    """Parts of its distance from the root that a step of Newton's method leaves, (len, n)."""
    n = len(tube.r0)
    step, going = instantiate(take_step, None, compiled=False), np.ones(n, bool)

    def moved(u, times):
        with np.errstate(all="ignore"):
            for _ in range(times):
                u = step(tube, Search(u, 0.0 * u, going, ~going), u - 1.0, u + 1.0).u
        return u

    root = moved(np.full(n, 0.5), 60)
    seen = (np.abs(root - 0.5) < 0.4) & (np.abs(moved(root, 1) - root) < 1e-12)
    assert seen.mean() > 0.9
    return [np.abs(moved(root + size, 1) - root)[seen] / size for size in sizes]


def test_the_cone_of_a_straight_tube_is_the_tube():
    [left] = left_after_a_step(tubes(400, 3, bends=0.0, tapers=1.0), [0.25 / PIECES])
    assert np.median(left) < 1e-9


def test_newtons_method_is_of_the_second_order_where_a_tube_bends():
    sizes = 0.25 / PIECES, 0.25 / PIECES / 8.0
    far, near = left_after_a_step(tubes(400, 4, bends=1.0, tapers=0.0), sizes)
    # Of the error h about h is left.
    np.testing.assert_allclose(np.median(near / far), 1.0 / 8.0, rtol=0.2)
    assert np.median(far) < 0.1
