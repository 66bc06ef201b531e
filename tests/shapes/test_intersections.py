"""Ray-shape intersections against their formulas, in float64 and by hand."""

import numpy as np
import pytest

from alight.shapes.cube import Cube
from alight.shapes.disk import Disk
from alight.shapes.mesh import Mesh
from alight.shapes.plane import Plane
from alight.shapes.rectangle import Rectangle
from alight.shapes.sphere import Sphere
from tests.shapes.tracing import PLACEMENTS, World, directions, unit

TRIANGLE = Mesh(vertices=((-1, -1, 0), (1, -1, 0), (0, 1, 0)), faces=((0, 1, 2),))
IDENTITY = np.eye(4)
FLAT = {"plane": Plane(), "rectangle": Rectangle(), "disk": Disk(), "mesh": TRIANGLE}

each_flat_shape = pytest.mark.parametrize("shape", FLAT.values(), ids=FLAT)
each_placement = pytest.mark.parametrize("placement", PLACEMENTS.values(), ids=PLACEMENTS)


def distance(world, o, d, t_max=np.inf):
    """t of one ray; infinity for a miss."""
    column = [np.array([x]) for x in o], [np.array([x]) for x in d]
    return float(world.trace(*column, t_max).t[0])


# ---------------------------------------------------------------- sphere


def test_sphere_two_roots():
    world = World((Sphere(), IDENTITY))
    assert distance(world, (0, 0, -5), (0, 0, 1)) == pytest.approx(4.0, rel=1e-6)
    # A chord at distance 0.6 from the centre is 1.6 long.
    assert distance(world, (0.6, 0, -5), (0, 0, 1)) == pytest.approx(4.2, rel=1e-6)


def test_sphere_one_root_at_a_tangent():
    world = World((Sphere(), IDENTITY))
    assert distance(world, (1, 0, -5), (0, 0, 1)) == pytest.approx(5.0, rel=1e-6)


def test_sphere_no_root():
    world = World((Sphere(), IDENTITY))
    assert distance(world, (1.0001, 0, -5), (0, 0, 1)) == np.inf
    assert distance(world, (0, 0, 5), (0, 0, 1)) == np.inf  # both roots are behind


def test_sphere_with_the_origin_inside():
    world = World((Sphere(), IDENTITY))
    assert distance(world, (0, 0, 0.5), (0, 0, 1)) == pytest.approx(0.5, rel=1e-6)
    assert distance(world, (0, 0, 0.5), (0, 0, -1)) == pytest.approx(1.5, rel=1e-6)
    assert distance(world, (0, 0, 0), (0, 1, 0)) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("far", [1e2, 1e3, 1e4])
def test_small_far_sphere_keeps_its_shape(far):
    # b^2 - a C has lost the radius here: 1e-4 of 1e8.
    world = World((Sphere(radius=0.01), IDENTITY))
    offset = np.linspace(-0.02, 0.02, 401)
    offset = offset[np.abs(np.abs(offset) - 0.01) > 1e-4]
    zero = np.zeros_like(offset)
    hit = world.trace((offset, zero, zero - far), (zero, zero, zero + 1.0))
    np.testing.assert_array_equal(np.isfinite(hit.t), np.abs(offset) < 0.01)


def test_ground_sphere_is_as_exact_as_a_floor_near_the_origin():
    radius = 1e4
    world = World((Sphere(center=(0, -radius, 0), radius=radius), IDENTITY))
    rng = np.random.default_rng(1)
    o, d = rng.uniform(-1, 1, (3, 5000)), directions(5000, rng)
    o[1], d[1] = rng.uniform(0.1, 1, 5000), -np.abs(d[1]) - 0.05
    o, d = o.astype(np.float32).astype(float), unit(d).astype(np.float32).astype(float)
    _, g, found = world.surface(o, d)
    assert found.all()
    p = np.array([g.p.x, g.p.y, g.p.z], float)
    p[1] += radius
    height = np.linalg.norm(p, axis=0) - radius
    p[1] -= radius
    assert np.all(np.abs(height) <= g.error)
    # A single ulp of the radius is 1e-3.
    assert np.all(g.error[np.linalg.norm(p, axis=0) < 2.0] < 2e-6)


@each_placement
def test_sphere_meets_the_ellipsoid_of_its_transform(placement):
    rng = np.random.default_rng(2)
    world = World((Sphere(center=(0.1, 0.2, -0.3), radius=0.8), placement))
    d = directions(20_000, rng)
    o = placement[:3, 3:] - 4.0 * d + rng.uniform(-2, 2, (3, 20_000))
    o, d = o.astype(np.float32).astype(float), d.astype(np.float32).astype(float)
    inverse = np.linalg.inv(placement)
    f = (inverse[:3, :3] @ o + inverse[:3, 3:] - [[0.1], [0.2], [-0.3]]) / 0.8
    w = inverse[:3, :3] @ d / 0.8
    a, b, c = (w * w).sum(0), -(f * w).sum(0), (f * f).sum(0) - 1.0
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    roots = np.stack([(b - root) / a, (b + root) / a])
    expected = np.where(roots > 0, roots, np.inf).min(0)
    clear = np.abs(b * b - a * c) > 1e-4 * a
    expected[b * b < a * c] = np.inf
    np.testing.assert_allclose(world.trace(o, d).t[clear], expected[clear], rtol=2e-5, atol=2e-5)
    assert np.isfinite(expected).sum() > 500


