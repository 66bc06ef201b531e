"""Closed meshes do not leak, not even at shared edges and vertices."""

import numpy as np
import pytest

from alight.accel import batch
from tests.accel.tracing import World, icosphere, same_bits, torus, triangle_set


def aimed_rays(vertices, faces, origin, n, rng):
    """Rays from near `origin` to vertices, points of edges, and next to them."""
    start = (origin + 0.05 * rng.normal(size=(n, 3))).astype(np.float32)
    corner = faces[rng.integers(len(faces), size=n)]
    side = rng.integers(3, size=n)
    a = vertices[corner[np.arange(n), side]].astype(np.float64)
    b = vertices[corner[np.arange(n), (side + 1) % 3]].astype(np.float64)
    share = rng.random((n, 1))
    share[rng.random(n) < 0.3] = 0.0
    share[rng.random(n) < 0.1] = 0.5
    target = (a + share * (b - a)).astype(np.float32)
    nudge = rng.integers(-1, 2, (n, 3)).astype(np.float32)
    target = np.where(rng.random((n, 1)) < 0.3, np.nextafter(target, target + nudge), target)
    return start, (target - start).astype(np.float32)


def tube_center(n, rng):
    """Points within the tube of `torus`."""
    angle = rng.uniform(0, 2 * np.pi, n)
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)


MESHES = {
    "sphere": (lambda: icosphere(4), lambda n, rng: np.zeros((n, 3))),
    "tetrahedron": (
        lambda: (
            np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], np.float32),
            np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], np.int32),
        ),
        lambda n, rng: np.zeros((n, 3)),
    ),
    "torus": (lambda: torus(90, 40, 0.1), tube_center),
    "slivers": (lambda: torus(2000, 5), tube_center),
    "far away": (
        lambda: (icosphere(3)[0] + np.float32(1000.0), icosphere(3)[1]),
        lambda n, rng: np.full((n, 3), 1000.0),
    ),
}


def leaks(name, n, seed):
    make, center = MESHES[name]
    vertices, faces = make()
    rng = np.random.default_rng(seed)
    bvh, _ = batch.build(vertices, faces)
    o, d = aimed_rays(vertices, faces, center(n, rng), n, rng)
    t, _, _, _ = batch.intersect_batch(bvh, o, d)
    blocked = batch.is_occluded_batch(bvh, o, d)
    return int(np.isinf(t).sum()), int((~blocked).sum())


@pytest.mark.parametrize("name", MESHES)
def test_no_ray_to_an_edge_or_vertex_leaks_out(name):
    assert leaks(name, 200_000, 1) == (0, 0)


@pytest.mark.proofs
@pytest.mark.parametrize("name", MESHES)
def test_ten_million_rays_to_edges_and_vertices_do_not_leak(name):
    for seed in range(8):
        assert leaks(name, 250_000, 10 + seed) == (0, 0)


@pytest.mark.parametrize("name", ["sphere", "tetrahedron"])
def test_packets_do_not_leak_and_find_what_single_rays_find(name):
    make, center = MESHES[name]
    vertices, faces = make() if name != "sphere" else icosphere(2)
    rng = np.random.default_rng(2)
    o, d = aimed_rays(vertices, faces, center(50_000, rng), 50_000, rng)
    triangles = triangle_set(vertices, faces)
    listed = World(triangles, structure="list").trace(o, d)
    assert np.isfinite(listed.t).all()
    assert listed.occluded.all()
    assert same_bits(listed, World(triangles, structure="bvh").trace(o, d))
