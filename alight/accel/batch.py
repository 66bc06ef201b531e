"""Many rays at once, from arrays to arrays: against a scene, or one triangle mesh."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any

import numpy as np

from alight.accel.build import build_bvh
from alight.accel.forest import box_of
from alight.accel.layout import TREE, Bvh
from alight.accel.lists import Accelerator
from alight.accel.query import intersect_closest, is_occluded
from alight.core.vec import Vec3
from alight.shapes.hit import Hit
from lanewise.jit import instantiate, kernel, specialised
from lanewise.simd import (
    LANES,
    bits_float,
    gather,
    lane_index,
    lanes,
    minimum_u32,
    store_lanes,
    where,
)
from lanewise.view import View

#: Rays that a thread takes at a time, and to which their number is rounded up: any packet's width
#: divides both.
_CHUNK, _PADDING = 16384, 16

#: What `query` needs to know of a scene and a program.
_Scene = namedtuple("_Scene", "accel shapes")
_Shapes = namedtuple("_Shapes", "data")
_Program = namedtuple("_Program", "accel motion")

#: The same of a scene in motion, without the times and with them.
_Moving = namedtuple("_Moving", "accel shapes motions")
_AtTimes = namedtuple("_AtTimes", (*_Moving._fields, "time"))


@kernel(strict=True)
def packet(rays, begin, end):
    """Rays begin, begin + 1, ...: (origins, directions, largest t, which there are)."""
    origins, directions, t_max, _ = rays
    lane = begin + lane_index()
    i = minimum_u32(lane, end - 1)
    o = Vec3(gather(origins, 3 * i), gather(origins, 3 * i + 1), gather(origins, 3 * i + 2))
    d = Vec3(
        gather(directions, 3 * i), gather(directions, 3 * i + 1), gather(directions, 3 * i + 2)
    )
    return o, d, gather(t_max, i), lane < end


@specialised
def scene_at(program):
    """``scene_at(scene, rays, begin, end)``: as the rays begin, begin + 1, ... meet it."""
    if not program.motion:

        @kernel(strict=True)
        def at_rest(scene, rays, begin, end):
            return scene

        return at_rest

    @kernel(strict=True)
    def at_their_times(scene, rays, begin, end):
        times = gather(rays[3], minimum_u32(begin + lane_index(), end - 1))
        return _AtTimes(scene.accel, scene.shapes, scene.motions, times)

    return at_their_times


@kernel(strict=True)
def hits_range(scene, rays, results, begin, end):
    """Rays begin to end; results: columns of a `Hit`, integers as bits."""
    n = results.size // 5
    for first in range(begin, end, LANES):
        o, d, t_max, there = packet(rays, first, end)
        hit = intersect_closest(scene_at(scene, rays, first, end), o, d, t_max, there)
        store_lanes(results, first, hit.t)
        store_lanes(results, n + first, hit.u)
        store_lanes(results, 2 * n + first, hit.v)
        store_lanes(results, 3 * n + first, bits_float(hit.shape))
        store_lanes(results, 4 * n + first, bits_float(hit.prim))


@kernel(strict=True)
def occluded_range(scene, rays, results, begin, end):
    """Rays begin to end; results: 1 where something is met."""
    for first in range(begin, end, LANES):
        o, d, t_max, there = packet(rays, first, end)
        blocked = is_occluded(scene, o, d, t_max, there)
        store_lanes(results, first, where(blocked, lanes(1.0), lanes(0.0)))


@lru_cache(maxsize=2)
def _compiled(text: Callable) -> Callable:
    return instantiate(text, _Program((TREE,), ()))


def build(
    vertices: np.ndarray, faces: np.ndarray, *, method: str = "sah", threads: int = 1
) -> tuple[Bvh, dict]:
    """Hierarchy over a triangle mesh; see `build_bvh`."""
    vertices = np.ascontiguousarray(vertices, np.float32)
    faces = np.ascontiguousarray(faces, np.int32)
    bvh, stats = build_bvh(vertices, faces, method=method, threads=threads)
    ids = np.zeros((len(faces), 2), np.uint32)
    ids[:, 1] = np.arange(len(faces))
    return bvh._replace(ids=View(ids)), stats


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
    t, u, v, _, prim = _run(hits_range, bvh, origins, directions, t_max, 5, threads)
    return t, np.where(np.isfinite(t), prim.view(np.int32), -1), u, v


def is_occluded_batch(
    bvh: Bvh,
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: np.ndarray | None = None,
    *,
    threads: int = 1,
) -> np.ndarray:
    """(n,) bool: is anything met at 0 < t <= t_max? Parameters as of `intersect_batch`."""
    return _run(occluded_range, bvh, origins, directions, t_max, 1, threads)[0] > 0


def closest_hits(program: Any, scene: Any, o: Vec3, d: Vec3, t_max: np.ndarray) -> Hit:
    """Closest hits in a scene.

    Parameters
    ----------
    program, scene
        Of a `CompiledScene`: its program and its tables; where something moves, those of
        `alight.compiled.at_times.tables_at`, with a time for each ray.
    o, d : Vec3 of (n,) float32
        Metres; t is in units of the direction's length.
    t_max : (n,) float32

    Returns
    -------
    Hit of (n,)
        In machine code's own bits; t is infinite for a miss.
    """
    n, times = len(t_max), np.zeros(0)
    if program.motion:
        times, scene = scene.time, _Moving(scene.accel, scene.shapes, scene.motions)
    else:
        scene = _Scene(scene.accel, scene.shapes)
    rays = tuple(
        View(np.ascontiguousarray(a, np.float32))
        for a in (np.stack([o.x, o.y, o.z], 1), np.stack([d.x, d.y, d.z], 1), t_max, times)
    )
    results = np.zeros((5, -(-n // _PADDING) * _PADDING), np.float32)
    instantiate(hits_range, _asked(program))(scene, rays, View(results), 0, n)
    t, u, v, shape, prim = results[:, :n]
    return Hit(t, u, v, shape.view(np.uint32), prim.view(np.uint32))


def _asked(program: Any) -> Any:
    """What a search asks of a program, so that scenes of like shapes share its machine code."""
    # A user's own shape may ask for anything.
    return program if program.registered else _Program(program.accel, program.motion)


def _run(text, bvh, origins, directions, t_max, columns, threads) -> np.ndarray:
    """What a kernel writes for the rays, (columns, n) float32."""
    function, n = _compiled(text), len(origins)
    if t_max is None:
        t_max = np.full(n, np.inf, np.float32)
    rays = tuple(
        View(np.ascontiguousarray(a, np.float32)) for a in (origins, directions, t_max, np.zeros(0))
    )
    results = np.zeros((columns, -(-n // _PADDING) * _PADDING), np.float32)
    out, empty = View(results), View(np.zeros(0, np.float32))
    no_ids = View(np.zeros(0, np.uint32))
    accel = Accelerator(
        shapes=no_ids,
        triangles=empty,
        triangle_ids=no_ids,
        pairs=empty,
        pair_ids=no_ids,
        tree=bvh,
        box=View(box_of(bvh)),
    )
    scene = _Scene(accel, _Shapes(empty))

    def chunk(begin: int) -> None:
        function(scene, rays, out, begin, min(begin + _CHUNK, n))

    if threads == 1:
        function(scene, rays, out, 0, n)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(chunk, range(0, n, _CHUNK)))
    return results[:, :n]
