"""Chains of mirrors and clear glass: what lies between a surface that scatters light and a lamp.

A chain is known by where it starts, its first direction, and its *type*: whether it is reflected or
transmitted at each of the surfaces that it meets. The rest follows from the scene.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import open_share
from alight.bsdfs.flags import DELTA, LAYER, NULL
from alight.bsdfs.specular import (
    EVENT_BITS,
    EVENT_MASK,
    MOST_LAYERS,
    event_of,
    is_only_open,
    sample_event,
)
from alight.core.constants import INFINITY
from alight.core.vec import dot, length, max_component
from alight.integrators.caustics.chain_types import (
    MOST_EVENTS,
    Chain,
    Type,
    turns,
    with_event,
)
from alight.integrators.interiors.body_walk import enters_body
from alight.integrators.interiors.dispersed import at_wavelength_of, meet_dispersion
from alight.integrators.interiors.enclosing import bodies_beyond, come_to
from alight.integrators.walk import count_lanes, to_local, to_world
from alight.lights.hits import emitted
from alight.lights.targets import end_at_point, found_beyond, radius_at, way_to
from alight.media.tables import step_numbers
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.simd import any_lane, lanes, lanes_mask, lanes_u32, lanes_vec3, minimum, where

#: How chains are followed. type: of those that are given; chance: mask, the others choose events;
#: final: mask, what the last ray meets is looked at; first: u32, number of the first pair in the
#: `Stream` of random numbers; most: u32, edges that light may have that is found.
Plan = namedtuple("Plan", "type chance final stream first most")

#: What came of it. fine: mask, the chain is possible; type; miss: Vec3, by which the last ray
#: passes the middle of the target, in radii; found: Vec3, radiance of the target that it meets,
#: times all factors on the way; edges: u32, how many there are to it. `alight.lights.targets` says
#: what targets are.
Followed = namedtuple("Followed", "fine type miss found edges rays")


#: Most edges of a chain: it may pass many leaves and other surfaces with holes.
MOST_EDGES = 64

#: A ray on its way: d: Vec3; beta: Vec3, what is left of the light; bodies: `Bodies` around it, or
#: (); monochromatic, sampler: as of its path.
Lit = namedtuple("Lit", "d beta bodies monochromatic sampler")

#: Where a chain starts: o, d: Vec3, its first ray; the others: as of `Lit`.
Start = namedtuple("Start", "o d bodies monochromatic sampler")


@kernel
def extended(scene, chain, surface, o, d, flags):
    """The chain of a path with one more vertex; o, d: ray from there; flags: of `BsdfSample`."""
    smooth = (flags & (DELTA | NULL)) == 0
    event = (flags >> LAYER) < MOST_LAYERS
    type = with_event(chain.type, event_of(flags))
    longer = Chain(chain.o, chain.d, type, chain.known & event & (type.count <= MOST_EVENTS))
    passed = ((flags & NULL) != 0) & is_only_open(scene, surface)
    longer = where(passed, chain, longer)
    none = lanes_u32(0)
    outside = ~enters_body(scene, surface, d)
    # Lamps themselves are no places from which chains are looked for.
    begun = Chain(o, d, Type(none, none), (surface.light == 0) & outside)
    return where(smooth, begun, longer)


@kernel
def _miss_of(o, d, target):
    """(by how much, as a Vec3 in radii; angle) a ray passes the middle of the target."""
    to = way_to(target, o)
    along = dot(to, d)
    ahead = along > 0.0
    miss = where(ahead, to - along * d, to)
    distance = length(to)
    radius = radius_at(target, distance)
    angle = where(ahead, (length(miss) + radius) / distance, 1.0)
    return miss * (1.0 / radius), minimum(angle, 1.0)


@kernel
def follow(scene, start, target, plan, active):
    """Follow chains from their `Start`s; gives what came of it, `Followed`.

    Where events are chosen, each as its BSDF has it, a chain goes on until nothing is left to
    choose; then one of its beginnings is taken, those that lead near the target more often.
    """
    o, d, bodies = start.o, start.d, start.bodies
    monochromatic, sampler = start.monochromatic, start.sampler
    chance, type, none = plan.chance, plan.type, lanes_u32(0)
    passed, taken, total = Type(none, none), Type(none, none), lanes(0.0)
    beta, found, miss = lanes_vec3(1.0), lanes_vec3(0.0), lanes_vec3(0.0)
    fine, going, rays = lanes_mask(False), active, 0
    edges, edges_found = none, none
    while any_lane(going):
        edges = edges + 1
        rays += count_lanes(going)
        hit = intersect_closest(scene, o, d, lanes(INFINITY), going)
        met = going & (hit.t < INFINITY)
        surface = at_wavelength_of(make_surface(scene, hit, o, d, met), sampler)
        wo = to_local(surface, -d)
        last = going & ~chance & (passed.count == type.count)
        t, of_point = end_at_point(scene, target, o, d, hit.t, last)
        # Dimmed by the body that the ray crossed.
        ray = Lit(d, beta, bodies, monochromatic, sampler)
        ray = come_to(scene, ray, surface, t, met, met | (last & target.delta))
        # The end of the chain: is it the target? A lamp may be met again behind its own holes.
        light = where(last & target.delta, ray.beta * of_point, lanes_vec3(0.0))
        arrived = met & last
        if any_lane(arrived):
            shines = arrived & (surface.light == target.light + 1)
            light = where(shines, ray.beta * emitted(scene, surface, -d), light)
        left = last & ~met & ~target.delta
        light = where(left, ray.beta * found_beyond(scene, target, d, left), light)
        light = where(edges <= plan.most, light, lanes_vec3(0.0))
        found = where(last, found + light, found)
        edges_found = where(
            edges_found == 0, where(max_component(light) > 0.0, edges, none), edges_found
        )
        ray = meet_dispersion(scene, surface, ray, met)
        beta, bodies, monochromatic = ray.beta, ray.bodies, ray.monochromatic
        # Straight on, where nothing else could come of it.
        straight = met & is_only_open(scene, surface) & (edges < MOST_EDGES)
        if any_lane(straight):
            beta = where(straight, beta * open_share(scene, surface, straight), beta)
            bodies = where(straight, bodies_beyond(scene, bodies, surface, d, d), bodies)
            o = where(straight, spawn_origin(surface.p, surface.error, surface.ng, d), o)
        # One more mirror or piece of glass.
        turning = met & ~arrived & ~straight
        u, choice = step_numbers(plan.stream, plan.first + passed.count)
        wanted = (type.events >> (EVENT_BITS * passed.count)) & EVENT_MASK
        sample = sample_event(scene, surface, wo, u, wanted, chance, turning)
        event = event_of(sample.flags)
        turned = turning & ((sample.flags & DELTA) != 0) & (sample.pdf > 0.0)
        turned = turned & (chance | (event == wanted))
        w = to_world(surface, sample.wi)
        bodies = where(turned, bodies_beyond(scene, bodies, surface, d, w), bodies)
        o = where(turned, spawn_origin(surface.p, surface.error, surface.ng, w), o)
        d = where(turned, w, d)
        beta = where(turned, beta * (sample.weight * sample.pdf), beta)
        passed = where(turned, with_event(passed, event), passed)
        # By how much it would miss the target from here.
        by, angle = _miss_of(o, d, target)
        weight = 1.0 / angle
        ends = turned & turns(passed)
        total = where(ends, total + weight, total)
        chosen = ends & chance & (choice * total < weight)
        taken = where(chosen, passed, taken)
        complete = turned & ~chance & (passed.count == type.count)
        miss = where(chosen | complete, by, miss)
        fine = fine | chosen | complete
        more = where(chance, passed.count < MOST_EVENTS, ~complete | plan.final)
        going = straight | (turned & more)
    return Followed(fine, where(chance, taken, type), miss, found, edges_found, rays)
