"""Which model is it? The scattering of any row of the materials, for packets that mix models.

Each class of model runs only if one of the lanes needs it, over all lanes, and is then blended in.
A program with one class calls it directly. Values in lanes that are not active are arbitrary.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from alight.bsdfs.absorption import ABSORBING
from alight.bsdfs.relief import BENT, bent_evaluate, bent_sample
from alight.core.frame import mirrored_if
from alight.core.maths import exp
from alight.core.registry import Models, Numbers, specs_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    as_int,
    as_uint,
    gather,
    horizontal_max,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    to_float,
    where,
)

#: Least number of slots of a material in `materials.data`, see `stride_of`: a power of two.
STRIDE = 16
#: Bits of a material's flags: the back looks like the front; both Dirac and smooth lobes; and
#: from bit `RELIEF` on, the row of its normal or bump map + 1.
TWO_SIDED, MIXED, RELIEF = 1, 2, 2
#: What programs call the first bit; the second is `alight.bsdfs.flags.DELTA_AND_SMOOTH`.
TWO_SIDED_NAME = "two_sided"
#: Kernel of models that refract: ``(scene, base, surface)``, the index inside over that outside.
INNER_INDEX = "inner_index"
#: Attribute of such models: what programs call it that one of its materials refracts. Without the
#: attribute all of them do.
REFRACTING = "REFRACTING"
#: Kernel of models with an inside: ``(scene, base, surface)``, absorption coefficients per metre.
ABSORPTION = "absorption"


def stride_of(names: Iterable[str]) -> int:
    """Slots of a material where models of these names occur: more than `STRIDE` if one needs it."""
    models = Models("bsdfs")
    widths = [sum(getattr(models[n], "SLOTS", {}).values()) for n in names if n in models]
    return max(STRIDE, 1 << (max(widths, default=1) - 1).bit_length())


class Used(NamedTuple):
    """A model that a program uses.

    Attributes
    ----------
    number : int
        Of its kind, in `materials.info`.
    model : module
    stride : int
        Numbers of a row in `materials.data`.
    """

    number: int
    model: Any
    stride: int


def models_of(program) -> list[Used]:
    """The models that a program uses."""
    stride = stride_of(program.bsdfs)
    return [
        Used(Numbers("bsdfs")[name], model, stride)
        for name, model in Models("bsdfs").items()
        if name in program.bsdfs and hasattr(model, "sample")
    ]


@kernel
def _kind(scene, row):
    return gather(scene.materials.info, 2 * row)


@kernel
def _own_rows(mine, row):
    """Rows of one kind in every lane, those of `mine` in their places.

    Rows of other kinds hold other numbers, and what means the start of a table to one model would
    lead another one out of all tables.
    """
    some = as_uint(as_int(horizontal_max(where(mine, to_float(row), 0.0))))
    return where(mine, row, some)


@kernel
def material_flags(scene, row):
    """Bits `TWO_SIDED` and `MIXED` of a material."""
    return gather(scene.materials.info, 2 * row + 1)


@kernel
def _turned(scene, row, wo):
    """Mask: seen from the back, and the back looks like the front."""
    return (wo.z < 0.0) & ((material_flags(scene, row) & TWO_SIDED) != 0)


@kernel
def _relief(scene, row):
    """Row of the map that bends a material's normals, + 1; 0 without one."""
    return material_flags(scene, row) >> RELIEF


# ---------------------------------------------------------------- surfaces that are not there


def has_null(program) -> bool:
    """Whether there are surfaces, or holes in them, that light passes as if nothing was there."""
    return bool(_unseen(program))


def _unseen(program) -> list[str]:
    """Models of surfaces that are not there."""
    return [
        name for name, model in specs_of(Bsdf).items() if name in program.bsdfs and model.unseen
    ]


@specialised
def is_null(program):
    """``(scene, row) -> mask``: the model of this row is `null`."""
    return _one_of([Numbers("bsdfs")[name] for name in _unseen(program)])


def _one_of(numbers: list[int]):
    """``(scene, row) -> mask``: the model of this row has one of the numbers."""
    if not numbers:
        return _never
    number, others = numbers[0], _one_of(numbers[1:])
    if len(numbers) == 1:

        @kernel
        def by_kind(scene, row):
            return _kind(scene, row) == number

        return by_kind

    @kernel
    def by_kinds(scene, row):
        return (_kind(scene, row) == number) | others(scene, row)

    return by_kinds


