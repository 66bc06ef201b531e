"""Laws of lights: directions, densities and radiance fit each other, and the declared power.

Each law is a function of an example and raises `BrokenLawError`. Lights at a point have one
direction; those that rays can hit are found by rays with the density of light sampling, whether
they stand on a shape or around the scene.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from alight.accel import intersect_closest
from alight.cameras import MODELS as CAMERAS
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.constants import PI
from alight.core.registry import specs_of
from alight.core.spec import Light, Shape
from alight.core.vec import Vec3, luminance
from alight.laws.materials import stacked
from alight.laws.remembered import remembered
from alight.laws.report import BrokenLawError, demand, demand_close
from alight.laws.statistics import (
    LARGEST_Z,
    ROUNDING,
    SIDES,
    SIGNIFICANCE,
    UNIT,
    chi_square,
    demand_mean,
    length_error,
    sphere_cells,
    turns,
    unit_vectors,
    z_of_mean,
)
from alight.lights.environment_map import BAND, COLUMNS, FIRST_BAND, ROWS, TEXEL
from alight.lights.hits import emitted, light_pdf
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.model import LIGHTS
from alight.lights.sampling import sample_light
from alight.scene import Node, Scene, flatten
from alight.scene.transform import rotate, translate
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, lanes_mask, load_lanes, store_lanes
from lanewise.view import View

#: Where the light stands; where the ball is that is no light, in m.
PLACE, FAR = (0.3, -0.2, 0.5), 1000.0
N = 4096

#: A grid of directions, and how often it is turned.
CELLS = sphere_cells(16)
TURNS = 8


def described(spec: Light) -> Scene:
    """A scene with this light and a ball: the light's own, or one that is far away."""
    model, turned = LIGHTS[spec.type_name()], rotate("y", 40) @ rotate("x", 25)
    ball = next(s for s in specs_of(Shape).values() if s.closed)()
    place = translate(*PLACE) @ turned
    nodes = {"light": Node(light=spec, transform=turned if model.is_around else place)}
    if model.is_on_shape:
        nodes["light"] = Node(light=spec, shape=ball, transform=place)
    else:
        nodes["far"] = Node(shape=ball, transform=translate(0, 0, FAR))
    camera = Node(camera=CAMERAS[0].EXAMPLES[0])
    # A window shows what else is around the scene.
    seen = not model.is_around or model.radiance is not None
    sky = next(m for m in LIGHTS.values() if m.is_around).EXAMPLES[0]
    return Scene(nodes=nodes, camera=camera, environment=None if seen else sky)


@remembered(2)
def scene_of(spec: Light) -> CompiledScene:
    """That scene for light sampling alone: else a map may leave light to BSDF sampling."""
    return compile_scene(flatten(strategy(described(spec), "emitter")), structure="list")


def strategy(scene: Scene, light_sampling: str) -> Scene:
    """The same scene with a strategy of light sampling."""
    return scene.replaced(integrator=scene.integrator.replaced(light_sampling=light_sampling))


def light_at(spec: Light, points: np.ndarray):
    """`LightSample` at points (3, n)."""
    n = points.shape[1]
    scene = scene_of(spec)
    rng = np.random.default_rng(1)
    u = rng.random((3, n), np.float32)
    p = Vec3(*np.ascontiguousarray(points, np.float32))
    return run(scene, sample_light, p, p, u[0], (u[1], u[2]), np.ones(n, bool))


def run(scene: CompiledScene, kernel: Callable, *arguments: Any) -> Any:
    """A kernel on lanes of NumPy."""
    with np.errstate(all="ignore"):
        return instantiate(kernel, scene.program, compiled=False)(scene.tables, *arguments)


def _around(distance: float) -> np.ndarray:
    return np.reshape(PLACE, (3, 1)) + distance * unit_vectors(N, 3)


def samples_are_directions_with_light(spec: Light) -> None:
    """Samples are unit directions, with finite radiance and the density of a delta light."""
    light = light_at(spec, _around(3.0))
    wi, radiance = stacked(light.wi, N), stacked(light.radiance, N)
    pdf = np.broadcast_to(light.pdf, N)
    demand(length_error(wi[:, pdf > 0.0]) < 1e-6 if (pdf > 0.0).any() else True, "wi is not unit")
    demand(np.isfinite(radiance) & (radiance >= 0.0), "radiance is negative or not finite")
    demand(np.isin(pdf, (0.0, 1.0)), "the pdf of a delta light must be 1, or 0 where it is dark")
    demand(light.delta, "delta must be true")
    demand(np.broadcast_to(light.distance, N) > 0.0, "the distance must be > 0")


