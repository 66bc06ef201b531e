"""The build: the same tree for any number of threads, bounded depth, nothing lost."""

import numpy as np
import pytest

from alight.accel import batch, top_division
from alight.accel.build import build_bvh
from alight.accel.cost import BIG, waits_for_memory
from alight.accel.fill import expected_fill
from alight.accel.kept import tree_of
from alight.accel.layout import (
    BLOCK,
    CHILD,
    CHILDREN,
    CORNERS,
    IDS,
    LEAF,
    MAX_BLOCKS,
    MAX_DEPTH,
    NODE,
    OTHER,
    OTHERS_IN_LEAF,
    UPPER,
    WIDTH,
    check_blocks,
)
from lanewise.simd import LANES
from lanewise.view import View
from tests.accel.tracing import icosphere, torus


def indices_in_leaves(bvh):
    """Triangle indices of all leaves reached from the root, and the number of levels."""
    nodes = bvh.nodes.array.reshape(-1, NODE)
    children = nodes.view(np.uint32)[:, CHILD:]
    ids = bvh.blocks.array.view(np.uint32).reshape(-1, BLOCK)[:, IDS : IDS + WIDTH]
    found, level, depth = [], np.array([0]), 0
    while len(level):
        depth += 1
        there = nodes[level][:, :CHILDREN] <= nodes[level][:, UPPER : UPPER + CHILDREN]
        codes = children[level][there].astype(np.int64)
        leaves = codes[codes >= LEAF] - LEAF
        for block, count in zip(leaves >> 4, leaves & 15, strict=True):
            found.append(np.unique(ids[block : block + count]))
        level = codes[codes < LEAF]
    return np.concatenate(found), depth


def assert_complete(bvh, stats, n):
    found, depth = indices_in_leaves(bvh)
    assert np.array_equal(np.sort(found), np.arange(n))
    assert depth == stats["depth"] <= MAX_DEPTH
    # Children stand side by side, and only what is missing is number 0.
    nodes = bvh.nodes.array.reshape(-1, NODE)
    there = nodes[:, :CHILDREN] <= nodes[:, UPPER : UPPER + CHILDREN]
    assert np.array_equal(there, np.arange(CHILDREN) < there.sum(axis=1)[:, None])
    assert np.array_equal(there, nodes.view(np.uint32)[:, CHILD:] != 0)


@pytest.mark.parametrize("method", ["sah", "median"])
def test_every_triangle_is_in_exactly_one_leaf(method):
    for vertices, faces in (icosphere(0), icosphere(3), torus(200, 100)):
        bvh, stats = batch.build(vertices, faces, method=method)
        assert_complete(bvh, stats, len(faces))


def test_the_tree_does_not_depend_on_the_number_of_threads():
    vertices, faces = torus(500, 120, 0.1)
    trees = [batch.build(vertices, faces, threads=threads)[0] for threads in (1, 2, 3)]
    for tree in trees[1:]:
        assert np.array_equal(
            tree.nodes.array.view(np.uint32), trees[0].nodes.array.view(np.uint32)
        )
        assert np.array_equal(
            tree.blocks.array.view(np.uint32), trees[0].blocks.array.view(np.uint32)
        )


@pytest.mark.parametrize(
    "changed",
    [{"SMALLEST_TASK": 10**9}, {"CHUNK": 1000}, {"CHUNK": 1000, "TOGETHER": 1}],
    ids=["by one thread from the root on", "in small chunks", "a thread for each part"],
)
def test_the_tree_does_not_depend_on_who_divides_the_first_levels(changed, monkeypatch):
    """The same splits by two texts: together in chunks, and by one thread alone (`subtree`)."""
    vertices, faces = torus(300, 100, 0.15)
    boxes = []
    for constants in ({}, changed):
        for name, value in constants.items():
            monkeypatch.setattr(top_division, name, value)
        tree, _ = batch.build(vertices, faces)
        # Only where a node stands in the table may differ.
        bounds = tree.nodes.array.reshape(-1, NODE)[:, :CHILD].view(np.uint32)
        boxes.append(sorted(map(bytes, np.ascontiguousarray(bounds))))
    assert boxes[0] == boxes[1]


def hard_cases():
    rng = np.random.default_rng(1)
    n = 20_000
    small = 1e-3 * rng.normal(size=(n, 3, 3))
    yield "the same triangle", np.tile(rng.normal(size=(1, 3, 3)), (n, 1, 1))
    yield "the same centre", small - small.mean(axis=1, keepdims=True)
    yield "points", np.tile(rng.normal(size=(n, 1, 3)), (1, 3, 1))
    yield "on a line", small * [1, 0, 0] + np.linspace(0, 1, n)[:, None, None] * [1, 0, 0]
    # Each is smaller than the one before by the same factor: every split takes off few.
    powers = np.float64(10.0) ** -np.linspace(0, 36, 400)
    yield "a geometric series", powers[:, None, None] * (np.eye(3) + 1.0)
    yield "huge ones", np.where(rng.random((n, 1, 1)) < 0.01, 1e30, 1.0) * small


