"""Rays that leave a surface never meet it again, and shadow rays end just before their light."""

import numpy as np
import pytest

from alight.accel.other_leaves import to_object
from alight.core.constants import gamma
from alight.lights.area import Area
from alight.lights.sampling import sample_light, shadow_ray
from alight.scene.transform import scale, translate
from alight.shapes.cylinder import Cylinder
from alight.shapes.hit import Hit, shadow_length, spawn_origin
from alight.shapes.mesh import Mesh
from alight.shapes.plane import Plane
from alight.shapes.rectangle import Rectangle
from alight.shapes.sphere import Sphere
from alight.shapes.triangle import rotated, shear_of, sheared_hit
from lanewise.jit import instantiate
from lanewise.view import View
from tests.shapes.tracing import (
    PLACEMENTS,
    PROGRAM,
    World,
    bounce,
    directions,
    one_of_each,
    rows,
    unit,
    vec,
)

TRIANGLE = Mesh(vertices=((0, 0, 0), (1, 0, 0), (0.2, 1, 0.3)), faces=((0, 1, 2),))
SHAPES = one_of_each(mesh=TRIANGLE, cylinder=Cylinder(p0=(0, 0, -1)))
FINITE = {name: shape for name, shape in SHAPES.items() if shape.finite}
#: All others are flat and lie in the plane z = 0, the triangle nearly so.
ROUND = ("sphere", "cylinder")

each_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)

#: 27 worlds of 40 000 rays make a million a shape.
RAYS = 40_000
WORLDS = [
    (size, offset, placement)
    for size in (1e-3, 1.0, 1e4)
    for offset in (0.0, 10.0, 1e3)
    for placement in ("moved", "stretched", "sheared")
]


def local_points(shape, n, rng):
    """Points on a shape in its own space, (3, n)."""
    kind = shape.type_name()
    if kind == "sphere":
        return directions(n, rng)
    if kind == "cylinder":
        phi = rng.uniform(0.0, 2.0 * np.pi, n)
        return np.stack([np.cos(phi), np.sin(phi), rng.uniform(-0.98, 0.98, n)])
    if kind == "mesh":
        return np.asarray(shape.vertices, float).T @ rng.dirichlet((1, 1, 1), n).T
    points = rng.uniform(-0.7, 0.7, (3, n))
    points[2] = 0.0
    # A plane to its horizon.
    return points * 10.0 ** rng.uniform(-2, 3, n) if kind == "plane" else points


def rays_to(points, far, rng):
    """Rays that meet points (3, n) from about as far as `far`: origins and directions."""
    d = directions(points.shape[1], rng)
    o = (points - d * far * 10.0 ** rng.uniform(-1, 2, d.shape[1])).astype(np.float32)
    return o, unit(points - o).astype(np.float32)


def leaving(n, rng):
    """Local directions to both sides, cosines of all sizes down to 1e-8."""
    cosine = 10.0 ** rng.uniform(-8, 0, n) * rng.choice([-1, 1], n)
    sine, phi = np.sqrt(1.0 - cosine**2), rng.uniform(0, 2 * np.pi, n)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine])


@each_shape
def test_a_million_rays_leave_their_surface(shape):
    rng = np.random.default_rng(1)
    for size, offset, placement in WORLDS:
        moved = translate(offset, -0.7 * offset, 0.3 * offset) @ scale(size)
        place = moved.matrix @ PLACEMENTS[placement]
        points = place[:3, :3] @ local_points(shape, RAYS, rng) + place[:3, 3:]
        r = bounce(World((shape, place)), *rays_to(points, size, rng), leaving(RAYS, rng))
        # Rounding of the corners may take a ray off a shape no larger than a few roundings.
        assert r.found.mean() > (0.85 if offset / size > 1e5 else 0.95)
        met_again = np.isfinite(r.again)
        inwards = r.side < 0.0
        if shape.type_name() == "sphere":
            # Inwards there is always the far side, outwards nothing.
            np.testing.assert_array_equal(met_again[r.found], inwards[r.found])
        elif shape.type_name() == "cylinder":
            # Outwards nothing; inwards the other side, unless the ray leaves through an end.
            assert not met_again[r.found & ~inwards].any(), (size, offset, placement)
            assert met_again[r.found & inwards].mean() > 0.3
        else:
            assert not met_again[r.found].any(), (size, offset, placement)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("name", [name for name in SHAPES if name not in ROUND])
