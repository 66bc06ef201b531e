"""Dispatch over BSDF models, for packets whose lanes hold different materials.

All questions to models go through `_answers`. A program with one model calls it directly. Values in
lanes that are not active are arbitrary.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from alight.bsdfs.model import BSDFS, BsdfModel, BsdfSample, BsdfValue, Inside, stride_of
from alight.bsdfs.normals import coat_normals
from alight.bsdfs.normals.shading_normals import BENT, bent_evaluate, bent_sample
from alight.core.frame import mirrored_if
from alight.core.registry import Kernel
from alight.core.switch import is_one_of, switch
from alight.shapes.hit import is_bent_below
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    as_int,
    as_uint,
    gather,
    horizontal_max,
    lanes,
    lanes_u32,
    lanes_vec3,
    maximum,
    to_float,
    where,
)

#: Bits of a material's flags: the back looks like the front; both delta and smooth lobes; it, or a
#: part of it, disperses light; its coat has normals of its own; some of it is a mirror or clear
#: glass; light passes some of it as if nothing was there; and from bit `NORMALS` on, the row of its
#: normal or bump map + 1.
TWO_SIDED, MIXED, SPREADS, COATED_APART, SPECULAR, OPEN, NORMALS = 1, 2, 4, 8, 16, 32, 6
#: What programs call the first bit; the second is `alight.bsdfs.flags.DELTA_AND_SMOOTH`.
SAME_BACK = "same_back"


@kernel
def _kind(scene, row):
    return gather(scene.materials.info, 2 * row)


@kernel
def material_flags(scene, row):
    """Bits `TWO_SIDED` to `OPEN` of a material."""
    return gather(scene.materials.info, 2 * row + 1)


@kernel
def _turned(scene, row, wo):
    """Mask: seen from the back, and the back looks like the front."""
    return (wo.z < 0.0) & ((material_flags(scene, row) & TWO_SIDED) != 0)


@kernel
def _normals(scene, row):
    """Row of the map that bends a material's normals, + 1; 0 without one."""
    return material_flags(scene, row) >> NORMALS


@kernel
def _is_coated_apart(scene, row):
    return (material_flags(scene, row) & COATED_APART) != 0


# ---------------------------------------------------------------- questions to models


def models_of(program) -> list[BsdfModel]:
    """The models that scatter light in a program."""
    return [
        model for name, model in BSDFS.items() if name in program.bsdfs and model.sample is not None
    ]


def _answers(program, models: Iterable[BsdfModel], answer_of: Callable[..., Kernel]) -> Kernel:
    """Write ``(scene, surface, kind, query, active, value) -> value``.

    It is what the model of each row answers, or the given value if that is none of `models`.

    Parameters
    ----------
    answer_of : (model, base_of) -> kernel of the same form
        ``base_of(row, active)`` is where a row that a query names begins.
    """
    models, stride = list(models), stride_of(program.bsdfs)
    if models and models == models_of(program)[:1] == models_of(program):
        answer = answer_of(models[0], _any_base(stride))

        @kernel
        def of_the_only_model(scene, surface, kind, query, active, value):
            # Its kind is not looked up.
            return answer(scene, surface, 0, query, active, value)

        return of_the_only_model
    base_of = _own_base(stride)
    return switch((model.number, answer_of(model, base_of)) for model in models)


def _any_base(stride):
    @kernel
    def base_of(row, active):
        return row * stride

    return base_of


def _own_base(stride):
    """Rows of one kind in every lane, those of active ones in their places.

    Rows of other kinds hold other numbers, and what means the start of a table to one model would
    lead another one out of all tables.
    """

    @kernel
    def base_of(row, active):
        some = as_uint(as_int(horizontal_max(where(active, to_float(row), 0.0))))
        return where(active, row, some) * stride

    return base_of


# ---------------------------------------------------------------- evaluate


@specialised
def evaluate_row(program):
    """``(scene, surface, row, wo, wi, active) -> BsdfValue`` in the local frame."""
    answers = _answers(program, models_of(program), _evaluating)

    @kernel
    def one_sided(scene, surface, row, wo, wi, active):
        nothing = BsdfValue(lanes_vec3(0.0), lanes(0.0))
        return answers(scene, surface, _kind(scene, row), (row, wo, wi), active, nothing)

    if is_bent_below(program):
        bent = coat_normals.bent_evaluate
        one_sided = bent(one_sided, stride_of(program.bsdfs), _normals, _is_coated_apart)
    elif BENT in program.bsdfs:
        one_sided = bent_evaluate(one_sided, stride_of(program.bsdfs), _normals)
    if SAME_BACK not in program.bsdfs:
        return one_sided

    @kernel
    def evaluate_row(scene, surface, row, wo, wi, active):
        back = _turned(scene, row, wo)
        return one_sided(scene, surface, row, mirrored_if(back, wo), mirrored_if(back, wi), active)

    return evaluate_row


def _evaluating(model, base_of):
    load, evaluate = model.load, model.evaluate

    @kernel
    def answer(scene, surface, kind, query, active, value):
        row, wo, wi = query
        f_cos, pdf = evaluate(load(scene, base_of(row, active), surface), wo, wi)
        return BsdfValue(f_cos, pdf)

    return answer


# ---------------------------------------------------------------- sample