def light_comes_from_its_place(spec: Light) -> None:
    """All samples point to the place of the node, and fall off with the distance squared.

    A sample knows its direction to a few units of 2^-24. How much the light may differ for that
    follows from directions nearby.
    """
    near, far = _around(2.0), _around(4.0)
    here, there = light_at(spec, near), light_at(spec, far)
    distance = np.broadcast_to(here.distance, N)
    lit = np.broadcast_to(here.pdf, N) > 0.0
    if not lit.any() or not np.isfinite(distance).all():
        return
    place = near + stacked(here.wi, N) * distance
    wanted = np.broadcast_to(np.reshape(PLACE, (3, 1)), place.shape)
    # A difference of coordinates, three squares, a root, a quotient and a product.
    a_way = 8 * UNIT
    atol = a_way * (2.0 + np.abs(wanted).max())
    demand_close(place[:, lit], wanted[:, lit], "where samples point", atol=atol)
    a, b = (stacked(light.radiance, N).astype(float) for light in (here, there))
    changes = []
    for side in unit_vectors(4, 17).T:
        beside = near + 2.0 * NEARBY * np.cross(stacked(here.wi, N), side, axis=0)
        changes.append(np.abs(stacked(light_at(spec, beside).radiance, N) - a) / NEARBY)
    atol = ROUNDING * a + 2.0 * a_way * np.max(changes, axis=0)
    demand_close(4.0 * b, a, "four times the light at twice the distance", atol=atol)


#: Radians between directions nearby.
NEARBY = 1e-3


def power_is_the_integral(spec: Light) -> None:
    """`power` is the integral of the intensity over all directions.

    The sum over a grid that is turned at random has the integral as its mean.
    """
    model, n = LIGHTS[spec.type_name()], CELLS.points.shape[1]
    points = np.hstack([turn @ CELLS.points for turn in turns(TURNS, 4)])
    light = light_at(spec, np.reshape(PLACE, (3, 1)) + points)
    if not np.isfinite(np.broadcast_to(light.distance, TURNS * n)).all():
        return
    bright = luminance(Vec3(*stacked(light.radiance, TURNS * n))).reshape(TURNS, n)
    whole = CELLS.integrals(np.ones(n)).sum() / (4.0 * PI)
    found = [CELLS.integrals(one).sum() / whole for one in bright]
    declared = model.power(float(luminance(Vec3(*model.mean(spec)))), 0.0, 1.0)
    demand_mean(found, declared, "integral against the declared power", ROUNDING * declared)


# ---------------------------------------------------------------- around the scene

#: Densities above it belong to lights that are narrower than a cell of the sphere.
NARROW = 200.0


def _one_point(n: int) -> np.ndarray:
    return np.repeat(np.float32([[0.4], [1.1], [-0.7]]), n, axis=1)


def _lit_from_around(spec: Light) -> tuple[CompiledScene, Any, np.ndarray, np.ndarray] | None:
    """The scene, samples at one point, their directions and densities; None if it is dark."""
    scene, n = scene_of(spec), 60_000
    u = np.random.default_rng(5).random((3, n), np.float32)
    p = Vec3(*_one_point(n))
    light = run(scene, sample_light, p, p, u[0], (u[1], u[2]), np.ones(n, bool))
    pdf = np.broadcast_to(light.pdf, n).astype(float)
    return (scene, light, stacked(light.wi, n), pdf) if (pdf > 0.0).any() else None


def directions_follow_their_density(spec: Light) -> None:
    """Sampled directions follow the density (chi-square), which integrates to at most 1."""
    lit = _lit_from_around(spec)
    if lit is None:
        return
    scene, _, wi, pdf = lit
    if pdf.max() > NARROW:
        return
    p = total = 0.0
    for side in SIDES:
        cells = sphere_cells(side)
        n = cells.points.shape[1]
        density = run(scene, environment_pdf, Vec3(*_one_point(n)), Vec3(*cells.points))
        density = np.broadcast_to(density, n)
        demand(np.isfinite(density) & (density >= 0.0), "a density is negative or not finite")
        probabilities = cells.integrals(density)
        p = chi_square(cells.counts(wi, pdf > 0.0), probabilities)
        total = probabilities.sum()
        if p > SIGNIFICANCE and total <= 1.0 + 2e-3:
            return
    raise BrokenLawError(f"directions do not follow pdf: p = {p:.2g}, integral {total:.5g}")


