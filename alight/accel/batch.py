"""Many rays against one triangle mesh, from arrays to arrays: for tests, benchmarks and tools."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np

from alight.accel.build import build_bvh
from alight.accel.layout import Bvh
from alight.accel.node_test import is_traceable
from alight.accel.query import trace_tree
from alight.accel.rays import NONE
from alight.core.constants import INFINITY
from alight.core.vec import Vec3
from lanewise.jit import instantiate, kernel
from lanewise.simd import (
    LANES,
    as_float,
    as_int,
    as_uint,
    bits_float,
    gather,
    lane_index,
    mask_bits,
    maximum,
    minimum_u32,
    where,
)
from lanewise.view import View

_CHUNK = 16384


@kernel(strict=True)
def trace_rays(bvh, origins, directions, t_max, begin, end, nearest):
    """The `Hits` of rays begin, begin + 1, ..., as many as there are lanes."""
    ray = begin + lane_index()
    i = minimum_u32(ray, end - 1)
    o = Vec3(gather(origins, 3 * i), gather(origins, 3 * i + 1), gather(origins, 3 * i + 2))
    d = Vec3(
        gather(directions, 3 * i), gather(directions, 3 * i + 1), gather(directions, 3 * i + 2)
    )
    t = gather(t_max, i)
    bits = mask_bits((ray < end) & is_traceable(o, d, t))
    # Rays that meet nothing for lack of a direction keep an end that is not negative.
    return trace_tree(bvh, bvh.blocks, o, d, maximum(t, 0.0), bits, nearest, None)


@kernel(strict=True)
def intersect_range(bvh, origins, directions, t_max, results, begin, end):
    """Rays begin to end; results: 4 floats a ray: t, index (bits), u, v."""
    for first in range(begin, end, LANES):
        hits = trace_rays(bvh, origins, directions, t_max, first, end, True)
        for j in range(min(LANES, end - first)):
            at, found = 4 * (first + j), hits.index[j] != NONE
            results[at] = where(found, hits.t[j], as_float(0) + INFINITY)
            results[at + 1] = bits_float(as_uint(where(found, as_int(hits.index[j]), -1)))
            results[at + 2], results[at + 3] = hits.u[j], hits.v[j]


@kernel(strict=True)
def occluded_range(bvh, origins, directions, t_max, results, begin, end):
    """Rays begin to end; results: 1 where something is met."""
    for first in range(begin, end, LANES):
        hits = trace_rays(bvh, origins, directions, t_max, first, end, False)
        for j in range(min(LANES, end - first)):
            results[first + j] = as_float(where(hits.t[j] < 0.0, 1, 0))


@lru_cache(maxsize=2)
def _compiled(text: Callable) -> Callable:
    return instantiate(text)


def build(
    vertices: np.ndarray, faces: np.ndarray, *, method: str = "sah", threads: int = 1
) -> tuple[Bvh, dict]:
    """Hierarchy over a triangle mesh; see `build_bvh`."""
    vertices = np.ascontiguousarray(vertices, np.float32)
    faces = np.ascontiguousarray(faces, np.int32)
    return build_bvh(vertices, faces, method=method, threads=threads)


def intersect_batch(
    bvh: Bvh,
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: np.ndarray | None = None,
    *,
    threads: int = 1,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Closest hits.

    Parameters
    ----------
    origins, directions : (n, 3) float32
        Metres; t is in units of the direction's length.
    t_max : (n,) float32, optional
        Largest t that counts.
    threads : int

    Returns
    -------
    t : (n,) float32
        Infinity for a miss.
    prim : (n,) int32
        Triangle, -1 for a miss.
    u, v : (n,) float32
        Barycentrics b1, b2.
    """
    results = np.zeros((len(origins), 4), np.float32)
    _run(intersect_range, bvh, origins, directions, t_max, results, threads)
    return (results[:, 0], results[:, 1].view(np.int32), results[:, 2], results[:, 3])


def is_occluded_batch(
    bvh: Bvh,
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: np.ndarray | None = None,
    *,
    threads: int = 1,
) -> np.ndarray:
    """(n,) bool: is anything met at 0 < t <= t_max? Parameters as of `intersect_batch`."""
    results = np.zeros(len(origins), np.float32)
    _run(occluded_range, bvh, origins, directions, t_max, results, threads)
    return results > 0


def _run(text, bvh, origins, directions, t_max, results, threads):
    function, n = _compiled(text), len(origins)
    if t_max is None:
        t_max = np.full(n, np.inf, np.float32)
    rays = [View(np.ascontiguousarray(a, np.float32)) for a in (origins, directions, t_max)]
    out = View(results)

    def chunk(begin: int) -> None:
        function(bvh, *rays, out, begin, min(begin + _CHUNK, n))

    if threads == 1:
        function(bvh, *rays, out, 0, n)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(chunk, range(0, n, _CHUNK)))
