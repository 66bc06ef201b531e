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

How bright a patch is and how often it is met follow from there as they do for mirrors. Media are
neglected, and scenes that have some are not looked at.

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
from alight.rendering.pilot_rays import (
    MOST_SURFACES,
    Pilot,
    Turns,
    columns_of,
    dots,
    lanes_of,
    picked,
    wide,
)
from alight.rendering.sight import Sight
from alight.shapes.hit import Surface

#: Light paths.
PATHS = 2**14

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
    turned : (n,) bool
        Whether a surface has scattered it.
    times : (n,) float32
    lamp, prim : (n,) int
        Row of the lamp, and triangle of its mesh.
    normal : Vec3
        Of the lamp.
    near, sized : (n,) bool
        Whether the lamp is a point; whether it has a size.
    """

    o: Vec3
    d: Vec3
    radiance: np.ndarray
    share: np.ndarray
    turned: np.ndarray
    times: np.ndarray
    lamp: np.ndarray
    prim: np.ndarray
    normal: Vec3
    near: np.ndarray
    sized: np.ndarray

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
    if not scene.program.lights or scene.program.media or longest < _EDGES:
        return None
    if sight.lights is None or not len(sight.seen.point):
        return None
    both = scene.tables._replace(lights=_both(scene.tables.lights, sight.lights))
    lit = Pilot(scene, sight.random(), both)
    mirrors = any(is_caster(bsdf) for bsdf in sight.flat.bsdfs)
    # What light misses is no number.
    with np.errstate(all="ignore"):
        arrived = _follow(lit, _set_out(lit), mirrors, min(longest - _EDGES + 2, MOST_SURFACES))
    if len(arrived.share) < NEAREST:
        return None
    table = gather(lit, sight.seen, arrived)
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
        turned=np.zeros(n, bool),
        times=times,
        lamp=lamp,
        prim=wide(e.prim, n),
        normal=normal,
        near=near,
        sized=~wide(e.delta_position, n) & ~wide(e.delta_direction, n),
    ).some(good)


def _follow(pilot: Pilot, light: _Light, mirrors: bool, most: int) -> Arrived:
    """Where light arrives that a surface has scattered, after at most so many surfaces."""
    found, random = [], pilot.random
    for _ in range(most):
        hit = pilot.hits(light.o, light.d, light.times)
        met = np.isfinite(hit.t)
        light, hit = light.some(met), picked(hit, met)
        n = len(light.share)
        if not n:
            break
        surface, wl = pilot.surface(hit, light.o, light.d, light.times)
        turns = pilot.turns(surface, wl, light.times)
        p, normal = (columns_of(lanes_of(v, n)) for v in (surface.p, surface.ns))
        here = Arrived(p, normal, -columns_of(light.d), light.radiance, light.share)
        found.append(picked(here, light.turned))
        first = ~light.turned & ~turns.holes
        seen, share = _scattered(pilot, light, hit.t, surface, wl, turns)
        # Paths end by chance where they lose light: the others stand for more.
        keep = np.minimum(np.nan_to_num(seen.max(axis=1) * share), 1.0)
        keep = np.where(turns.holes, 1.0, keep)
        on = random.random(n) < keep
        # What mirrors and clear glass turn first is that of `light_off_mirrors`, or straight on.
        on &= ~(first & turns.sharp & (mirrors | ((turns.flags & TRANSMISSION) != 0)))
        light = light._replace(
            o=pilot.leave(surface, turns.d),
            d=turns.d,
            radiance=light.radiance * seen,
            share=light.share * share / np.where(on, keep, 1.0),
            turned=light.turned | first,
        ).some(on)
    return all_of(found)


def _scattered(
    pilot: Pilot, light: _Light, way: np.ndarray, surface: Surface, wl: Vec3, turns: Turns
) -> tuple[np.ndarray, np.ndarray]:
    """L' / L, shape (n, 3), and G' / G of light that a surface turns."""
    n, tables = len(light.share), pilot.at(light.times)
    there = np.full(n, True)
    wo = lanes_of(pilot.twin(to_local)(surface, turns.d), n)
    f_cos, reverse = pilot.twin(evaluate_bsdf)(tables, surface, wo, wl, there)
    f_cos, reverse = columns_of(lanes_of(f_cos, n)), wide(reverse, n).astype(np.float64)
    zeros = no_emission(None, None, None, None, None)
    start = zeros._replace(light=light.lamp, prim=light.prim, n=light.normal)
    led = pilot.twin(direct_density)(tables, start, surface.p, light.d, way)
    led = np.nan_to_num(wide(led, n).astype(np.float64))
    alone = np.flatnonzero(~light.sized & ~light.turned)
    if len(alone):
        led[alone] = _chosen(pilot, light.some(alone), picked(lanes_of(surface.p, n), alone))
    # What lamps without a size bring is over their probability alone, and falls with the distance.
    led = np.where(light.near, led * way.astype(np.float64) ** 2, led)
    both = np.where(light.turned, 0.0, led) + np.where(light.turned | light.sized, reverse, 0.0)
    cosines = np.abs(wo.z.astype(np.float64)) / np.maximum(np.abs(wide(wl.z, n)), 1e-6)
    scatters = (turns.pdf > 0.0) & (both > 0.0) & ((turns.flags & DELTA) == 0)
    seen = np.where(scatters[:, None], f_cos / np.where(scatters, both, 1.0)[:, None], 0.0)
    share = np.where(scatters, cosines * both / np.where(scatters, turns.pdf, 1.0), 0.0)
    straight = (turns.pdf > 0.0) & ~scatters & ((turns.flags & DELTA) != 0)
    seen = np.where(straight[:, None], turns.reversed_weight, seen)
    return np.nan_to_num(seen), np.where(straight, turns.spreading, share)


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
