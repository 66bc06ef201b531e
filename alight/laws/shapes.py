"""Laws of shapes: hits, normals and coordinates fit each other, areas and densities the surface.

Each law is a function of an example and raises `BrokenLawError`. All of them look at it under
`bodies.PLACEMENTS`, which turn, stretch, slant and mirror it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from alight.accel import intersect_closest
from alight.core.constants import INFINITY
from alight.core.spec import Shape
from alight.laws.bodies import (
    HIT,
    Body,
    N,
    body_of,
    margin_of,
    placed_everywhere,
    rows_of,
    vec_of,
)
from alight.laws.distances import distances_are_in_lengths_of_the_direction
from alight.laws.framing import an_automatic_camera_sees_all_of_it
from alight.laws.report import demand, demand_close
from alight.laws.statistics import LARGEST_Z, ROUNDING, UNIT, unit_vectors, z_of_mean
from alight.lights.area_radiance import coordinates
from alight.lights.shining import sample_area, sample_shape, shape_pdf
from alight.shapes.derivatives import uv_derivatives
from alight.shapes.hit import Hit, ShapeHit, spawn_origin
from alight.shapes.model import SHAPES
from alight.shapes.surfaces import make_surface, surface_from_rest
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, lanes_mask, load_lanes, store_lanes, to_float, where
from lanewise.vec3 import Vec3
from lanewise.view import View

#: Surfaces that one line crosses at most, of those that are counted.
MOST_CROSSINGS = 8

#: Error of a unit vector: half of its square's (three operations), a root, a quotient, a product;
#: of a frame: two of them, orthogonal up to three operations more, and a cross product.
UNIT_VECTOR, FRAME = 5 * UNIT, 16 * UNIT
#: Step between neighbours, in parts of the radius; and least cosine of the rays to them, which are
#: then at most so many steps apart.
STEP, LEAST_COSINE, FARTHEST = 5e-3, 0.3, 8.0


# ---------------------------------------------------------------- hits


@placed_everywhere
def hits_lie_on_their_rays_and_in_the_box(body: Body) -> None:
    """Hits lie on their rays, within the box, with unit normals and a right-handed frame."""
    o, d = body.lines(1)
    hit, surface = body.hit(o, d, np.ones(N, bool))
    # What is infinite is met anywhere.
    found = hit.t < 6.0 * body.radius
    demand(found.any(), "no line through its box meets it")
    p = rows_of(surface.p, N)[:, found]
    along = (o + np.where(found, hit.t, 0.0) * d)[:, found]
    margin = margin_of(body, o)
    off = np.linalg.norm(np.cross(p - o[:, found], d[:, found], axis=0), axis=0)
    demand_close(off, 0.0, "metres from the ray", atol=margin)
    facing = np.abs(np.sum(rows_of(surface.ng, N)[:, found] * d[:, found], axis=0))
    demand_close(
        np.abs(np.sum((p - along) * d[:, found], axis=0)) * facing, 0.0,
        "metres from the hit, along the normal", atol=margin,
    )  # fmt: skip
    if body.spec.finite:
        low, high = body.low[:, None] - margin, body.high[:, None] + margin
        demand((p >= low) & (p <= high), "a hit lies outside of the box")
    ng, ns, s, t = (rows_of(v, N)[:, found] for v in (surface.ng, surface.ns, surface.s, surface.t))
    for name, v in (("ng", ng), ("ns", ns), ("s", s)):
        demand_close(np.linalg.norm(v, axis=0), 1.0, f"length of {name}", atol=UNIT_VECTOR)
    demand_close(np.cross(ns, s, axis=0), t, "ns x s against t", atol=FRAME)
    demand_close(np.cross(s, t, axis=0), ns, "s x t against ns", atol=FRAME)


def _neighbours(body: Body, seed: int) -> tuple[np.ndarray, Any, list[tuple[Any, Any]], np.ndarray]:
    """Hits of parallel lines, up to 4 steps to both sides of one.

    Returns
    -------
    o : (3, n)
    surface
        In the middle.
    pairs : list of pairs of surfaces
        1, 2 and 4 steps to both sides.
    found : (n,) bool
        Where all of them belong together.
    """
    o, d = body.lines(seed)
    first, here = body.hit(o, d, np.ones(N, bool))
    size = STEP * body.radius + 0.01 * STEP * np.abs(body.center).max()
    step = size * np.cross(d, unit_vectors(N, 5), axis=0)
    facing = np.abs(np.sum(rows_of(here.ng, N) * d, axis=0))
    pairs, found = [], (first.t < 6.0 * body.radius) & (facing > LEAST_COSINE)
    for steps in (1, 2, 4):
        pair = []
        for side in (steps, -steps):
            beside = (o + side * step).astype(np.float32)
            hit, surface = body.hit(beside, d, found)
            away = np.linalg.norm(rows_of(surface.p, N) - rows_of(here.p, N), axis=0)
            # Neither another part of the surface nor the other side of a seam.
            found = found & (hit.shape == first.shape) & (hit.prim == first.prim)
            found = found & np.isfinite(hit.t) & (away < FARTHEST * steps * size)
            for k in "uv":
                found = found & (np.abs(getattr(surface, k) - getattr(here, k)) < 0.1)
            pair.append(surface)
        pairs.append((pair[0], pair[1]))
    return o, here, pairs, found


@placed_everywhere
def neighbours_differ_as_the_derivatives_say(body: Body) -> None:
    """Hits next to each other differ along the surface, by dp/du du + dp/dv dv.

    What is left of that is of the third order in the distance of two hits, so an eighth at half of
    it. Were a derivative wrong, it would be half: more than a quarter is not allowed, but for what
    rounding adds to two hits.
    """
    o, here, pairs, found = _neighbours(body, 2)
    if not found.any():
        return
    ng, (along, across) = rows_of(here.ng, N), body.run(uv_derivatives, body.scene, here)
    beside, wrong = [], []
    for a, b in pairs:
        du, dv = (np.broadcast_to(getattr(a, k) - getattr(b, k), N).astype(float) for k in "uv")
        moved = rows_of(a.p, N) - rows_of(b.p, N)
        beside.append(np.abs(np.sum(ng * moved, axis=0)))
        said = rows_of(along, N) * du + rows_of(across, N) * dv
        wrong.append(np.linalg.norm(said - moved, axis=0))
    for left, what in ((beside, "beside the tangent plane"), (wrong, "off dp/du du + dp/dv dv")):
        # Orders that cancel at one distance do not at the other.
        bound = np.maximum(left[1] / 4.0, left[2] / 16.0) + 2.0 * margin_of(body, o)
        demand_close(left[0][found], 0.0, f"metres of neighbours {what}", atol=bound[found])


def crossings(body: Body, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """How often random lines cross the surface, and whether they go in and out by turns."""
    o, d = body.lines(seed)
    active, count, in_turns = np.ones(N, bool), np.zeros(N), np.ones(N, bool)
    side = np.zeros(N)
    for _ in range(MOST_CROSSINGS):
        hit, surface = body.hit(o, d, active)
        active = active & np.isfinite(hit.t)
        if not active.any():
            break
        now = np.sign(np.sum(rows_of(surface.ng, N) * d, axis=0))
        in_turns &= ~active | (now != side)
        side, count = np.where(active, now, side), count + active
        start = body.run(spawn_origin, surface.p, surface.error, surface.ng, vec_of(d))
        o = np.where(active, rows_of(start, N), o).astype(np.float32)
    return count, in_turns


@placed_everywhere
def area_is_that_of_crofton(body: Body) -> None:
    """Random lines cross it as often as its area says (Crofton's formula)."""
    if not body.spec.finite:
        return
    count, in_turns = crossings(body, 3)
    area = sum(float(row.areas.sum()) for row in body.shapes.rows)
    expected = area / (2.0 * np.pi * body.radius**2)
    # What is met from outside only is met half as often.
    expected *= 0.5 if SHAPES[body.spec.type_name()].is_many else 1.0
    z = z_of_mean(count, expected, ROUNDING * expected)
    demand(abs(z) < LARGEST_Z, f"{count.mean():.5g} crossings a line, by the area {expected:.5g}")
    if body.spec.closed:
        even = (count % 2 == 0) & in_turns
        demand(even, f"{(~even).sum()} of {N} lines do not come out again")


# ---------------------------------------------------------------- light


def _points_around(body: Body) -> Iterator[np.ndarray]:
    """Where it is looked at from: near it, farther away."""
    for k, distance in enumerate((1.6, 5.0)):
        yield body.center + distance * body.radius * unit_vectors(1, 11 + k)[:, 0]


def _sampled(body: Body, point: np.ndarray, seed: int) -> tuple[Any, np.ndarray, tuple]:
    rng = np.random.default_rng(seed)
    u, u2 = rng.random(N, np.float32), tuple(rng.random((2, N), np.float32))
    p = np.repeat(point.astype(np.float32)[:, None], N, axis=1)
    shape = rng.integers(0, len(body.shapes.rows), N).astype(np.uint32)
    lights, cdf = body.scene.lights, body.scene.lights.cdf
    # Rows of the lights are those of the shapes.
    start = lights.info.array.reshape(-1, 4)[shape, 3]
    sample = body.run(sample_shape, body.scene.shapes, cdf, start, shape, vec_of(p), u, u2)
    return sample, p, (shape, start, u, u2)


@placed_everywhere
def densities_give_the_solid_angle(body: Body) -> None:
    """Visible samples over their density fill the same directions as those that meet it."""
    if not body.spec.finite:
        return
    for point in _points_around(body):
        sample, p, (shape, *_) = _sampled(body, point, 21)
        wi, pdf = rows_of(sample.wi, N), np.broadcast_to(sample.pdf, N).astype(float)
        hit, _ = body.hit(p, wi.astype(np.float32), pdf > 0.0)
        t, distance = np.asarray(hit.t, float), np.broadcast_to(sample.distance, N)
        near = np.abs(t - distance) < 2e-3 * distance
        seen = (pdf > 0.0) & near & (hit.shape == shape)
        weight = np.where(seen, len(body.shapes.rows) / np.where(pdf > 0.0, pdf, 1.0), 0.0)
        # All directions within a cone around it.
        axis = (body.center - point) / np.linalg.norm(body.center - point)
        edge = np.sqrt(1.0 - (body.radius / np.linalg.norm(body.center - point)) ** 2)
        d = _in_cone(axis, edge, 22)
        met, _ = body.hit(p, d, np.ones(N, bool))
        cone = np.where(np.isfinite(met.t), 2.0 * np.pi * (1.0 - edge), 0.0)
        for name, a, b in (("solid angle", 1.0, 1.0), *((c, wi[i], d[i]) for i, c in _AXES)):
            x, y = weight * a, cone * b
            error = np.sqrt(x.var() / N + y.var() / N) + ROUNDING * cone.mean()
            z = (x.mean() - y.mean()) / error
            demand(abs(z) < LARGEST_Z, f"{name}: {x.mean():.5g} by samples, {y.mean():.5g} by rays")


_AXES = ((0, "mean of x"), (1, "mean of y"), (2, "mean of z"))


def _in_cone(axis: np.ndarray, edge: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(edge, 1.0, N), rng.uniform(0.0, 2.0 * np.pi, N)
    s = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.6 else [0.0, 1.0, 0.0])
    s /= np.linalg.norm(s)
    r = np.sqrt(1.0 - z * z)
    d = np.outer(s, r * np.cos(phi)) + np.outer(np.cross(axis, s), r * np.sin(phi))
    return np.ascontiguousarray(d + np.outer(axis, z), np.float32)


def _curvature(body: Body, surface: Any, o: np.ndarray, active: np.ndarray) -> float:
    """About the largest curvature, rad per m, where rays from o (3, n) meet a surface."""
    d = rows_of(surface.p, N) - o
    d += 0.2 * STEP * np.cross(d, unit_vectors(N, 5), axis=0)
    _, beside = body.hit(o, d.astype(np.float32), active)
    moved, turned = (
        np.linalg.norm(rows_of(getattr(beside, k), N) - rows_of(getattr(surface, k), N), axis=0)
        for k in ("p", "ng")
    )
    # Not beyond an edge, nor another part of the surface.
    near = active & (moved > 0.0) & (moved < STEP * np.linalg.norm(d, axis=0)) & (turned < 0.5)
    return float(np.max(turned / np.where(near, moved, 1.0), where=near, initial=0.0))


@placed_everywhere
def samples_are_hits_with_their_density(body: Body) -> None:
    """A sample is the hit that it says it is, and has there the density that it came with.

    Points that err turn the normal by the curvature, and a density per solid angle is divided by
    the cosine.
    """
    if not body.spec.finite:
        return
    for point in _points_around(body):
        sample, p, (shape, start, u, u2) = _sampled(body, point, 23)
        pdf = np.broadcast_to(sample.pdf, N)
        distance = np.broadcast_to(sample.distance, N)
        cosine = np.broadcast_to(sample.cosine, N)
        ok = (pdf > 0.0) & np.isfinite(pdf) & (np.abs(cosine) > 0.05)
        q = vec_of(p) + distance * sample.wi
        x, y, prim = body.run(coordinates, body.scene, shape, start, q, u, u2)
        prim = np.broadcast_to(prim, N).astype(np.uint32)
        x, y = np.broadcast_to(x, N), np.broadcast_to(y, N)
        hit = Hit(distance, x, y, shape, prim)
        surface = body.run(make_surface, body.scene, hit, vec_of(p), sample.wi, ok)
        margin = HIT * (np.linalg.norm(point) + distance.max(where=ok, initial=0.0))
        off = np.linalg.norm(rows_of(surface.p, N) - rows_of(q, N), axis=0)
        demand_close(off[ok], 0.0, "metres between a sample and its hit", atol=margin)
        turned = UNIT_VECTOR + margin * _curvature(
            body, surface, p, ok & (np.abs(cosine) > LEAST_COSINE)
        )
        facing = -np.sum(rows_of(surface.ng, N) * rows_of(sample.wi, N), axis=0)
        demand_close(facing[ok], cosine[ok], "cosine of a sample", atol=turned)
        density = body.run(
            shape_pdf, body.scene.shapes, body.scene.lights.cdf, start, shape, vec_of(p),
            ShapeHit(prim, sample.wi, distance, cosine),
        )  # fmt: skip
        again = np.broadcast_to(density, N)
        atol = pdf[ok] * (HIT + turned / np.abs(cosine[ok]))
        demand_close(again[ok], pdf[ok], "pdf against that of the sample", atol=atol)


@placed_everywhere
def points_by_area_are_the_hits_that_they_name(body: Body) -> None:
    """A point chosen by area has the coordinates of a ray's hit there; densities give the area."""
    if not body.spec.finite or any(
        SHAPES[row.kind].sample_area is None for row in body.shapes.rows
    ):
        return
    _, _, (shape, start, u, u2) = _sampled(body, body.center, 24)
    s = body.run(sample_area, body.scene.shapes, body.scene.lights.cdf, start, shape, u, u2)
    area = sum(float(row.areas.sum()) for row in body.shapes.rows)
    pdf = np.broadcast_to(s.pdf, N).astype(float)
    # A shape may draw points that lie within it: they have no density.
    covered = np.divide(len(body.shapes.rows), pdf, out=np.zeros(N), where=pdf > 0.0)
    z = z_of_mean(covered, area, ROUNDING * area)
    demand(abs(z) < LARGEST_Z, f"densities by area cover {covered.mean():.5g} m^2 of {area:.5g}")
    x, y = np.broadcast_to(s.u, N), np.broadcast_to(s.v, N)
    named = Hit(np.zeros(N, np.float32), x, y, shape, np.broadcast_to(s.prim, N).astype(np.uint32))
    everywhere, one = np.ones(N, bool), Vec3(*np.ones((3, N), np.float32))
    there = body.run(surface_from_rest, body.scene, named, s.p, one, everywhere)
    # A ray from just outside meets the same point, unless another part is in its way.
    n = rows_of(there.ng, N)
    o = rows_of(s.p, N) + STEP * body.radius * n
    hit, here = body.hit(o.astype(np.float32), -n.astype(np.float32), everywhere)
    same = (hit.shape == shape) & (np.abs(hit.t / (STEP * body.radius) - 1.0) < 0.1)
    demand(same.mean() > 0.5, "rays do not meet the points that were chosen")
    for name in "uv":
        off = np.abs(getattr(here, name) - getattr(there, name))[same]
        # At a seam 0 and 1 are the same; at a pole an angle is anything.
        close = np.minimum(off, 1.0 - off) < 1e-3
        demand(close.mean() > 0.99, f"{name} of a point is not that of the hit there")


# ---------------------------------------------------------------- machine code

RESULTS = 12


@kernel
def look_all(scene, o, d, out, n):
    """Hits and surfaces of n rays."""
    for i in range(0, n, LANES):
        origin = Vec3(load_lanes(o, i), load_lanes(o, i + n), load_lanes(o, i + 2 * n))
        direction = Vec3(load_lanes(d, i), load_lanes(d, i + n), load_lanes(d, i + 2 * n))
        hit = intersect_closest(scene, origin, direction, lanes(INFINITY), lanes_mask(True))
        found = hit.t < INFINITY
        safe = Hit(where(found, hit.t, 1.0), hit.u, hit.v, hit.shape, hit.prim)
        g = make_surface(scene, safe, origin, direction, found)
        for_misses = where(found, 1.0, 0.0)
        store_lanes(out, i, where(found, hit.t, -1.0))
        store_lanes(out, i + n, for_misses * g.p.x)
        store_lanes(out, i + 2 * n, for_misses * g.p.y)
        store_lanes(out, i + 3 * n, for_misses * g.p.z)
        store_lanes(out, i + 4 * n, for_misses * g.ng.x)
        store_lanes(out, i + 5 * n, for_misses * g.ng.y)
        store_lanes(out, i + 6 * n, for_misses * g.ng.z)
        store_lanes(out, i + 7 * n, for_misses * g.s.x)
        store_lanes(out, i + 8 * n, for_misses * g.s.y)
        store_lanes(out, i + 9 * n, for_misses * g.u)
        store_lanes(out, i + 10 * n, for_misses * g.v)
        store_lanes(out, i + 11 * n, where(found, to_float(hit.shape), -1.0))


def compiled_surfaces_are_the_twins(spec: Shape) -> None:
    """Machine code finds the hits and surfaces of the Python text."""
    demand_same_surfaces(body_of(spec, "turned"))


def demand_same_surfaces(body: Body) -> None:
    """Compare what machine code and the Python text see along the same lines."""
    n = 2048
    o, d = (np.ascontiguousarray(v[:, :n]) for v in body.lines(7))
    found = []
    for compiled in (True, False):
        out = View(np.zeros((RESULTS, n), np.float32))
        run = instantiate(look_all, body.program, compiled=compiled, lanes=n)
        with np.errstate(all="ignore"):
            run(body.scene, View(o), View(d), out, n)
        found.append(out.shaped)
    same = (found[0][0] < 0.0) == (found[1][0] < 0.0)
    demand(same.mean() > 0.999, "machine code hits and misses otherwise")
    a, b = (np.where(np.isnan(x), 0.0, x)[:, same] for x in found)
    close = np.isclose(a, b, rtol=1e-3, atol=1e-4 * max(body.radius, 1e-3))
    demand(close.mean() > 0.998, f"{100 * (1 - close.mean()):.2g} % of the numbers differ")


LAWS = (
    hits_lie_on_their_rays_and_in_the_box,
    distances_are_in_lengths_of_the_direction,
    an_automatic_camera_sees_all_of_it,
    neighbours_differ_as_the_derivatives_say,
    area_is_that_of_crofton,
    densities_give_the_solid_angle,
    samples_are_hits_with_their_density,
    points_by_area_are_the_hits_that_they_name,
)
COMPILED_LAWS = (compiled_surfaces_are_the_twins,)
