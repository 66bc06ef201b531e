"""Light sampling against its density, closed forms and plain Monte Carlo."""

import numpy as np
import pytest

from alight.lights.area import Area
from alight.lights.constant import Constant
from alight.lights.directional import Directional
from alight.lights.hits import emitted, light_pdf
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.point import Point
from alight.lights.sampling import sample_light
from alight.lights.tables import STRIDE
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, scale, translate
from alight.shapes.cylinder import Cylinder
from alight.shapes.disk import Disk
from alight.shapes.mesh import Mesh
from alight.shapes.rectangle import Rectangle
from alight.shapes.sphere import Sphere
from lanewise.jit import instantiate
from lanewise.simd import gather
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square, length_error, z_of_mean
from tests.shapes.tracing import PLACEMENTS, PROGRAM, World, directions, rows, vec

ROOF = Mesh(
    vertices=((-1, -1, 0), (1, -1, 0.2), (1, 1, 0), (-0.3, 0.6, 0.3)),
    faces=((0, 1, 2), (0, 2, 3)),
)
SHAPES = {
    "sphere": Sphere(),
    "rectangle": Rectangle(),
    "disk": Disk(),
    "mesh": ROOF,
    "cylinder": Cylinder(p0=(-0.7, 0, 0), p1=(0.9, 0.2, 0), radius=0.6),
}

each_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
each_placement = pytest.mark.parametrize("placement", PLACEMENTS.values(), ids=PLACEMENTS)
N = 16_000


def run(kernel, *arguments, program=PROGRAM):
    """A kernel of the common program, in NumPy."""
    with np.errstate(all="ignore"):
        return instantiate(kernel, program, compiled=False)(*arguments)


def sample(world, p, n, seed=1, program=PROGRAM):
    """n samples of the lights at the point p, from stratified numbers for the choice."""
    u = np.random.default_rng(seed).random((3, n), np.float32)
    at = vec(np.tile(np.reshape(p, (3, 1)), n))
    numbers = u[0], (u[1], u[2])
    return run(sample_light, world.scene, at, at, *numbers, np.ones(n, bool), program=program)


def densities(world, p, d):
    """`light_pdf` of directions (3, n) at p; 0 where no light is met."""
    n = d.shape[1]
    o = np.tile(np.reshape(p, (3, 1)), n)
    hit, surface, found = world.surface(o, d)
    distance = np.where(found, hit.t, 1.0).astype(np.float32)
    light = np.where(found, surface.light, 0).astype(np.uint32)
    pdf = run(light_pdf, world.scene, light, vec(o), vec(d), distance, surface)
    return np.where(found, pdf, 0.0), surface, found


def viewpoint(placement, distance, side=1.0):
    """A point on the bright side of a placed shape, `distance` of its own sizes away."""
    return (placement @ [0.4, -0.3, side * distance, 1.0])[:3]


#: Near the shape and far from it.
DISTANCES = [1.5, 8.0]
each_distance = pytest.mark.parametrize("distance", DISTANCES)


@each_shape
@each_placement
@each_distance
def test_sampled_directions_hit_the_shape(shape, placement, distance):
    world = World((shape, placement, Area()))
    p = viewpoint(placement, distance)
    light = sample(world, p, N)
    valid = light.pdf > 0.0
    assert valid.mean() > 0.15
    wi = rows(light.wi)[:, valid]
    assert length_error(wi) < 1e-6
    hit = world.trace(np.tile(p[:, None], valid.sum()), wi)
    met = np.isfinite(hit.t)
    # Points within rounding of the rim may be missed.
    assert met.mean() > 0.9995
    edge_on = np.maximum(light.cosine[valid][met], 0.02)
    error = np.abs(hit.t[met] - light.distance[valid][met]) * edge_on
    assert np.quantile(error, 0.999) < 2e-5 * np.linalg.norm(p - placement[:3, 3]) + 1e-5


@each_shape
@each_placement
@each_distance
def test_sampled_density_is_that_of_the_density_function(shape, placement, distance):
    world = World((shape, placement, Area()))
    p = viewpoint(placement, distance)
    light = sample(world, p, N)
    wi = rows(light.wi)
    pdf, _, found = densities(world, p, wi)
    clear = (light.pdf > 0.0) & found & (light.cosine > 0.05)
    assert clear.mean() > 0.15
    np.testing.assert_allclose(light.pdf[clear], pdf[clear], rtol=2e-3)


