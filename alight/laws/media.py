"""Laws of media: what comes through is the transmittance, what is scattered is the rest.

Each law is a function of an example and raises `BrokenLawError`. The density along a ray is that of
`density_at`, summed up in small steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.registry import default_of, specs_of
from alight.core.spec import Bsdf, Camera, Integrator, Medium, Shape
from alight.laws.bodies import scene_of
from alight.laws.integrators import picture
from alight.laws.remembered import remembered
from alight.laws.report import demand
from alight.laws.statistics import LARGEST_Z, unit_vectors, z_of_mean
from alight.media.coefficients import Coefficients, extinction
from alight.media.model import MEDIA
from alight.media.sampling import cross, fly
from alight.media.tables import Segment, Stream
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import Node, Scene, flatten
from alight.scene.transform import scale, translate
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3

#: Lanes that follow one ray, rays, and steps of the integral along each.
N, RAYS, STEPS = 40_000, 6, 20_000

#: Sides of the furnace's picture in pixels, and samples of each.
FILM, FURNACE_SPP = (12, 12), 8


def _ball(spec: Medium) -> Scene:
    """A ball of the medium around (0.5, 0.5, 0.5), behind a border that is not there."""
    border = next(b for b in specs_of(Bsdf).values() if b.unseen)()
    round_ = next(s for s in specs_of(Shape).values() if s.closed)()
    place = translate(0.5, 0.5, 0.5) @ scale(0.8)
    node = Node(shape=round_, bsdf=border, interior=spec, transform=place)
    sees = next(i for i in specs_of(Integrator).values() if i.sees_media)()
    return scene_of({"ball": node}).replaced(integrator=sees)


@remembered(4)
def ball_of(spec: Medium) -> CompiledScene:
    """That ball, compiled."""
    return compile_scene(flatten(_ball(spec)), structure="list")


@remembered(4)
def furnace_of(spec: Medium) -> CompiledScene:
    """That ball before surroundings of radiance 1, on a small film."""
    scene = _ball(spec)
    camera = Node(camera=default_of(Camera), transform=translate(0.5, 0.5, 3.0))
    film = scene.film.replaced(size=FILM)
    return compile_scene(flatten(scene.replaced(camera=camera, film=film)), structure="list")


def _rays(spec: Medium) -> Any:
    """Origins and directions (3,), and lengths, in and around the unit cube.

    Not so long that hardly any light comes through.
    """
    longest = min(3.0, 3.0 / max(*extinction(spec), 1e-6))
    rng = np.random.default_rng(1)
    for k in range(RAYS):
        direction = unit_vectors(1, k)[:, 0].astype(float)
        yield rng.uniform(-0.3, 1.3, 3), direction, rng.uniform(0.1, 1.0) * longest


def _depth(spec: Medium, o: np.ndarray, d: np.ndarray, length: float) -> float:
    """Integral of the density along a ray, m."""
    t = (np.arange(STEPS) + 0.5) / STEPS * length
    density = np.asarray(MEDIA[spec.type_name()].density_at(spec, o + t[:, None] * d), float)
    demand(np.isfinite(density) & (density >= 0.0), "a density is negative or not finite")
    return float(density.mean() * length)


def _segment(o: np.ndarray, d: np.ndarray, length: float) -> tuple[Segment, np.ndarray]:
    """Many times the same way, with random numbers of their own."""
    rng = np.random.default_rng(4)
    ones = np.ones(N, np.float32)
    rows = np.ones(N, np.uint32)
    origin, direction = (Vec3(*(np.float32(c) * ones for c in v)) for v in (o, d))
    channel = rng.integers(0, 3, N).astype(np.uint32)
    keys = Stream(*(rng.integers(0, 2**32, N, np.uint32) for _ in range(3)))
    way = Segment(origin, direction, np.float32(length) * ones, rows, channel, keys)
    return way, rng.random(N, np.float32)


def _columns(v: Any) -> np.ndarray:
    return np.stack([np.broadcast_to(np.float64(c), N) for c in (v.x, v.y, v.z)], 1)


def _demand_mean(values: np.ndarray, expected: float, what: str) -> None:
    z = z_of_mean(values, expected, 2e-5 + 1e-4 * expected)
    demand(abs(z) < LARGEST_Z, f"{what}: {values.mean():.6g} against {expected:.6g}")


def flights_come_through_as_the_transmittance_says(spec: Medium) -> None:
    """Flights come through as the transmittance says, whichever channel chose, or scatter."""
    scene = ball_of(spec)
    run = instantiate(fly, scene.program, compiled=False)
    for o, d, length in _rays(spec):
        segment, u = _segment(o, d, length)
        with np.errstate(all="ignore"):
            flight = run(scene.tables, segment, u, np.ones(N, bool))
        factor, through = _columns(flight.factor), ~np.broadcast_to(flight.scattered, N)
        t = np.broadcast_to(flight.t, N)
        demand((t >= 0.0) & (t <= np.float32(length)), "a flight ends beyond the ray")
        expected = np.exp(-_depth(spec, o, d, length) * np.array(extinction(spec)))
        # Of the chances of the three channels that might have chosen.
        weight = factor / factor.mean(axis=1, keepdims=True)
        for c in range(3):
            _demand_mean(np.where(through, weight[:, c], 0.0), expected[c], "comes through")
            if extinction(spec)[c] > 0.0:
                _demand_mean(np.where(through, 0.0, weight[:, c]), 1.0 - expected[c], "scattered")


def scattering_is_spread_as_the_density(spec: Medium) -> None:
    """Light is scattered before the middle of a ray as often as the first half says."""
    scene = ball_of(spec)
    run = instantiate(fly, scene.program, compiled=False)
    for o, d, length in _rays(spec):
        segment, u = _segment(o, d, length)
        with np.errstate(all="ignore"):
            flight = run(scene.tables, segment, u, np.ones(N, bool))
        factor = _columns(flight.factor)
        early = np.broadcast_to(flight.scattered & (flight.t < 0.5 * np.float32(length)), N)
        weight = factor / factor.mean(axis=1, keepdims=True)
        expected = np.exp(-_depth(spec, o, d, 0.5 * length) * np.array(extinction(spec)))
        for c in range(3):
            if extinction(spec)[c] > 0.0:
                found = np.where(early, weight[:, c], 0.0)
                _demand_mean(found, 1.0 - expected[c], "scattered in the first half")


def shadow_rays_come_through_as_the_transmittance_says(spec: Medium) -> None:
    """So much light comes through along shadow rays as the transmittance says."""
    scene = ball_of(spec)
    run = instantiate(cross, scene.program, compiled=False)
    for o, d, length in _rays(spec):
        segment, _ = _segment(o, d, length)
        with np.errstate(all="ignore"):
            crossing = run(scene.tables, segment, np.ones(N, bool))
        passed = _columns(crossing.passed) * np.broadcast_to(crossing.weight, N)[:, None]
        weight = passed / _columns(crossing.light).mean(axis=1, keepdims=True)
        expected = np.exp(-_depth(spec, o, d, length) * np.array(extinction(spec)))
        for c in range(3):
            _demand_mean(weight[:, c], expected[c], "comes through")


def in_a_furnace_it_vanishes(spec: Coefficients) -> None:
    """In a furnace as bright as the medium itself nothing is seen: all light is 1."""
    scene = furnace_of(spec.shining((1.0, 1.0, 1.0)))
    values = picture(scene, Tile(0, 0, *FILM), spp=FURNACE_SPP).sum(axis=2) / FURNACE_SPP
    for channel in range(3):
        # Samples of a pixel have one mean: pixels are independent values of it.
        mean = values[..., channel].ravel()
        _demand_mean(mean, 1.0, f"light in the furnace, channel {channel}")


LAWS = (
    in_a_furnace_it_vanishes,
    flights_come_through_as_the_transmittance_says,
    scattering_is_spread_as_the_density,
    shadow_rays_come_through_as_the_transmittance_says,
)
