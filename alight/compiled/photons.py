"""Photons of what walks aim at: traced once, the same way whatever the seed of the picture.

They start at the middle of a target, towards a point in the box of a mirror or a piece of glass,
and go on as the materials have it, until they meet a surface that scatters light. Where something
moves, each sees the scene at a time of its own, all its way.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from alight.accel.batch import closest_hits
from alight.bsdfs.dielectrics.dispersion import disperses
from alight.bsdfs.dispatch import sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.compiled.at_times import tables_at
from alight.compiled.program import Program
from alight.core.motion import inverse_rows, matrix_at, moved_along, point_at_rest
from alight.core.vec import Vec3, dot, normalize
from alight.lights.photons import BUCKETS, are_in_motion, bucket_of, key_of
from alight.lights.tables import INFO
from alight.lights.targets import BOX, SPHERE, target_at
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate, kernel
from lanewise.view import View

#: Photons that set out, and surfaces that they may meet.
PHOTONS, MOST_SURFACES = 1 << 15, 12

#: Cells along the longest edge of the box around nearly all of them: without this share at each
#: end, which may lie far away.
CELLS, OUTLIERS = 32, 0.05

#: Wavelength at which dispersive glass is evaluated, nanometres.
_GREEN = np.float32(550.0)

#: Photons on their way: origins and directions, (n, 3) float32; which light, (n,) uint32; when,
#: (n,) float32 in [0, 1).
_Flight = namedtuple("_Flight", "o d light time")


class Landed(NamedTuple):
    """Photons that have met a surface which scatters light, after a mirror or glass.

    Attributes
    ----------
    p : (n, 3) float32, metres
        Where.
    last : (n, 3) float32, metres
        The last mirror or piece of glass before.
    shape : (n,) uint32
        Row of that.
    light : (n,) uint32
        Row of the light.
    time : (n,) float32
        When, in [0, 1).
    """

    p: np.ndarray
    last: np.ndarray
    shape: np.ndarray
    light: np.ndarray
    time: np.ndarray


def with_photons(program: Program, tables: Any, center: np.ndarray, radius: float) -> Any:
    """The tables of a scene, with photons of what is aimed at.

    Parameters
    ----------
    program : Program
    tables : SceneTables or another one
        With the boxes of `alight.compiled.light_targets.targets`.
    center : (3,) float64, metres
    radius : float, metres
        Of a ball around the scene.
    """
    table = tables.lights.targets.array
    flight = _setting_out(program, tables, table, center, radius)
    if flight is None:
        return tables
    landed = _landed(program, tables, flight)
    if not len(landed.p):
        return tables
    low, high = np.quantile(landed.p.astype(np.float64), [OUTLIERS, 1.0 - OUTLIERS], axis=0)
    per_edge = np.float32(CELLS / max(float((high - low).max()), 1e-6 * radius, 1e-20))
    scene = _at(program, tables, landed.time)
    key = _twin(key_of, program)(scene, landed.light)
    bucket = _twin(bucket_of, program)(_columns(landed.p), key, per_edge)
    order = np.argsort(bucket, kind="stable")
    starts = np.searchsorted(bucket[order], np.arange(BUCKETS + 1))
    points = _as_kept(program, scene, landed)[order]
    parts = [table, [per_edge], starts, points.ravel()]
    targets = np.concatenate([np.asarray(part, np.float32) for part in parts])
    return tables._replace(lights=tables.lights._replace(targets=View(targets)))


def _as_kept(program: Program, scene: Any, landed: Landed) -> np.ndarray:
    """What photons remember: points, where something moves at rest and with their motions."""
    if not are_in_motion(program):
        return landed.last
    number = scene.motions.of_shape.array[landed.shape]
    points, moving = landed.last.copy(), number > 0
    some = _at(program, scene, landed.time[moving])
    matrix = _twin(matrix_at, program)(some.motions, number[moving] - 1, some.time)
    rows = _twin(inverse_rows, program)(matrix)
    points[moving] = _rows(point_at_rest(rows, _columns(points[moving])), len(some.time))
    return np.column_stack([points, number])


def _setting_out(
    program: Program, tables: Any, table: np.ndarray, center: np.ndarray, radius: float
) -> _Flight | None:
    """Rays from the targets, where there are any, and something that casts caustics."""
    count = tables.lights.info.size // INFO
    first = count * (1 + SPHERE) + 3
    boxes = table[first:].reshape(-1, BOX).astype(np.float64)
    if not len(boxes) or not count:
        return None
    random = np.random.default_rng(0)
    choice, _, box = random.random((3, PHOTONS))
    light = np.searchsorted(table[1 : count + 1], choice, side="right").astype(np.uint32)
    time = np.random.default_rng(2).random(PHOTONS, np.float32)
    scene = _at(program, tables, time)
    target = _twin(target_at, program)(scene, light)
    c, far = _rows(target.c, PHOTONS), np.broadcast_to(target.far, PHOTONS)[:, None]
    size = np.broadcast_to(target.radius, PHOTONS).astype(np.float64)[:, None]
    chosen = boxes[(box * len(boxes)).astype(int)]
    low, high, motion = chosen[:, :3], chosen[:, 3:6], chosen[:, 6].astype(np.uint32)
    there = low + random.random((PHOTONS, 3)) * (high - low)
    there = _rows(_twin(moved_along, program)(scene, motion, _columns(there)), PHOTONS)
    to = np.where(far, -c, there - c)
    distance = np.linalg.norm(to, axis=1, keepdims=True)
    d = to / np.maximum(distance, 1e-30)
    behind = radius + np.linalg.norm(there - center, axis=1, keepdims=True)
    o = np.where(far, there - behind * d, c + 1.01 * size * d)
    # What is in the lamp, and lights that are no targets.
    fine = ((size > 0.0) & (far | (distance > size)))[:, 0]
    o, d = o[fine].astype(np.float32), d[fine].astype(np.float32)
    return _Flight(o, d, light[fine], time[fine])


def _landed(program: Program, tables: Any, flight: _Flight) -> Landed:
    """Follow them."""
    random = np.random.default_rng(1)
    o, d, light, time = flight
    last, turned, found = o, np.zeros(len(o), bool), []
    shape = np.zeros(len(o), np.uint32)
    for _ in range(MOST_SURFACES):
        n = len(o)
        end, scene = np.full(n, np.inf, np.float32), _at(program, tables, time)
        hit = closest_hits(program, scene, _columns(o), _columns(d), end)
        met = np.isfinite(hit.t)
        surface = _twin(make_surface, program)(scene, hit, _columns(o), _columns(d), met)
        if disperses(program):
            surface = surface._replace(wavelength=np.full(n, _GREEN))
        u, x, y = random.random((3, n)).astype(np.float32)
        flags, pdf, w, origin = _twin(_scattered, program)(
            scene, surface, _columns(d), u, (x, y), met
        )
        flags, p = np.broadcast_to(flags, n), _rows(surface.p, n).astype(np.float32)
        going = met & (np.broadcast_to(pdf, n) > 0.0)
        sharp, hole = (flags & DELTA) != 0, (flags & NULL) != 0
        landed = going & ~sharp & ~hole & turned
        columns = Landed(p, last, shape, light, time)
        found.append(Landed(*(column[landed] for column in columns)))
        bent = going & sharp & ~hole
        last, turned = np.where(bent[:, None], p, last), turned | bent
        shape = np.where(bent, hit.shape, shape)
        on = going & (sharp | hole)
        o, d = _rows(origin, n)[on].astype(np.float32), _rows(w, n)[on].astype(np.float32)
        last, turned, shape, light, time = last[on], turned[on], shape[on], light[on], time[on]
        if not len(o):
            break
    return Landed(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


@kernel
def _scattered(scene, surface, d, u, u2, active):
    """(flags, pdf, direction, origin) of the ray that goes on."""
    back = Vec3(-dot(d, surface.s), -dot(d, surface.t), -dot(d, surface.ns))
    sample = sample_bsdf(scene, surface, back, u, u2, active)
    w = normalize(sample.wi.x * surface.s + sample.wi.y * surface.t + sample.wi.z * surface.ns)
    return sample.flags, sample.pdf, w, spawn_origin(surface.p, surface.error, surface.ng, w)


def _at(program: Program, tables: Any, times: np.ndarray) -> Any:
    """A scene at these times."""
    return tables_at(tables, times) if program.motion else tables


def _twin(text: Any, program: Program) -> Any:
    return np.errstate(all="ignore")(instantiate(text, program, compiled=False))


def _columns(rows: np.ndarray) -> Vec3:
    return Vec3(*np.ascontiguousarray(rows.T))


def _rows(v: Vec3, n: int) -> np.ndarray:
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)], axis=1)
