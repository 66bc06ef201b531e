r"""Light off small bright surfaces, which only chance finds: how much there is.

A lamp close to a wall lights a patch of it, a lamp in a frosted bulb lights the bulb. Light
sampling finds the lamp from there, and a path that happens to be scattered to the patch brings a
lot. Until one is, no sample tells of it.

So paths from the lamps look for it, as `alight.rendering.light_off_mirrors` does for what mirrors
and clear glass have turned. What differs is the first surface, since light sampling finds the lamp
there. At that surface a path from the camera, going on along :math:`\omega_o`, turns to the lamp
along :math:`\omega_l` by one of two techniques, which the balance heuristic combines:

.. math:: L' = \frac{L\, f |\cos\theta_l|}{p(\omega_l \mid \omega_o) + P\, p_l} , \qquad
    G' = G\, \frac{|\cos\theta_o|}{|\cos\theta_l|\, p(\omega_o \mid \omega_l)}
    \left( p(\omega_l \mid \omega_o) + P\, p_l \right) ,

P being the probability of light sampling to choose the lamp and :math:`p_l` its density, one over
the lamp's solid angle. L' is what a sample brings, and G' the étendue of the light path, which has
turned with the density :math:`p(\omega_o \mid \omega_l)`: the flux L' G' is what arrives. At
further surfaces light sampling finds nothing, so P is 0 there. Lamps without a size are found by
light sampling alone.

A medium is as good as a surface, with its phase function and albedo in place of f: smoke around a
lamp, fog beside it. What it leaves of the light on the first way, light sampling knows; on further
ways light paths collide or pass, as paths from the camera do.

How bright a patch is and how often it is met follow from there as they do for mirrors. Light that a
medium scatters straight into the camera is that of `alight.rendering.light_in_media`.

Source: Veach 1997, sections 8.3 and 9.2; Jensen 1996.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.flags import DELTA, TRANSMISSION
from alight.compiled.casters import is_caster
from alight.core.vec import Vec3
from alight.films import CELL_SIZE
from alight.integrators.walk import to_local
from alight.lights.emission.density import direct_density, is_kind
from alight.lights.emission.sampling import no_emission, sample_emission
from alight.lights.tables import STRIDE
from alight.lights.tree.traversal import mis_probability
from alight.lights.tree.ways import with_ways
from alight.rendering.arriving_light import NEAREST, Arrived, all_of, gather
from alight.rendering.light_in_media import Beams, gather_in_media
from alight.rendering.nearby_lamps import with_nearby_lamps
from alight.rendering.pilot_media import (
    Flown,
    Way,
    beyond,
    flown,
    in_no_medium,
    medium_around,
    transmittance,
    turned_by_media,
)
from alight.rendering.pilot_rays import (
    MOST_SURFACES,
    Pilot,
    Turns,
    columns_of,
    dots,
    joined,
    lanes_of,
    picked,
    wide,
)
from alight.rendering.sight import Sight
from alight.shapes.hit import Hit, Surface

#: Light paths.
PATHS = 2**14

#: Surfaces and collisions on one way through media.
_MOST_IN_MEDIA = 64

#: Edges of the shortest path by way of a surface: lamp, surface, what the camera sees, camera.
_EDGES = 3

#: Light that a cell's first samples meet so many times is no matter of chance.
_OFTEN = 10.0

#: Samples per pixel at the first look at a picture.
_FIRST = 16


class _Light(NamedTuple):
    """Light paths on their way.

    Attributes
    ----------
    o, d : Vec3
    radiance : (n, 3) float64
        L; of lamps at a point the intensity, of those in one direction the irradiance.
    share : (n,) float64
        G, so that the product is a flux.
    turns : (n,) int
        How often something has scattered it.
    times : (n,) float32
    lamp, prim : (n,) int
        Row of the lamp, and triangle of its mesh.
    normal : Vec3
        Of the lamp.
    near, sized : (n,) bool
        Whether the lamp is a point; whether it has a size.
    way : (n,) float64
        From the lamp to the last surface that was not there.
    medium : (n,) uint32
        Row of the medium that the light is in.
    """

    o: Vec3
    d: Vec3
    radiance: np.ndarray
    share: np.ndarray
    turns: np.ndarray
    times: np.ndarray
    lamp: np.ndarray
    prim: np.ndarray
    normal: Vec3
    near: np.ndarray
    sized: np.ndarray
    way: np.ndarray
    medium: np.ndarray

    @property
    def turned(self) -> np.ndarray:
        """Whether anything has scattered it, (n,) bool."""
        return self.turns > 0

    def some(self, rows: np.ndarray) -> _Light:
        return _Light(*(picked(part, rows) for part in self))


def light_off_surfaces(sight: Sight) -> np.ndarray | None:
    """Look for it, the same way whatever the seed of the picture.

    Returns
    -------
    (n, 7) float64, or None where there is none
        Rows of `alight.rendering.light_behind_glass.light_behind_glass`, for the same points.
    """
    scene, integrator = sight.scene, sight.scene.integrator
    longest = integrator.longest_path or MOST_SURFACES + _EDGES
    if not integrator.needs_light or integrator.finds_light_by_chance or integrator.splats:
        return None
    if not scene.program.lights or longest < _EDGES:
        return None
    if sight.lights is None or not len(sight.seen.point) + len(sight.collided.point):
        return None
    both = scene.tables._replace(lights=_both(scene.tables.lights, sight.lights))
    lit = with_nearby_lamps(Pilot(scene, sight.random(), both), sight.seen)
    mirrors = any(is_caster(bsdf) for bsdf in sight.flat.bsdfs)
    # What light misses is no number.
    with np.errstate(all="ignore"):
        arrived, beams = _follow(lit, _set_out(lit), mirrors, longest - _EDGES + 1)
        table = gather_in_media(lit, sight.collided, beams)
    if len(arrived.share) >= NEAREST and len(sight.seen.point):
        table = np.concatenate([gather(lit, sight.seen, arrived), table])
    table = table[table[:, 5] * CELL_SIZE**2 * _FIRST < _OFTEN]
    return table if len(table) else None


def _both(sampled: Any, emitting: Any) -> Any:
    """Tables of lights that light sampling reads, and what light that is emitted reads beside."""
    more = [name for name in emitting._fields if name not in sampled._fields]
    fields = [*sampled, *(getattr(emitting, name) for name in more)]
    return namedtuple("BothLights", (*sampled._fields, *more))(*fields)


def _set_out(pilot: Pilot) -> _Light:
    """Begin light paths."""
    n, times = PATHS, pilot.times(PATHS)
    tables = pilot.at(times)
    u, ux, uy, vx, vy = pilot.random.random((5, n)).astype(np.float32)
    e = pilot.twin(sample_emission)(tables, u, (ux, uy), (vx, vy))
    lamp = wide(e.light, n)
    on_shape, near, _ = (wide(kind, n) for kind in pilot.twin(is_kind)(tables, lamp))
    normal, d = lanes_of(e.n, n), lanes_of(e.d, n)
    cosine = np.where(on_shape, dots(columns_of(normal), columns_of(d)), 1.0)
    chances = (e.choice, e.pdf_position, e.pdf_direction)
    density = np.prod([wide(chance, n).astype(np.float64) for chance in chances], axis=0)
    good = (density > 0.0) & (cosine > 0.0)
    per = np.where(good, density / np.where(good, cosine, 1.0), 0.0)
    return _Light(
        o=lanes_of(e.o, n),
        d=d,
        radiance=columns_of(lanes_of(e.flux, n)) * per[:, None],
        share=1.0 / (np.where(good, per, 1.0) * n),
        turns=np.zeros(n, int),
        times=times,
        lamp=lamp,
        prim=wide(e.prim, n),
        normal=normal,
        near=near,
        sized=~wide(e.delta_position, n) & ~wide(e.delta_direction, n),
        way=np.zeros(n),
        medium=in_no_medium(n),
    ).some(good)


def _follow(pilot: Pilot, light: _Light, mirrors: bool, most: int) -> tuple[Arrived, list[Beams]]:
    """Where light arrives that something has scattered, at most so often; its ways in media."""
    found, beams, random = [], [], pilot.random
    light = light._replace(medium=medium_around(pilot, light.o, light.d, light.times))
    clouds = _nobody(light)
    for _ in range(_MOST_IN_MEDIA if pilot.program.media else MOST_SURFACES):
        # What a medium has scattered goes on with the rest.
        light = joined([light, clouds])
        hit = pilot.hits(light.o, light.d, light.times)
        beams.append(_beams(light, hit))
        light, hit, clouds = _through_media(pilot, light, hit)
        clouds = clouds.some(clouds.turns <= most)
        n = len(light.share)
        if not n:
            if not len(clouds.share):
                break
            continue
        surface, wl = pilot.surface(hit, light.o, light.d, light.times)
        turns = pilot.turns(surface, wl, light.times)
        p, normal = (columns_of(lanes_of(v, n)) for v in (surface.p, surface.ns))
        here = Arrived(p, normal, -columns_of(light.d), light.radiance, light.share)
        found.append(picked(here, light.turned))
        first = ~light.turned & ~turns.holes
        way = light.way + hit.t
        seen, share = _scattered(pilot, light, way, surface, wl, turns)
        # Paths end by chance where they lose light: the others count for more.
        keep = np.minimum(np.nan_to_num(seen.max(axis=1) * share), 1.0)
        keep = np.where(turns.holes, 1.0, keep)
        on = random.random(n) < keep
        # What mirrors and clear glass turn first is that of `light_off_mirrors`, or straight on.
        on &= ~(first & turns.sharp & (mirrors | ((turns.flags & TRANSMISSION) != 0)))
        on &= turns.holes | (light.turns < most)
        light = light._replace(
            o=pilot.leave(surface, turns.d),
            d=turns.d,
            radiance=light.radiance * seen,
            share=light.share * share / np.where(on, keep, 1.0),
            turns=light.turns + ~turns.holes,
            way=way,
            medium=beyond(pilot, surface, turns.d, light.medium, light.times),
        ).some(on)
    return all_of(found), beams


def _beams(light: _Light, hit: Hit) -> Beams:
    """Ways in media of light that something has scattered."""
    on = light._replace(way=hit.t).some(light.turned & (light.medium != 0))
    return Beams(
        o=on.o,
        d=on.d,
        length=on.way,
        radiance=on.radiance,
        share=on.share,
        medium=on.medium,
        times=on.times,
    )


def _nobody(light: _Light) -> _Light:
    return light.some(np.zeros(len(light.share), bool))


def _through_media(pilot: Pilot, light: _Light, hit: Hit) -> tuple[_Light, Hit, _Light]:
    """Light that reaches surfaces, what it meets there, and light that media have scattered."""
    if not light.medium.any():
        met = np.isfinite(hit.t)
        return light.some(met), picked(hit, met), _nobody(light)
    way = Way(light.o, light.d, hit.t, light.medium, light.times)
    flight = flown(pilot, way._replace(length=hit.t))
    # Light sampling knows what is left on the way from the lamp; further ways are left to chance.
    left = transmittance(pilot, way._replace(length=flight.t))
    # On a grid it knows that by ratio tracking, which may leave nothing of light that has passed.
    known = ~light.turned & (light.medium != 0) & (dots(light.radiance, left) > 0.0)
    seen = np.where(known[:, None], left, flight.weight)
    share = np.where(known, _quotient(light.radiance, flight.weight, left), 1.0)
    radiance = light.radiance * seen * flight.albedo
    on = light._replace(radiance=radiance, share=light.share * share)
    passed = ~flight.scattered & np.isfinite(hit.t)
    return on.some(passed), picked(hit, passed), _in_clouds(pilot, on, flight)


def _quotient(radiance: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Radiance times a over radiance times b, channels added."""
    below = dots(radiance, b)
    return np.where(below > 0.0, dots(radiance, a) / np.where(below > 0.0, below, 1.0), 0.0)


