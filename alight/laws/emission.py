"""Laws of emitted light: rays that leave a light carry the light that it sheds elsewhere.

Rays of `sample_emission` are held against the declared power, against their own densities, and
against light sampling: what arrives on a small disk must be the same by both.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from alight.accel import intersect_closest
from alight.cameras import MODELS as CAMERAS
from alight.compiled.scene import CompiledScene, compile_scene
from alight.compiled.shapes import compile_shapes
from alight.core.frame import frame_from_normal, to_world
from alight.core.spec import Light, Shape
from alight.core.vec import Vec3, luminance
from alight.laws.bodies import PLACEMENTS, nearest_hits
from alight.laws.lights import NARROW, described, mean_radiance, run, strategy
from alight.laws.materials import stacked
from alight.laws.remembered import remembered
from alight.laws.report import BrokenLawError, demand, demand_close
from alight.laws.statistics import (
    LARGEST_Z,
    ROUNDING,
    SIDES,
    SIGNIFICANCE,
    chi_square,
    length_error,
    sphere_cells,
    z_of_mean,
)
from alight.lights.emission.sampling import emission_direction_pdf, sample_emission
from alight.lights.model import LIGHTS
from alight.lights.sampling import sample_light
from alight.lights.tables import MIDDLE, RADIUS
from alight.scene import Node, Scene, flatten
from alight.shapes.model import SHAPES
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, load_lanes, store_lanes
from lanewise.view import View

#: Rays, and points of receivers; receivers of a light, half as many of each placed shape.
N, RECEIVERS = 1 << 16, 6

#: Fewer rays on a receiver do not know their own error.
FEWEST = 24


class Rays(NamedTuple):
    """Emitted rays as arrays: vectors (3, N), the rest (N,)."""

    scene: CompiledScene
    p: np.ndarray
    n: np.ndarray
    o: np.ndarray
    d: np.ndarray
    flux: np.ndarray
    light: np.ndarray
    pdf_position: np.ndarray
    pdf_direction: np.ndarray
    delta_position: np.ndarray
    delta_direction: np.ndarray


def compiled(scene: Scene) -> CompiledScene:
    """A scene whose lights emit."""
    return compile_scene(flatten(scene), structure="list", emits=True)


def _vec(v: Any) -> Vec3:
    return Vec3(*np.asarray(v, np.float32))


def rays_of(scene: CompiledScene, seed: int = 8) -> Rays:
    """`N` rays of a scene's lights."""
    u = np.random.default_rng(seed).random((5, N), np.float32)
    e = run(scene, sample_emission, u[0], (u[1], u[2]), (u[3], u[4]))
    vectors = [stacked(v, N) for v in (e.p, e.n, e.o, e.d, e.flux)]
    rest = (e.light, e.pdf_position, e.pdf_direction, e.delta_position, e.delta_direction)
    return Rays(scene, *vectors, *(np.broadcast_to(part, N) for part in rest))


def emits(spec: Light) -> bool:
    """Whether light paths can start at a light."""
    model = LIGHTS[spec.type_name()]
    return model.is_around or model.is_on_shape or model.emit is not None


def scenes_with(spec: Light) -> list[Scene]:
    """The scene of `described`; where light may be left to BSDF sampling, with and without it."""
    ways = ("emitter", "mis") if LIGHTS[spec.type_name()].left_out else ("emitter",)
    return [strategy(described(spec), way) for way in ways] if emits(spec) else []


@remembered(2)
def emitted_by(spec: Light) -> tuple[tuple[Scene, Rays], ...]:
    """Each of `scenes_with`, and its rays: all laws of an example look at the same."""
    return tuple((scene, rays_of(compiled(scene))) for scene in scenes_with(spec))


# ---------------------------------------------------------------- power


def declared_power(scene: Scene) -> float:
    """Power in W of all lights of a scene."""
    flat = flatten(scene)
    shapes, total = compile_shapes(flat), 0.0
    placed = [(s.light, i) for i, s in enumerate(flat.shapes) if s.light is not None]
    placed += [(light.light, -1) for light in (*flat.lights, *flat.environments)]
    for light, source in placed:
        area = sum(row.areas.sum() for row in shapes.rows if row.source == source)
        model = LIGHTS[light.type_name()]
        total += model.power(mean_radiance(light), float(area), shapes.radius)
    return total