@kernel
def _never(scene, row):
    return lanes_mask(False)


# ---------------------------------------------------------------- evaluate


@specialised
def evaluate_row(program):
    """``(scene, surface, row, wo, wi, active) -> (f_cos, pdf)`` in the local frame."""
    one_sided = _evaluate_one_sided(models_of(program))
    if BENT in program.bsdfs:
        one_sided = bent_evaluate(one_sided, stride_of(program.bsdfs), _relief)
    if TWO_SIDED_NAME not in program.bsdfs:
        return one_sided

    @kernel
    def evaluate_row(scene, surface, row, wo, wi, active):
        back = _turned(scene, row, wo)
        return one_sided(scene, surface, row, mirrored_if(back, wo), mirrored_if(back, wi), active)

    return evaluate_row


def _evaluate_one_sided(models):
    if len(models) == 1:
        return _evaluate_of(models[0])
    switch = _evaluate_switch(models)

    @kernel
    def evaluate_row(scene, surface, row, wo, wi, active):
        kind = _kind(scene, row)
        return switch(scene, surface, row, kind, wo, wi, active, lanes_vec3(0.0), lanes(0.0))

    return evaluate_row


def _evaluate_of(used):
    load, evaluate, stride = used.model.load, used.model.evaluate, used.stride

    @kernel
    def evaluate_row(scene, surface, row, wo, wi, active):
        return evaluate(load(scene, row * stride, surface), wo, wi)

    return evaluate_row


def _evaluate_switch(models):
    if not models:
        return _keep_value
    number, evaluate = models[0].number, _evaluate_of(models[0])
    rest = _evaluate_switch(models[1:])

    @kernel
    def step(scene, surface, row, kind, wo, wi, active, f_cos, pdf):
        mine = active & (kind == number)
        if any_lane(mine):
            own = _own_rows(mine, row)
            f_cos_new, pdf_new = evaluate(scene, surface, own, wo, wi, mine)
            f_cos, pdf = where(mine, f_cos_new, f_cos), where(mine, pdf_new, pdf)
        return rest(scene, surface, row, kind, wo, wi, active, f_cos, pdf)

    return step


@kernel
def _keep_value(scene, surface, row, kind, wo, wi, active, f_cos, pdf):
    return f_cos, pdf


# ---------------------------------------------------------------- sample


@specialised
def sample_row(program):
    """``(scene, surface, row, wo, u, u2, active) -> (wi, weight, pdf, flags)``, local frame."""
    one_sided = _sample_one_sided(models_of(program))
    if BENT in program.bsdfs:
        one_sided = bent_sample(one_sided, stride_of(program.bsdfs), _relief)
    if TWO_SIDED_NAME not in program.bsdfs:
        return one_sided

    @kernel
    def sample_row(scene, surface, row, wo, u, u2, active):
        back = _turned(scene, row, wo)
        wi, weight, pdf, flags = one_sided(
            scene, surface, row, mirrored_if(back, wo), u, u2, active
        )
        return mirrored_if(back, wi), weight, pdf, flags

    return sample_row


def _sample_one_sided(models):
    if len(models) == 1:
        return _sample_of(models[0])
    switch = _sample_switch(models)

    @kernel
    def sample_row(scene, surface, row, wo, u, u2, active):
        kind = _kind(scene, row)
        wi, weight = lanes_vec3(0.0), lanes_vec3(0.0)
        pdf, flags = lanes(0.0), lanes_u32(0)
        return switch(scene, surface, row, kind, wo, u, u2, active, wi, weight, pdf, flags)

    return sample_row


def _sample_of(used):
    load, sample, stride = used.model.load, used.model.sample, used.stride

    @kernel
    def sample_row(scene, surface, row, wo, u, u2, active):
        return sample(load(scene, row * stride, surface), wo, u, u2)

    return sample_row


def _sample_switch(models):
    if not models:
        return _keep_sample
    number, sample = models[0].number, _sample_of(models[0])
    rest = _sample_switch(models[1:])

    @kernel
    def step(scene, surface, row, kind, wo, u, u2, active, wi, weight, pdf, flags):
        mine = active & (kind == number)
        if any_lane(mine):
            own = _own_rows(mine, row)
            wi_new, weight_new, pdf_new, flags_new = sample(scene, surface, own, wo, u, u2, mine)
            wi, weight = where(mine, wi_new, wi), where(mine, weight_new, weight)
            pdf, flags = where(mine, pdf_new, pdf), where(mine, flags_new, flags)
        return rest(scene, surface, row, kind, wo, u, u2, active, wi, weight, pdf, flags)

    return step


