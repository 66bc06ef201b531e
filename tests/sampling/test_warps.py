"""Every warp spreads its samples by the density that goes with it."""

import numpy as np
import pytest

from alight.core.warps import (
    cosine_hemisphere_pdf,
    direction_around_z,
    disk_pdf,
    disk_to_square_concentric,
    square_to_cosine_hemisphere,
    square_to_disk_concentric,
    square_to_disk_polar,
    square_to_triangle,
    square_to_uniform_cone,
    square_to_uniform_hemisphere,
    square_to_uniform_sphere,
    triangle_to_square,
    uniform_cone_pdf,
    uniform_hemisphere_pdf,
    uniform_sphere_pdf,
    uniform_sphere_to_square,
)
from lanewise.vec3 import Vec3
from tests.sampling.materials import random_numbers
from tests.sampling.statistics import SIDES, SIGNIFICANCE, chi_square, length_error, sphere_cells

CELLS = sphere_cells(SIDES[0])
N = 100_000
f = np.float32

# Half angles of 90, 30 and 3 degrees.
CONES = [1.0, 0.134, 0.00137]


def square(seed, n=N):
    u = random_numbers(n, seed)
    return u[0], u[1]


def corners_and_edges():
    """The ends of [0, 1) in both numbers, where warps divide by zero if they do."""
    ends = f([0.0, 2.0**-24, 0.25, 0.5, 0.75, 1.0 - 2.0**-24])
    a, b = np.meshgrid(ends, ends)
    return a.ravel(), b.ravel()


def stack(v):
    return np.stack([v.x, v.y, v.z])


DIRECTIONS = {
    "cosine hemisphere": (square_to_cosine_hemisphere, cosine_hemisphere_pdf),
    "uniform hemisphere": (square_to_uniform_hemisphere, uniform_hemisphere_pdf),
    "uniform sphere": (square_to_uniform_sphere, lambda w: uniform_sphere_pdf() + 0.0 * w.z),
    **{f"cone {c}": (lambda u2, c=c: square_to_uniform_cone(u2, f(c)), None) for c in CONES},
}


@pytest.mark.parametrize("name", DIRECTIONS)
def test_directions_follow_their_density(name):
    warp, pdf = DIRECTIONS[name]
    if pdf is None:
        # The edge of a cone cuts cells: their exact share, from the cosines of their borders.
        border = 1.0 - np.cos(np.linspace(0.0, np.pi, CELLS.rows + 1))
        share = np.diff(np.minimum(border / float(name.split()[1]), 1.0))
        probabilities = np.repeat(share / CELLS.columns, CELLS.columns)
    else:
        probabilities = CELLS.integrals(pdf(Vec3(*CELLS.points)))
    assert probabilities.sum() == pytest.approx(1.0, abs=1e-3)
    w = stack(warp(square(1)))
    assert chi_square(CELLS.counts(w, np.ones(N, bool)), probabilities) > SIGNIFICANCE


@pytest.mark.parametrize("name", DIRECTIONS)
def test_directions_have_unit_length(name):
    for u2 in (square(2), corners_and_edges()):
        assert length_error(stack(DIRECTIONS[name][0](u2))) < 2.5e-7


@pytest.mark.parametrize("one_minus_cos", CONES)
def test_the_density_of_a_cone_is_one_over_its_solid_angle(one_minus_cos):
    solid_angle = 2.0 * np.pi * one_minus_cos
    assert uniform_cone_pdf(f(one_minus_cos)) * solid_angle == pytest.approx(1.0, rel=3e-7)


@pytest.mark.parametrize("one_minus_cos", CONES)
def test_cones_are_filled_evenly_from_the_axis_to_the_edge(one_minus_cos):
    w = stack(square_to_uniform_cone(square(3), f(one_minus_cos))).astype(float)
    # The share of the solid angle within an angle t is (1 - cos t) / (1 - cos t_max). From the
    # sine: 1 - cos itself is rounded away in narrow cones.
    sine2 = w[0] ** 2 + w[1] ** 2
    share = sine2 / (1.0 + np.sqrt(np.maximum(0.0, 1.0 - sine2))) / one_minus_cos
    assert share.max() <= 1.0 + 1e-5
    counts, _ = np.histogram(share, 50, (0.0, 1.0 + 1e-5))
    assert chi_square([*counts, 0], np.full(50, 0.02)) > SIGNIFICANCE


