"""Portals: directions through a window, the density of the mixture, and pictures of a room."""

import numpy as np
import pytest

import alight
from alight.compiled.program import Program
from alight.core.errors import SceneError
from alight.formats import loads
from alight.lights.constant import Constant
from alight.lights.environment import Environment
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.portal import Portal
from alight.lights.sampling import sample_light
from alight.lights.sun import Sun
from alight.scene import flatten
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, scale, translate
from lanewise.jit import instantiate
from tests.lights.test_environment import sky
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square
from tests.shapes.tracing import World, directions, rows, vec

WINDOWS = (
    translate(0.3, 0.2, 2.0).matrix @ rotate((1, 2, 3), 20).matrix @ scale(0.8, 1.5, 1.0).matrix,
    translate(-3.0, 0.0, 0.0).matrix @ rotate("y", 60).matrix @ scale(0.6).matrix,
)
N = 60_000
#: Before, beside and close to the first window, and so far away that it is sampled by its area.
POINTS = [(0.0, 0.0, 0.0), (2.0, -1.0, 3.0), (0.3, 0.4, 1.7), (5.0, -60.0, 20.0)]
each_point = pytest.mark.parametrize("p", POINTS)
SKIES = {"constant": Constant(radiance=(0.2, 0.4, 0.6)), "map": Environment(pixels=sky(sun=30.0))}


class Windows:
    """An environment with two portals."""

    def __init__(self, sky_name, selection="power"):
        portals = [PlacedLight("window", Portal(), to_world) for to_world in WINDOWS]
        world = World(environment=SKIES[sky_name], around=portals, selection=selection)
        self.scene, self.data = world.scene, world.lights.tables.data.array.reshape(-1, 16)
        kinds = (SKIES[sky_name].type_name(), "portal", "portal")
        self.program = Program(lights=kinds[:2], environments=kinds, light_tree=selection == "tree")

    def run(self, text, *arguments):
        """A kernel, in NumPy."""
        with np.errstate(all="ignore"):
            return instantiate(text, self.program, compiled=False)(*arguments)

    def pdf(self, p, d):
        """Density at one point, of directions (3, n)."""
        at = vec(np.tile(np.reshape(p, (3, 1)), d.shape[1]))
        found = self.run(environment_pdf, self.scene, at, vec(d))
        return np.broadcast_to(found, d.shape[1]).astype(float)

    def seen(self, d):
        """Radiance (3, n) from directions (3, n)."""
        found = rows(self.run(environment_radiance, self.scene, vec(d)))
        return np.broadcast_to(found.reshape(3, -1), d.shape)

    def samples(self, p):
        """N samples."""
        u = np.random.default_rng(1).random((3, N), np.float32)
        at, up = (vec(np.tile(np.reshape(v, (3, 1)), N)) for v in (p, (0.0, 1.0, 0.0)))
        return self.run(sample_light, self.scene, at, up, u[0], (u[1], u[2]), np.ones(N, bool))


def through(to_world, p, d):
    """Whether rays go through a window: its definition, in float64."""
    local = np.linalg.inv(to_world)
    o, e = local[:3, :3] @ p + local[:3, 3], local[:3, :3] @ d
    t = -o[2] / e[2]
    return (t > 0.0) & (np.abs(o[0] + t * e[0]) <= 1.0) & (np.abs(o[1] + t * e[1]) <= 1.0)


def window_from(to_world, p, n=1200):
    """Directions (3, n^2) to places of a window, and the solid angle of each: dA cos / d^2."""
    x, y = (2.0 * (np.mgrid[:n, :n] + 0.5) / n - 1.0).reshape(2, -1)
    d = to_world[:3, :3] @ np.stack([x, y, 0.0 * x]) + (to_world[:3, 3] - p)[:, None]
    normal = np.cross(to_world[:3, 0], to_world[:3, 1]) * (4.0 / n**2)
    length = np.linalg.norm(d, axis=0)
    return d / length, np.abs(normal @ d) / length**3


