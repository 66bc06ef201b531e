"""The surface at a hit: points, normals, tangents, parameters, under every kind of transform."""

from itertools import cycle

import numpy as np
import pytest

from alight.compiled.program import Program
from alight.core.constants import INFINITY
from alight.core.vec import Vec3
from alight.shapes.cylinder import turn_of
from alight.shapes.derivatives import uv_derivatives
from alight.shapes.hit import BENT, OWN_COAT
from alight.shapes.mesh import Mesh
from lanewise.jit import instantiate
from tests.shapes.tracing import (
    PLACEMENTS,
    PROGRAM,
    World,
    bounce,
    directions,
    one_of_each,
    rows,
    unit,
)

N = 8000
QUAD = Mesh(
    vertices=((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)),
    faces=((0, 1, 2), (0, 2, 3)),
    normals=((-0.3, 0, 1), (0.3, 0.1, 1), (0, 0, 1), (0.1, -0.2, 1)),
    uvs=((0, 0), (1, 0), (1, 1), (0, 1)),
    colors=((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)),
)
SHAPES = one_of_each(mesh=QUAD)


def round_one(q):
    return np.linalg.norm(q, axis=0) - 1.0, unit(q)


def around_the_axis(q):
    return round_one(q * [[1.0], [1.0], [0.0]])


def flat(q):
    return q[2], np.broadcast_to([[0.0], [0.0], [1.0]], q.shape)


#: Distance from the surface in its own space, and the outer normal; all others are flat.
DISTANCES = {"sphere": round_one, "cylinder": around_the_axis}


def distance(shape, q):
    return DISTANCES.get(shape.type_name(), flat)(q)


def turn(x, y):
    """The angle about z, in turns."""
    return np.arctan2(y, x) / (2 * np.pi) % 1.0


#: Texture coordinates, and the direction in which the first grows; all others have `square`.
COORDINATES = {
    "sphere": lambda x, y, z: (turn(x, y), np.arccos(np.clip(z, -1, 1)) / np.pi, (-y, x, 0 * z)),
    "plane": lambda x, y, z: (x, y, (1 + 0 * x, 0 * y, 0 * z)),
    "disk": lambda x, y, z: (np.hypot(x, y), turn(x, y), (x, y, 0 * z)),
    "cylinder": lambda x, y, z: (turn(x, y), z, (-y, x, 0 * z)),
}


def square(x, y, z):
    return 0.5 * x + 0.5, 0.5 * y + 0.5, (1 + 0 * x, 0 * y, 0 * z)


each_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
each_placement = pytest.mark.parametrize("placement", PLACEMENTS.values(), ids=PLACEMENTS)


def look_at(shape, placement, seed=1):
    """Hits from all around a shape: local points, outer normals, directions, and the surface."""
    rng = np.random.default_rng(seed)
    target = rng.uniform(-0.7, 0.7, (3, N))
    # Each goes along the gradient to where the surface is.
    off, gradient = distance(shape, target)
    target -= off * gradient
    if shape.type_name() == "cylinder":
        target[2] = 0.5 + target[2] / 1.5
    d = directions(N, rng)
    o = placement[:3, :3] @ target + placement[:3, 3:] - 3.0 * d
    o, d = o.astype(np.float32), d.astype(np.float32)
    hit, g, found = World((shape, placement)).surface(o, d)
    assert found.mean() > 0.95
    inverse = np.linalg.inv(placement)
    # The true local point: of the ray, not of the surface.
    t = np.where(found, hit.t, 1.0)
    q = inverse[:3, :3] @ (o.astype(float) + t * d.astype(float)) + inverse[:3, 3:]
    _, normal = distance(shape, q)
    if shape.flip_normals:
        normal = -normal
    normal = unit(np.linalg.inv(placement[:3, :3]).T @ normal)
    return SurfaceUnderTest(q[:, found], normal[:, found], select(g, found), found)