def emitted_flux_is_the_power(spec: Light) -> None:
    """The mean flux of emitted rays is the declared power."""
    for scene, rays in emitted_by(spec):
        declared = declared_power(scene)
        demand(np.isfinite(rays.flux) & (rays.flux >= 0.0), "flux is negative or not finite")
        found = luminance(Vec3(*rays.flux)).astype(float)
        z = z_of_mean(found, declared, ROUNDING * declared)
        demand(abs(z) < LARGEST_Z, f"rays carry {found.mean():.5g} W, by `power` {declared:.5g} W")


# ---------------------------------------------------------------- densities


def emitted_directions_follow_their_density(spec: Light) -> None:
    """Emitted directions are unit vectors that follow their density (chi-square)."""
    for _, rays in emitted_by(spec):
        lit = rays.pdf_direction > 0.0
        demand(length_error(rays.d[:, lit]) < 2e-6 if lit.any() else True, "d is not unit")
        one = rays.pdf_direction[rays.delta_direction]
        demand(one == 1.0, "pdf_direction must be 1 where there is one direction")
        if lit.any() and not rays.delta_direction.all():
            _density_is_theirs(rays, lit)
            if rays.pdf_direction.max() < NARROW:
                _directions_follow(rays, lit)


def _density_is_theirs(rays: Rays, lit: np.ndarray) -> None:
    n, d = _vec(rays.n), _vec(rays.d)
    found = run(rays.scene, emission_direction_pdf, rays.light, n, d)
    # At an edge, rounding decides to which side a direction belongs.
    same = np.isclose(np.broadcast_to(found, N), rays.pdf_direction, rtol=5e-3, atol=1e-6)[lit]
    demand(same.mean() > 0.995, f"the density of {(~same).sum()} directions is not the sample's")


def _directions_follow(rays: Rays, lit: np.ndarray) -> None:
    """In the frame of the normal where there is a surface, else in the world."""
    d = rays.d
    if not np.array_equal(rays.n, rays.d):
        s, t = frame_from_normal(_vec(rays.n))
        d = np.stack([np.sum(axis * d, axis=0) for axis in (stacked(s, N), stacked(t, N), rays.n)])
    p = total = 0.0
    for side in SIDES:
        cells = sphere_cells(side)
        n = cells.points.shape[1]
        up = Vec3(np.zeros(n, np.float32), np.zeros(n, np.float32), np.ones(n, np.float32))
        light, points = np.full(n, rays.light[0]), Vec3(*cells.points)
        density = run(rays.scene, emission_direction_pdf, light, up, points)
        probabilities = cells.integrals(np.broadcast_to(density, n))
        p = chi_square(cells.counts(d, lit), probabilities)
        total = probabilities.sum()
        if p > SIGNIFICANCE and total <= 1.0 + 2e-3:
            return
    raise BrokenLawError(f"directions do not follow their density: p = {p:.2g}, sum {total:.5g}")


def densities_of_positions_cover_the_light(spec: Light) -> None:
    """The mean of 1 / pdf_position is the area that rays start on."""
    for scene, rays in emitted_by(spec):
        at_points = rays.delta_position
        demand(rays.pdf_position[at_points] == 1.0, "pdf_position must be 1 where there is no area")
        if not at_points.any() and (rays.pdf_position > 0.0).all():
            _areas_are_covered(rays, scene)


def _areas_are_covered(rays: Rays, scene: Scene) -> None:
    ball = rays.scene.tables.lights.emission.array
    middle, radius = ball[MIDDLE:RADIUS, None].astype(float), float(ball[RADIUS])
    per_ray, flat = 1.0 / rays.pdf_position.astype(float), flatten(scene)
    if any(shape.light is not None for shape in flat.shapes):
        area = sum(row.areas.sum() for row in compile_shapes(flat).rows)
    else:
        # Across the direction, lines beside the ball do not count.
        off = rays.p - middle
        off = off - np.sum(off * rays.d, axis=0) * rays.d
        per_ray = np.where(np.linalg.norm(off, axis=0) <= radius * (1.0 + 1e-4), per_ray, 0.0)
        area = np.pi * radius * radius
    z = z_of_mean(per_ray, area, ROUNDING * area)
    demand(abs(z) < LARGEST_Z, f"positions cover {per_ray.mean():.5g} m^2 of {area:.5g}")


