"""Rectangles sampled by the solid angle that they show, against float64 geometry."""

import numpy as np
import pytest

from alight.core.warps import (
    spherical_rectangle,
    spherical_rectangle_pdf,
    square_to_spherical_rectangle,
)
from lanewise.vec3 import Vec3
from tests.sampling.materials import random_numbers
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square

N = 50_000
f = np.float32

# name: corner, edge_x, edge_y, p
SCENES = {
    "overhead": ((-1, -1, 2), (2, 0, 0), (0, 2, 0), (0, 0, 0)),
    "close": ((-1, -1, 0.01), (2, 0, 0), (0, 2, 0), (0.3, -0.2, 0)),
    "from behind": ((-1, -1, 2), (2, 0, 0), (0, 2, 0), (0.5, 0.1, 5)),
    "aside": ((2, 1, 1), (1, 0, 0), (0, 3, 0), (0, 0, 0)),
    "grazing": ((2, -1, 0.05), (1, 0, 0), (0, 2, 0), (0, 0, 0)),
    "tilted": ((1, 2, 3), (0.6, 0.8, 0), (-0.8, 0.6, 0), (0.2, -0.4, 0.1)),
    "thin": ((-5, 0.3, 0.2), (10, 0, 0), (0, 1e-2, 0), (0, 0, 0)),
    "far": ((-0.5, -0.5, 300), (1, 0, 0), (0, 1, 0), (0, 0, 0)),
    "far aside": ((200, 100, 150), (0.1, 0, 0), (0, 0, 0.1), (0, 0, 0)),
    "a speck a mile away": ((0, 0, 1e4), (1e-3, 0, 0), (0, 1e-3, 0), (0, 0, 0)),
    "a world": ((-1e6, -2e6, 1e6), (3e6, 0, 0), (0, 3e6, 0), (0, 0, 0)),
    "tiny": ((-1e-4, -1e-4, 1), (2e-4, 0, 0), (0, 2e-4, 0), (0, 0, 0)),
    "corner of a room": ((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 0)),
}
BY_AREA = {"a speck a mile away", "far", "far aside", "tiny"}

each_scene = pytest.mark.parametrize("name", SCENES)


def vec(v, n=1):
    return Vec3(*(np.full(n, c, f) for c in v))


def seen(name, n=1):
    corner, edge_x, edge_y, p = SCENES[name]
    return spherical_rectangle(vec(corner, n), vec(edge_x, n), vec(edge_y, n), vec(p, n))


def solid_angle(a, b, c):
    """Of a triangle seen from the origin, float64 (Van Oosterom and Strackee 1983)."""
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    dot = lambda u, v: np.sum(u * v, axis=-1)  # noqa: E731
    above = np.abs(dot(a, np.cross(b, c)))
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return 2.0 * np.arctan2(above, below)


def exact_solid_angle(name, x0=0.0, x1=1.0, y0=0.0, y1=1.0):
    """Of the part [x0, x1] by [y0, y1] of a rectangle."""
    corner, edge_x, edge_y, p = (np.array(v, float) for v in SCENES[name])
    at = lambda x, y: corner - p + np.multiply.outer(x, edge_x) + np.multiply.outer(y, edge_y)  # noqa: E731
    a, b, c, d = at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)
    return solid_angle(a, b, c) + solid_angle(a, c, d)


def sampled(name, seed=1):
    """(rectangle, vectors (3, N), fractions along the edges (2, N))."""
    rectangle, u = seen(name, N), random_numbers(N, seed)
    d = square_to_spherical_rectangle(rectangle, (u[0], u[1]))
    d = np.stack([d.x, d.y, d.z])
    corner, edge_x, edge_y, p = (np.array(v, float) for v in SCENES[name])
    from_corner = d.T.astype(float) - (corner - p)
    return rectangle, d, np.stack([from_corner @ e / (e @ e) for e in (edge_x, edge_y)])


@each_scene
def test_solid_angle_is_that_of_two_triangles(name):
    rectangle = seen(name)
    assert rectangle.by_area[0] == (name in BY_AREA)
    if not rectangle.by_area[0]:
        assert rectangle.solid_angle[0] == pytest.approx(exact_solid_angle(name), rel=2e-4)


