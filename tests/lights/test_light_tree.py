"""The light tree: its bounds, the probabilities of its choice, and that it changes no mean."""

from collections import namedtuple

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.lights.area import Area
from alight.lights.constant import Constant
from alight.lights.directional import Directional
from alight.lights.hits import light_pdf
from alight.lights.point import Point
from alight.lights.sampling import sample_light
from alight.lights.spot import Spot
from alight.lights.tables import INFO
from alight.lights.tree.bounds import ALIKE, AXIS, CONE, FLAT, REACH, STRENGTH, Groups
from alight.lights.tree.build import binary_tree
from alight.lights.tree.split import Leaves
from alight.lights.tree.traversal import (
    CHILD,
    LEAF,
    MOST_LEVELS,
    NEXT,
    NODE,
    PRIM,
    choose_by_tree,
    mis_probability,
)
from alight.scene import flatten
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, translate
from alight.shapes.hit import PRIMITIVES
from alight.shapes.rectangle import Rectangle
from alight.shapes.sphere import Sphere
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes_mask, load_lanes, store_lanes
from lanewise.view import View
from tests.lights.test_light_sampling import ROOF, densities
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square
from tests.shapes.tracing import PROGRAM, World, load_vec3, store_vec3, vec

MODELS = ("point", "directional", "area", "constant", "spot")
TREE = PROGRAM._replace(bsdfs=("diffuse",), lights=MODELS, light_tree=True)
TABLE = TREE._replace(light_tree=False)
N = 60_000
UP, DOWN, NONE = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)


def run(text, *arguments, program=TREE):
    """A kernel in NumPy."""
    with np.errstate(all="ignore"):
        return instantiate(text, program, compiled=False)(*arguments)


def crowd(selection, *, beside=True):
    """Lamps of all kinds and unequal powers above the plane z = 0, most of them in one corner."""
    rng = np.random.default_rng(5)
    placed, lights = [], []
    for k in range(24):
        low, high = ((-4, -4, 1), (4, 4, 3)) if k % 3 else ((3, 3, 0.5), (4, 4, 1))
        place = rng.uniform(low, high)
        turn = rotate(tuple(rng.normal(size=3)), float(rng.uniform(0, 180))).matrix
        matrix = translate(*place).matrix @ turn @ np.diag([0.2, 0.2, 0.2, 1.0])
        shape = (Rectangle(), Sphere(), ROOF)[k % 3]
        placed.append((shape, matrix, Area(radiance=float(np.exp(rng.uniform(-2, 4))))))
        lamp = (Point(intensity=float(rng.uniform(0, 2))), Spot(intensity=3.0))[k % 2]
        lights.append(PlacedLight("lamp", lamp, translate(*rng.uniform(1, 4, 3)).matrix @ turn))
    lights.append(PlacedLight("black", Point(intensity=0.0), np.eye(4)))
    if beside:
        lights.append(PlacedLight("sun", Directional(irradiance=0.5), rotate("x", 150).matrix))
    sky = Constant(radiance=0.1) if beside else None
    return World(*placed, lights=lights, environment=sky, selection=selection)


def points(p, n=N):
    """The same point or normal in all lanes."""
    return vec(np.tile(np.reshape(p, (3, 1)), n))


def choices(world, p, n, seed=1):
    """`Choice` at one point from N numbers, and a word for light and triangle."""
    u = np.random.default_rng(seed).random((3, N), np.float32)
    at, normal, on = points(p), points(n), np.ones(N, bool)
    found = run(choose_by_tree, world.scene, at, normal, u[0], (u[1], u[2]), on)
    kind = world.scene.lights.info.array.reshape(-1, INFO)[found.index, 0]
    prim = np.where(kind == 2, found.rest, 0).astype(int)
    return found, found.index.astype(int) * 16 + prim


