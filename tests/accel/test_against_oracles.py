"""The tree against brute force, bit for bit, and against float64, away from edges."""

import numpy as np
import pytest

from alight.accel import batch
from tests.accel.tracing import World, mismatches, same_bits, soup, soup_rays

SOUPS = range(50)
RAYS = 20_000


@pytest.mark.parametrize("group", range(10))
def test_a_million_rays_meet_in_the_tree_what_they_meet_one_by_one_and_in_float64(group):
    wrong = decided = 0
    for seed in SOUPS[group::10]:
        triangles = soup(seed)
        o, d = soup_rays(1000 + seed, triangles, RAYS)
        listed = World(triangles, structure="list").trace(o, d)
        tree = World(triangles, structure="bvh").trace(o, d)
        assert same_bits(listed, tree)
        row = {
            (int(s), int(p)): i
            for i, (s, p) in enumerate(zip(triangles.shape, triangles.prim, strict=True))
        }
        which = np.array(
            [
                row[s, p] if t < np.inf else -1
                for t, s, p in zip(tree.t, tree.shape.tolist(), tree.prim.tolist(), strict=True)
            ]
        )
        # `soup` gives its middle triangle the corners of the first one; the oracle names the first.
        which[which == len(triangles.faces) // 2] = 0
        bad, sure = mismatches(triangles, o, d, tree.t, which)
        wrong, decided = wrong + bad, decided + sure
    assert wrong == 0
    assert decided > 0.5 * RAYS * len(SOUPS[group::10])


@pytest.mark.parametrize("method", ["sah", "median"])
def test_every_builder_finds_the_same_hits(method):
    triangles = soup(77, 3000)
    o, d = soup_rays(78, triangles, 5000)
    listed = World(triangles, structure="list").trace(o, d)
    assert same_bits(listed, World(triangles, structure="bvh", builder=method).trace(o, d))


def test_single_rays_find_what_packets_find():
    triangles = soup(5, 500)
    order = np.lexsort((triangles.prim, triangles.shape))
    o, d = soup_rays(6, triangles, 20_000)
    bvh, _ = batch.build(triangles.vertices, triangles.faces[order])
    t, prim, u, v = batch.intersect_batch(bvh, o, d)
    packets = World(triangles, structure="list").trace(o, d)
    assert t.tobytes() == packets.t.tobytes()
    hit = t < np.inf
    assert np.array_equal(hit, prim >= 0)
    assert np.array_equal(triangles.prim[order][prim[hit]], packets.prim[hit])
    assert np.array_equal(u[hit], packets.u[hit])
    assert np.array_equal(v[hit], packets.v[hit])
    assert np.array_equal(batch.is_occluded_batch(bvh, o, d), hit)
    threaded = batch.intersect_batch(bvh, o, d, threads=2)
    assert threaded[0].tobytes() == t.tobytes()


def test_the_twin_runs_the_lists():
    triangles = soup(9, 40)
    o, d = soup_rays(10, triangles, 500)
    world = World(triangles, structure="list")
    assert same_bits(world.trace(o, d), world.trace(o, d, compiled=False))


@pytest.mark.parametrize("structure", ["list", "bvh"])
def test_a_ray_finds_the_same_whatever_its_companions_are(structure):
    triangles = soup(11, 300)
    o, d = soup_rays(12, triangles, 4096)
    world = World(triangles, structure=structure)
    whole = world.trace(o, d)
    rng = np.random.default_rng(13)
    order = rng.permutation(len(o))
    active = rng.random(len(o)) < 0.3
    mixed = world.trace(o[order], d[order], active=active)
    for name, a, b in zip(whole._fields, whole, mixed, strict=True):
        nothing = {"t": np.inf}.get(name, 0)
        expected = np.where(active, a[order], np.asarray(nothing, a.dtype))
        used = active & (whole.t[order] < np.inf) if name in "uv" else slice(None)
        assert np.array_equal(expected[used], b[used]), name


@pytest.mark.parametrize("structure", ["list", "bvh"])
def test_any_hit_agrees_with_closest_and_t_max_ends_the_ray(structure):
    triangles = soup(14, 300)
    o, d = soup_rays(15, triangles, 4000)
    world = World(triangles, structure=structure)
    whole = world.trace(o, d)
    assert np.array_equal(whole.occluded, whole.t < np.inf)
    exact = world.trace(o, d, t_max=whole.t)
    assert same_bits(whole, exact)
    before = np.nextafter(whole.t, np.float32(0))
    short = world.trace(o, d, t_max=before)
    hit = whole.t < np.inf
    assert not short.occluded[hit].any()
    assert np.isinf(short.t[hit]).all()
    rng = np.random.default_rng(16)
    limit = rng.exponential(np.median(whole.t[hit]), len(o)).astype(np.float32)
    some = world.trace(o, d, t_max=limit)
    assert np.array_equal(some.t < np.inf, whole.t <= limit)
    assert np.array_equal(some.occluded, whole.t <= limit)