@specialised
def sample_row(program):
    """``(scene, surface, row, wo, u, u2, active) -> BsdfSample`` in the local frame."""
    answers = _answers(program, models_of(program), _sampling)

    @kernel
    def one_sided(scene, surface, row, wo, u, u2, active):
        failed = BsdfSample(lanes_vec3(0.0), lanes_vec3(0.0), lanes(0.0), lanes_u32(0))
        return answers(scene, surface, _kind(scene, row), (row, wo, u, u2), active, failed)

    if is_bent_below(program):
        bent = coat_normals.bent_sample
        one_sided = bent(one_sided, stride_of(program.bsdfs), _normals, _is_coated_apart)
    elif BENT in program.bsdfs:
        one_sided = bent_sample(one_sided, stride_of(program.bsdfs), _normals)
    if SAME_BACK not in program.bsdfs:
        return one_sided

    @kernel
    def sample_row(scene, surface, row, wo, u, u2, active):
        back = _turned(scene, row, wo)
        found = one_sided(scene, surface, row, mirrored_if(back, wo), u, u2, active)
        return replace(found, wi=mirrored_if(back, found.wi))

    return sample_row


def _sampling(model, base_of):
    load, sample = model.load, model.sample

    @kernel
    def answer(scene, surface, kind, query, active, value):
        row, wo, u, u2 = query
        params = load(scene, base_of(row, active), surface)
        wi, weight, pdf, flags = sample(params, wo, u, u2)
        return BsdfSample(wi, weight, pdf, flags)

    return answer


# ---------------------------------------------------------------- albedo, for the AOV


@specialised
def albedo_row(program):
    """``(scene, surface, row, active) -> Vec3``: a colour, without light and angle."""
    answers = _answers(program, models_of(program), _albedo_of)

    @kernel
    def albedo_row(scene, surface, row, active):
        return answers(scene, surface, _kind(scene, row), row, active, lanes_vec3(0.0))

    return albedo_row


def _albedo_of(model, base_of):
    load, albedo = model.load, model.albedo

    @kernel
    def answer(scene, surface, kind, row, active, value):
        return albedo(load(scene, base_of(row, active), surface))

    return answer


# ---------------------------------------------------------------- surfaces that are not there


def has_null(program) -> bool:
    """Whether there are surfaces, or holes in them, that light passes as if nothing was there."""
    return bool(_unseen(program))


def _unseen(program) -> list[BsdfModel]:
    """Models of surfaces that are not there."""
    return [model for model in models_of(program) if model.spec.unseen]


@specialised
def is_null(program):
    """``(scene, row) -> mask``: light passes the material as if nothing was there."""
    is_unseen = is_one_of(model.number for model in _unseen(program))

    @kernel
    def is_null(scene, row):
        return is_unseen(_kind(scene, row))

    return is_null


# ---------------------------------------------------------------- bodies


def refracts(program) -> bool:
    """Whether `concentration` may be other than 1."""
    return bool(_refracting(program))


def _refracting(program) -> list[BsdfModel]:
    """The models with a material in the program that may refract."""
    return [
        model
        for model in models_of(program)
        if model.inner_index is not None and model.REFRACTING in ("", *program.bsdfs)
    ]


@specialised
def squared_index(program):
    """``(scene, surface, w) -> eta^2``: where w (local frame) leads into glass, else 1.

    eta is the index inside over that outside. Glass that is a part of a blend counts as 1.
    """
    answers = _answers(program, _refracting(program), _inner_index_of)

    @kernel
    def squared_index(scene, surface, w):
        inside = w.z < 0.0
        kind = _kind(scene, surface.bsdf)
        eta = answers(scene, surface, kind, surface.bsdf, inside, lanes(1.0))
        return where(inside, eta * eta, 1.0)

    return squared_index


@kernel
def concentration(scene, surface, wi):
    """`squared_index`, at least 1.

    Radiance is concentrated in glass: the throughput falls by 1 / eta^2, and rises again by eta^2
    when the path comes out (PBR4 section 14.1.4).
    """
    return maximum(squared_index(scene, surface, wi), 1.0)


def _inner_index_of(model, base_of):
    inner_index = model.inner_index

    @kernel
    def answer(scene, surface, kind, row, active, value):
        return inner_index(scene, base_of(row, active), surface)

    return answer


def _with_inside(program) -> list[BsdfModel]:
    """Models of bodies that scatter light."""
    return [model for model in models_of(program) if model.inside is not None]


def has_bodies(program) -> bool:
    """Whether there are bodies in which paths walk at random."""
    return bool(_with_inside(program))


@specialised
def is_body(program):
    """``(scene, row) -> mask``: below the material is a body that scatters light."""
    bodies = is_one_of(model.number for model in _with_inside(program))

    @kernel
    def is_body(scene, row):
        return bodies(_kind(scene, row))

    return is_body


@specialised
def inside_of(program):
    """``(scene, surface, active) -> Inside``: the body below active lanes."""
    answers = _answers(program, _with_inside(program), _inside_of)

    @kernel
    def inside_of(scene, surface, active):
        row, nothing = surface.bsdf, Inside(lanes_vec3(1.0), lanes_vec3(0.0))
        return answers(scene, surface, _kind(scene, row), row, active, nothing)

    return inside_of


def _inside_of(model, base_of):
    inside = model.inside

    @kernel
    def answer(scene, surface, kind, row, active, value):
        extinction, albedo = inside(scene, base_of(row, active), surface)
        return Inside(extinction, albedo)

    return answer