@pytest.mark.parametrize("n", [UP, DOWN, (0.6, 0.0, 0.8), NONE])
@pytest.mark.parametrize("p", [(0.0, 0.0, 0.0), (3.5, 3.6, 0.7), (40.0, -3.0, 2.0)])
def test_choice_follows_its_probabilities(p, n):
    found, word = choices(crowd("tree"), p, n)
    there = found.pmf > 0.0
    names, first, counts = np.unique(word[there], return_index=True, return_counts=True)
    said = found.pmf[there][first].astype(float)
    # One probability a light, and what is left is the way to where no light can shine.
    np.testing.assert_allclose(found.pmf[there], said[np.searchsorted(names, word[there])], 1e-5)
    assert said.sum() <= 1.0 + 1e-5
    assert chi_square(np.append(counts, N - counts.sum()), said) > SIGNIFICANCE


def test_densities_for_mis_add_up_to_one_and_agree():
    world, p = crowd("tree"), (1.0, 2.0, 0.3)
    info = world.scene.lights.info.array.reshape(-1, INFO)
    found, word = choices(world, p, UP)
    total = 0.0
    for index in range(len(info)):
        for prim in range(2 if index < 24 and index % 3 == 2 else 1):
            if index >= 24:
                continue
            one = np.full(1, index, np.uint32)
            plain = run(
                mis_probability, world.scene, one, one * 0 + np.uint32(prim), points(p, 1),
                np.ones(1, bool),
            )[0]  # fmt: skip
            total += plain
            same = (word == index * 16 + prim) & (found.pmf > 0.0)
            if same.any():
                np.testing.assert_allclose(found.mis_pmf[same], plain, rtol=1e-5)
    beside = world.scene.lights.data.array.reshape(-1, 16)[:, 3].sum()
    lamps = np.unique(word[found.pmf > 0.0])
    # Lamps at points are found by the tree only.
    shares = [found.mis_pmf[word == w][0] for w in lamps if 24 * 16 <= w < 48 * 16]
    assert 0.9 < total + beside + sum(shares) <= 1.0 + 1e-5
    # Without a normal both are the same, and what is missing leads to groups that are dark.
    found, word = choices(world, p, NONE)
    lit = found.pmf > 0.0
    _, first = np.unique(word[lit], return_index=True)
    error = np.sqrt(lit.mean() * (1.0 - lit.mean()) / N)
    assert abs(found.mis_pmf[lit][first].sum() - lit.mean()) < LARGEST_Z * error
    assert lit.mean() > 0.9


def test_choice_where_groups_are_dark():
    # Ceiling lamps of eight floors, of equal power; p is on the fifth, and most shine elsewhere.
    down = rotate("x", 180).matrix @ np.diag([0.1, 0.1, 0.1, 1.0])
    places = [(x, y, 4.0 * z + 2.5) for z in range(8) for x in (0, 3) for y in (0, 3)]
    world = World(
        *((Rectangle(), translate(*at).matrix @ down, Area()) for at in places), selection="tree"
    )
    found, _ = choices(world, (1.0, 1.0, 16.0), UP)
    there = found.pmf > 0.0
    names, first, counts = np.unique(found.index[there], return_index=True, return_counts=True)
    assert names.min() == 16 and len(names) == 16
    said = found.pmf[there][first].astype(float)
    assert chi_square(np.append(counts, N - counts.sum()), said) > SIGNIFICANCE


def irradiance(world, program, p, n, seed):
    """Mean of the light on a surface without blockers, and its standard error."""
    u = np.random.default_rng(seed).random((3, N), np.float32)
    on = np.ones(N, bool)
    s = run(
        sample_light, world.scene, points(p), points(n), u[0], (u[1], u[2]), on, program=program
    )
    cosine = np.maximum(n[0] * s.wi.x + n[1] * s.wi.y + n[2] * s.wi.z, 0.0)
    lit = s.pdf > 0.0
    value = np.where(lit, s.radiance.x * cosine / np.where(lit, s.pdf, 1.0), 0.0).astype(float)
    return value.mean(), value.std(ddof=1) / np.sqrt(N)


