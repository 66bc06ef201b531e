"""Rays and boxes: what is met is met, and nothing else, or the search would be long."""

import numpy as np
import pytest

from alight.accel import references
from alight.accel.node_test import meet_slabs
from alight.compiled.program import Program
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from lanewise.view import View


def test_a_box_is_met_where_the_ray_is_in_all_three_slabs_at_once():
    """By float64; only within rounding of an edge may a ray that misses enter."""
    rng, n = np.random.default_rng(1), 200_000
    low = rng.uniform(-2.0, 0.0, (3, n))
    high = low + rng.exponential(2.0, (3, n))
    o, d, t = rng.normal(size=(3, n)), rng.normal(size=(3, n)), rng.exponential(4.0, n)
    slabs = np.sort([(low - o) / d, (high - o) / d], axis=0)
    near, far = (Vec3(*side.astype(np.float32)) for side in slabs)
    enter, met = instantiate(meet_slabs, Program(), compiled=False)(near, far, np.float32(t))
    entry, exit_ = np.maximum(slabs[0].max(axis=0), 0.0), np.minimum(slabs[1].min(axis=0), t)
    certain = np.abs(exit_ - entry) > 1e-4 * (1.0 + np.abs(entry))
    assert 0.05 < (entry <= exit_).mean() < 0.5
    np.testing.assert_array_equal(met[certain], (entry <= exit_)[certain])
    np.testing.assert_allclose(enter[met], entry[met], rtol=1e-5, atol=1e-6)


# ---------------------------------------------------------------- boxes of the build


def random_boxes(n):
    """Boxes as references keep them: lower bounds, upper ones negated; (n, 8) and (n, 2, 3)."""
    rng = np.random.default_rng(2)
    low = rng.normal(size=(n, 3)) * 10.0 ** rng.uniform(-2.0, 2.0, (n, 1))
    corners = np.stack([low, low + 10.0 ** rng.uniform(-3.0, 2.0, (n, 3))], axis=1)
    corners = corners.astype(np.float32)
    boxes = np.zeros((n, 8), np.float32)
    boxes[:, :3], boxes[:, 4:7] = corners[:, 0], -corners[:, 1]
    return boxes, corners.astype(np.float64)


def test_boxes_are_enlarged_by_their_longest_edge_and_their_coordinates():
    boxes, corners = random_boxes(300)
    edges = corners[:, 1] - corners[:, 0]
    for box, corner, edge in zip(boxes, corners, edges, strict=True):
        low, high = corner
        found = references.enlarged(box).astype(float)
        margin = edge.max() * references.MARGIN + np.abs(corner) * references.ROUNDING
        rounding = 2.0**-23 * (np.abs(corner) + edge.max())
        assert (np.abs(found[:3] - (low - margin[0])) <= rounding[0]).all()
        assert (np.abs(-found[4:7] - (high + margin[1])) <= rounding[1]).all()
        assert references.largest_edge(box) == pytest.approx(edge.max(), rel=1e-6, abs=1e-3)
        faces = edge * np.roll(edge, 1)
        assert references.half_area(box, np.float32(0.5)) == pytest.approx(
            0.25 * faces.sum(), rel=1e-4
        )
        middle = references.centroid(box)[[0, 1, 2, 4, 5, 6]]
        assert middle == pytest.approx(np.concatenate([low + high, -low - high]), abs=1e-4)


@pytest.mark.parametrize("factor", [0.3, 1.0, 1.02, 7.0])
def test_any_scale_of_bins_divides_references_without_loss(factor, monkeypatch):
    """How finely does not matter: who stands left of a border is decided once, for all uses."""
    n, per_axis, first = 62, 8, 3
    plain = references.bin_scale

    def scaled(centers, per_axis):
        with np.errstate(divide="ignore"):
            return np.float32(factor) * plain(centers, per_axis)

    monkeypatch.setattr(references, "bin_scale", scaled)
    boxes, _ = random_boxes(n)
    source, target = View(boxes.ravel()), View(np.zeros(8 * n, np.float32))
    centers = np.min([references.centroid(box) for box in boxes[first:]], axis=0)
    bins = references.new_bins()
    references.fill_bins(source, first, n, centers, per_axis, bins)
    counts = np.array(bins.counts[: references.COUNTS]).reshape(3, -1)[:, :per_axis]
    assert (counts.sum(axis=1) == n - first).all()
    for axis in range(3):
        for last in (0, 3, 6):
            border = references.Border(centers, per_axis, axis, last)
            left = int(counts[axis, : last + 1].sum())
            references.partition(source, target, first, n, 0, left, border)
            moved = target.array.reshape(n, 8)[: n - first]
            np.testing.assert_array_equal(np.sort(moved, axis=0), np.sort(boxes[first:], axis=0))
            # All on the left have lower centroids than all on the right.
            middles = moved[:, axis] - moved[:, 4 + axis]
            if 0 < left < n - first:
                assert middles[:left].max() <= middles[left:].min()
    if factor == 1.0:
        assert (counts[:, [0, -1]] > 0).all()