class SurfaceUnderTest:
    def __init__(self, q, normal, surface, found):
        self.q, self.normal, self.surface, self.found = q, normal, surface, found


def select(surface, found):
    """The surface's fields as float64 arrays, hits only."""
    fields = {}
    # No texture here names a set of coordinates, nothing disperses light or bends a frame.
    assert surface.chart == surface.wavelength == surface.bend == ()
    for name, value in surface._replace(chart=0, wavelength=0, bend=0)._asdict().items():
        if name in ("p", "ng", "ns", "s", "t", "color"):
            fields[name] = np.broadcast_to(rows(value), (3, N))[:, found]
        else:
            fields[name] = np.broadcast_to(value, (N,))[found].astype(float)
    return type("Fields", (), fields)


@each_shape
@each_placement
def test_points_lie_on_the_surface_within_their_error_bound(shape, placement):
    seen = look_at(shape, placement)
    g = seen.surface
    inverse = np.linalg.inv(placement)
    q = inverse[:3, :3] @ g.p + inverse[:3, 3:]
    off, gradient = distance(shape, q)
    off /= np.linalg.norm(inverse[:3, :3].T @ gradient, axis=0)
    assert np.all(np.abs(off) <= g.error)
    assert np.all(g.error < 2e-5)
    np.testing.assert_allclose(q, seen.q, atol=3e-5)


@each_shape
@each_placement
@pytest.mark.parametrize("flip", [False, True])
def test_normals_go_by_the_inverse_transpose(shape, placement, flip):
    seen = look_at(shape.replaced(flip_normals=flip), placement)
    np.testing.assert_allclose(seen.surface.ng, seen.normal, atol=2e-5)


@each_shape
@each_placement
def test_shading_frames_are_orthonormal_and_right_handed(shape, placement):
    g = look_at(shape, placement).surface
    np.testing.assert_allclose(np.cross(g.s, g.t, axis=0), g.ns, atol=2e-6)
    for v in (g.ng, g.ns, g.s, g.t):
        np.testing.assert_allclose(np.linalg.norm(v, axis=0), 1.0, atol=1e-6)
    assert np.all((g.ns * g.ng).sum(0) > 0.0)


@each_shape
@each_placement
def test_texture_coordinates_and_tangents(shape, placement):
    seen = look_at(shape, placement)
    g, (x, y, z) = seen.surface, seen.q
    u, v, tangent = COORDINATES.get(shape.type_name(), square)(x, y, z)
    clear = np.hypot(x, y) > 0.05
    for error in (np.abs(g.u - u), np.abs(g.v - v)):
        # Angles wrap around.
        assert np.all(np.minimum(error, 1.0 - error)[clear] < 2e-4)
    tangent = unit(placement[:3, :3] @ np.stack(tangent))
    # The shading normal may be tilted: compare within its tangent plane.
    tangent = unit(tangent - (tangent * g.ns).sum(0) * g.ns)
    np.testing.assert_allclose(g.s[:, clear], tangent[:, clear], atol=2e-3)


@each_placement
def test_mesh_normals_and_colours_are_interpolated(placement):
    seen = look_at(QUAD, placement)
    g, (x, y, _) = seen.surface, seen.q
    lower = y <= x  # which triangle
    b1 = np.where(lower, 0.5 * (x - y), 0.5 * (x + 1))
    b2 = np.where(lower, 0.5 * (y + 1), 0.5 * (y - x))
    i, j = np.where(lower, 1, 2), np.where(lower, 2, 3)

    def mix(table):
        table = np.asarray(table, float)
        weights = (1 - b1 - b2, b1, b2)
        corners = (table[0], table[i], table[j])
        return sum(w[:, None] * c for w, c in zip(weights, corners, strict=True)).T

    normals = np.asarray(QUAD.normals, float)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals @ np.linalg.inv(placement[:3, :3])
    np.testing.assert_allclose(g.color, mix(QUAD.colors), atol=2e-4)
    np.testing.assert_allclose(g.ns, unit(mix(normals)), atol=2e-4)