@pytest.mark.parametrize("n", [UP, (0.6, 0.0, -0.8), (-0.6, 0.64, 0.48)])
@pytest.mark.parametrize("p", [(0.0, 0.0, 0.0), (3.5, 3.6, 0.7), (2.0, -3.0, 1.2)])
def test_tree_and_power_agree_on_the_light(p, n):
    a, error_a = irradiance(crowd("tree"), TREE, p, n, 1)
    b, error_b = irradiance(crowd("power"), TABLE, p, n, 2)
    assert abs(a - b) < LARGEST_Z * np.hypot(error_a, error_b)
    # And it is worth it where lamps are near.
    if p[2] == 0.7:
        assert error_a < error_b


def test_rays_find_the_density_that_light_sampling_says():
    world, p, n = crowd("tree", beside=False), (1.0, -1.0, 0.2), 4000
    u = np.random.default_rng(3).random((3, n), np.float32)
    on = np.ones(n, bool)
    s = run(sample_light, world.scene, points(p, n), points(UP, n), u[0], (u[1], u[2]), on)
    lit = (s.pdf > 0.0) & ~np.broadcast_to(s.delta, n)
    d = np.stack([s.wi.x, s.wi.y, s.wi.z])[:, lit]
    hit, surface, found = world.surface(np.tile(np.reshape(p, (3, 1)), d.shape[1]), d)
    near = found & (np.abs(hit.t - s.distance[lit]) < 1e-3 * s.distance[lit])
    assert near.mean() > 0.5
    distance = np.where(found, hit.t, 1.0).astype(np.float32)
    light = np.where(found, surface.light, 0).astype(np.uint32)
    pdf = run(light_pdf, world.scene, light, points(p, d.shape[1]), vec(d), distance, surface)
    close = np.isclose(pdf[near], s.pdf[lit][near], rtol=2e-3)
    assert close.mean() > 0.99


def test_a_group_is_not_dark_where_one_of_it_shines():
    # Two lamps of a group face down; the point is above its middle and below the upper one. Other
    # pairs are far, so that the root looks at pairs.
    down = rotate("x", 180).matrix @ np.diag([0.1, 0.1, 0.1, 1.0])
    places = [(60 * k, 0, z) for k in range(5) for z in (1, 5)]
    world = World(
        *((Rectangle(), translate(*at).matrix @ down, Area()) for at in places), selection="tree"
    )
    upper = np.ones(1, np.uint32)
    p, on = points((3.0, 0.0, 3.5), 1), np.ones(1, bool)
    assert run(mis_probability, world.scene, upper, upper * 0, p, on)[0] > 0.9
    found, _ = choices(world, (3.0, 0.0, 3.5), (-0.6, 0.0, 0.8))
    assert np.mean((found.pmf > 0.0) & (found.index == 1)) > 0.9


def far_lamps():
    """A panel of triangles and point lamps that all face the origin from 200 m above, unequal."""
    down = translate(0, 0, 200).matrix @ rotate("x", 180).matrix
    lamps = [
        PlacedLight("lamp", Spot(intensity=2.0**k, cutoff_angle=5.0), down) for k in range(0, 12, 3)
    ]
    return World((ROOF, down, Area(radiance=3.0)), lights=lamps, selection="tree")


def test_from_afar_only_intensity_counts():
    world = far_lamps()
    found, word = choices(world, (0.0, 0.0, 0.0), UP)
    names, first, counts = np.unique(word, return_index=True, return_counts=True)
    pmf = found.pmf[first].astype(float)
    assert np.all(found.pmf == found.pmf[first][np.searchsorted(names, word)])
    assert pmf.sum() == pytest.approx(1.0, abs=1e-6)
    assert chi_square(np.append(counts, 0), pmf) > SIGNIFICANCE
    # Of the lamps, each is eight times as strong as the one before.
    lamps = pmf[names >= 16]
    np.testing.assert_allclose(lamps[1:] / lamps[:-1], 8.0, rtol=1e-4)
    one, at, on = np.zeros(1, np.uint32), points((0.0, 0.0, 0.0), 1), np.ones(1, bool)
    for prim in (0, 1):
        plain = run(mis_probability, world.scene, one, one + np.uint32(prim), at, on)[0]
        assert plain == found.mis_pmf[word == prim][0] == found.pmf[word == prim][0]


