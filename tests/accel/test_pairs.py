"""Two triangles of a flat quadrilateral share a division, and nothing else changes."""

import numpy as np

from alight.accel import build_accelerator
from alight.accel.primitives import first_of_pairs
from tests.accel.tracing import World, same_bits, triangle_set, unit


def quadrilaterals(rng, n, bend=0.0):
    """n quadrilaterals a, b, c, d as fans of two triangles; d is off the plane by about `bend`."""
    middle = rng.normal(size=(n, 1, 3))
    x, y = rng.normal(size=(2, n, 3))
    z = np.cross(x, y)
    shape = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * rng.uniform(0.3, 1.0, (n, 4, 1))
    corners = middle + shape[..., :1] * x[:, None] + shape[..., 1:] * y[:, None]
    corners[:, 3] += bend * z
    vertices = corners.reshape(-1, 3).astype(np.float32)
    faces = 4 * np.arange(n)[:, None, None] + [[0, 1, 2], [0, 2, 3]]
    return vertices, faces.reshape(-1, 3)


def rays_at(rng, vertices, faces, n):
    """Rays through the box; every third one hits the middle of an edge, and starts on a grid."""
    o = np.rint(4.0 * rng.uniform(-2, 2, (n, 3))) / 4.0
    picked = vertices[faces[rng.integers(0, len(faces), n)]].astype(np.float64)
    target = np.where(np.arange(n)[:, None] % 3 == 0, picked[:, [0, 2]].mean(axis=1), picked[:, 1])
    target += np.where(np.arange(n)[:, None] % 3 == 2, 0.3 * rng.normal(size=(n, 3)), 0.0)
    return o.astype(np.float32), unit(target - o).astype(np.float32)


def test_pairs_give_the_bits_of_single_triangles():
    """Some are bent, so that grazing rays meet both triangles, which needs the second division."""
    for seed, bend in enumerate((0.0, 0.003, 0.06)):
        rng = np.random.default_rng(seed)
        vertices, faces = quadrilaterals(rng, 12, bend)
        triangles = triangle_set(vertices, faces, shape=np.arange(24) // 8)
        o, d = rays_at(rng, vertices, faces, 6000)
        worlds = {s: World(triangles, structure=s) for s in ("auto", "list", "bvh")}
        assert "list pairs" in worlds["auto"].plan and "list pairs" not in worlds["list"].plan
        paired, listed, tree = (w.trace(o, d) for w in worlds.values())
        assert same_bits(listed, tree)
        assert same_bits(paired, listed)
        twin = worlds["auto"].trace(o[:256], d[:256], compiled=False)
        assert all(a[:256].tobytes() == b.tobytes() for a, b in zip(paired, twin, strict=True))


def test_rays_along_the_shared_edge_meet_the_first_triangle():
    """A wall at right angles to the rays: its diagonal is met exactly."""
    square = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]
    world = World(triangle_set(square, [[0, 1, 2], [0, 2, 3]]))
    assert world.plan == ("list pairs",)
    k = np.linspace(0.25, 3.75, 15, dtype=np.float32)
    o = np.stack([k, k, np.ones_like(k)], axis=1)
    hits = world.trace(o, np.tile(np.float32([0, 0, -1]), (15, 1)))
    assert np.all(hits.t == 1.0) and np.all(hits.prim == 0)
    sides = np.stack([k, k + np.float32(0.125), np.ones_like(k)], axis=1)
    assert np.all(world.trace(sides, np.tile(np.float32([0, 0, -1]), (15, 1))).prim == 1)


def test_what_is_a_pair():
    vertices, faces = quadrilaterals(np.random.default_rng(1), 3)
    corners, ids = vertices[faces], np.stack([np.zeros(6), np.arange(6)], axis=1).astype(np.uint32)
    assert first_of_pairs(corners, ids).tolist() == [True, False] * 3
    # A fan of three has one pair: no triangle is in two.
    fan = np.float32([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 2, 0], [0, 2, 0]])
    three = fan[[[0, 1, 2], [0, 2, 3], [0, 3, 4]]]
    assert first_of_pairs(three, ids[:3]).tolist() == [True, False, False]
    # Other shapes, other corners, a fold, and a triangle without area stay alone.
    assert not first_of_pairs(corners[:2], np.uint32([[0, 0], [1, 0]])).any()
    assert not first_of_pairs(corners[:2][:, [1, 2, 0]], ids[:2]).any()
    # Corners that differ in one coordinate, by next to nothing, are others: there is a crack.
    for corner in (0, 1):
        for axis in range(3):
            apart = corners[:2].copy()
            apart[1, corner, axis] += np.float32(1e-4)
            assert not first_of_pairs(apart, ids[:2]).any()
    folded = corners[:2].copy()
    folded[1, 2] = folded[0, 1]
    assert not first_of_pairs(folded, ids[:2]).any()
    assert not first_of_pairs(np.zeros((2, 3, 3), np.float32), ids[:2]).any()


def test_an_odd_triangle_of_a_mesh_is_listed_beside_its_pairs():
    vertices, faces = quadrilaterals(np.random.default_rng(4), 4)
    triangles = triangle_set(vertices, np.vstack([faces, [[1, 6, 9]]]))
    accelerator, plan, stats = build_accelerator(triangles)
    assert plan == ("list pairs", "list triangles") and stats["listed"] == 9
    assert accelerator.pair_ids.size == 4 * 3 and accelerator.triangle_ids.size == 2
    # Of two that lie on each other the lower prim counts, whichever list it is in.
    for lower in ([0, 1, 2], [0, 2, 3]):
        faces = [lower, [4, 5, 6], [0, 1, 2], [0, 2, 3], lower]
        twice = triangle_set(vertices[:8], faces)
        o, d = rays_at(np.random.default_rng(5), vertices[:4], np.array([lower]), 600)
        worlds = [World(twice, structure=s) for s in ("auto", "list")]
        assert worlds[0].plan == ("list pairs", "list triangles")
        paired, listed = (world.trace(o, d) for world in worlds)
        assert same_bits(paired, listed) and 0 in paired.prim[np.isfinite(paired.t)]