@each_shape
@each_placement
def test_density_integrates_to_one(shape, placement):
    world = World((shape, placement, Area()))
    p = viewpoint(placement, 1.2)
    pdf, _, _ = densities(world, p, directions(40_000, np.random.default_rng(2)))
    bright = pdf > 0.0
    assert bright.sum() > 500
    # Area sampling also draws points on the dark side, which count for nothing.
    share = np.mean(sample(world, p, 40_000).pdf > 0.0)
    error = np.sqrt(share * (1.0 - share) / 40_000)
    assert abs(z_of_mean(4.0 * np.pi * pdf, share, error)) < LARGEST_Z


@each_shape
@each_placement
@each_distance
def test_light_sampling_and_uniform_directions_find_the_same_light(shape, placement, distance):
    world = World((shape, placement, Area(radiance=(2.0, 1.0, 0.5))))
    p = viewpoint(placement, distance)
    light = sample(world, p, N)
    valid = light.pdf > 0.0
    wi = rows(light.wi)
    radiance = rows(light.radiance).reshape(3, -1) * np.ones(N)
    d = directions(60_000, np.random.default_rng(3))
    # Look towards the shape only: uniform in a cap around it.
    axis = placement[:3, 3] - p
    axis = axis / np.linalg.norm(axis)
    _, surface, found = densities(world, p, d)
    seen = run(emitted, world.scene, surface, vec(-d))
    seen = np.where(found, np.broadcast_to(rows(seen), d.shape), 0.0)
    for weigh in (lambda w: np.ones(w.shape[1]), lambda w: w[0] + 2.0 * w[1], lambda w: w[2] ** 2):
        by_light = np.where(valid, radiance[0] * weigh(wi) / np.where(valid, light.pdf, 1.0), 0.0)
        by_chance = 4.0 * np.pi * seen[0] * weigh(d)
        error = by_light.std() / np.sqrt(N)
        assert abs(z_of_mean(by_chance, by_light.mean(), error)) < LARGEST_Z


# ---------------------------------------------------------------- where the points fall


@each_placement
@pytest.mark.parametrize("name", ["rectangle", "disk", "mesh"])
def test_points_are_distributed_as_the_density_says(name, placement):
    world = World((SHAPES[name], placement, Area()))
    p = viewpoint(placement, 1.0)
    light = sample(world, p, 30_000)
    valid = light.pdf > 0.0
    points = np.asarray(p)[:, None] + rows(light.wi) * light.distance
    q = np.linalg.inv(placement) @ np.vstack([points, np.ones(points.shape[1])])
    # Cells of equal area in the shape's own space; each with a grid of directions to its middle.
    side, fine = 8, 12
    x, y = (np.mgrid[: side * fine, : side * fine] + 0.5) * 2.0 / (side * fine) - 1.0
    x, y = x.ravel(), y.ravel()
    z = np.zeros_like(x)
    if name == "disk":
        r, phi = np.sqrt(0.5 * x + 0.5), np.pi * y
        x, y = r * np.cos(phi), r * np.sin(phi)
        cell = 2.0 * (q[0] ** 2 + q[1] ** 2) - 1.0, np.arctan2(q[1], q[0]) / np.pi
    elif name == "mesh":
        # Seen from above, the two triangles: heights of the middles by their planes.
        x, y, z, area = roof(x, y)
        cell = q[0], q[1]
    else:
        cell = q[0], q[1]
    places = placement[:3, :3] @ np.stack([x, y, z]) + placement[:3, 3:]
    d = places - np.asarray(p)[:, None]
    distance = np.linalg.norm(d, axis=0)
    pdf, surface, found = densities(world, p, d / distance)
    cosine = -(rows(surface.ng) * d / distance).sum(0)
    if name != "mesh":
        e1, e2 = placement[:3, 0], placement[:3, 1]
        area = np.linalg.norm(np.cross(e1, e2)) * (np.pi if name == "disk" else 4.0) / x.size
    else:
        normal = np.linalg.inv(placement[:3, :3]).T
        slope = np.stack([-roof_slopes(x, y)[0], -roof_slopes(x, y)[1], np.ones_like(x)])
        area = np.abs(np.linalg.det(placement[:3, :3])) * np.linalg.norm(normal @ slope, axis=0)
        area = np.where(roof_inside(x, y), area * 4.0 / x.size, 0.0)
        found = found & roof_inside(x, y)
    density = np.where(found, pdf * cosine * area / distance**2, 0.0)
    grid = density.reshape(side, fine, side, fine).sum((1, 3)).ravel()
    index = [np.clip((0.5 * c + 0.5) * side, 0, side - 1).astype(int) for c in cell]
    counts = np.bincount((index[0] * side + index[1])[valid], minlength=side * side)
    if name == "mesh":
        # Cells on the rim are resolved by points only roughly: compare full ones.
        full = roof_inside(x, y).reshape(side, fine, side, fine).all((1, 3)).ravel()
        rest = counts[~full].sum() + np.count_nonzero(~valid)
        counts, grid = counts[full], grid[full]
    else:
        rest = np.count_nonzero(~valid)
    assert grid.sum() > 0.5
    assert chi_square(np.append(counts, rest), grid) > SIGNIFICANCE