# ---------------------------------------------------------------- flat shapes


@each_flat_shape
@each_placement
def test_flat_shapes_meet_the_plane_of_their_transform(shape, placement):
    rng = np.random.default_rng(3)
    world = World((shape, placement))
    target = rng.uniform(-1.2, 1.2, (3, 20_000))
    target[2] = 0.0
    d = directions(20_000, rng)
    o = placement[:3, :3] @ target + placement[:3, 3:] - 3.0 * d
    o, d = o.astype(np.float32).astype(float), d.astype(np.float32).astype(float)
    inverse = np.linalg.inv(placement)
    f, w = inverse[:3, :3] @ o + inverse[:3, 3:], inverse[:3, :3] @ d
    t = -f[2] / w[2]
    x, y = f[0] + t * w[0], f[1] + t * w[1]
    margins = {
        "plane": np.full_like(x, np.inf),
        "rectangle": 1.0 - np.maximum(np.abs(x), np.abs(y)),
        "disk": 1.0 - np.hypot(x, y),
        "mesh": np.minimum(y + 1.0, 1.0 - y - 2.0 * np.abs(x)),
    }
    margin = margins[shape.type_name()]
    clear = (np.abs(margin) > 1e-4) & (np.abs(w[2]) > 1e-3)
    expected = np.where((margin > 0) & (t > 0), t, np.inf)
    np.testing.assert_allclose(world.trace(o, d).t[clear], expected[clear], rtol=1e-4)


@each_flat_shape
def test_ray_parallel_to_the_plane_misses(shape):
    world = World((shape, IDENTITY))
    for d in [(1, 0, 0), (0, -1, 0), (0.6, 0.8, 0)]:
        assert distance(world, (0.1, 0.2, 0.5), d) == np.inf
        assert distance(world, (0.1, 0.2, -0.5), d) == np.inf


@each_flat_shape
def test_ray_in_the_plane_misses(shape):
    world = World((shape, IDENTITY))
    for d in [(1, 0, 0), (0, -1, 0), (0.6, 0.8, 0)]:
        assert distance(world, (-0.3, 0.2, 0), d) == np.inf


SOLID = {**FLAT, "sphere": Sphere()}


@pytest.mark.parametrize("shape", SOLID.values(), ids=SOLID)
def test_t_interval_is_open_at_zero_and_closed_at_its_end(shape):
    top = 1.0 if shape.type_name() == "sphere" else 0.0
    world = World((shape, IDENTITY))
    o, d = (0.0, 0.0, top + 2.0), (0.0, 0.0, -1.0)
    assert distance(world, o, d, 2.0) == 2.0
    assert distance(world, o, d, np.nextafter(np.float32(2.0), np.float32(0.0))) == np.inf
    assert distance(world, (0.0, 0.0, top), (0.0, 0.0, 1.0)) == np.inf  # t = 0 at the origin
    assert distance(world, o, (0.0, 0.0, 1.0)) == np.inf  # behind


@pytest.mark.parametrize("shape", SOLID.values(), ids=SOLID)
def test_t_counts_in_lengths_of_d(shape):
    world = World((shape, IDENTITY))
    o = (0.1, -0.2, 4.0)
    assert distance(world, o, (0, 0, -4)) == pytest.approx(
        distance(world, o, (0, 0, -1)) / 4.0, rel=1e-6
    )


def test_directions_along_the_axes_and_zeros_give_no_nan():
    world = World(*((shape, PLACEMENTS["sheared"]) for shape in SOLID.values()))
    axes = np.concatenate([np.eye(3), -np.eye(3)], axis=1)
    o = np.repeat([[0.3], [0.1], [2.0]], 6, axis=1)
    assert not np.isnan(world.trace(o, axes).t).any()


# ---------------------------------------------------------------- cube


def test_cube_is_six_rectangles_with_outward_normals():
    rng = np.random.default_rng(4)
    world = World((Cube(), PLACEMENTS["stretched"]))
    assert [row.kind for row in world.shapes.rows] == ["rectangle"] * 6
    d = directions(4000, rng)
    center = PLACEMENTS["stretched"][:3, 3:]
    o = center - 10.0 * d + rng.uniform(-0.2, 0.2, (3, 1))
    _, g, found = world.surface(o, d)
    outward = g.ng.x * d[0] + g.ng.y * d[1] + g.ng.z * d[2]
    assert found.sum() > 1000
    assert np.all(outward[found] < 0.0)


@pytest.mark.parametrize("placement", [PLACEMENTS["moved"], PLACEMENTS["stretched"]])
def test_no_ray_leaks_through_the_edges_of_a_cube(placement):
    rng = np.random.default_rng(5)
    n = 100_000
    world = World((Cube(), placement))
    # From inside, exactly at the edges and corners.
    edge = rng.uniform(-1, 1, (3, n))
    axis = rng.integers(0, 3, n)
    edge = np.where(np.arange(3)[:, None] == axis, edge, np.sign(edge))
    o = placement[:3, :3] @ rng.uniform(-0.9, 0.9, (3, n)) + placement[:3, 3:]
    o = o.astype(np.float32).astype(float)
    d = unit(placement[:3, :3] @ edge + placement[:3, 3:] - o)
    assert np.isfinite(world.trace(o, d).t).all()
