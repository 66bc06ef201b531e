"""Which medium is it? Flights, crossings and phase functions of any medium of a scene.

Each model runs only if one of the lanes needs it, over all lanes, and is then blended in. Values in
lanes that are not active are arbitrary, but for the crossing of empty space, which is 1.
"""

from __future__ import annotations

from alight.core.frame import frame_from_normal
from alight.core.vec import length_squared
from alight.core.warps import direction_around_z
from alight.media.model import MEDIA
from alight.media.tables import INFO, KIND, PARAMETER, PHASE, STRIDE, Crossing, Flight
from alight.phases.model import PHASES
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, lanes, lanes_mask, lanes_vec3, where


def _models(records, names):
    return [model for name, model in records.items() if name in names]


@kernel
def _kind(scene, medium):
    return gather(scene.media.info, medium * INFO + KIND)


# ---------------------------------------------------------------- distances


@specialised
def fly(program):
    """``(scene, medium, o, d, t_max, channel, u, stream, active) -> Flight``.

    `medium` is a row of the tables, not 0 where active.
    """
    chain = _fly_chain(_models(MEDIA, program.media))

    @kernel
    def fly(scene, medium, o, d, t_max, channel, u, stream, active):
        kind = _kind(scene, medium)
        return chain(scene, medium, kind, o, d, t_max, channel, u, stream, active)

    return fly


def _fly_chain(models):
    if not models:
        return _stay
    own, number, rest = models[0].fly, models[0].number, _fly_chain(models[1:])

    @kernel
    def step(scene, medium, kind, o, d, t_max, channel, u, stream, active):
        result = rest(scene, medium, kind, o, d, t_max, channel, u, stream, active)
        mine = active & (kind == number)
        if any_lane(mine):
            found = own(scene, medium, o, d, t_max, channel, u, stream, mine)
            result = Flight(
                where(mine, found.scattered, result.scattered),
                where(mine, found.t, result.t),
                where(mine, found.factor, result.factor),
                where(mine, found.light, result.light),
                where(mine, found.albedo, result.albedo),
            )
        return result

    return step


@kernel
def _stay(scene, medium, kind, o, d, t_max, channel, u, stream, active):
    one = lanes_vec3(1.0)
    return Flight(lanes_mask(False), lanes(0.0) + t_max, one, one, one)


@specialised
def cross(program):
    """``(scene, medium, o, d, t_max, channel, stream, active) -> Crossing``."""
    chain = _cross_chain(_models(MEDIA, program.media))

    @kernel
    def cross(scene, medium, o, d, t_max, channel, stream, active):
        kind, within = _kind(scene, medium), active & (medium != 0)
        return chain(scene, medium, kind, o, d, t_max, channel, stream, within)

    return cross


def _cross_chain(models):
    if not models:
        return _come_through
    own, number, rest = models[0].cross, models[0].number, _cross_chain(models[1:])

    @kernel
    def step(scene, medium, kind, o, d, t_max, channel, stream, active):
        result = rest(scene, medium, kind, o, d, t_max, channel, stream, active)
        mine = active & (kind == number)
        if any_lane(mine):
            found = own(scene, medium, o, d, t_max, channel, stream, mine)
            result = Crossing(
                where(mine, found.passed, result.passed),
                where(mine, found.light, result.light),
                where(mine, found.boost, result.boost),
            )
        return result

    return step


@kernel
def _come_through(scene, medium, kind, o, d, t_max, channel, stream, active):
    return Crossing(lanes_vec3(1.0), lanes_vec3(1.0), lanes(1.0))


# ---------------------------------------------------------------- directions


@specialised
def evaluate_phase(program):
    """``(scene, medium, d, wi, active) -> density``: light along -wi continues along -d, or back.

    Both are unit vectors; d is the direction of the path before, wi that after.
    """
    chain = _density_chain(_models(PHASES, program.phases))

    @kernel
    def evaluate_phase(scene, medium, d, wi, active):
        parameter = gather(scene.media.data, medium * STRIDE + PARAMETER)
        kind = gather(scene.media.info, medium * INFO + PHASE)
        # 1 - cosine, without cancellation in a forward peak.
        return chain(kind, parameter, 0.5 * length_squared(wi - d), active)

    return evaluate_phase


def _density_chain(models):
    if not models:
        return _nowhere
    own, number, rest = models[0].density, models[0].number, _density_chain(models[1:])

    @kernel
    def step(kind, parameter, one_minus_cosine, active):
        value = rest(kind, parameter, one_minus_cosine, active)
        mine = active & (kind == number)
        if any_lane(mine):
            value = where(mine, own(parameter, one_minus_cosine), value)
        return value

    return step


@kernel
def _nowhere(kind, parameter, one_minus_cosine, active):
    return lanes(0.0)


@specialised
def sample_phase(program):
    """``(scene, medium, d, u2, active) -> (wi, density)``: where a path goes on."""
    models = _models(PHASES, program.phases)
    sample, density = _sample_chain(models), _density_chain(models)

    @kernel
    def sample_phase(scene, medium, d, u2, active):
        parameter = gather(scene.media.data, medium * STRIDE + PARAMETER)
        kind = gather(scene.media.info, medium * INFO + PHASE)
        one_minus_cosine = sample(kind, parameter, u2[0], active)
        local = direction_around_z(one_minus_cosine, u2[1])
        s, t = frame_from_normal(d)
        wi = local.x * s + local.y * t + local.z * d
        return wi, density(kind, parameter, one_minus_cosine, active)

    return sample_phase


def _sample_chain(models):
    if not models:
        return _straight_on
    own, number, rest = models[0].sample, models[0].number, _sample_chain(models[1:])

    @kernel
    def step(kind, parameter, u, active):
        value = rest(kind, parameter, u, active)
        mine = active & (kind == number)
        if any_lane(mine):
            value = where(mine, own(parameter, u), value)
        return value

    return step


@kernel
def _straight_on(kind, parameter, u, active):
    return lanes(0.0)