def test_rays_leave_the_plane_of_the_axes(name, size):
    # Here all coordinates along the normal are 0, and so are their rounding errors.
    rng = np.random.default_rng(8)
    floor = Mesh(vertices=((0, 0, 0), (1, 0, 0), (0.2, 1, 0)), faces=((0, 1, 2),))
    shape, place = (floor if name == "mesh" else SHAPES[name]), scale(size).matrix
    points = place[:3, :3] @ local_points(shape, RAYS, rng)
    r = bounce(World((shape, place)), *rays_to(points, size, rng), leaving(RAYS, rng))
    assert r.found.mean() > 0.95
    assert not np.isfinite(r.again[r.found]).any()


def test_a_tiny_and_a_huge_sphere_in_one_scene():
    rng = np.random.default_rng(2)
    tiny, huge, n = 1e-3, 1e4, 200_000
    world = World(
        (Sphere(center=(0, tiny, 0), radius=tiny), np.eye(4)),
        (Sphere(center=(0, -huge, 0), radius=huge), np.eye(4)),
    )
    points = directions(n, rng) * tiny + [[0], [tiny], [0]]
    points[:, ::2] = rng.uniform(-3 * tiny, 3 * tiny, (3, n // 2))
    points[1, ::2] = -huge + np.sqrt(huge**2 - points[0, ::2] ** 2 - points[2, ::2] ** 2)
    d = directions(n, rng)
    d[1] = -np.abs(d[1])
    o = (points - d * 10.0 ** rng.uniform(-2, 1, n)).astype(np.float32)
    r = bounce(world, o, unit(points - o), leaving(n, rng))
    assert r.found.all()
    assert {0.0, 1.0} == set(r.shape)
    outwards = r.side > 0.0
    # No acne: a ray that leaves a sphere does not meet the same one.
    assert not np.any(outwards & np.isfinite(r.again) & (r.again_shape == r.shape))
    # No leak: inside a sphere it is met again; and the ground beside the ball is dark beneath it.
    assert np.all(np.isfinite(r.again[~outwards]))
    assert np.all(r.error < 1e-6)


@pytest.mark.parametrize("gap", [1e-4, 1e-5])
def test_a_ray_stays_between_near_planes(gap):
    rng = np.random.default_rng(3)
    turn = PLACEMENTS["moved"]
    world = World((Plane(), turn), (Plane(), turn @ translate(0, 0, gap).matrix))
    inside = rng.uniform(-1, 1, (3, RAYS))
    inside[2] = 0.5 * gap
    o = turn[:3, :3] @ inside + turn[:3, 3:]
    r = bounce(world, o, directions(RAYS, rng), leaving(RAYS, rng))
    into_gap = r.found & ((r.side > 0) == (r.shape == 0))
    assert into_gap.sum() > RAYS // 4
    met = np.isfinite(r.again[into_gap])
    # Planes are endless: only rays within rounding of parallel get lost.
    assert np.mean(met) > 0.9
    np.testing.assert_array_equal(r.again_shape[into_gap][met], 1.0 - r.shape[into_gap][met])


# ---------------------------------------------------------------- shadow rays


def lit_points(shape, placement, n, rng):
    """A light, points around it with their surfaces, and samples of the light."""
    floor = translate(0, 0, -4).matrix @ scale(50.0).matrix
    world = World((shape, placement, Area()), (Rectangle(), floor))
    o = np.stack([rng.uniform(-9, 9, n), rng.uniform(-9, 9, n), np.full(n, -3.0)])
    d = np.tile([[0.0], [0.0], [-1.0]], n)
    _, surface, found = world.surface(o, d)
    assert found.all()
    sample = instantiate(sample_light, PROGRAM, compiled=False)
    u = rng.random((3, n), np.float32)
    with np.errstate(all="ignore"):
        light = sample(world.scene, surface.p, surface.ns, u[0], (u[1], u[2]), found)
        start, length = shadow_ray(surface, light)
    return world, surface, light, rows(start), np.broadcast_to(length, (n,))


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("name", FINITE)
def test_shadow_rays_do_not_meet_their_light(name, placement):
    rng = np.random.default_rng(4)
    place = PLACEMENTS[placement]
    # Flat ones both ways up, so that some points see the bright side.
    shapes = [FINITE[name]]
    if name not in ROUND:
        shapes.append(FINITE[name].replaced(flip_normals=True))
    world, surface, light, o, length = max(
        (lit_points(shape, place, 20_000, rng) for shape in shapes),
        key=lambda case: np.count_nonzero(case[2].pdf > 0.0),
    )
    lit = light.pdf > 0.0
    assert lit.sum() > 2000
    t_max = np.where(lit, length, 1.0).astype(np.float32)
    hit = world.trace(o, rows(light.wi), t_max)
    assert not np.isfinite(hit.t[lit]).any()
    # ... and end just before it: float32 errors over the cosine.
    band = 2.0 * (light.error + surface.error + gamma(24) * light.distance)
    steep = lit & (light.cosine > 0.01)
    short = (light.distance - t_max)[steep]
    assert np.all(short <= (np.broadcast_to(band, lit.shape) / light.cosine)[steep])
    assert np.median(short) < 1e-4


@pytest.mark.parametrize("middle", [(0.0, 0.0, 0.0), (2000.0, -1000.0, 500.0)], ids=["here", "far"])
@pytest.mark.parametrize("name", FINITE)
def test_shadow_rays_from_the_air_do_not_meet_their_light(name, middle):
    """In fog nothing but the light has an error, which is what counts just in front of it."""
    rng = np.random.default_rng(9)
    sample = instantiate(sample_light, PROGRAM, compiled=False)
    for placement in PLACEMENTS.values():
        place = translate(*middle).matrix @ placement
        world = World((FINITE[name], place, Area()))
        p = place[:3, :3] @ local_points(FINITE[name], 20_000, rng) + place[:3, 3:]
        p += rng.normal(size=p.shape) * 10.0 ** rng.uniform(-3, 1, 20_000)
        p, u = vec(p.astype(np.float32)), rng.random((3, 20_000), np.float32)
        with np.errstate(all="ignore"):
            light = sample(world.scene, p, vec(np.zeros((3, 20_000))), u[0], (u[1], u[2]), True)
            length = shadow_length(light.distance, light.cosine, light.error, 0.0)
        # Edge-on half of the way is searched in any case.
        lit = (light.pdf > 0.0) & (length > 0.5 * light.distance)
        assert lit.sum() > 2000
        hit = world.trace(rows(p), rows(light.wi), np.where(lit, length, 1.0))
        assert not np.isfinite(hit.t[lit]).any()
        short = (light.distance - length)[lit & (light.cosine > 0.1)]
        assert np.median(short) < 1e-4 + 4e-6 * np.abs(middle).max()


@pytest.mark.parametrize("name", ["sphere", *(name for name in FINITE if name not in ROUND)])
def test_a_blocker_just_in_front_of_a_light_is_not_missed(name):
    rng = np.random.default_rng(5)
    light_side = Sphere() if name == "sphere" else FINITE[name].replaced(flip_normals=True)
    place = np.eye(4)
    _, _, light, o, length = lit_points(light_side, place, 20_000, rng)
    gap = 1e-4
    if name == "sphere":
        blocker = scale(1.0 + gap).matrix
    else:
        blocker = translate(0, 0, -gap).matrix @ scale(1.5, 1.5, 1.0).matrix
    shields = World((light_side, blocker))
    lit = (light.pdf > 0.0) & (light.cosine > 0.2)
    if name == "mesh":
        lit &= False  # its plane is slanted: shield it along its normal instead
        normal = np.cross((1, 0, 0), (0.2, 1, 0.3))
        shift = translate(*(-gap * normal / np.linalg.norm(normal))).matrix
        middle = translate(0.4, 0.33, 0.1).matrix
        around = middle @ scale(1.5).matrix @ np.linalg.inv(middle)
        shields = World((light_side, shift @ around))
        lit = (light.pdf > 0.0) & (light.cosine > 0.2)
    hit = shields.trace(o, rows(light.wi), np.where(lit, length, 1.0).astype(np.float32))
    assert lit.sum() > 2000
    assert np.isfinite(hit.t[lit]).all()


def test_points_on_their_own_light_are_not_lit_by_it():
    rng = np.random.default_rng(6)
    for shape in FINITE.values():
        world = World((shape, PLACEMENTS["sheared"], Area()))
        points = PLACEMENTS["sheared"][:3, :3] @ local_points(shape, 4000, rng)
        o, d = rays_to(points + PLACEMENTS["sheared"][:3, 3:], 1.0, rng)
        _, g, found = world.surface(o, d)
        sample = instantiate(sample_light, PROGRAM, compiled=False)
        u = rng.random((3, 4000), np.float32)
        with np.errstate(all="ignore"):
            light = sample(world.scene, g.p, g.ns, u[0], (u[1], u[2]), found)
        outwards = (rows(light.wi) * rows(g.ng)).sum(0)
        lit = found & (light.pdf > 0.0) & (outwards > 1e-5)
        start, length = shadow_ray(g, light)
        hit = world.trace(rows(start), rows(light.wi), np.where(lit, length, 1.0))
        assert not np.any(lit & ~np.isfinite(hit.t)), shape.type_name()


def test_spawn_origin_moves_to_the_side_of_the_direction():
    p, n = vec(([1.0], [2.0], [3.0])), vec(([0.0], [0.0], [1.0]))
    up = spawn_origin(p, np.float32(1e-3), n, vec(([0.6], [0.0], [0.8])))
    down = spawn_origin(p, np.float32(1e-3), n, vec(([0.6], [0.0], [-0.8])))
    np.testing.assert_allclose((rows(up) - rows(p)).ravel(), (0, 0, 1e-3), atol=3e-7)
    np.testing.assert_allclose((rows(down) - rows(p)).ravel(), (0, 0, -1e-3), atol=3e-7)


def soup(rng):
    """A mesh of 40 triangles of all sizes; two copies of it become instances."""
    middles = rng.uniform(-1, 1, (40, 1, 3))
    corners = middles + rng.normal(size=(40, 3, 3)) * 10.0 ** rng.uniform(-2, 0, (40, 1, 1))
    return Mesh(vertices=corners.reshape(-1, 3), faces=np.arange(120).reshape(-1, 3))


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("placement", PLACEMENTS)
def test_rays_leave_instances(size, placement):
    rng = np.random.default_rng(7)
    mesh, n = soup(rng), 20_000
    place = translate(3 * size, 0, 5 * size).matrix @ scale(size).matrix @ PLACEMENTS[placement]
    world = World((mesh, np.eye(4)), (mesh, place))
    _, shape, forward, inverse = world.shapes.instances[1]
    triangle = rng.integers(0, 40, n)
    corners = mesh.vertices.astype(float)[mesh.faces[triangle]]
    points = np.einsum("nck,nc->kn", corners, rng.dirichlet((2, 2, 2), n))
    o, d = rays_to(forward[:, :3] @ points + forward[:, 3:], size, rng)
    t, u, v, inside = meet(corners, inverse, o, d)
    found = inside & (t > 0.0)
    assert found.mean() > 0.95
    hit = Hit(t, u, v, np.full(n, shape, np.uint32), triangle.astype(np.uint32))
    g = world.surface_at(hit, o, d, found)
    side = leaving(n, rng)
    w = (side[0] * rows(g.s) + side[1] * rows(g.t) + side[2] * rows(g.ng)).astype(np.float32)
    start = rows(spawn_origin(g.p, g.error, g.ng, vec(w))).astype(np.float32)
    again, _, _, inside = meet(corners, inverse, start, w)
    assert not np.any(found & inside & (again > 0.0))
    assert np.median(g.error[found]) < 4e-5 * size


def meet(corners, inverse, o, d):
    """`sheared_hit` of ray i and triangle i in an instance's space, as the traversal does it."""
    blocks = View(np.ascontiguousarray(inverse, np.float32))
    origin, direction = to_object(blocks, 0, vec(o), 1.0), to_object(blocks, 0, vec(d), 0.0)
    with np.errstate(all="ignore"):
        shear = shear_of(direction)
        a, b, c = (rotated(vec(corners[:, i].T) - origin, shear) for i in range(3))
        return sheared_hit(a, b, c, shear)
