"""Rays and scenes for the tests of acceleration structures, and an oracle in float64."""

from collections import namedtuple
from functools import lru_cache

import numba
import numpy as np

from alight.accel import TriangleSet, build_accelerator, intersect_closest, is_occluded
from alight.core.vec import Vec3
from lanewise.jit import instantiate, kernel
from lanewise.simd import (
    LANES,
    bits_float,
    lanes,
    load_lanes,
    store_lanes,
    where,
)
from lanewise.view import View

Program = namedtuple("Program", "accel")
Shapes = namedtuple("Shapes", "data")
Scene = namedtuple("Scene", "accel shapes")
Hits = namedtuple("Hits", "t u v shape prim occluded")

#: Lanes for which packets are padded; a multiple of any packet width.
PADDING = 16


@kernel(strict=True)
def trace_packets(scene, rays, active, results, n):
    """Closest hits and occlusion of n rays; rays: 7 columns of n, results: 6 columns of n."""
    for i in range(0, n, LANES):
        o = Vec3(load_lanes(rays, i), load_lanes(rays, n + i), load_lanes(rays, 2 * n + i))
        d = Vec3(
            load_lanes(rays, 3 * n + i), load_lanes(rays, 4 * n + i), load_lanes(rays, 5 * n + i)
        )
        t_max, on = load_lanes(rays, 6 * n + i), load_lanes(active, i) > 0.5
        hit = intersect_closest(scene, o, d, t_max, on)
        blocked = is_occluded(scene, o, d, t_max, on)
        store_lanes(results, i, hit.t)
        store_lanes(results, n + i, hit.u)
        store_lanes(results, 2 * n + i, hit.v)
        store_lanes(results, 3 * n + i, bits_float(hit.shape))
        store_lanes(results, 4 * n + i, bits_float(hit.prim))
        store_lanes(results, 5 * n + i, where(blocked, lanes(1.0), lanes(0.0)))


@lru_cache(maxsize=32)
def kernel_of(plan, compiled=True):
    return instantiate(trace_packets, Program(plan), compiled=compiled)