def leaves_at(places, axes):
    """Leaves of small size at some places."""
    n = len(places)
    ones, words = np.ones(n), np.arange(n, dtype=np.uint32)
    return Leaves(
        places - 0.01, places + 0.01, axes, 0.1 * ones, 0.5 * np.pi * ones, 0.0 * ones, ones,
        words, words,
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["even", "same place", "each twice as far"])
def test_nodes_bound_their_lights(kind):
    rng = np.random.default_rng(2)
    n = 600
    places = rng.normal(size=(n, 3))
    if kind == "same place":
        places[:] = 1.0
    if kind == "each twice as far":
        places = np.outer(2.0 ** np.linspace(0.0, 60.0, n), [1.0, 0.0, 0.0])
    axes = rng.normal(size=(n, 3)) + np.array([0.0, 0.0, 2.0])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    leaves = leaves_at(places, axes)
    tree = binary_tree(leaves._replace(intensity=leaves.intensity / n), 100)
    words = np.ascontiguousarray(tree.nodes[:, : 2 * CHILD]).reshape(-1, CHILD)
    for item in range(n):
        at, way, child = 0, int(tree.ways[item]), 0
        for _ in range(MOST_LEVELS):
            child = 2 * at + (way & 1)
            way >>= 1
            group = unpacked(words[child])
            ends = np.abs(leaves.low[item] - group.center), np.abs(leaves.high[item] - group.center)
            assert np.linalg.norm(np.maximum(*ends)) <= group.radius * (1.0 + 1e-5)
            lone = words[child, NEXT] >= LEAF
            # Up to the rounding of the axis, which `_GRAZING` allows for.
            within = np.cos(max(np.arccos(group.cosine) - 0.1, 0.0))
            assert group.axis @ axes[item] >= within - 2e-3
            # All directions that it faces, from all of its places.
            away = group.center - places[item]
            length = max(float(np.linalg.norm(away)), 1e-9)
            angle = np.arccos(np.clip(away @ axes[item] / length, -1.0, 1.0))
            least = length * np.cos(max(angle - 0.1, 0.0))
            assert least <= group.behind + 1e-5 * (1.0 + np.abs(places[item]).max())
            if lone:
                break
            at = (int(words[child, NEXT]) - 100) // NODE
        assert words[child, NEXT] == LEAF | item and words[child, PRIM] == item
    total = sum(unpacked(row).intensity for row in words[:2])
    assert total == pytest.approx(1.0, rel=0.01)


def unpacked(words):
    """`Groups` of one row."""
    high, low = (words >> 16).astype(np.uint32), (words & 0xFFFF).astype(np.uint32)
    radius, behind, intensity = (
        float((part << 16).astype(np.uint32).view(np.float32))
        for part in (high[REACH], low[REACH], high[STRENGTH] & 0x7FFF)
    )
    axis = np.array([(int(words[AXIS]) >> k & 1023) - 511 for k in (0, 10, 20)]) / 511.0
    cosine = (int(words[CONE]) >> 15 & 32767) / 32767 * 2.0 - 1.0
    dark = int(low[STRENGTH]) / 65535 * 2.0 - 1.0
    center = words[:3].view(np.float32).astype(float)
    flat, alike = bool(words[STRENGTH] & FLAT), bool(words[AXIS] & ALIKE)
    return Groups(center, radius, behind, axis, cosine, dark, intensity, flat, alike)