def _in_clouds(pilot: Pilot, light: _Light, flight: Flown) -> _Light:
    """Light that has collided, on its way on."""
    # What is absorbed, the others stand for.
    left = np.minimum(flight.albedo.max(axis=1), 1.0)
    there = flight.scattered & (pilot.random.random(len(left)) < left)
    light = light._replace(share=light.share / np.where(there, left, 1.0)).some(there)
    t = flight.t[there]
    n = len(t)
    if not n:
        return light
    d, phase = turned_by_media(pilot, light.medium, light.d, light.times, np.full(n, True))
    o = Vec3(light.o.x + t * light.d.x, light.o.y + t * light.d.y, light.o.z + t * light.d.z)
    led = _led(pilot, light, light.way + t, o)
    both = np.where(light.turned, phase, led + np.where(light.sized, phase, 0.0))
    seen = np.where(both > 0.0, phase / np.where(both > 0.0, both, 1.0), 0.0)
    share = np.where(seen > 0.0, 1.0 / np.where(seen > 0.0, seen, 1.0), 0.0)
    return light._replace(
        o=o,
        d=d,
        radiance=light.radiance * seen[:, None],
        share=light.share * share,
        turns=light.turns + 1,
    )


def _scattered(
    pilot: Pilot, light: _Light, way: np.ndarray, surface: Surface, wl: Vec3, turns: Turns
) -> tuple[np.ndarray, np.ndarray]:
    """L' / L, shape (n, 3), and G' / G of light that a surface turns."""
    n, tables = len(light.share), pilot.at(light.times)
    there = np.full(n, True)
    wo = lanes_of(pilot.twin(to_local)(surface, turns.d), n)
    f_cos, reverse = pilot.twin(evaluate_bsdf)(tables, surface, wo, wl, there)
    f_cos, reverse = columns_of(lanes_of(f_cos, n)), wide(reverse, n).astype(np.float64)
    led = _led(pilot, light, way, lanes_of(surface.p, n))
    both = np.where(light.turned, 0.0, led) + np.where(light.turned | light.sized, reverse, 0.0)
    cosines = np.abs(wo.z.astype(np.float64)) / np.maximum(np.abs(wide(wl.z, n)), 1e-6)
    scatters = (turns.pdf > 0.0) & (both > 0.0) & ((turns.flags & DELTA) == 0)
    seen = np.where(scatters[:, None], f_cos / np.where(scatters, both, 1.0)[:, None], 0.0)
    share = np.where(scatters, cosines * both / np.where(scatters, turns.pdf, 1.0), 0.0)
    straight = (turns.pdf > 0.0) & ~scatters & ((turns.flags & DELTA) != 0)
    seen = np.where(straight[:, None], turns.reversed_weight, seen)
    return np.nan_to_num(seen), np.where(straight, turns.spreading, share)