def rays_find_what_samples_bring(spec: Light) -> None:
    """A ray in a sampled direction finds the same radiance, and the density of the sample."""
    lit = _lit_from_around(spec)
    if lit is None:
        return
    scene, light, wi, pdf = lit
    n, ok = len(pdf), pdf > 0.0
    demand(length_error(wi[:, ok]) < 1e-6, "wi is not a unit vector")
    demand(np.isinf(np.broadcast_to(light.distance, n)), "the distance must be infinite")
    d = Vec3(*np.ascontiguousarray(wi))
    found = np.broadcast_to(run(scene, environment_pdf, Vec3(*_one_point(n)), d), n)
    # At an edge, rounding decides to which side a direction belongs.
    same = np.asarray(np.isclose(found, pdf, rtol=2e-3))[ok]
    demand(same.mean() > 0.998, f"pdf differs from the sample's in {(~same).sum()} directions")
    seen, brought = (stacked(v, n) for v in (run(scene, environment_radiance, d), light.radiance))
    same = np.all(np.isclose(seen[:, ok], brought[:, ok], rtol=2e-3, atol=1e-6), axis=0)
    demand(same.mean() > 0.998, f"radiance differs in {(~same).sum()} directions")


def samples_bring_the_power(spec: Light) -> None:
    """The radiance of samples over their density has the mean that `power` says."""
    lit = _lit_from_around(spec)
    model = LIGHTS[spec.type_name()]
    if lit is None or model.radiance is None:
        return
    _, light, _, pdf = lit
    n = len(pdf)
    weight = luminance(Vec3(*stacked(light.radiance, n))).astype(float)
    weight = np.where(pdf > 0.0, weight / np.where(pdf > 0.0, pdf, 1.0), 0.0)
    declared = model.power(mean_radiance(spec), 0.0, 1.0) / PI
    z = z_of_mean(weight, declared, ROUNDING * declared)
    demand(abs(z) < LARGEST_Z, f"samples bring {weight.mean():.5g}, by its power {declared:.5g}")


def mean_radiance(spec: Light) -> float:
    """Luminance of the mean over all directions."""
    model = LIGHTS[spec.type_name()]
    color = model.mean(spec)
    if model.map_of is not None:
        made, aside = model.map_of(spec, np.eye(4), False), model.beside_the_map(spec)
        scale = model.place(spec, np.eye(4))[0]
        mean, most_off = mean_of_map(made.table)
        demand_close(made.mean, mean, "mean of the map", atol=most_off + ROUNDING * mean)
        color = [a * (b + c) for a, b, c in zip(scale, mean, aside, strict=True)]
    return float(luminance(Vec3(*color)))


