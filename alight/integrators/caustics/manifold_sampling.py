r"""Caustics by specular manifold sampling, without bias whatever the quality of its walks.

At a place x that scatters light, directions :math:`\omega` are wanted whose chain of mirrors and
glass leads to a small lamp. A *search* draws a seed as the BSDF would, follows it along a chain of
some type, and walks from there to a solution s, around which an ellipse of directions leads to the
lamp (`alight.integrators.caustics.manifold_walk`). A direction :math:`\omega` is drawn uniformly
from it, with the density :math:`p_s(\omega)`.

The density of all this, :math:`p(\omega) = \operatorname E_s[p_s(\omega)]`, is an integral over
seeds that nobody knows; but one over it can be estimated. Let M bound :math:`p_s(\omega)`. Searches
are repeated, and each is taken with the probability :math:`p_s(\omega) / M`; the number n of
searches until one is taken has the mean :math:`M / p(\omega)`, so that

.. math:: \frac{n}{M}\, f(\omega)\, |\cos\theta|\, T(\omega)\, L_e, \qquad
    \operatorname E \Big[\frac nM\Big] = \frac{1}{p(\omega)},

is an unbiased estimate of the light from all :math:`\omega` that can be drawn; T is what the chain
leaves of the light.

Paths find the same lamps by chance. A direction is *covered* if a walk that starts from
:math:`\omega` itself ends at a solution s' whose ellipse holds it (:math:`q_{s'}(\omega) \le 1`).
Light from covered directions is what the estimate above counts, all other light is counted where
paths find it. Both ask the same function of the direction, so nothing is missed or counted twice;
what walks are worth decides the noise alone. The estimate needs covered directions to have a
density: seeds near :math:`\omega` end near s', and the ellipse that is drawn from is a little
larger. :math:`M = \kappa p_{s'}(\omega)`; solutions with a larger density count as if it was M: a
direction that was drawn from one is kept with the probability :math:`M / p_s(\omega)`.

Source: Zeltner, Georgiev and Jakob, Specular manifold sampling, SIGGRAPH 2020; Hanika, Droske and
Fascione, Manifold next event estimation, EGSR 2015; Booth, Unbiased Monte Carlo estimation of the
reciprocal of an integral, Nuclear Science and Engineering 156 (2007).
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.core.maths import pow
from alight.core.rng import sample_keys
from alight.core.vec import absolute_vec3, max_component
from alight.integrators.caustics.chain_types import turns
from alight.integrators.caustics.manifold_search import PAIRS, Begin, Search, search_lamps
from alight.integrators.caustics.manifold_walk import place_near
from alight.integrators.interiors.body_walk import enters_body
from alight.integrators.interiors.dispersed import meet_dispersion
from alight.integrators.moments import at_times_of
from alight.integrators.walk import gather_light, gather_unguided, to_local
from alight.lights.tables import INFO
from alight.lights.targets import choose_target, far_light, target_at
from alight.media.tables import Stream, step_numbers
from lanewise.jit import kernel
from lanewise.records import local_records, put_records, records_at, replace
from lanewise.simd import (
    LANES,
    any_lane,
    count_bits,
    lane_index,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    mask_bits,
    maximum,
    minimum,
    to_float,
    trailing_zeros,
    where,
)

#: Kappa.
SLACK = 1.2
#: Keys of these random numbers.
SALT = 0x3C6EF372
#: The pair that chooses the lamp and whether it is looked for, and the one of the roulette.
OWN_PAIRS = 2
#: A lamp is looked for at least with this probability, and always on a path as bright as a white
#: one.
LEAST_CHANCE = 0.1
#: So many searches are made for sure; of more, k are made with the probability (LONG / k)^1.5.
LONG, LONG_POWER = 1 << 16, 1.5
#: Room for the widest packet.
ROOM = 16

#: So many searches are made at a time, and count together; fewer where a packet has fewer lanes.
BLOCK = 4

#: What repeated searches need. search: `Search`; type: `Type`; w: Vec3; most: M; number: u32, how
#: many have been made.
Trial = namedtuple("Trial", "search type w most number")


@kernel
def _stream(path):
    """Random numbers of the next vertex."""
    a, b = sample_keys(path.sampler.a, path.sampler.b, path.sampler.index)
    a, b = sample_keys(a ^ SALT, b, path.depth)
    return Stream(a, b, lanes_u32(0))


@kernel
def _share_out(waiting):
    """(whose searches each lane makes, u32; how many lanes they have each) of those that wait.

    waiting: bits of lanes, not 0. The more they are, the fewer lanes has each, down to `BLOCK`.
    """
    width = 1 * LANES
    while width > BLOCK and LANES // width < count_bits(waiting):
        width = width // 2
    owner, first = lanes_u32(0), 0
    while first < LANES and waiting != 0:
        owner = where(lane_index() >= first, lanes_u32(trailing_zeros(waiting)), owner)
        waiting &= waiting - 1
        first += width
    return owner, width


@kernel
def _again(trial, width):
    """(`Search`, `Begin`) of the next `width` searches of each trial, one in each lane."""
    number = trial.number + (lane_index() & (width - 1))
    every = lanes_mask(True)
    begin = Begin(every, ~every, every, trial.w, trial.w, trial.type)
    return replace(trial.search, first=OWN_PAIRS + (number + 1) * PAIRS), begin


@kernel
def _counted(waiting, width, taken, made, number, stop):
    """(waiting, made, number) after one more round of searches; bits of lanes: waiting and taken.

    made: one over the density, so far, in searches. Of a block of n searches, k of which are taken,
    the first one that is has the mean number (n + 1) / (k + 1): that is what counts. Nothing
    depends on how many lanes a trial was given.
    """
    owners, first, block = waiting, 0, min(BLOCK, 1 * LANES)
    while first < LANES and owners != 0:
        lane, end = trailing_zeros(owners), first + width
        mine = lane_index() == lane
        owners &= owners - 1
        while first < end:
            if (waiting >> lane) & 1 != 0:
                count = count_bits((taken >> first) & ((1 << block) - 1))
                mean = (block + 1.0) / (count + 1.0) if count != 0 else 1.0 * block
                made = where(mine, made + mean / _going_on(number), made)
                number = where(mine, number + block, number)
                if count != 0 or not any_lane(mine & (stop < _going_on(number))):
                    waiting &= ~(1 << lane)
            first += block
    return waiting, made, number


@kernel
def _is_taken(trial, search, result):
    """Mask: searches are as many as one over the density of the direction, once one is taken."""
    _, density = place_near(result.first, trial.w)
    u, _ = step_numbers(search.stream, search.first + (PAIRS - 1))
    return u * trial.most < density


@kernel
def _is_kept(accept, drawn, most):
    """Mask: a direction counts, of all that are drawn with a density as if `most` was the largest.

    accept: uniform in [0, 1); drawn: the density with which it was.
    """
    return accept * drawn < minimum(drawn, most)


@kernel
def _going_on(number):
    """With which probability search `number` is made."""
    ratio = LONG / maximum(to_float(number), LONG)
    return pow(ratio, lanes(LONG_POWER))


def write_add_caustics(listeners, guided=False):
    """``(scene, settings, path, surface, wo, active, left) -> (path, covered)``.

    Light of lamps behind mirrors and glass is added where active paths scatter it. left: mask,
    paths that have left the scene to the disk that is a target. covered: mask, the light that the
    path has found, on its surface or there, was counted where the path was last scattered.
    `listeners`: kernels of `alight.integrators.contributions`, or nothing in the place of each.
    """
    recorded, find = listeners.find is not None, listeners.find

    @kernel
    def add_caustics(scene, settings, path, surface, wo, active, left):
        """One search a lane; then its repetitions, by all lanes for up to a few at a time."""
        depth, rays = path.depth + 1, path.rays
        shining = surface.light != 0
        given = (left | (active & shining)) & path.chain.known & turns(path.chain.type)
        stream = _stream(path)
        # One more surface and the lamp.
        looking = active & ~shining & (depth + 1 < settings.max_depth)
        chance, u = step_numbers(stream, lanes_u32(0))
        stop, _ = step_numbers(stream, lanes_u32(1))
        probability = minimum(maximum(max_component(absolute_vec3(path.beta)), LEAST_CHANCE), 1.0)
        looking = looking & (chance < probability)
        lamp, chosen = choose_target(scene, u)
        lamp = where(given, where(left, lanes_u32(far_light(scene)), surface.light - 1), lamp)
        target = target_at(scene, lamp)
        given, looking = given & (target.radius > 0.0), looking & (target.radius > 0.0)
        covered = lanes_mask(False)
        if any_lane(given | looking):
            factor, total = lanes_vec3(0.0), lanes(0.0)
            number, edges, width = lanes_u32(0), lanes_u32(0), 1 * LANES
            first = lanes_u32(OWN_PAIRS)
            arrived = meet_dispersion(scene, surface, path, looking)
            search = Search(
                surface=surface, wo=wo, d=path.d, bodies=path.bodies, target=target, stream=stream,
                monochromatic=arrived.monochromatic, sampler=path.sampler, first=first,
                most=lanes_u32(0) + settings.max_depth - depth,
            )  # fmt: skip
            begin = Begin(
                looking, given, lanes_mask(False), path.chain.o, path.chain.d, path.chain.type
            )
            trial = Trial(search, path.chain.type, path.chain.d, lanes(0.0), number)
            memory = local_records(ROOM, trial)
            seen, repeating, going, waiting, mine = scene, False, True, 0, trial
            while going:
                result = search_lamps(seen, search, begin)
                rays += result.rays
                if repeating:
                    bits = mask_bits(_is_taken(trial, search, result))
                    waiting, total, number = _counted(waiting, width, bits, total, number, stop)
                else:
                    # Of a direction by itself: is it covered?
                    w = where(given, path.chain.d, result.w)
                    q, density = place_near(result.second, w)
                    holds = q <= 1.0
                    covered = given & holds
                    # Light from there, if it is and its solution is one that is taken.
                    most = SLACK * density
                    _, drawn = place_near(result.first, w)
                    accept, _ = step_numbers(stream, first + (PAIRS - 1))
                    lit = looking & holds & _is_kept(accept, drawn, most)
                    lit = lit & (max_component(result.found) > 0.0)
                    lit = lit & ~enters_body(scene, surface, w)
                    if any_lane(lit):
                        f_cos, _ = evaluate_bsdf(scene, surface, wo, to_local(surface, w), lit)
                        per_search = 1.0 / (probability * chosen * where(lit, most, 1.0))
                        factor = arrived.beta * f_cos * result.found * per_search
                        lit = lit & (max_component(absolute_vec3(factor)) > 0.0)
                        factor = where(lit, factor, lanes_vec3(0.0))
                    waiting, repeating = mask_bits(lit), True
                    edges = result.edges
                    mine = Trial(search, result.type, w, most, number)
                going = waiting != 0
                if going:
                    # All lanes search for a few.
                    owner, width = _share_out(waiting)
                    put_records(memory, ROOM, 0, owner, replace(mine, number=number))
                    trial = records_at(memory, ROOM, 0, mine)
                    search, begin = _again(trial, width)
                    seen = at_times_of(scene, trial.search.sampler)
            light = factor * total
            path = gather_light(path, light, looking, lanes_mask(False))
            if guided:
                # Searches follow no guide.
                path = gather_unguided(path, light, looking)
            if recorded:
                as_hit = replace(path, delta=lanes_mask(True))
                # What is around the scene is known by its last light.
                last = lanes_u32(scene.lights.info.size // INFO)
                row = where(target.far & ~target.delta, last, lamp + 1)
                find(scene, as_hit, row, depth + edges, looking & (total > 0.0), light)
        return replace(path, rays=rays), covered

    return add_caustics