def test_instances_look_like_copies():
    rng = np.random.default_rng(6)
    v = rng.normal(size=(30, 3)).astype(np.float32)
    mesh = Mesh(
        vertices=v,
        faces=rng.permuted(np.tile(np.arange(30), (40, 1)), axis=1)[:, :3],
        normals=v,
        uvs=v[:, :2],
        colors=np.abs(v) / 10,
    )
    derivatives = instantiate(uv_derivatives, PROGRAM, compiled=False)
    places = [PLACEMENTS[name] for name in ("sheared", "mirrored")]
    shared = World(*((mesh, place) for place in places))
    assert len(shared.shapes.instances) == 2 and len(shared.shapes.geometries) == 1
    for index, place in enumerate(places):
        copy = World((mesh, place))
        assert len(copy.shapes.instances) == 0
        o, d = rng.uniform(-2, 2, (3, N)), directions(N, rng)
        hit, expected, found = copy.surface(o, d)
        same = hit._replace(shape=np.full(N, index, np.uint32))
        got = shared.surface_at(same, o, d, found)
        for name, value in select(expected, found).__dict__.items():
            if name[0] != "_" and name not in ("shape", "error"):
                np.testing.assert_allclose(
                    getattr(select(got, found), name), value, atol=1e-4, err_msg=name
                )
        ratio = got.error[found] / expected.error[found]
        assert np.all((ratio > 0.5) & (ratio < 20.0))
        pairs = zip(derivatives(shared.scene, got), derivatives(copy.scene, expected), strict=True)
        for mine, other in pairs:
            mine, other = rows(mine)[:, found], rows(other)[:, found]
            size = np.linalg.norm(other, axis=0)
            assert np.all(np.linalg.norm(mine - other, axis=0) < 1e-4 * (1.0 + size))


def test_compiled_surfaces_are_those_of_numpy():
    rng = np.random.default_rng(7)
    world = World(*zip(SHAPES.values(), cycle(PLACEMENTS.values())))
    n = 4096
    o, d, leaving = rng.uniform(-3, 3, (3, n)), directions(n, rng), directions(n, rng)
    compiled, plain = (bounce(world, o, d, leaving, compiled=c) for c in (True, False))
    np.testing.assert_array_equal(compiled.found, plain.found)
    assert set(range(len(SHAPES))) <= set(plain.shape[plain.found])
    for name in ("t", "p", "ng", "ns", "s", "tangent", "u", "v", "error"):
        a, b = (getattr(r, name)[..., plain.found] for r in (compiled, plain))
        np.testing.assert_allclose(a, b, rtol=1e-4, atol=2e-5, err_msg=name)
    both = (compiled.again < INFINITY) & (plain.again < INFINITY) & plain.found
    assert np.mean((compiled.again < INFINITY) == (plain.again < INFINITY)) > 0.999
    near = np.isclose(compiled.again[both], plain.again[both], rtol=1e-3, atol=1e-3)
    assert near.mean() > 0.995


#: Who reads texture coordinates: a texture, a layer, the axes of maps.
READERS = {
    "texture": Program(textures=("constant", "checkerboard")),
    "layer": Program(textures=("constant",), aovs=("uv",)),
    "map": Program(textures=("constant",), bsdfs=(BENT,)),
    "coat": Program(textures=("constant",), bsdfs=(OWN_COAT,)),
}


@pytest.mark.parametrize("program", READERS.values(), ids=READERS)
def test_angles_are_found_where_anything_reads_them(program):
    x, y, z = np.float32(directions(64, np.random.default_rng(7)))
    found = instantiate(turn_of, program, compiled=False)(Vec3(x, y, z))
    np.testing.assert_allclose(found, turn(x, y), atol=1e-6)


def test_angles_are_not_found_where_nothing_reads_them():
    found = instantiate(turn_of, Program(textures=("constant",)), compiled=False)
    assert np.all(found(Vec3(*np.ones((3, 4), np.float32))) == 0.0)
