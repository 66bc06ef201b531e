"""Which medium is it? Flights, crossings and phase functions of any medium of a scene.

Each model runs only if one of the lanes needs it, over all lanes, and is then blended in. Values in
lanes that are not active are arbitrary, but for the crossing of empty space, which is 1.
"""

from __future__ import annotations

from alight.core.frame import frame_from_normal
from alight.core.switch import switch
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
    """``(scene, segment, u, active) -> Flight``; active lanes are in a medium."""
    answers = switch((m.number, _flying(m)) for m in _models(MEDIA, program.media))

    @kernel
    def fly(scene, segment, u, active):
        one = lanes_vec3(1.0)
        nothing = Flight(lanes_mask(False), lanes(0.0) + segment.length, one, one, one)
        return answers(scene, segment, _kind(scene, segment.medium), u, active, nothing)

    return fly


def _flying(model):
    own = model.fly

    @kernel
    def answer(scene, segment, kind, u, active, value):
        return own(scene, segment, u, active)

    return answer


@specialised
def cross(program):
    """``(scene, segment, active) -> Crossing``."""
    answers = switch((m.number, _crossing(m)) for m in _models(MEDIA, program.media))

    @kernel
    def cross(scene, segment, active):
        medium, empty = segment.medium, Crossing(lanes_vec3(1.0), lanes_vec3(1.0), lanes(1.0))
        return answers(scene, segment, _kind(scene, medium), (), active & (medium != 0), empty)

    return cross


def _crossing(model):
    own = model.cross

    @kernel
    def answer(scene, segment, kind, query, active, value):
        return own(scene, segment, active)

    return answer


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