@pytest.mark.parametrize(("name", "corners"), list(hard_cases()), ids=[c[0] for c in hard_cases()])
def test_hard_cases_give_complete_trees_of_bounded_depth_with_the_same_hits(name, corners):
    vertices = corners.reshape(-1, 3).astype(np.float32)
    faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    # At triangles of all sizes, from near enough that their points are not rounded away.
    rng = np.random.default_rng(2)
    aim = corners.mean(axis=1)[rng.integers(0, len(corners), 1000)]
    d = rng.normal(size=(1000, 3))
    size = np.median(np.ptp(corners, axis=1)) + np.abs(aim).max(axis=1)
    o = (aim - d * size[:, None]).astype(np.float32)
    found = []
    for method in ("sah", "median"):
        bvh, stats = batch.build(vertices, faces, method=method, threads=2)
        assert_complete(bvh, stats, len(faces))
        hits = batch.intersect_batch(bvh, o, d.astype(np.float32))
        found.append([*hits, batch.is_occluded_batch(bvh, o, d.astype(np.float32))])
    for sah, median in zip(*found, strict=True):
        np.testing.assert_array_equal(sah, median)
    if name not in ("points", "on a line"):
        assert np.isfinite(found[0][0]).sum() > 100


def test_sah_costs_less_than_the_median():
    from alight.accel.cost import sah_cost

    vertices, faces = torus(300, 100, 0.15)
    costs = [sah_cost(batch.build(vertices, faces, method=m)[0]) for m in ("sah", "median")]
    assert costs[0] < costs[1]


def test_a_tree_that_is_kept_is_that_of_its_builder():
    vertices, faces = torus(20, 15, 0.3)
    vertices, faces = vertices.astype(np.float32), faces.astype(np.int32)
    for array in (vertices, faces):
        array.flags.writeable = False
    kept = {m: tree_of(vertices, faces, method=m, threads=1) for m in ("sah", "median")}
    for method, (tree, stats) in kept.items():
        assert tree_of(vertices, faces, method=method, threads=2)[0] is tree
        built, figures = build_bvh(vertices, faces, method=method, threads=1)
        np.testing.assert_array_equal(tree.nodes.array, built.nodes.array)
        assert {**stats, "seconds": 0} == {**figures, "seconds": 0}
    assert not np.array_equal(*(tree.nodes.array[:NODE] for tree, _ in kept.values()))