# ---------------------------------------------------------------- what arrives


def emitted_light_arrives_as_sampled(spec: Light) -> None:
    """Small disks receive as much by emitted rays as by light sampling."""
    found = emitted_by(spec)
    for _, rays in found:
        # The first scene is the one for light sampling alone.
        same_by_both(rays, found[0][1].scene, RECEIVERS)


def rays_leave_shapes_as_sampled(spec: Shape) -> None:
    """From a shape that shines, small disks receive as much by emitted rays as by samples."""
    if not spec.finite or (SHAPES[spec.type_name()].sample_area is None and not spec.parts()):
        return
    lamp = next(light for light in LIGHTS.values() if light.is_on_shape).EXAMPLES[0]
    camera = Node(camera=CAMERAS[0].EXAMPLES[0])
    for name, placement in PLACEMENTS.items():
        body = Node(shape=spec, transform=placement, light=lamp)
        try:
            scene = compiled(strategy(Scene(nodes={"body": body}, camera=camera), "emitter"))
            same_by_both(rays_of(scene), scene, RECEIVERS // 2)
        except BrokenLawError as error:
            raise BrokenLawError(f"{name}: {error}") from None


def same_by_both(rays: Rays, sampled: CompiledScene, receivers: int) -> None:
    """Compare what receivers in the way of some rays get.

    Parameters
    ----------
    rays : Rays
        Of a scene whose lights emit.
    sampled : CompiledScene
        The same for light sampling alone.
    receivers : int

    Raises
    ------
    BrokenLawError
        If it differs.
    """
    ball = rays.scene.tables.lights.emission.array
    middle, radius = ball[MIDDLE:RADIUS].astype(float), float(ball[RADIUS])
    from_infinity = (~rays.delta_position & np.all(rays.n == rays.d, axis=0)).any()
    lit = np.flatnonzero(rays.flux.max(axis=0) > 0.0)
    if not lit.size:
        return
    chosen = np.zeros(N, bool)
    chosen[lit[np.arange(receivers) * len(lit) // receivers]] = True
    free = _free_way(sampled, rays.o, rays.d, chosen)
    for k in range(receivers):
        ray = lit[k * len(lit) // receivers]
        reach = min(float(free[ray]), 2.0 * radius)
        center = (rays.o[:, ray] + 0.5 * reach * rays.d[:, ray]).astype(float)
        size = 0.25 * reach
        if from_infinity:
            # Rays go through the ball only.
            off = center - middle
            center, size = middle + 0.75 * radius / np.linalg.norm(off) * off, 0.2 * radius
        # Facing the ray, but not squarely.
        normal = 0.4 * np.roll(rays.d[:, ray], 1).astype(float) - rays.d[:, ray]
        normal /= np.linalg.norm(normal)
        _compare(rays, sampled, (center, normal, size))


def _compare(rays: Rays, scene: CompiledScene, disk: tuple) -> None:
    """Irradiance on the disk (center, normal, radius), W/m^2, by both."""
    center, normal, size = disk
    o, d = rays.o.astype(float), rays.d.astype(float)
    towards = -np.sum(d * normal[:, None], axis=0)
    height = np.sum((o - center[:, None]) * normal[:, None], axis=0)
    t = height / np.where(towards > 0.0, towards, 1.0)
    beside = np.linalg.norm(o + t * d - center[:, None], axis=0)
    met = (towards > 0.0) & (t > 0.0) & (beside < size)
    met &= t < _free_way(scene, rays.o, rays.d, met)
    flux = luminance(Vec3(*rays.flux)).astype(float)
    emitted = np.where(met, flux, 0.0) / (np.pi * size * size)
    sampled = _by_samples(scene, center, normal, size)
    if np.count_nonzero(met) + np.count_nonzero(sampled) <= FEWEST:
        return
    error = np.hypot(*(v.std(ddof=1) / np.sqrt(N) for v in (emitted, sampled)))
    a, b = emitted.mean(), sampled.mean()
    demand(
        abs(a - b) <= LARGEST_Z * error + ROUNDING * b,
        f"a disk receives {a:.5g} W/m^2 of rays, {b:.5g} of samples",
    )


def _by_samples(
    scene: CompiledScene, center: np.ndarray, normal: np.ndarray, size: float
) -> np.ndarray:
    """Estimates of the irradiance at `N` points of the disk, by light sampling."""
    u = np.random.default_rng(9).random((5, N), np.float32)
    r, turn = size * np.sqrt(u[3]), 2.0 * np.pi * u[4]
    s, t = frame_from_normal(_vec(normal))
    local = Vec3(r * np.cos(turn), r * np.sin(turn), 0.0 * r)
    points = center[:, None] + stacked(to_world(s, t, Vec3(*normal), local), N)
    facing = _vec(np.repeat(normal[:, None], N, axis=1))
    p, active = _vec(points), np.ones(N, bool)
    light = run(scene, sample_light, p, facing, u[0], (u[1], u[2]), active)
    wi, pdf = stacked(light.wi, N), np.broadcast_to(light.pdf, N).astype(float)
    cosine = np.maximum(np.sum(wi * normal[:, None], axis=0), 0.0)
    bright = luminance(Vec3(*stacked(light.radiance, N))).astype(float)
    found = (pdf > 0.0) & (bright * cosine != 0.0)
    found &= _free_way(scene, points, wi, found) >= 0.999 * np.broadcast_to(light.distance, N)
    return np.where(found, bright * cosine / np.where(pdf > 0.0, pdf, 1.0), 0.0)


def _free_way(scene: CompiledScene, o: Any, d: Any, active: np.ndarray) -> np.ndarray:
    """Distance of the first surface along active rays (3, N), m."""
    return nearest_hits(partial(run, scene, intersect_closest), o, d, active).t.astype(float)


# ---------------------------------------------------------------- machine code


@kernel
def rays_of_lights(scene, u, out, n):
    """Origin, direction, flux and densities of n rays."""
    for i in range(0, n, LANES):
        u2 = load_lanes(u, i + n), load_lanes(u, i + 2 * n)
        v2 = load_lanes(u, i + 3 * n), load_lanes(u, i + 4 * n)
        e = sample_emission(scene, load_lanes(u, i), u2, v2)
        store_lanes(out, i, e.p.x)
        store_lanes(out, i + n, e.p.y)
        store_lanes(out, i + 2 * n, e.p.z)
        store_lanes(out, i + 3 * n, e.d.x)
        store_lanes(out, i + 4 * n, e.d.y)
        store_lanes(out, i + 5 * n, e.d.z)
        store_lanes(out, i + 6 * n, e.flux.x)
        store_lanes(out, i + 7 * n, e.flux.y)
        store_lanes(out, i + 8 * n, e.flux.z)
        store_lanes(out, i + 9 * n, lanes(0.0) + e.pdf_position)
        store_lanes(out, i + 10 * n, lanes(0.0) + e.pdf_direction)


def compiled_rays_are_the_twins(spec: Light) -> None:
    """Machine code emits the rays of the Python text."""
    for scene in scenes_with(spec)[:1]:
        tables, n = compiled(scene), 4096
        u = np.random.default_rng(2).random((5, n), np.float32)
        found = []
        for machine in (True, False):
            out = View(np.zeros((11, n), np.float32))
            emit = instantiate(rays_of_lights, tables.program, compiled=machine, lanes=n)
            with np.errstate(all="ignore"):
                emit(tables.tables, View(u), out, n)
            found.append(out.shaped)
        demand_close(found[0], found[1], "compiled against Python", rtol=2e-3, atol=1e-3)


LAWS = (
    emitted_flux_is_the_power,
    emitted_directions_follow_their_density,
    densities_of_positions_cover_the_light,
    emitted_light_arrives_as_sampled,
)
LAWS_OF_SHAPES = (rays_leave_shapes_as_sampled,)
COMPILED_LAWS = (compiled_rays_are_the_twins,)