def mean_of_map(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean radiance of a map, and how far from it the means of the cells' corners may be.

    Between two rows of texels, at a and b = a + h, radiance is linear in theta: with
    S = cos a - cos b and T = sin b - sin a - h cos b it is half of L_a S + (L_b - L_a) T / h.
    Corners take S / 2 for T / h, whose difference is h^2 cos((a + b) / 2) / 12 to the second order.
    """
    columns, rows = int(table[COLUMNS]), int(table[ROWS])
    texels = table[FIRST_BAND + BAND * rows :].reshape(rows + 1, columns, TEXEL)
    radiance = texels[:, :, :3].astype(float).mean(axis=1)
    theta, h = np.linspace(0.0, PI, rows + 1), PI / rows
    s = -np.diff(np.cos(theta))[:, None]
    t = (np.diff(np.sin(theta)) - h * np.cos(theta[1:]))[:, None]
    steps = np.diff(radiance, axis=0)
    mean = 0.5 * (radiance[:-1] * s + steps * t / h).sum(axis=0)
    middle = np.abs(np.cos(0.5 * (theta[1:] + theta[:-1])))[:, None]
    return mean, (np.abs(steps) * middle).sum(axis=0) * h * h / 24.0


# ---------------------------------------------------------------- on a shape

#: Points that are seen at less count for little, and rounding for much.
LEAST_COSINE = 0.1


def hits_bring_what_samples_bring(spec: Light) -> None:
    """A ray to a sample finds there the same radiance, and the density of the sample."""
    scene, points = scene_of(spec), np.ascontiguousarray(_around(3.0), np.float32)
    u = np.random.default_rng(6).random((3, N), np.float32)
    p, active = Vec3(*points), np.ones(N, bool)
    light = run(scene, sample_light, p, p, u[0], (u[1], u[2]), active)
    pdf, cosine = np.broadcast_to(light.pdf, N), np.broadcast_to(light.cosine, N)
    far = np.full(N, np.inf, np.float32)
    wi = Vec3(*np.ascontiguousarray(stacked(light.wi, N)))
    hit = run(scene, intersect_closest, p, wi, far, active)
    ok = (pdf > 0.0) & np.isfinite(hit.t) & (cosine > LEAST_COSINE)
    surface = run(scene, make_surface, hit, p, wi, ok)
    density = run(scene, light_pdf, surface.light, p, wi, hit.t, surface)
    # A density per solid angle is divided by the cosine, and so are its errors.
    rtol = ROUNDING / LEAST_COSINE
    demand_close(density[ok], pdf[ok], "pdf of a hit against the sample's", rtol=rtol)
    seen = stacked(run(scene, emitted, surface, -1.0 * wi), N)
    brought = stacked(light.radiance, N)
    demand(np.isfinite(seen) & (seen >= 0.0), "radiance is negative or not finite")
    demand_close(seen[:, ok], brought[:, ok], "radiance of a hit", rtol=5e-3, atol=1e-6)


def power_is_that_of_its_surface(spec: Light) -> None:
    """`power` is the radiance, times the cosine, over the hemisphere and the area."""
    scene, model = scene_of(spec), LIGHTS[spec.type_name()]
    # Gauss and Legendre: exact for powers of the cosine up to 127.
    n = 64
    nodes, shares = np.polynomial.legendre.leggauss(n)
    z = (0.5 + 0.5 * nodes).astype(np.float32)
    one, zero = np.ones(n, np.float32), np.zeros(n, np.float32)
    # The same point, looked at from all angles.
    p, d = Vec3(*(np.float32(c) * one for c in (PLACE[0], PLACE[1], 50.0))), Vec3(zero, zero, -one)
    hit = run(scene, intersect_closest, p, d, np.inf * one, np.ones(n, bool))
    surface = run(scene, make_surface, hit, p, d, np.ones(n, bool))
    ng, across = surface.ng, surface.s
    wo = z * ng + np.sqrt(1.0 - z * z) * across
    seen = luminance(Vec3(*stacked(run(scene, emitted, surface, wo), n))).astype(float)
    found = PI * float((shares * seen * z).sum())
    declared = model.power(float(luminance(Vec3(*model.mean(spec)))), 1.0, 1.0)
    demand_close(found, declared, "flux of a square metre against `power`", rtol=ROUNDING)


# ---------------------------------------------------------------- machine code


@kernel
def light_of_points(scene, points, u, out, n):
    """Direction, distance, radiance and density at n points."""
    for i in range(0, n, LANES):
        p = Vec3(load_lanes(points, i), load_lanes(points, i + n), load_lanes(points, i + 2 * n))
        u2 = load_lanes(u, i + n), load_lanes(u, i + 2 * n)
        s = sample_light(scene, p, p, load_lanes(u, i), u2, lanes_mask(True))
        store_lanes(out, i, s.wi.x)
        store_lanes(out, i + n, s.wi.y)
        store_lanes(out, i + 2 * n, s.wi.z)
        store_lanes(out, i + 3 * n, lanes(0.0) + s.distance)
        store_lanes(out, i + 4 * n, s.radiance.x)
        store_lanes(out, i + 5 * n, s.radiance.y)
        store_lanes(out, i + 6 * n, s.radiance.z)
        store_lanes(out, i + 7 * n, lanes(0.0) + s.pdf)


def compiled_light_is_the_twins(spec: Light) -> None:
    """Machine code gives the light of the Python text."""
    scene = scene_of(spec)
    points = np.ascontiguousarray(_around(3.0), np.float32)
    u = np.random.default_rng(2).random((3, N), np.float32)
    found = []
    for compiled in (True, False):
        out = View(np.zeros((8, N), np.float32))
        run = instantiate(light_of_points, scene.program, compiled=compiled, lanes=N)
        with np.errstate(all="ignore"):
            run(scene.tables, View(points), View(u), out, N)
        found.append(out.shaped)
    with np.errstate(invalid="ignore"):
        both = np.where(np.isinf(found[0]) & np.isinf(found[1]), 0.0, found)
    demand_close(both[0], both[1], "compiled against Python", rtol=1e-3, atol=1e-4)


#: By placement.
LAWS = {
    "node": (samples_are_directions_with_light, light_comes_from_its_place, power_is_the_integral),
    "shape": (hits_bring_what_samples_bring, power_is_that_of_its_surface),
    "environment": (
        directions_follow_their_density,
        rays_find_what_samples_bring,
        samples_bring_the_power,
    ),
}
COMPILED_LAWS = (compiled_light_is_the_twins,)