def test_rays_wait_for_memory_in_big_trees_only():
    bvh, _ = batch.build(*torus(40, 30, 0.3))
    assert bvh.waits == 0
    # Only the size of the arrays counts, not what is in them.
    assert waits_for_memory(bvh._replace(nodes=View(np.zeros(BIG // 4 + 1, np.float32)))) == 1


def test_what_is_asked_for_before_it_is_needed_changes_no_hit():
    rng = np.random.default_rng(5)
    vertices, faces = torus(60, 40, 0.3)
    vertices = np.concatenate([vertices, rng.normal(size=(900, 3)).astype(np.float32)])
    soup = len(vertices) - 900 + np.arange(900, dtype=np.int32).reshape(-1, 3)
    bvh, _ = batch.build(vertices, np.concatenate([faces, soup]))
    o = rng.normal(size=(3000, 3)).astype(np.float32)
    d = rng.normal(size=(3000, 3)).astype(np.float32)
    results = []
    for waits in (0, 1):
        tree = bvh._replace(waits=waits)
        hits = batch.intersect_batch(tree, o, d)
        results.append([*hits, batch.is_occluded_batch(tree, o, d)])
    assert 0 < np.isfinite(results[0][0]).sum() < 3000
    for other in results[1:]:
        for a, b in zip(results[0], other, strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("big", [False, True])
def test_rays_that_travel_together_find_what_each_finds_alone(big):
    """Camera rays stay together to the leaves, random ones part at once and wait in numbers."""
    rng = np.random.default_rng(6)
    vertices, faces = torus(60, 40, 0.3)
    vertices = np.concatenate([vertices, rng.normal(size=(9000, 3)).astype(np.float32)])
    soup = len(vertices) - 9000 + np.arange(9000, dtype=np.int32).reshape(-1, 3)
    bvh, _ = batch.build(vertices, np.concatenate([faces, soup]))
    bvh = bvh._replace(waits=int(big))
    x, y = np.meshgrid(np.linspace(-1.5, 1.5, 32), np.linspace(-1.5, 1.5, 32))
    camera = np.stack([x, y, np.full_like(x, -3.0)], axis=-1).reshape(-1, 3)
    d = np.concatenate([camera, rng.normal(size=(512, 3))]).astype(np.float32)
    o = np.where(np.arange(len(d))[:, None] < 1024, [0.0, 0.0, 3.0], rng.normal(size=d.shape))
    o = o.astype(np.float32)
    together = [*batch.intersect_batch(bvh, o, d), batch.is_occluded_batch(bvh, o, d)]
    # Rays without a direction fill the other lanes of each packet.
    n = int(LANES)
    alone = np.zeros((n * len(d), 3), np.float32)
    alone[::n] = d
    origins = np.repeat(o, n, axis=0)
    single = [
        *batch.intersect_batch(bvh, origins, alone),
        batch.is_occluded_batch(bvh, origins, alone),
    ]
    assert 300 < np.isfinite(together[0]).sum() < len(d)
    for a, b in zip(together, single, strict=True):
        np.testing.assert_array_equal(a, b[::n])


def block_contents(bvh):
    """Corners (blocks, WIDTH, 3, 3) and indices (blocks, WIDTH) of the triangles of all blocks."""
    rows = bvh.blocks.array.reshape(-1, BLOCK)
    vertices = np.stack([rows[:, WIDTH * k : WIDTH * (k + 1)] for k in range(3)], axis=-1)
    words = rows.view(np.uint32)[:, CORNERS:IDS]
    which = np.stack([words >> 4 * k & 15 for k in range(3)], axis=-1)
    corners = vertices[np.arange(len(rows))[:, None, None], which]
    return corners, rows.view(np.uint32)[:, IDS : IDS + WIDTH], words


@pytest.mark.parametrize("shared", [True, False])
def test_blocks_hold_the_corners_of_their_triangles_bit_by_bit(shared):
    vertices, faces = torus(70, 50, 0.3)
    rng = np.random.default_rng(7)
    if not shared:
        vertices = (vertices[faces] + 0.01 * rng.normal(size=(len(faces), 3, 3))).reshape(-1, 3)
        vertices, faces = vertices.astype(np.float32), np.arange(3 * len(faces)).reshape(-1, 3)
        faces = faces.astype(np.int32)
    bvh, stats = batch.build(vertices, faces)
    corners, indices, words = block_contents(bvh)
    assert np.array_equal(corners.view(np.uint32), vertices[faces][indices].view(np.uint32))
    assert not np.any(words >> 12)
    # Neighbours share vertices, so that a block takes more of them than of strangers.
    held = [len(np.unique(block)) for block in indices]
    assert max(held) == (WIDTH if shared else WIDTH // 3)
    assert np.mean(held) > (9.0 if shared else 3.0)
    assert stats["blocks"] == len(held)


def test_the_expected_fill_of_a_block_follows_what_triangles_share():
    vertices, faces = torus(70, 50, 0.3)
    shuffled = np.random.default_rng(8).permutation(faces)
    repeated = vertices[faces].reshape(-1, 3)
    one_each = np.arange(3 * len(faces), dtype=np.int32).reshape(-1, 3)
    soup = np.random.default_rng(9).normal(size=(900, 3)).astype(np.float32)
    assert expected_fill(vertices, faces, 0) == WIDTH
    assert expected_fill(vertices, shuffled, 0) == WIDTH
    assert expected_fill(repeated, one_each, 0) == WIDTH
    assert expected_fill(soup, one_each[:300], 0) == WIDTH // 3
    # A leaf of other things has a block for each; fifteen are counted in its code.
    assert expected_fill(vertices, faces, 3) == 15
    assert expected_fill(vertices, faces[:0], 20) == 8
    # What is one of many stands alone.
    assert expected_fill(vertices, faces[:0], 20, 20) == 1
    assert expected_fill(vertices, faces[:0], 0) == 1


def test_a_leaf_holds_few_things_that_are_not_triangles():
    """In a scene of many triangles, too, where more of those are expected in a leaf."""
    vertices, faces = torus(70, 50, 0.3)
    rng = np.random.default_rng(10)
    centers = 0.1 * rng.normal(size=(400, 1, 3)) + [0.0, 0.0, 3.0]
    half = np.array([[-0.001], [0.001]])
    boxes = (centers + half).astype(np.float32)
    others = np.zeros((400, BLOCK), np.float32)
    words = others.view(np.uint32)
    words[:, CORNERS:IDS], words[:, IDS] = OTHER, len(faces) + np.arange(400)
    bvh, _ = build_bvh(vertices.astype(np.float32), faces.astype(np.int32), others, boxes)
    codes = bvh.nodes.array.reshape(-1, NODE)[:, CHILD:].view(np.uint32)
    leaves = codes[codes >= LEAF]
    last_corners = bvh.blocks.array.view(np.uint32).reshape(-1, BLOCK)[:, IDS - 1]
    holds_others = last_corners[(leaves - LEAF) >> 4] == OTHER
    assert holds_others.sum() >= 400 / OTHERS_IN_LEAF
    assert (leaves[holds_others] & 15).max() <= OTHERS_IN_LEAF


def test_more_blocks_than_a_code_can_number_are_an_error():
    check_blocks(MAX_BLOCKS)
    assert ((LEAF | (MAX_BLOCKS - 1) << 4 | 15) & (LEAF - 1)) >> 4 == MAX_BLOCKS - 1
    with pytest.raises(ValueError, match="134217729 blocks of primitives, more than 134217728"):
        check_blocks(MAX_BLOCKS + 1)