def test_narrow_directions_keep_their_angle():
    w = direction_around_z(f([1e-10]), f([0.1]))
    assert np.hypot(w.x[0], w.y[0]) == pytest.approx(np.sqrt(2e-10), rel=1e-6)


@pytest.mark.parametrize("warp", [square_to_disk_concentric, square_to_disk_polar])
def test_disk_points_are_uniform(warp):
    x, y = (v.astype(float) for v in warp(square(4)))
    # Rings of equal area, and sectors.
    ring = np.minimum((x * x + y * y) * 16.0, 15.999).astype(int)
    sector = (np.arctan2(y, x) / (2.0 * np.pi) % 1.0 * 16.0).astype(int) % 16
    counts = np.bincount(16 * ring + sector, minlength=256)
    assert chi_square([*counts, 0], np.full(256, 1.0 / 256.0)) > SIGNIFICANCE
    assert np.max(np.hypot(x, y)) <= 1.0 + 1e-7
    np.testing.assert_array_equal(disk_pdf(f(0.999 * x), f(0.999 * y)), f(1.0 / np.pi))


def test_polar_points_have_the_radius_and_the_angle_that_are_stated():
    u = square(4)
    x, y = (v.astype(float) for v in square_to_disk_polar(u))
    np.testing.assert_allclose(np.hypot(x, y), np.sqrt(u[0]), atol=1e-6)
    turn = 2.0 * np.pi * u[1].astype(float)
    np.testing.assert_allclose(x * np.sin(turn), y * np.cos(turn), atol=1e-6)
    assert np.all(x * np.cos(turn) + y * np.sin(turn) >= 0.0)


INVERSES = {
    "disk": (square_to_disk_concentric, disk_to_square_concentric),
    "triangle": (square_to_triangle, triangle_to_square),
    "sphere": (lambda u2: (square_to_uniform_sphere(u2),), uniform_sphere_to_square),
}


@pytest.mark.parametrize("name", INVERSES)
def test_inverses_lead_back_to_the_square(name):
    warp, inverse = INVERSES[name]
    for u in (square(5), corners_and_edges()):
        back = np.stack(inverse(*warp(u))).astype(float)
        off = np.abs(back - np.stack(u))
        if name == "sphere":
            # Once around is where it began; at the poles it is anywhere.
            off[1] = np.minimum(off[1], 1.0 - off[1]) * (np.abs(u[0] - 0.5) < 0.499)
        assert np.max(off) < 1e-6


@pytest.mark.parametrize("warp", [square_to_disk_concentric, square_to_disk_polar])
def test_disk_points_stay_inside_at_the_ends_of_the_square(warp):
    x, y = warp(corners_and_edges())
    assert np.all(np.isfinite(x)) and np.max(np.hypot(x.astype(float), y)) <= 1.0 + 1e-7


def test_the_concentric_disk_keeps_neighbours_together():
    u = np.linspace(0.0, 1.0, 513)[:-1].astype(f)
    a, b = np.meshgrid(u, u)
    x, y = (v.reshape(a.shape) for v in square_to_disk_concentric((a.ravel(), b.ravel())))
    for axis in (0, 1):
        step = np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis))
        # A map without tears: at most pi / 2 times 2 per unit of u.
        assert step.max() < 1.01 * np.pi / 512.0


def test_triangle_points_are_uniform():
    b1, b2 = (v.astype(float) for v in square_to_triangle(square(5)))
    assert min(b1.min(), b2.min(), (1.0 - b1 - b2).min()) >= -1e-7
    # The classic inverse map sends uniform points back to a uniform square.
    s = np.clip((b1 + b2) ** 2, 0.0, 0.999999)
    t = np.clip(b2 / np.maximum(b1 + b2, 1e-12), 0.0, 0.999999)
    counts = np.bincount(16 * (16 * s).astype(int) + (16 * t).astype(int), minlength=256)
    assert chi_square([*counts, 0], np.full(256, 1.0 / 256.0)) > SIGNIFICANCE


def test_triangle_points_stay_inside_at_the_ends_of_the_square():
    b1, b2 = square_to_triangle(corners_and_edges())
    assert min(b1.min(), b2.min(), (1.0 - b1 - b2).min()) >= -1e-7