def cells(d, side):
    """The cell, of side x side of equal solid angle, of each direction."""
    turn = np.arctan2(d[0], d[2]) / (2.0 * np.pi) + 0.5
    found = [np.clip((c * side).astype(int), 0, side - 1) for c in (0.5 * d[1] + 0.5, turn)]
    return found[0] * side + found[1]


@each_point
def test_directions_follow_the_density_of_the_mixture(p):
    world, side, rng = Windows("constant"), 12, np.random.default_rng(3)
    # Half by the sky, evenly; half through windows by their area, evenly in the solid angle.
    weights = world.data[:, 3]
    areas = np.array([4.8, 1.44])
    np.testing.assert_allclose(weights, np.append(0.5, 0.5 * areas / areas.sum()), rtol=1e-5)
    share, d = np.full(side * side, weights[0] / side**2), directions(4000, rng)
    expected = np.full(4000, weights[0] / (4.0 * np.pi))
    for weight, to_world in zip(weights[1:], WINDOWS, strict=True):
        e, angle = window_from(to_world, np.array(p))
        share += weight * np.bincount(cells(e, side), angle, minlength=side**2) / angle.sum()
        expected += weight / angle.sum() * through(to_world, np.array(p), d)
    # From afar a window is uniform in its area.
    rough = 0.1 if p == POINTS[-1] else 3e-3
    assert np.isclose(world.pdf(p, d), expected, rtol=rough).mean() > 0.999
    s = world.samples(p)
    assert np.all(s.pdf > 0.0)
    counts = np.bincount(cells(rows(s.wi), side), minlength=side * side)
    assert chi_square(np.append(counts, 0), share) > SIGNIFICANCE


@each_point
@pytest.mark.parametrize("name", SKIES)
@pytest.mark.parametrize("selection", ["power", "tree"])
def test_samples_bring_the_light_of_the_surroundings(name, selection, p):
    world = Windows(name, selection)
    s = world.samples(p)
    wi = rows(s.wi)
    # The edge of a window may round to its other side.
    assert np.isclose(world.pdf(p, wi), s.pdf, rtol=3e-3).mean() > 0.999
    seen = world.seen(wi)
    assert np.isclose(rows(s.radiance), seen, rtol=2e-3, atol=1e-5).mean() > 0.999
    d = directions(200_000, np.random.default_rng(5))
    by_chance = 4.0 * np.pi * world.seen(d)
    found = rows(s.radiance)[1] / s.pdf
    error = np.hypot(by_chance[1].std() / np.sqrt(d.shape[1]), found.std() / np.sqrt(N))
    assert abs(found.mean() - by_chance[1].mean()) < LARGEST_Z * max(error, 1e-6)


def test_portals_leave_the_sun_its_samples():
    windows = [PlacedLight("window", Portal(), to_world) for to_world in WINDOWS]
    sun = PlacedLight("sun", Sun(sun_direction=(0.0, 1.0, 0.0)), np.eye(4))
    shares = []
    for around in ([sun], [sun, *windows]):
        world = World(environment=SKIES["constant"], around=around)
        shares.append(world.lights.tables.data.array.reshape(-1, 16)[:, 3])
    assert shares[1][1] == pytest.approx(shares[0][1], rel=1e-4)
    assert shares[1][0] == pytest.approx(0.5 * shares[0][0], rel=1e-4)
    assert shares[1][2] / shares[1][3] == pytest.approx(4.8 / 1.44, rel=1e-3)


def test_a_point_in_the_plane_of_a_portal_sees_nothing_of_it():
    world = Windows("constant")
    p = (WINDOWS[0] @ [3.0, 0.0, 0.0, 1.0])[:3]
    s = world.samples(p)
    assert np.all(np.isfinite(s.pdf)) and np.all(np.isfinite(rows(s.radiance)))
    assert np.all(np.isfinite(world.pdf(p, rows(s.wi))))