def roof_slopes(x, y):
    """dz/dx and dz/dy of the two triangles of ROOF."""
    v = np.asarray(ROOF.vertices, float)
    slopes = []
    for face in ROOF.faces:
        n = np.cross(v[face[1]] - v[face[0]], v[face[2]] - v[face[0]])
        slopes.append((-n[0] / n[2], -n[1] / n[2]))
    lower = y <= x
    return [np.where(lower, slopes[0][i], slopes[1][i]) for i in range(2)]


def roof(x, y):
    """Points of ROOF above (x, y)."""
    sx, sy = roof_slopes(x, y)
    return x, y, sx * (x + 1.0) + sy * (y + 1.0), None


def roof_inside(x, y):
    """True where there is a triangle of ROOF above (x, y)."""
    v = np.asarray(ROOF.vertices, float)[:, :2]
    inside = np.zeros(x.shape, bool)
    for face in ROOF.faces:
        a, b, c = v[face]
        sides = [
            (j[0] - i[0]) * (y - i[1]) - (j[1] - i[1]) * (x - i[0])
            for i, j in ((a, b), (b, c), (c, a))
        ]
        inside |= np.min(sides, axis=0) > 0
    return inside


# ---------------------------------------------------------------- lights without a shape


def test_point_light():
    light = PlacedLight("light", Point(intensity=(8.0, 4.0, 2.0)), translate(1, 2, 3).matrix)
    s = sample(World(lights=[light]), (1, 2, 1), 16)
    np.testing.assert_allclose(rows(s.wi)[:, 0], (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(rows(s.radiance)[:, 0], (2, 1, 0.5), rtol=1e-6)  # I / d^2
    assert np.all(s.distance == 2.0) and np.all(s.pdf == 1.0) and np.all(s.delta)


def test_directional_light_comes_along_z_of_its_node():
    turned = rotate("x", 90).matrix @ scale(3).matrix
    light = PlacedLight("sun", Directional(irradiance=(3.0, 2.0, 1.0)), turned)
    s = sample(World(lights=[light]), (5, 5, 5), 16)
    # +z turned about x by 90 degrees is -y: the light stands at +y.
    np.testing.assert_allclose(rows(s.wi).reshape(3, -1)[:, 0], (0, 1, 0), atol=1e-6)
    np.testing.assert_allclose(rows(s.radiance).ravel()[:3], (3, 2, 1))
    assert np.all(np.isinf(s.distance)) and np.all(s.pdf == 1.0) and np.all(s.delta)


def test_constant_environment():
    world = World(environment=Constant(radiance=(1.0, 2.0, 3.0)))
    s = sample(world, (0, 0, 0), N)
    np.testing.assert_allclose(s.pdf, 1.0 / (4.0 * np.pi), rtol=1e-6)
    assert not np.any(s.delta)
    wi = rows(s.wi)
    assert length_error(wi) < 1e-6
    for component in wi:
        assert abs(z_of_mean(component, 0.0)) < LARGEST_Z
        assert abs(z_of_mean(component**2, 1.0 / 3.0)) < LARGEST_Z
    d = vec(wi)
    np.testing.assert_allclose(run(environment_pdf, world.scene, d, d), np.max(s.pdf), rtol=1e-6)
    seen = rows(run(environment_radiance, world.scene, d)).reshape(3, -1)
    np.testing.assert_allclose(seen[:, 0], (1, 2, 3))


# ---------------------------------------------------------------- choice of the light


def several(selection):
    """Four lights and one that is black; powers in the order of the table."""
    black = PlacedLight("black", Point(intensity=0.0), np.eye(4))
    point = PlacedLight("point", Point(intensity=2.0), translate(0, 0, 9).matrix)
    sun = PlacedLight("sun", Directional(irradiance=0.5), np.eye(4))
    world = World(
        (Rectangle(), translate(3, 0, 0).matrix, Area(radiance=3.0)),
        (Rectangle(), translate(-3, 0, 0).matrix),
        lights=[black, point, sun],
        environment=Constant(radiance=0.25),
        selection=selection,
    )
    r2 = world.shapes.radius**2
    powers = [np.pi * 4 * 3, 0, 4 * np.pi * 2, np.pi * r2 * 0.5, 4 * np.pi**2 * r2 * 0.25]
    return world, np.array(powers)


@pytest.mark.parametrize("selection", ["uniform", "power"])
def test_lights_are_chosen_as_asked(selection):
    world, powers = several(selection)
    weights = powers if selection == "power" else (powers > 0.0) * 1.0
    pmf = world.lights.tables.data.array.reshape(-1, STRIDE)[:, 3]
    np.testing.assert_allclose(pmf, weights / weights.sum(), atol=1e-6)
    assert pmf[1] == 0.0
    u = (np.arange(N) + 0.5).astype(np.float32) / N
    p = vec(np.zeros((3, N)))
    s = run(sample_light, world.scene, p, p, u, (u, u), np.ones(N, bool))
    assert not np.any(s.pdf < 0.0)
    point = np.isclose(s.distance, 9.0) & s.delta
    sun = np.isinf(s.distance) & s.delta
    sky = np.isinf(s.distance) & ~s.delta
    for chosen, expected in ((point, pmf[2]), (sun, pmf[3]), (sky, pmf[4])):
        assert np.mean(chosen) == pytest.approx(expected, abs=2.0 / N)
    np.testing.assert_allclose(s.pdf[point], pmf[2], rtol=1e-6)
    np.testing.assert_allclose(s.pdf[sun], pmf[3], rtol=1e-6)
    np.testing.assert_allclose(s.pdf[sky], pmf[4] / (4 * np.pi), rtol=1e-5)
    radiance = np.broadcast_to(rows(s.radiance), (3, N))
    np.testing.assert_allclose(radiance[0, sky], 0.25)
    # A hit on the area light knows the probability of having been chosen, and sky does too.
    up = np.array([[0.0], [0.0], [-1.0]])
    pdf, _, _ = densities(world, (3.0, 0.0, 1.0), up)
    alone, _, _ = densities(
        World((Rectangle(), translate(3, 0, 0).matrix, Area())), (3.0, 0.0, 1.0), up
    )
    assert pdf[0] == pytest.approx(pmf[0] * alone[0], rel=1e-6)
    sky_pdf = run(environment_pdf, world.scene, vec(up), vec(up))
    assert float(sky_pdf) == pytest.approx(pmf[4] / (4 * np.pi), rel=1e-6)


def test_without_light_nothing_arrives():
    black = PlacedLight("black", Point(intensity=0.0), np.eye(4))
    world = World((Rectangle(), np.eye(4)), lights=[black])
    s = sample(world, (0, 0, 1), 64)
    assert np.all(rows(s.radiance) == 0.0)


@each_shape
def test_area_lights_shine_on_their_outer_side_only(shape):
    for flip in (False, True):
        light = Area(radiance=2.0)
        world = World((shape.replaced(flip_normals=flip), PLACEMENTS["mirrored"], light))
        outside, inside = ((viewpoint(PLACEMENTS["mirrored"], 3.0, s)) for s in (1.0, -1.0))
        if shape.type_name() in ("sphere", "cylinder"):
            inside = viewpoint(PLACEMENTS["mirrored"], 0.2)
        for p, bright in ((outside, not flip), (inside, flip)):
            aim = placement_point(shape) - p
            d = np.tile((aim / np.linalg.norm(aim))[:, None], 4)
            _, surface, found = densities(world, p, d)
            assert found.all()
            seen = np.broadcast_to(rows(run(emitted, world.scene, surface, vec(-d))), (3, 4))
            np.testing.assert_array_equal(seen, 2.0 if bright else 0.0)
            # A dark wall of a round shape hides a bright one behind it: for shadow rays to see.
            if bright or shape.type_name() not in ("sphere", "cylinder"):
                assert np.any(sample(world, p, 256).pdf > 0.0) == bright


def placement_point(shape):
    """A point on or in every one of the shapes, placed mirrored."""
    return (PLACEMENTS["mirrored"] @ [0.35, 0.05, 0.1 if shape is ROOF else 0.0, 1.0])[:3]


def test_mesh_triangles_are_chosen_by_area():
    world = World((ROOF, np.eye(4), Area()))
    areas = world.shapes.rows[0].areas
    start = int(world.lights.tables.info.array[3])
    cdf = gather(world.lights.tables.cdf, np.arange(start, start + 3, dtype=np.uint32))
    np.testing.assert_allclose(np.diff(cdf), areas / areas.sum(), rtol=1e-6)
