"""The cylinder: its roots, open ends, surface, area and bounds."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.lights.area import Area
from alight.scene.transform import scale
from alight.shapes import cylinder
from alight.shapes.cylinder import Cylinder
from tests.accel.tracing import World as Accelerated
from tests.accel.tracing import same_bits
from tests.lights.test_light_sampling import sample
from tests.shapes.tracing import PLACEMENTS, World, bounce, directions, rows, unit

IDENTITY = np.eye(4)
SLANTED = Cylinder(p0=(0.3, -0.5, 0.2), p1=(-0.4, 0.9, 1.1), radius=0.7)
N = 20_000

each_placement = pytest.mark.parametrize("placement", PLACEMENTS.values(), ids=PLACEMENTS)


def distance(o, d, shape=None, t_max=np.inf):
    """t of one ray with one cylinder, by default the unit one; infinity for a miss."""
    world = World((shape or Cylinder(), IDENTITY))
    column = [np.array([float(x)]) for x in o], [np.array([float(x)]) for x in d]
    return float(world.trace(*column, t_max).t[0])


def frame(shape, placement):
    """The map from the unit cylinder, worked out here: (3, 3) matrix and origin."""
    axis = np.subtract(shape.p1, shape.p0)
    a = unit(axis)
    x = unit(np.cross(a, [0.36, -0.48, 0.8]))
    linear = placement[:3, :3] @ np.stack(
        [shape.radius * x, shape.radius * np.cross(a, x), axis], axis=1
    )
    return linear, placement[:3, :3] @ shape.p0 + placement[:3, 3]


# ---------------------------------------------------------------- roots


def test_two_roots():
    assert distance((-5, 0, 0.5), (1, 0, 0)) == pytest.approx(4.0, rel=1e-6)
    # A chord at distance 0.6 from the axis is 1.6 long.
    assert distance((0.6, -5, 0.5), (0, 1, 0)) == pytest.approx(4.2, rel=1e-6)


def test_no_root():
    assert distance((1.0001, -5, 0.5), (0, 1, 0)) == np.inf
    assert distance((5, 0, 0.5), (1, 0, 0)) == np.inf  # both are behind
    assert distance((-5, 0, 0.5), (1, 0, 0), t_max=3.9) == np.inf


def test_from_inside():
    assert distance((0.5, 0, 0.5), (1, 0, 0)) == pytest.approx(0.5, rel=1e-6)
    assert distance((0.5, 0, 0.5), (-1, 0, 0)) == pytest.approx(1.5, rel=1e-6)


def test_both_ends_are_open():
    assert distance((0.2, 0.3, 5), (0, 0, -1)) == np.inf
    assert distance((-5, 0, 1.001), (1, 0, 0)) == np.inf
    assert distance((-5, 0, -0.001), (1, 0, 0)) == np.inf
    # In through the end, out at the mantle: the far root.
    assert distance((0, 0, 1.5), (0.8, 0, -0.6)) == pytest.approx(1.25, rel=1e-6)
    # Over the near rim to the far wall.
    assert distance((-2, 0, 1.5), (0.96, 0, -0.28)) == pytest.approx(3.125, rel=1e-6)


def test_parallel_to_the_axis():
    for x in (0.0, 0.5, 1.0, 2.0):
        for z in (-3.0, 0.5):
            assert distance((x, 0, z), (0, 0, 1)) == np.inf
            assert distance((0, x, z), (0, 0, -1)) == np.inf


def test_far_away_a_thin_cylinder_keeps_its_width():
    world = World((Cylinder(p0=(0, 0, -1), radius=0.01), IDENTITY))
    offset = np.linspace(-0.02, 0.02, 401)
    offset = offset[np.abs(np.abs(offset) - 0.01) > 1e-4]
    zero = np.zeros_like(offset)
    hit = world.trace((zero - 1e3, offset, zero), (zero + 1.0, zero, zero))
    np.testing.assert_array_equal(np.isfinite(hit.t), np.abs(offset) < 0.01)


@each_placement
def test_meets_the_image_of_the_unit_cylinder(placement):
    rng = np.random.default_rng(2)
    linear, origin = frame(SLANTED, placement)
    d = directions(N, rng)
    o = (origin[:, None] - 4.0 * d + rng.uniform(-2, 2, (3, N))).astype(np.float32).astype(float)
    d = d.astype(np.float32).astype(float)
    inverse = np.linalg.inv(linear)
    f, w = inverse @ (o - origin[:, None]), inverse @ d
    a, b, c = (w[:2] ** 2).sum(0), -(f[:2] * w[:2]).sum(0), (f[:2] ** 2).sum(0) - 1.0
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    t = np.stack([(b - root) / a, (b + root) / a])
    z = f[2] + t * w[2]
    good = (b * b >= a * c) & (t > 0.0) & (z >= 0.0) & (z <= 1.0)
    expected = np.where(good, t, np.inf).min(0)
    clear = (np.abs(b * b - a * c) > 1e-3 * a) & (np.abs(z * (1.0 - z)) > 1e-3).all(0)
    found = World((SLANTED, placement)).trace(o, d).t
    np.testing.assert_allclose(found[clear], expected[clear], rtol=1e-4, atol=1e-5)
    assert np.isfinite(expected[clear]).sum() > 1000


# ---------------------------------------------------------------- surface


@each_placement
@pytest.mark.parametrize("flip", [False, True])
def test_points_normals_and_coordinates(placement, flip):
    rng = np.random.default_rng(3)
    shape = SLANTED.replaced(flip_normals=flip)
    linear, origin = frame(shape, placement)
    d = directions(N, rng)
    o = origin[:, None] + linear @ rng.uniform(-1, 1, (3, N)) - 3.0 * d
    _, g, found = World((shape, placement)).surface(o.astype(np.float32), d.astype(np.float32))
    p, n = rows(g.p)[:, found], rows(g.ng)[:, found]
    q = np.linalg.inv(linear) @ (p - origin[:, None])
    radius = np.hypot(q[0], q[1])
    outward = np.stack([q[0], q[1], 0 * radius])
    gradient = np.linalg.inv(linear).T @ outward
    # The bound holds, and it is no larger than a few roundings.
    assert np.all(np.abs(radius - 1.0) / np.linalg.norm(gradient, axis=0) <= g.error[found])
    assert np.all(g.error[found] < 1e-4)
    np.testing.assert_allclose(n, unit(gradient) * (-1 if flip else 1), atol=1e-5)
    np.testing.assert_allclose(g.v[found], q[2], atol=1e-5)
    # u runs once around; its direction is the tangent.
    around = unit(linear @ np.stack([-q[1], q[0], 0 * radius]))
    np.testing.assert_allclose(rows(g.s)[:, found], around, atol=1e-4)
    turn = np.arctan2(q[1], q[0]) / (2.0 * np.pi) - g.u[found]
    spread = np.abs(np.exp(2j * np.pi * (turn - turn[0])) - 1.0)
    assert spread.max() < 1e-3


def test_the_angle_starts_where_mitsuba_has_it():
    # Found by experiment: a cylinder along y has its x there and its y along -z.
    world = World((Cylinder(p0=(1, 0, 0), p1=(1, 3, 0), radius=0.5), IDENTITY))
    o, d = np.array([[5.0], [0.2], [0.3]]), np.array([[-1.0], [0.0], [0.0]])
    hit, g, _ = world.surface(o, d)
    assert float(hit.t[0]) == pytest.approx(3.6, rel=1e-6)
    assert float(g.u[0]) == pytest.approx(0.8976, abs=1e-4)
    assert float(g.v[0]) == pytest.approx(0.0667, abs=1e-4)


def test_compiled_is_the_twin():
    rng = np.random.default_rng(4)
    world = World((SLANTED, PLACEMENTS["sheared"]))
    d = directions(512, rng)
    o = rng.uniform(-1, 1, (3, 512)) - 3.0 * d
    leaving = directions(512, rng)
    a, b = (bounce(world, o, d, leaving, compiled=c) for c in (True, False))
    assert a.found.sum() > 100
    np.testing.assert_array_equal(a.found, b.found)
    np.testing.assert_allclose(a.t[a.found], b.t[a.found], rtol=1e-5)
    np.testing.assert_allclose(a.p[:, a.found], b.p[:, a.found], atol=1e-5)


def test_a_tree_of_cylinders_finds_what_a_list_finds():
    rng = np.random.default_rng(5)
    shapes, rows_ = [], []
    for i in range(80):
        p0 = rng.normal(size=3)
        shape = Cylinder(p0=tuple(p0), p1=tuple(p0 + rng.normal(size=3) * 0.5), radius=0.1)
        row = cylinder.pack(shape, IDENTITY)
        shapes.append(("cylinder", i, cylinder.STRIDE * i, *cylinder.bounds(row)))
        rows_.append(row)
    o = rng.uniform(-2, 2, (20_000, 3)).astype(np.float32)
    d = directions(20_000, rng).T.astype(np.float32)
    listed, tree = (
        Accelerated(None, shapes, data=np.concatenate(rows_), structure=s).trace(o, d)
        for s in ("list", "bvh")
    )
    assert same_bits(listed, tree)
    assert len(set(listed.shape[np.isfinite(listed.t)])) > 70


# ---------------------------------------------------------------- area and bounds


def test_area_of_round_and_elliptic_cylinders():
    def area(shape, matrix):
        return cylinder.area(cylinder.pack(shape, matrix))

    round_ = Cylinder(p0=(1, 2, 3), p1=(1, 2, 7), radius=0.25)
    assert area(round_, IDENTITY) == pytest.approx(2.0 * np.pi * 0.25 * 4.0, rel=1e-6)
    # The perimeter of the ellipse with half axes 2 and 1: 8 E(3/4), Abramowitz and Stegun 17.3.
    assert area(Cylinder(), scale(2, 1, 5).matrix) == pytest.approx(5 * 9.688448220547675, rel=1e-6)


@each_placement
def test_area_is_the_integral_of_its_elements(placement):
    linear, _ = frame(SLANTED, placement)
    phi = np.linspace(0.0, 2.0 * np.pi, 2001)
    ring = linear[:, :2] @ np.stack([np.cos(phi), np.sin(phi)])
    sides = np.cross(np.diff(ring, axis=1), linear[:, 2:], axis=0)
    exact = np.linalg.norm(sides, axis=0).sum()
    row = cylinder.pack(SLANTED, placement)
    assert cylinder.area(row) == pytest.approx(exact, rel=1e-5)


@each_placement
def test_bounds_hold_the_surface_tightly(placement):
    linear, origin = frame(SLANTED, placement)
    phi, z = np.meshgrid(np.linspace(0, 2 * np.pi, 500), [0.0, 1.0])
    points = linear @ np.stack([np.cos(phi), np.sin(phi), z]).reshape(3, -1) + origin[:, None]
    low, high = cylinder.bounds(cylinder.pack(SLANTED, placement))
    assert np.all(points.min(1) >= low)
    assert np.all(points.max(1) <= high)
    np.testing.assert_allclose(points.min(1), low, atol=1e-3)
    np.testing.assert_allclose(points.max(1), high, atol=1e-3)


# ---------------------------------------------------------------- as a light


def test_a_lamp_around_a_point_lights_it_as_the_integral_says():
    # Seen from the middle the wall covers the angles from atan(r / h) to 90 degrees of the upper
    # half: E = pi L h^2 / (h^2 + r^2) on a surface across the axis.
    r, h = 0.8, 1.5
    shape = Cylinder(p0=(0, 0, -h), p1=(0, 0, h), radius=r, flip_normals=True)
    s = sample(World((shape, IDENTITY, Area(radiance=2.0))), (0, 0, 0), 800_000)
    cosine = np.maximum(rows(s.wi)[2], 0.0)
    values = np.where(s.pdf > 0.0, rows(s.radiance)[0] * cosine / np.maximum(s.pdf, 1e-9), 0.0)
    exact = 2.0 * np.pi * h * h / (h * h + r * r)
    error = values.std() / np.sqrt(len(values))
    assert 4.5 * error < 0.007 * exact
    assert abs(values.mean() - exact) < 4.5 * error


def test_a_lamp_shines_outwards_by_its_view_factor():
    # A small surface that looks along the axis of a cylinder from the side sees one half of it:
    # by quadrature over the wall that faces it.
    r, h, x = 0.8, 1.5, 2.0
    shape = Cylinder(p0=(0, 0, 0), p1=(0, 0, h), radius=r)
    s = sample(World((shape, IDENTITY, Area(radiance=2.0))), (x, 0, 0), 1_600_000)
    cosine = np.maximum(rows(s.wi)[2], 0.0)
    values = np.where(s.pdf > 0.0, rows(s.radiance)[0] * cosine / np.maximum(s.pdf, 1e-9), 0.0)
    phi = (np.arange(4000) + 0.5) * (2.0 * np.pi / 4000)
    z = ((np.arange(2000) + 0.5) * (h / 2000))[:, None]
    to_wall = r * np.cos(phi) - x, r * np.sin(phi)
    squared = to_wall[0] ** 2 + to_wall[1] ** 2 + z * z
    facing = np.maximum(-(to_wall[0] * np.cos(phi) + to_wall[1] * np.sin(phi)), 0.0)
    exact = 2.0 * (z * facing / squared**2).sum() * (2.0 * np.pi * r / 4000) * (h / 2000)
    error = values.std() / np.sqrt(len(values))
    assert 4.5 * error < 0.007 * exact
    assert abs(values.mean() - exact) < 4.5 * error


@pytest.mark.parametrize("p", [(0, 0, 0), (1, -2, 3)])
def test_an_axis_without_length_is_refused(p):
    ends = [np.array(p), *(p + np.eye(3))]
    refused = []
    for end in ends:
        try:
            Cylinder(p0=p, p1=end)
        except SceneError as error:
            assert "p0 and p1 must differ" in str(error)
            refused.append(end)
    assert [*map(tuple, refused)] == [p]