@kernel
def _keep_sample(scene, surface, row, kind, wo, u, u2, active, wi, weight, pdf, flags):
    return wi, weight, pdf, flags


# ---------------------------------------------------------------- refraction


@specialised
def concentration(program):
    """``(scene, surface, wi) -> factor``: eta^2 >= 1 where wi (local frame) leads into glass, or 1.

    Radiance is concentrated there: the throughput falls by 1 / eta^2, and rises again by eta^2 when
    the path comes out (PBR4 section 14.1.4). Glass that is a part of a blend counts as 1.
    """
    return _concentration_switch(_refracting(program))


def refracts(program) -> bool:
    """Whether `concentration` may be other than 1."""
    return bool(_refracting(program))


def _refracting(program) -> list[Used]:
    """The models with a material in the program that may refract."""
    with_index = [used for used in models_of(program) if hasattr(used.model, INNER_INDEX)]
    return [
        used
        for used in with_index
        if getattr(used.model, REFRACTING, None) in (None, *program.bsdfs)
    ]


def _concentration_switch(models):
    if not models:
        return _no_concentration
    number, model, stride = models[0]
    inner_index = getattr(model, INNER_INDEX)
    rest = _concentration_switch(models[1:])

    @kernel
    def step(scene, surface, wi):
        factor = rest(scene, surface, wi)
        eta = inner_index(scene, surface.bsdf * stride, surface)
        inside = (wi.z < 0.0) & (_kind(scene, surface.bsdf) == number)
        return where(inside, maximum(eta * eta, 1.0), factor)

    return step


@kernel
def _no_concentration(scene, surface, wi):
    return lanes(1.0)


def absorbs(program) -> bool:
    """Whether `transmittance` may be other than 1."""
    return ABSORBING in program.bsdfs


@specialised
def transmittance(program):
    """``(scene, surface, wo, t) -> Vec3``: what the body around a piece of a path leaves of it.

    The piece of length t ends at the surface, coming from wo (local frame). Glass that is a part of
    a blend absorbs nothing.
    """
    switch = _absorption_switch([u for u in models_of(program) if hasattr(u.model, ABSORPTION)])

    @kernel
    def transmittance(scene, surface, wo, t):
        sigma = switch(scene, surface, wo.z < 0.0)
        return Vec3(exp(-sigma.x * t), exp(-sigma.y * t), exp(-sigma.z * t))

    return transmittance


def _absorption_switch(models):
    if not models:
        return _no_absorption
    number, model, stride = models[0]
    absorption = getattr(model, ABSORPTION)
    rest = _absorption_switch(models[1:])

    @kernel
    def step(scene, surface, inside):
        mine = inside & (_kind(scene, surface.bsdf) == number)
        found = absorption(scene, where(mine, surface.bsdf, 0) * stride, surface)
        return where(mine, found, rest(scene, surface, inside))

    return step


@kernel
def _no_absorption(scene, surface, inside):
    return lanes_vec3(0.0)


# ---------------------------------------------------------------- albedo, for the AOV


@specialised
def albedo_row(program):
    """``(scene, surface, row, active) -> Vec3``: a colour, without light and angle."""
    switch = _albedo_switch(models_of(program))

    @kernel
    def albedo_row(scene, surface, row, active):
        return switch(scene, surface, row, _kind(scene, row), active, lanes_vec3(0.0))

    return albedo_row


def _albedo_switch(models):
    if not models:
        return _keep_albedo
    number, model, stride = models[0]
    load, albedo = model.load, model.albedo
    rest = _albedo_switch(models[1:])

    @kernel
    def step(scene, surface, row, kind, active, value):
        mine = active & (kind == number)
        if any_lane(mine):
            params = load(scene, _own_rows(mine, row) * stride, surface)
            value = where(mine, albedo(params), value)
        return rest(scene, surface, row, kind, active, value)

    return step


@kernel
def _keep_albedo(scene, surface, row, kind, active, value):
    return value