def _led(pilot: Pilot, light: _Light, way: np.ndarray, p: Vec3) -> np.ndarray:
    """P p_l at places so far from the lamp."""
    zeros = no_emission(None, None, None, None, None)
    start = zeros._replace(light=light.lamp, prim=light.prim, n=light.normal)
    way = way.astype(np.float32)
    led = pilot.twin(direct_density)(pilot.at(light.times), start, p, light.d, way)
    led = np.nan_to_num(wide(led, len(way)).astype(np.float64))
    alone = np.flatnonzero(~light.sized & ~light.turned)
    if len(alone):
        led[alone] = _chosen(pilot, light.some(alone), picked(p, alone))
    # What lamps without a size bring is over their probability alone, and falls with the distance.
    return np.where(light.near, led * way.astype(np.float64) ** 2, led)


def _chosen(pilot: Pilot, light: _Light, p: Vec3) -> np.ndarray:
    """Probability of light sampling at p to choose lamps without a size."""
    lights = pilot.tables.lights
    own = lights.data.array[light.lamp * STRIDE + 3].astype(np.float64)
    if not pilot.program.light_tree:
        return own
    tables = pilot.tables._replace(lights=with_ways(lights))
    placed = Pilot(pilot.scene, pilot.random, tables).at(light.times)
    inner = own == 0.0
    by_tree = pilot.twin(mis_probability)(placed, light.lamp, np.uint32(0), p, inner)
    return np.where(inner, wide(by_tree, len(own)), own)