class World:
    """A scene of bare primitives that can be traced."""

    def __init__(self, *parts, data=None, **options):
        self.accel, self.plan, self.stats = build_accelerator(*parts, **options)
        rows = np.zeros(1, np.float32) if data is None else np.asarray(data, np.float32)
        self.scene = Scene(self.accel, Shapes(View(rows)))

    def trace(self, origins, directions, t_max=np.inf, active=True, compiled=True):
        """Hits of rays (n, 3), (n, 3) in packets."""
        n = len(origins)
        padded = -(-n // PADDING) * PADDING
        rays = np.zeros((7, padded), np.float32)
        rays[:3, :n], rays[3:6, :n], rays[6, :n] = origins.T, directions.T, t_max
        on = np.zeros(padded, np.float32)
        on[:n] = active
        results = np.zeros((6, padded), np.float32)
        with np.errstate(all="ignore"):
            kernel_of(self.plan, compiled)(self.scene, View(rays), View(on), View(results), padded)
        bits = results.view(np.uint32)
        return Hits(*results[:3, :n], *bits[3:5, :n], results[5, :n] > 0)


def same_bits(a, b):
    """Are all fields of two `Hits` the same, bit for bit?"""
    return all(x.tobytes() == y.tobytes() for x, y in zip(a, b, strict=True))


def triangle_set(vertices, faces, shape=0):
    """One mesh, or one shape number a face."""
    faces = np.asarray(faces, np.int32)
    shapes = np.broadcast_to(np.asarray(shape, np.uint32), len(faces)).copy()
    prims = np.zeros(len(faces), np.uint32)
    for number in np.unique(shapes):
        mine = shapes == number
        prims[mine] = np.arange(mine.sum())
    return TriangleSet(np.asarray(vertices, np.float32), faces, shapes, prims)


def unit(v):
    """Rows of length 1."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def soup(seed, n=120):
    """Random triangles: ordinary, tiny, huge, degenerate and doubled ones; at some scale."""
    rng = np.random.default_rng(seed)
    size = np.exp(rng.normal(-1.0, 1.0, (n, 1, 1)))
    size[rng.random(n) < 0.1] = 1e-5
    corners = rng.normal(size=(n, 1, 3)) + size * rng.normal(size=(n, 3, 3))
    huge = rng.random(n) < 0.03
    corners[huge] *= 10.0 ** rng.uniform(1, 3)
    flat = rng.random(n) < 0.05
    corners[flat, 2] = corners[flat, 1]
    needle = rng.random(n) < 0.05
    corners[needle, 2] = 0.5 * (corners[needle, 0] + corners[needle, 1])
    corners[rng.random(n) < 0.02] = corners[0, 0]
    axis = rng.integers(3)
    level = rng.random(n) < 0.1
    corners[level, :, axis] = corners[level, :1, axis]
    corners *= 10.0 ** rng.uniform(-4, 4)
    vertices = corners.reshape(-1, 3).astype(np.float32)
    faces = np.arange(3 * n, dtype=np.int32).reshape(n, 3)
    faces[n // 2] = faces[0]
    return triangle_set(vertices, faces, rng.integers(0, 3, n))


def soup_rays(seed, triangles, n):
    """Rays from and to the neighbourhood of random triangles, some along an axis."""
    rng = np.random.default_rng(seed)
    points = triangles.vertices[triangles.faces].astype(np.float64)
    middle = points.mean(axis=1)
    spread = np.median(np.abs(middle))
    target = middle[rng.integers(len(middle), size=n)]
    weights = rng.dirichlet((1, 1, 1), n)
    aimed = rng.random(n) < 0.5
    chosen = points[rng.integers(len(points), size=n)]
    target[aimed] = np.einsum("nk,nkc->nc", weights, chosen)[aimed]
    origins = spread * 3.0 * rng.normal(size=(n, 3))
    directions = unit(target - origins)
    straight = rng.random(n) < 0.1
    directions[straight] = np.eye(3)[rng.integers(3, size=straight.sum())]
    return origins.astype(np.float32), directions.astype(np.float32)


@numba.njit
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@numba.njit
def _minus(p, q):
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


@numba.njit
def _cross(p, q):
    return (
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    )


@numba.njit
def _largest(p):
    return max(abs(p[0]), abs(p[1]), abs(p[2]))


@numba.njit
def _across(p, d):
    """The part of p at right angles to the unit vector d."""
    s = _dot(p, d)
    return (p[0] - s * d[0], p[1] - s * d[1], p[2] - s * d[2])


@numba.njit
def _line_to_segment(d, p, q):
    """Distance of the line s d (|d| = 1) from the segment p q, and s of the nearest point."""
    e = _minus(q, p)
    # Seen along the line all is flat: the distance of the origin from the projected segment.
    p_flat, e_flat = _across(p, d), _across(e, d)
    ee = _dot(e_flat, e_flat)
    x = min(1.0, max(0.0, -_dot(p_flat, e_flat) / ee)) if ee > 0.0 else 0.0
    gap = (p_flat[0] + x * e_flat[0], p_flat[1] + x * e_flat[1], p_flat[2] + x * e_flat[2])
    return np.sqrt(_dot(gap, gap)), _dot(p, d) + x * _dot(e, d)


@numba.njit
def _meet(a, b, c, d, margin):
    """One triangle relative to the origin: (2 hit, 1 doubtful, 0 missed; t; least t)."""
    gap_ab, t_ab = _line_to_segment(d, a, b)
    gap_bc, _ = _line_to_segment(d, b, c)
    gap_ca, _ = _line_to_segment(d, c, a)
    edge = min(gap_ab, gap_bc, gap_ca)
    normal = _cross(_minus(b, a), _minus(c, a))
    along = _dot(normal, d)
    inside, t = False, t_ab
    if along != 0.0:
        u, v = _dot(_cross(b, c), d) / along, _dot(_cross(c, a), d) / along
        inside = u >= 0.0 and v >= 0.0 and u + v <= 1.0
        t = _dot(normal, a) / along
    steep = abs(along) > 1e-2 * np.sqrt(_dot(normal, normal))
    if inside and edge > margin and steep and abs(t) > margin:
        return 2, t, t
    if inside or edge <= margin:
        return 1, t, min(_dot(a, d), _dot(b, d), _dot(c, d)) - margin
    return 0, t, t


@numba.njit
def float64_oracle(corners, origins, directions):
    """What a ray meets, in float64, with the doubtful cases known.

    Returns, for each ray, the nearest triangle that it meets farther than a margin from all edges
    (-1: none), its t, and the least t of any other triangle that it meets or passes within the
    margin. The margin is 1e-4 of the size of the numbers involved.
    """
    n = len(origins)
    sure, t_sure, t_other = np.full(n, -1), np.full(n, np.inf), np.full(n, np.inf)
    for r in range(n):
        o = (origins[r, 0], origins[r, 1], origins[r, 2])
        length = np.sqrt((directions[r] ** 2).sum())
        d = (directions[r, 0] / length, directions[r, 1] / length, directions[r, 2] / length)
        for k in range(len(corners)):
            a = _minus((corners[k, 0, 0], corners[k, 0, 1], corners[k, 0, 2]), o)
            b = _minus((corners[k, 1, 0], corners[k, 1, 1], corners[k, 1, 2]), o)
            c = _minus((corners[k, 2, 0], corners[k, 2, 1], corners[k, 2, 2]), o)
            margin = 1e-4 * max(_largest(a), _largest(b), _largest(c), _largest(o))
            flat = _across(a, d)
            radius = margin + 2.0 * max(_largest(_minus(b, a)), _largest(_minus(c, a)))
            if _dot(flat, flat) > radius * radius:
                continue
            kind, t, low = _meet(a, b, c, d, margin)
            if kind == 2 and t > 0.0 and t < t_sure[r]:
                t_other[r] = min(t_other[r], t_sure[r])
                sure[r], t_sure[r] = k, t
            elif kind == 2 and t > 0.0:
                t_other[r] = min(t_other[r], t)
            elif kind == 1 and max(_dot(a, d), _dot(b, d), _dot(c, d)) > -margin:
                t_other[r] = min(t_other[r], low)
    return sure, t_sure, t_other


def mismatches(triangles, origins, directions, t, which):
    """Rays whose nearest triangle is beyond doubt in float64, and how many of them differ.

    Parameters
    ----------
    t, which : (n,) arrays
        Distance found, and row of the triangle found, -1 for none.

    Returns
    -------
    differing, decided : int
    """
    corners = triangles.vertices[triangles.faces].astype(np.float64)
    sure, t_sure, t_other = float64_oracle(
        corners, origins.astype(np.float64), directions.astype(np.float64)
    )
    t_sure[sure < 0] = 1e30
    decided = (sure >= 0) & (t_sure * (1 + 1e-6) < t_other)
    empty = (sure < 0) & np.isinf(t_other)
    wrong = decided & (which != sure)
    found = np.where(np.isfinite(t), t, -1e30)
    wrong[decided] |= (np.abs(found - t_sure) > 1e-3 * (np.abs(origins).max() + t_sure))[decided]
    wrong |= empty & (which >= 0)
    return int(wrong.sum()), int((decided | empty).sum())


def icosphere(levels):
    """Closed mesh of 20 * 4^levels triangles around the origin."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=levels)
    return np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.int32)


def torus(n, m, wave=0.0):
    """Closed mesh of 2 n m triangles: a tube around a circle, radius 0.4 with a wave on it."""
    u, v = np.meshgrid(np.arange(n) / n * 2 * np.pi, np.arange(m) / m * 2 * np.pi, indexing="ij")
    r = 0.4 + wave * np.sin(7 * u) * np.cos(3 * v)
    x, y, z = (1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u), r * np.sin(v)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32), faces.astype(np.int32)