@kernel
def _root(scene, points, numbers, vectors, scalars, n):
    i = 0
    while i < n:
        p, u = load_vec3(points, i, n), load_vec3(numbers, i, n)
        normal = load_vec3(points, 3 * n + i, n)
        s = sample_light(scene, p, normal, u.x, (u.y, u.z), lanes_mask(True))
        store_vec3(vectors, i, n, s.wi)
        store_vec3(vectors, 3 * n + i, n, s.radiance)
        store_lanes(scalars, i, s.pdf)
        index = load_lanes(scene.indices, i)
        store_lanes(scalars, n + i, mis_probability(scene, index, index * 0, p, lanes_mask(True)))
        i += LANES


def test_compiled_tree_is_that_of_numpy():
    world, n = crowd("tree"), 4096
    rng = np.random.default_rng(1)
    at = rng.uniform(-4, 4, (6, n)).astype(np.float32)
    at[3:] /= np.linalg.norm(at[3:], axis=0)
    fields = (*world.scene._fields, "indices")
    indices = rng.integers(0, 24, n).astype(np.uint32)
    scene = namedtuple("Scene", fields)(*world.scene, View(indices))
    u, found = rng.random((3, n), np.float32), []
    for compiled in (True, False):
        vectors, scalars = View(np.zeros(6 * n, np.float32)), View(np.zeros(2 * n, np.float32))
        with np.errstate(all="ignore"):
            instantiate(_root, TREE, compiled=compiled)(
                scene, View(at.copy()), View(u), vectors, scalars, n
            )
        found.append(np.concatenate([vectors.array, scalars.array]).reshape(8, n))
    assert (found[0][6] > 0.0).mean() > 0.4
    # A number on the edge between two lights may fall to either side.
    close = np.isclose(found[0], found[1], rtol=2e-3, atol=1e-4).all(axis=0)
    assert close.mean() > 0.995


def test_densities_of_a_lone_lamp():
    lamp = (ROOF, translate(0, 0, 3).matrix @ rotate("x", 180).matrix, Area())
    tree, power = World(lamp, selection="tree"), World(lamp, selection="power")
    d = np.array([[0.1, -0.2], [0.05, 0.1], [1.0, 1.0]])
    d /= np.linalg.norm(d, axis=0)
    hit, surface, found = tree.surface(np.zeros((3, 2)), d)
    assert found.all()
    light, p = surface.light.astype(np.uint32), points((0, 0, 0), 2)
    pdf = run(light_pdf, tree.scene, light, p, vec(d), hit.t, surface)
    plain = [
        run(mis_probability, tree.scene, light * 0, np.full(2, k, np.uint32), p, light > 0)
        for k in (0, 1)
    ]
    np.testing.assert_allclose(plain[0] + plain[1], 1.0, rtol=1e-6)
    by_area, _, _ = densities(power, (0, 0, 0), d)
    # The same density but for how often each triangle is chosen.
    assert np.all(pdf > 0.2 * by_area) and np.all(pdf < 5.0 * by_area)


def test_strands_that_shine_are_one_leaf_whichever_part_of_them_is_met():
    """Rays hit primitives of a strand, of which light sampling knows nothing."""
    text = """
alight: 1
integrator: {type: path, light_choice: tree}
camera: {type: pinhole}
nodes:
  thread:
    shape: {type: curves, points: [[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 1, 1]], radii: 0.01}
    light: {type: area, radiance: 5}
  other: {shape: sphere, light: {type: area}, transform: {translate: [-4, 0, 0]}}
"""
    scene = compile_scene(flatten(loads(text)), structure="list")
    rows = int(scene.tables.shapes.info.array[4]) >> PRIMITIVES
    assert rows > 3
    prims = np.arange(rows, dtype=np.uint32)
    p = vec(np.tile([[0.5], [1.0], [2.0]], rows))
    ask = instantiate(mis_probability, scene.program, compiled=False)
    found = ask(scene.tables, prims * 0, prims, p, prims >= 0)
    other = ask(scene.tables, prims * 0 + 1, prims * 0, p, prims >= 0)
    assert np.ptp(found) == 0.0
    assert found[0] > 0.0
    np.testing.assert_allclose(found + other, 1.0, rtol=1e-6)