def test_a_cube_has_six_faces():
    cube = spherical_rectangle(vec((-1, -1, 1)), vec((2, 0, 0)), vec((0, 2, 0)), vec((0, 0, 0)))
    assert cube.solid_angle[0] == pytest.approx(4.0 * np.pi / 6.0, rel=1e-6)


@each_scene
def test_samples_lie_on_the_rectangle(name):
    _, d, (s, t) = sampled(name)
    corner, edge_x, edge_y, p = (np.array(v, float) for v in SCENES[name])
    scale = np.linalg.norm(corner - p) * 2e-7
    assert min(s.min(), t.min()) >= -scale / min(np.linalg.norm(edge_x), np.linalg.norm(edge_y))
    assert max(s.max(), t.max()) <= 1.0 + scale / min(
        np.linalg.norm(edge_x), np.linalg.norm(edge_y)
    )
    normal = np.cross(edge_x, edge_y) / np.linalg.norm(np.cross(edge_x, edge_y))
    np.testing.assert_allclose(normal @ d, normal @ (corner - p), atol=3.0 * scale)


@pytest.mark.parametrize("name", [name for name in SCENES if name not in BY_AREA])
def test_samples_are_uniform_in_the_solid_angle(name):
    _, _, (s, t) = sampled(name)
    edges = np.linspace(0.0, 1.0, 17)
    x0, y0 = np.meshgrid(edges[:-1], edges[:-1], indexing="ij")
    x1, y1 = np.meshgrid(edges[1:], edges[1:], indexing="ij")
    exact = exact_solid_angle(name, x0, x1, y0, y1)
    cells = 16 * np.clip(16.0 * s, 0, 15).astype(int) + np.clip(16.0 * t, 0, 15).astype(int)
    counts = np.bincount(cells, minlength=256)
    assert chi_square([*counts, 0], (exact / exact.sum()).ravel()) > SIGNIFICANCE


@each_scene
def test_mean_of_one_over_density_is_the_solid_angle(name):
    rectangle, d, _ = sampled(name)
    pdf = spherical_rectangle_pdf(rectangle, Vec3(*d))
    assert np.all(np.isfinite(pdf)) and np.all(pdf > 0.0)
    estimate = 1.0 / pdf.astype(float)
    error = LARGEST_Z * estimate.std() / np.sqrt(N)
    exact = exact_solid_angle(name)
    assert estimate.mean() == pytest.approx(exact, abs=2e-4 * exact + error)


def test_the_plane_of_the_rectangle_has_no_density():
    rectangle = spherical_rectangle(vec((1, 1, 0)), vec((1, 0, 0)), vec((0, 1, 0)), vec((0, 0, 0)))
    d = square_to_spherical_rectangle(rectangle, (f([0.5]), f([0.5])))
    assert np.isfinite([d.x[0], d.y[0], d.z[0]]).all()
    assert spherical_rectangle_pdf(rectangle, d)[0] == 0.0


def test_solid_angles_of_random_rectangles():
    rng = np.random.default_rng(3)
    n = 20_000
    size = np.exp(rng.uniform(-6.0, 4.0, (n, 2)))
    corner = rng.normal(size=(n, 3)) * np.exp(rng.uniform(-3.0, 3.0, (n, 1)))
    corner, size = corner.astype(f), size.astype(f)
    zero = np.zeros(n, f)
    rectangle = spherical_rectangle(
        Vec3(*corner.T),
        Vec3(size[:, 0], zero, zero),
        Vec3(zero, size[:, 1], zero),
        Vec3(zero, zero, zero),
    )
    ex, ey = np.zeros((2, n, 3))
    ex[:, 0], ey[:, 1] = size.T
    a = corner.astype(float)
    exact = solid_angle(a, a + ex, a + ex + ey) + solid_angle(a, a + ex + ey, a + ey)
    ok = ~rectangle.by_area
    assert ok.mean() > 0.5
    np.testing.assert_allclose(rectangle.solid_angle[ok], exact[ok], rtol=3e-4)
