"""Chains of mirrors and clear glass: what lies between a surface that scatters light and a lamp.

A chain is known by where it starts, its first direction, and its *type*: whether it is reflected or
transmitted at each of the surfaces that it meets. The rest follows from the scene.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import is_one_model, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL, REFLECTION
from alight.core.constants import INFINITY, ONE_MINUS_EPSILON
from alight.core.vec import dot, length
from alight.integrators.caustics.chain_types import (
    EVENT_BITS,
    EVENT_MASK,
    MOST_EVENTS,
    Chain,
    Type,
    with_event,
)
from alight.integrators.interiors.body_walk import enters_body
from alight.integrators.interiors.dispersed import spreads
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
#: `Stream` of random numbers.
Plan = namedtuple("Plan", "type chance final stream first")

#: What came of it. fine: mask, the chain is possible; type; miss: Vec3, by which the last ray
#: passes the middle of the target, in radii; found: Vec3, radiance of the target that it meets,
#: times all factors on the way. `alight.lights.targets` says what targets are.
Followed = namedtuple("Followed", "fine type miss found rays")


#: A ray on its way: d: Vec3; beta: Vec3, what is left of the light; bodies: `Bodies` around it, or
#: ().
Lit = namedtuple("Lit", "d beta bodies")

#: Where a chain starts: o, d: Vec3, its first ray; bodies: as of `Lit`.
Start = namedtuple("Start", "o d bodies")


@kernel
def _is_followed(scene, surface):
    """Mask: one delta model, whose directions are the same at all wavelengths."""
    return is_one_model(scene, surface) & ~spreads(scene, surface)


@kernel
def extended(scene, chain, surface, o, d, flags):
    """The chain of a path with one more vertex; o, d: ray from there; flags: of `BsdfSample`."""
    smooth = (flags & (DELTA | NULL)) == 0
    turned = ((flags & NULL) == 0) & _is_followed(scene, surface)
    type = with_event(chain.type, flags & EVENT_MASK)
    longer = Chain(chain.o, chain.d, type, chain.known & turned & (type.count <= MOST_EVENTS))
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
    o, d, bodies = start
    chance, half = plan.chance, (lanes(0.5), lanes(0.5))
    type, none = plan.type, lanes_u32(0)
    passed, taken, total = Type(none, none), Type(none, none), lanes(0.0)
    beta, found, miss = lanes_vec3(1.0), lanes_vec3(0.0), lanes_vec3(0.0)
    fine, going, rays = lanes_mask(False), active, 0
    while any_lane(going):
        rays += count_lanes(going)
        hit = intersect_closest(scene, o, d, lanes(INFINITY), going)
        met = going & (hit.t < INFINITY)
        surface = make_surface(scene, hit, o, d, met)
        wo = to_local(surface, -d)
        last = going & ~chance & (passed.count == type.count)
        t, of_point = end_at_point(scene, target, o, d, hit.t, last)
        # Dimmed by the body that the ray crossed.
        ray = come_to(scene, Lit(d, beta, bodies), surface, t, met, met | (last & target.delta))
        beta, bodies = ray.beta, ray.bodies
        found = where(last & target.delta, beta * of_point, found)
        # The end of the chain: is it the target?
        arrived = met & last
        if any_lane(arrived):
            shines = arrived & (surface.light == target.light + 1)
            found = where(shines, beta * emitted(scene, surface, -d), found)
        left = last & ~met & ~target.delta
        found = where(left, beta * found_beyond(scene, target, d, left), found)
        # One more mirror or piece of glass.
        turning = met & ~arrived
        u, choice = step_numbers(plan.stream, plan.first + passed.count)
        wanted = (type.events >> (EVENT_BITS * passed.count)) & EVENT_MASK
        # Models reflect at the lower numbers and transmit at the upper ones.
        u = where(chance, u, where(wanted == REFLECTION, 0.0, ONE_MINUS_EPSILON))
        sample = sample_bsdf(scene, surface, wo, u, half, turning)
        kind = sample.flags & EVENT_MASK
        turned = turning & ((sample.flags & (DELTA | NULL)) == DELTA) & (sample.pdf > 0.0)
        turned = turned & _is_followed(scene, surface) & (chance | (kind == wanted))
        w = to_world(surface, sample.wi)
        bodies = where(turned, bodies_beyond(scene, bodies, surface, d, w), bodies)
        o = where(turned, spawn_origin(surface.p, surface.error, surface.ng, w), o)
        d = where(turned, w, d)
        beta = where(turned, beta * (sample.weight * sample.pdf), beta)
        passed = where(turned, with_event(passed, kind), passed)
        # By how much it would miss the target from here.
        by, angle = _miss_of(o, d, target)
        weight = 1.0 / angle
        total = where(turned, total + weight, total)
        chosen = turned & chance & (choice * total < weight)
        taken = where(chosen, passed, taken)
        complete = turned & ~chance & (passed.count == type.count)
        miss = where(chosen | complete, by, miss)
        fine = fine | chosen | complete
        more = where(chance, passed.count < MOST_EVENTS, ~complete | plan.final)
        going = turned & more
    return Followed(fine, where(chance, taken, type), miss, found, rays)
