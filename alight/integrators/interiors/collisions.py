"""What happens to paths in media: they collide, meet light there, and turn by a phase function.

Programs without media have kernels that do nothing in their place.
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.flags import DELTA
from alight.bsdfs.model import BsdfValue
from alight.integrators.guided import evaluate_at_surface, is_guided, sample_at_surface
from alight.integrators.interiors.enclosing import dimmed, left_along
from alight.integrators.interiors.volume_walk import FREE_FLIGHT, mean
from alight.integrators.walk import gather_light, gather_unguided, vertex_dimension
from alight.media.sampling import evaluate_phase, fly, sample_phase
from alight.media.tables import EMISSIVE, Segment, stream_of
from alight.media.voxels import emission
from alight.samplers.sampling import get_1d
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, lanes_mask, lanes_u32, lanes_vec3, where

#: Where a path goes on: direction d (unit, in the world), weight of its throughput, density per
#: steradian, and whether a delta lobe chose it.
Turn = namedtuple("Turn", "d weight pdf delta")


@specialised
def pass_media(program):
    """``(scene, path, t) -> (path, scattered, t)``: collide before the surface at t, or do not.

    The path that comes back is one step on, with its throughput and densities up to there.
    """
    return _fly if program.media else _pass_nothing


@kernel
def _pass_nothing(scene, path, t):
    return replace(path, steps=path.steps + 1), lanes_mask(False), t


@kernel
def _fly(scene, path, t):
    first = path.steps == 0
    medium = where(first, lanes_u32(0) + scene.media.start[0], path.medium)
    within = path.active & (medium != 0)
    path, scattered = replace(path, medium=medium), lanes_mask(False)
    if any_lane(within):
        u = get_1d(path.sampler, vertex_dimension(path.steps + 1) + FREE_FLIGHT)
        stream = stream_of(path.sampler, 2 * path.steps)
        segment = Segment(path.o, path.d, t, medium, path.channel, stream)
        flight = fly(scene, segment, u, within)
        scattered = within & flight.scattered
        t = where(scattered, flight.t, t)
        path = replace(
            path,
            beta=where(within, path.beta * flight.factor, path.beta),
            ours=where(within, path.ours * flight.factor, path.ours),
            lights=where(within, path.lights * flight.light, path.lights),
        )
        path = shine(scene, path, t, flight.albedo, scattered)
        path = replace(path, beta=where(scattered, path.beta * flight.albedo, path.beta))
    return replace(path, steps=path.steps + 1), scattered, t


@specialised
def shine(program):
    """``(scene, path, t, albedo, scattered) -> path``: with the light that the medium emits at t.

    A collision is an absorption with the probability 1 - albedo; absorbed is what is emitted, times
    the medium's emission (Kirchhoff). No other strategy finds this light.
    """
    if EMISSIVE not in program.media:
        return _stay_dark
    guided = is_guided(program)

    @kernel
    def shine(scene, path, t, albedo, scattered):
        Le = emission(scene, where(scattered, path.medium, 0), path.o + t * path.d)
        absorbed = lanes_vec3(1.0) - albedo
        left = left_along(path.bodies, t, scattered)
        emitted = dimmed(path.beta * absorbed * Le, left) * (1.0 / mean(path.ours))
        path = gather_light(path, emitted, scattered, path.depth <= 1)
        if guided:
            path = gather_unguided(path, emitted, scattered)
        return path

    return shine


@kernel
def _stay_dark(scene, path, t, albedo, scattered):
    return path


@specialised
def turn_in_medium(program):
    """``(scene, path, u2, scattered, turn) -> turn``: by the phase function where `scattered`."""
    return _turn if program.media else _keep_turn


@kernel
def _keep_turn(scene, path, u2, scattered, turn):
    return turn


@kernel
def _turn(scene, path, u2, scattered, turn):
    if any_lane(scattered):
        wi, density = sample_phase(scene, path.medium, path.d, u2, scattered)
        turn = where(scattered, Turn(wi, lanes_vec3(1.0), density, lanes_mask(False)), turn)
    return turn


@specialised
def phase_towards_light(program):
    """``(scene, path, wi, scattered, f, pdf) -> (f, pdf)``: the phase function in their place."""
    return _towards_light if program.media else _keep_values


@kernel
def _keep_values(scene, path, wi, scattered, f, pdf):
    return f, pdf


@kernel
def _towards_light(scene, path, wi, scattered, f, pdf):
    if any_lane(scattered):
        density = evaluate_phase(scene, path.medium, path.d, wi, scattered)
        f = where(scattered, lanes_vec3(1.0) * density, f)
        pdf = where(scattered, density, pdf)
    return f, pdf


# ---------------------------------------------------------------- with a guide


@kernel
def sample_anywhere(scene, path, vertex, u, u2):
    """As `sample_at_surface`; by the phase function where paths collided."""
    collided = vertex.collided
    found, w = sample_at_surface(
        scene, replace(path, active=path.active & ~collided), vertex, u, u2
    )
    turn = Turn(w, found.weight, found.pdf, (found.flags & DELTA) != 0)
    turn = turn_in_medium(scene, path, u2, path.active & collided, turn)
    flags = where(collided, lanes_u32(0), found.flags)
    return replace(found, weight=turn.weight, pdf=turn.pdf, flags=flags), turn.d


@kernel
def evaluate_anywhere(scene, path, vertex, w, wi, active):
    """As `evaluate_at_surface`; the phase function where paths collided."""
    collided = vertex.collided
    f, pdf = evaluate_at_surface(scene, path, vertex, w, wi, active & ~collided)
    return BsdfValue(*phase_towards_light(scene, path, w, active & collided, f, pdf))
