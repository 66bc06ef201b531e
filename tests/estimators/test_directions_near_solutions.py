"""Directions of the ellipse about a walk's end: their density is that with which they are drawn."""

import numpy as np
import pytest

from alight.core.vec import Vec3
from alight.integrators.caustics.manifold_sampling import Trial, _is_taken
from alight.integrators.caustics.manifold_search import Result, Search
from alight.integrators.caustics.manifold_walk import (
    MARGIN,
    WIDEST,
    Solution,
    draw_near,
    place_near,
)
from alight.laws.statistics import LARGEST_Z
from alight.media.tables import Stream
from lanewise.jit import instantiate

N = 1 << 15


def solution(rng, bend):
    """A bent ellipse of random axes in the plane across a random direction, both (float)."""
    w, axis = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    axes = WIDEST * rng.uniform(0.3, 0.99, 2)
    density = 1.0 / (np.pi * MARGIN**2 * axes.prod())
    numbers = (*axes**-2.0, bend, density)
    vectors = (Vec3(*np.float32(v)) for v in (w, axis))
    return w, axes, Solution(*vectors, *map(np.float32, numbers))


def directions(axes, bend):
    """Places (u, v) of the larger ellipse, and parts of its area."""
    r, phi = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(400) + 0.5) / 400 * 2.0 * np.pi)
    u, v = MARGIN * axes[0] * r * np.cos(phi), MARGIN * axes[1] * r * np.sin(phi)
    return u, v - bend * u * u, r * 2.0 * np.pi / 400**2 * MARGIN**2 * axes.prod()


@pytest.mark.parametrize("bend", [0.0, 3.0])
@pytest.mark.parametrize("seed", range(2))
def test_the_mean_of_one_over_the_density_is_the_solid_angle(seed, bend):
    rng = np.random.default_rng(seed)
    w, axes, end = solution(rng, bend)
    u2 = tuple(rng.random(N, np.float32) for _ in range(2))
    drawn = instantiate(draw_near, compiled=False)(end, u2)
    q, density = instantiate(place_near, compiled=False)(end, drawn)
    rows = np.array([drawn.x, drawn.y, drawn.z], float)
    np.testing.assert_allclose(np.linalg.norm(rows, axis=0), 1.0, rtol=1e-6)
    # Uniform in the larger ellipse: so is q, in [0, MARGIN^2]. Rounding may put an edge outside.
    inside = density > 0.0
    assert inside.mean() > 0.999
    share = q[inside] / MARGIN**2
    assert abs(share.mean() - 0.5) < LARGEST_Z * np.sqrt(1.0 / 12.0 / N)
    values = 1.0 / density[inside].astype(float)
    u, v, area = directions(axes, bend)
    # Of all directions with a place (u, v): cos^3 dA.
    solid_angle = float((area * (1.0 + u * u + v * v) ** -1.5).sum())
    z = (values.mean() - solid_angle) / (values.std() / np.sqrt(N))
    assert abs(z) < LARGEST_Z
    # All around, and about the middle: the mean place is that of the ellipse.
    axis = np.array([end.axis.x, end.axis.y, end.axis.z], float)
    x, y = (rows.T @ e / (rows.T @ w) for e in (axis, np.cross(w, axis)))
    middle = (v * area).sum() / area.sum()
    assert abs(x.mean()) < LARGEST_Z * x.std() / np.sqrt(N)
    assert abs(y.mean() - middle) < LARGEST_Z * y.std() / np.sqrt(N)
    # One power of the cosine more or less would be found.
    assert abs(np.mean(rows.T @ w) - 1.0) * values.mean() > LARGEST_Z * values.std() / np.sqrt(N)


@pytest.mark.parametrize("part", [0.2, 0.7, 1.5])
def test_a_search_is_taken_by_its_density_over_the_largest(part):
    """Those that draw the direction with more than the largest density are refused in part."""
    _, _, end = solution(np.random.default_rng(7), 0.0)
    rng = np.random.default_rng(8)
    words = tuple(rng.integers(0, 1 << 32, N, dtype=np.uint32) for _ in range(2))
    none = np.zeros(N, np.uint32)
    search = Search(*[()] * 7, stream=Stream(*words, none), first=none, most=())
    most = np.float32(float(end.density) / part)
    trial = Trial(search, (), end.w, most, ())
    result = Result(end, *[()] * 6)
    taken = instantiate(_is_taken, compiled=False)(trial, search, result)
    wanted = min(part, 1.0)
    spread = np.sqrt(max(wanted * (1.0 - wanted), 1e-9) / N)
    assert abs(np.mean(np.broadcast_to(taken, N)) - wanted) < LARGEST_Z * spread + 1e-9
