"""From places to directions that lead to a lamp: seeds, walks, and directions near their ends.

Lanes are at different stages of their searches, but each round of the loop follows one chain in all
of them: so rays are traced in one place, which the compiler sees once.

A search begins with a direction that the BSDF draws (`SEED`), whose chain is chosen on the way, or
with one that is given, with its type (`GIVEN`). The first one ends with a direction near the
solution and with what its ray meets; then, or at once if it was given, a second walk starts from
that direction itself.
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.dispatch import is_mixed, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.core.frame import frame_from_normal
from alight.core.maths import exp, log
from alight.core.vec import length, max_component, normalize
from alight.core.warps import direction_around_z
from alight.integrators.caustics.chain_types import MOST_EVENTS
from alight.integrators.caustics.manifold_walk import (
    LEAST_SHARE,
    MOST_TRIES,
    axes_of,
    bent_by,
    direction_at,
    draw_near,
    is_near,
    is_nearer,
    no_solution,
    no_walker,
    solution_at,
    starting_at,
    step_from,
    straight,
    updated,
)
from alight.integrators.caustics.specular_chain import Plan, Start, follow
from alight.integrators.interiors.body_walk import enters_body
from alight.integrators.interiors.enclosing import bodies_beyond
from alight.integrators.walk import to_world
from alight.lights.photons import way_of_photon
from alight.lights.targets import radius_at, way_to, way_to_caster
from alight.media.tables import step_numbers
from alight.shapes.hit import spawn_origin
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    where,
)

#: Stages of a search.
SEED, GIVEN, BY_U, BY_V, TRY, BY_U_AGAIN, BY_V_AGAIN, AHEAD, BEHIND, HIT, ENDED = range(11)
#: Pairs of random numbers of a search: those of the BSDF and of the direction near the solution,
#: then one an event.
OWN_PAIRS = 3
PAIRS = OWN_PAIRS + MOST_EVENTS + 1
#: Differences of directions are half of the lamp's radius as seen from where the chain starts, but
#: within these bounds.
LEAST_STEP, MOST_STEP = 1e-4, 1e-2

#: Parts of the seeds that go about the lamp, and towards mirrors and clear glass; the others go as
#: the BSDF has it.
AIMED, CASTING = 0.45, 0.2
#: Part of the seeds that follow a photon, where one is near; the others are as everywhere.
FOLLOWING = 0.75
#: How near to the lamp's middle the former go at least, as 1 - cos.
LEAST_TURN = 1e-7

#: What is looked for, and from where. surface, wo: as of `sample_bsdf`; d, bodies: the ray that
#: has come there, and the `Bodies` that it came in, or (); monochromatic, sampler: of the path
#: there; target: `Target`; stream: `Stream`; first: u32, the first pair of the search; most: u32,
#: edges of chains that are worth it.
Search = namedtuple("Search", "surface wo d bodies monochromatic sampler target stream first most")

#: How a search begins. seed, given: masks; once: mask, the first solution is all; o, w: Vec3, ray
#: of those that are given; type: `Type`, of those that are given, and asked for `once`.
Begin = namedtuple("Begin", "seed given once o w type")

#: What it has found. first, second: `Solution`; type; w: Vec3, the direction that was drawn; found:
#: Vec3, and edges, as of `Followed`; rays.
Result = namedtuple("Result", "first second type w found edges rays")


@kernel
def _towards(search, u, v):
    """A direction about that of the target; the logarithm of its distance is uniform."""
    to = way_to(search.target, search.surface.p)
    distance = maximum(length(to), 1e-20)
    axis = to * (1.0 / distance)
    # 1 - cos, from the edge of the target to the other side of the world.
    size = minimum(radius_at(search.target, distance) / distance, 1.0)
    least = maximum(0.5 * size * size, LEAST_TURN)
    local = direction_around_z(minimum(least * exp(u * log(2.0 / least)), 2.0), v)
    s, t = frame_from_normal(axis)
    return normalize(local.x * s + local.y * t + local.z * axis)


@kernel
def _seeds(scene, search, begin):
    """(mask, o, w): where searches start."""
    surface = search.surface
    choice, x = step_numbers(search.stream, search.first)
    y, way = step_numbers(search.stream, search.first + 1)
    sample = sample_bsdf(scene, surface, search.wo, choice, (x, y), begin.seed)
    smooth = (sample.flags & (DELTA | NULL)) == 0
    known, back = way_of_photon(scene, surface.p, search.target.light, x)
    following = known & (way < FOLLOWING)
    way = where(known & ~following, (way - FOLLOWING) * (1.0 / (1.0 - FOLLOWING)), way)
    aimed = ~following & (way < AIMED)
    rest = (way - AIMED) * (1.0 / CASTING)
    there, to = way_to_caster(scene, surface.p, choice, (x, y, minimum(rest, 1.0)))
    distance = length(to)
    casting = there & ~following & ~aimed & (rest < 1.0) & (distance > 0.0)
    freely = following | aimed | casting
    scattered = begin.seed & (
        (smooth & (sample.pdf > 0.0)) | (freely & (smooth | is_mixed(scene, surface)))
    )
    w = where(aimed, _towards(search, x, y), to_world(surface, sample.wi))
    w = where(casting, to * (1.0 / where(casting, distance, 1.0)), w)
    w = where(following, normalize(back), w)
    o = spawn_origin(surface.p, surface.error, surface.ng, w)
    scattered = scattered & ~enters_body(scene, surface, w)
    return (
        scattered | begin.given, where(begin.given, begin.o, o), where(begin.given, begin.w, w),
    )  # fmt: skip


@kernel
def search_lamps(scene, search, begin):
    """The `Result` of searches."""
    active, o, w = _seeds(scene, search, begin)
    stage = where(active, where(begin.given, lanes_u32(GIVEN), lanes_u32(SEED)), lanes_u32(ENDED))
    walker = replace(no_walker(), middle=w)
    first, second = no_solution(), no_solution()
    type, found = begin.type, lanes_vec3(0.0)
    drawn, late, rays, edges = w, begin.given, 0, lanes_u32(0)
    open_ahead = lanes_mask(False)
    target = search.target
    distance = maximum(length(way_to(target, o)), 1e-20)
    size = 0.5 * radius_at(target, distance) / distance
    h = minimum(maximum(size, LEAST_STEP), MOST_STEP)
    near = step_numbers(search.stream, search.first + 2)
    while any_lane(stage != ENDED):
        # The direction that each stage asks about.
        at_u = (stage == BY_U) | (stage == BY_U_AGAIN)
        at_v = (stage == BY_V) | (stage == BY_V_AGAIN)
        trying = stage == TRY
        ahead, behind = stage == AHEAD, stage == BEHIND
        axes = axes_of(walker)
        aside = where(ahead, axes.look, where(behind, -axes.look, 0.0))
        u = walker.u + where(trying, walker.share * walker.du, where(at_u, h, aside * axes.x))
        v = walker.v + where(trying, walker.share * walker.dv, where(at_v, h, aside * axes.y))
        w = direction_at(walker, u, v)
        first_pair = search.first + OWN_PAIRS
        plan = Plan(type, stage == SEED, stage == HIT, search.stream, first_pair, search.most)
        around = bodies_beyond(scene, search.bodies, search.surface, search.d, w)
        start = Start(o, w, around, search.monochromatic, search.sampler)
        seen = follow(scene, start, target, plan, stage != ENDED)
        rays += seen.rays
        fine, going = seen.fine, lanes_mask(False)

        # Where a walk starts.
        starts = stage == SEED
        wanted = ~begin.once | (
            (seen.type.events == begin.type.events) & (seen.type.count == begin.type.count)
        )
        type = where(starts & fine, seen.type, type)
        hits = stage == HIT
        found = where(hits & fine, seen.found, found)
        edges = where(hits & fine, seen.edges, edges)
        begun = (starts & wanted) | (stage == GIVEN)
        begun = fine & (begun | (hits & (max_component(seen.found) > 0.0)))
        walker = where(begun, starting_at(w, seen.miss), walker)
        next_stage = where(begun, lanes_u32(BY_U), lanes_u32(ENDED))

        # Derivatives.
        slope = (seen.miss - walker.miss) * (1.0 / h)
        walker = replace(
            walker, by_u=where(at_u, slope, walker.by_u), by_v=where(at_v, slope, walker.by_v)
        )
        next_stage = where(at_u & fine, stage + 1, next_stage)
        known = at_v & fine

        # A step that was tried.
        du, dv = walker.share * walker.du, walker.share * walker.dv
        by_u, by_v = updated(walker, du, dv, seen.miss)
        took = trying & fine & is_nearer(walker, seen.miss)
        updates = trying & fine
        walker = replace(
            walker, by_u=where(updates, by_u, walker.by_u), by_v=where(updates, by_v, walker.by_v),
            u=where(took, u, walker.u), v=where(took, v, walker.v),
            miss=where(took, seen.miss, walker.miss),
            tries=walker.tries + where(trying, lanes(1.0), 0.0),
            share=where(took, minimum(2.0 * walker.share, 1.0), 0.5 * walker.share),
        )  # fmt: skip
        walker = replace(walker, share=where(trying, walker.share, 1.0))
        arrived = took & is_near(walker.miss)
        # Derivatives once more, about where it has arrived.
        there = starting_at(w, walker.miss)
        walker = where(arrived, there, walker)
        next_stage = where(arrived, lanes_u32(BY_U_AGAIN), next_stage)
        lost = (walker.tries >= MOST_TRIES) | (walker.share < LEAST_SHARE)
        going = (trying & ~arrived & ~lost) | (known & (stage == BY_V) & ~is_near(walker.miss))
        du, dv = step_from(walker)
        walker = replace(walker, du=where(going, du, walker.du), dv=where(going, dv, walker.dv))
        next_stage = where(going, lanes_u32(TRY), next_stage)

        # Solutions: of slender ones it is asked how they are bent.
        solved, axes = known & ~going, axes_of(walker)
        asked = solved & axes.slender
        next_stage = where(asked, lanes_u32(AHEAD), next_stage)
        walker = replace(walker, ahead=where(ahead, seen.miss, walker.ahead))
        open_ahead = (open_ahead & ~ahead) | (ahead & fine)
        next_stage = where(ahead, lanes_u32(BEHIND), next_stage)
        bent = bent_by(walker, axes, seen.miss, fine & open_ahead)
        solution = solution_at(walker, axes, where(behind, bent, straight()))
        solved = (solved & ~asked) | behind
        second = where(solved & late, solution, second)
        first = where(solved & ~late, solution, first)
        draws = solved & ~late & ~begin.once & (solution.density > 0.0)
        drawn = where(draws, draw_near(solution, near), drawn)
        surface = search.surface
        o = where(draws, spawn_origin(surface.p, surface.error, surface.ng, drawn), o)
        walker = where(draws, replace(no_walker(), middle=drawn), walker)
        next_stage = where(draws, lanes_u32(HIT), next_stage)
        late = late | hits
        stage = where(stage == ENDED, stage, next_stage)
    return Result(
        first=first, second=second, type=type, w=drawn, found=found, edges=edges, rays=rays
    )
