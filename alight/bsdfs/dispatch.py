"""Which model is it? The scattering of any surface of a scene, for packets that mix materials.

Each class of model runs only if one of the lanes needs it, over all lanes, and is then blended in.
A program with one class calls it directly. Values in lanes that are not active are arbitrary.
"""

from __future__ import annotations

from alight.bsdfs import MODELS
from alight.core.jit import kernel, specialised
from alight.core.simd import any_lane, gather, lanes, lanes_u32, lanes_vec3, where
from alight.core.vec import Vec3

#: Slots of a material in `materials.data`: a power of two.
STRIDE = 1 << (max(sum(m.SLOTS.values()) for m in MODELS if hasattr(m, "SLOTS")) - 1).bit_length()
#: Bit of a material's flags: the back looks like the front.
TWO_SIDED = 1
#: What programs call that bit.
TWO_SIDED_NAME = "two_sided"


def models_of(program) -> list[tuple[int, object]]:
    """(kind number, module) of the models that a program uses."""
    return [
        (number, model)
        for number, model in enumerate(MODELS)
        if model.EXAMPLES[0].type_name() in program.bsdfs and hasattr(model, "sample")
    ]


@kernel
def _kind(scene, surface):
    return gather(scene.materials.info, 2 * surface.bsdf)


@kernel
def _turned(scene, surface, wo):
    """Mask: seen from the back, and the back looks like the front."""
    flags = gather(scene.materials.info, 2 * surface.bsdf + 1)
    return (wo.z < 0.0) & ((flags & TWO_SIDED) != 0)


@kernel
def _flip(mask, w):
    return Vec3(w.x, w.y, where(mask, -w.z, w.z))


# ---------------------------------------------------------------- evaluate


@specialised
def evaluate_bsdf(program):
    """``(scene, surface, wo, wi, active) -> (f_cos, pdf)`` in the local frame."""
    one_sided = _evaluate_one_sided(models_of(program))
    if TWO_SIDED_NAME not in program.bsdfs:
        return one_sided

    @kernel
    def evaluate_bsdf(scene, surface, wo, wi, active):
        back = _turned(scene, surface, wo)
        return one_sided(scene, surface, _flip(back, wo), _flip(back, wi), active)

    return evaluate_bsdf


def _evaluate_one_sided(models):
    if len(models) == 1:
        return _evaluate_of(models[0][1])
    switch = _evaluate_switch(models)

    @kernel
    def evaluate_bsdf(scene, surface, wo, wi, active):
        kind = _kind(scene, surface)
        return switch(scene, surface, kind, wo, wi, active, lanes_vec3(0.0), lanes(0.0))

    return evaluate_bsdf


def _evaluate_of(model):
    load, evaluate = model.load, model.evaluate

    @kernel
    def evaluate_bsdf(scene, surface, wo, wi, active):
        return evaluate(load(scene, surface.bsdf * STRIDE, surface), wo, wi)

    return evaluate_bsdf


def _evaluate_switch(models):
    if not models:
        return _keep_value
    number, evaluate = models[0][0], _evaluate_of(models[0][1])
    rest = _evaluate_switch(models[1:])

    @kernel
    def step(scene, surface, kind, wo, wi, active, f_cos, pdf):
        mine = active & (kind == number)
        if any_lane(mine):
            f_cos_new, pdf_new = evaluate(scene, surface, wo, wi, mine)
            f_cos, pdf = where(mine, f_cos_new, f_cos), where(mine, pdf_new, pdf)
        return rest(scene, surface, kind, wo, wi, active, f_cos, pdf)

    return step


@kernel
def _keep_value(scene, surface, kind, wo, wi, active, f_cos, pdf):
    return f_cos, pdf


# ---------------------------------------------------------------- sample


@specialised
def sample_bsdf(program):
    """``(scene, surface, wo, u, u2, active) -> (wi, weight, pdf, flags)`` in the local frame."""
    one_sided = _sample_one_sided(models_of(program))
    if TWO_SIDED_NAME not in program.bsdfs:
        return one_sided

    @kernel
    def sample_bsdf(scene, surface, wo, u, u2, active):
        back = _turned(scene, surface, wo)
        wi, weight, pdf, flags = one_sided(scene, surface, _flip(back, wo), u, u2, active)
        return _flip(back, wi), weight, pdf, flags

    return sample_bsdf


def _sample_one_sided(models):
    if len(models) == 1:
        return _sample_of(models[0][1])
    switch = _sample_switch(models)

    @kernel
    def sample_bsdf(scene, surface, wo, u, u2, active):
        kind = _kind(scene, surface)
        wi, weight = lanes_vec3(0.0), lanes_vec3(0.0)
        return switch(scene, surface, kind, wo, u, u2, active, wi, weight, lanes(0.0), lanes_u32(0))

    return sample_bsdf


def _sample_of(model):
    load, sample = model.load, model.sample

    @kernel
    def sample_bsdf(scene, surface, wo, u, u2, active):
        return sample(load(scene, surface.bsdf * STRIDE, surface), wo, u, u2)

    return sample_bsdf


def _sample_switch(models):
    if not models:
        return _keep_sample
    number, sample = models[0][0], _sample_of(models[0][1])
    rest = _sample_switch(models[1:])

    @kernel
    def step(scene, surface, kind, wo, u, u2, active, wi, weight, pdf, flags):
        mine = active & (kind == number)
        if any_lane(mine):
            wi_new, weight_new, pdf_new, flags_new = sample(scene, surface, wo, u, u2, mine)
            wi, weight = where(mine, wi_new, wi), where(mine, weight_new, weight)
            pdf, flags = where(mine, pdf_new, pdf), where(mine, flags_new, flags)
        return rest(scene, surface, kind, wo, u, u2, active, wi, weight, pdf, flags)

    return step


@kernel
def _keep_sample(scene, surface, kind, wo, u, u2, active, wi, weight, pdf, flags):
    return wi, weight, pdf, flags


# ---------------------------------------------------------------- albedo, for the AOV


@specialised
def albedo_bsdf(program):
    """``(scene, surface, active) -> Vec3``: the colour of a material, without light and angle."""
    switch = _albedo_switch(models_of(program))

    @kernel
    def albedo_bsdf(scene, surface, active):
        return switch(scene, surface, _kind(scene, surface), active, lanes_vec3(0.0))

    return albedo_bsdf


def _albedo_switch(models):
    if not models:
        return _keep_albedo
    number, load, albedo = models[0][0], models[0][1].load, models[0][1].albedo
    rest = _albedo_switch(models[1:])

    @kernel
    def step(scene, surface, kind, active, value):
        mine = active & (kind == number)
        if any_lane(mine):
            value = where(mine, albedo(load(scene, surface.bsdf * STRIDE, surface)), value)
        return rest(scene, surface, kind, active, value)

    return step


@kernel
def _keep_albedo(scene, surface, kind, active, value):
    return value