ROOM = """
alight: 1
camera: {transform: {look_at: {origin: [0, 1.5, 2.9], target: [0, 1, -1]}}}
film: {size: [16, 16]}
sampler: independent
integrator: {type: path, max_depth: 2}
environment: {type: environment, pixels: [[[2, 3, 4]], [[5, 4, 3]], [[1, 1, 1]]]}
bsdfs: {white: {type: diffuse, reflectance: 0.7}}
nodes:
  floor: {shape: rectangle, bsdf: white, transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}]}
  ceiling:
    shape: rectangle
    bsdf: white
    transform: [{scale: 3}, {rotate: {axis: x, angle: 90}}, {translate: [0, 3, 0]}]
  left:
    shape: rectangle
    bsdf: white
    transform: [{scale: 3}, {rotate: {axis: y, angle: 90}}, {translate: [-3, 0, 0]}]
  back: {shape: rectangle, bsdf: white, transform: [{scale: 3}, {translate: [0, 0, -3]}]}
  front:
    shape: rectangle
    bsdf: white
    transform: [{scale: 3}, {rotate: {axis: y, angle: 180}}, {translate: [0, 0, 3]}]
  above:
    shape: rectangle
    bsdf: white
    transform: [{scale: [3, 0.5, 1]}, {rotate: {axis: y, angle: -90}}, {translate: [3, 2.5, 0]}]
  below:
    shape: rectangle
    bsdf: white
    transform: [{scale: [3, 0.5, 1]}, {rotate: {axis: y, angle: -90}}, {translate: [3, 0.5, 0]}]
  beside:
    shape: rectangle
    bsdf: white
    transform: [{scale: [1, 1, 1]}, {rotate: {axis: y, angle: -90}}, {translate: [3, 1, -2]}]
  glossy:
    shape: {type: sphere, center: [0.5, 0.7, -1], radius: 0.7}
    bsdf: {type: phong, diffuse: 0.2, specular: 0.7, exponent: 30}
  window:
    light: portal
    transform: [{scale: [1, 0.5, 1]}, {rotate: {axis: y, angle: -90}}, {translate: [3, 1.5, 0]}]
"""


def pictures(strategy, portal=True, spp=2048, seeds=12):
    """Means of 4 x 4 blocks, one seed each. Some light comes beside the portal, z from 1 to 3."""
    scene = loads(ROOM)
    nodes = {name: node for name, node in scene.nodes.items() if portal or name != "window"}
    integrator = scene.integrator.replaced(light_sampling=strategy)
    scene = scene.replaced(nodes=nodes, integrator=integrator)
    stack = [alight.render(scene, spp=spp, seed=seed).image.astype(float) for seed in range(seeds)]
    return np.mean(stack, axis=-1).reshape(seeds, 4, 4, 4, 4).mean((2, 4))


def test_portals_change_no_mean_and_lower_the_noise():
    found, plain = pictures("mis"), pictures("mis", portal=False)
    assert found.var(0, ddof=1).mean() < 0.5 * plain.var(0, ddof=1).mean()
    # The glossy ball is noisy where light is sampled alone.
    for other in (plain, pictures("emitter", spp=8192), pictures("bsdf")):
        error = np.sqrt((found.var(0, ddof=1) + other.var(0, ddof=1)) / len(found))
        assert np.abs((found.mean(0) - other.mean(0)) / error).max() < 1.4 * LARGEST_Z
        whole = found.mean((1, 2)) - other.mean((1, 2))
        error = whole.std(ddof=1) / np.sqrt(len(whole))
        assert abs(whole.mean()) < LARGEST_Z * error
        # A mean that is 1 % off is found.
        assert 3.0 * error < 0.01 * found.mean()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("environment: {type: environment", "environment: {type: portal}\n#", "a node of its own"),
        (
            "[{scale: [1, 0.5, 1]},",
            "[{rotate: {axis: z, angle: 30}}, {scale: [1, 0.5, 1]},",
            "rect",
        ),
        ("    light: portal\n", "    light: portal\n    shape: rectangle\n", "has no shape"),
    ],
)
def test_bad_portals(old, new, message):
    text = ROOM.replace(old, new)
    assert text != ROOM
    with pytest.raises(SceneError, match=message):
        flatten(loads(text))
