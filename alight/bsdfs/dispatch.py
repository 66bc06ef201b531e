r"""The scattering of any surface of a scene, whatever its material is made of.

A material is a sum of models (`alight.bsdfs.nesting`), each with a share that may vary
over the surface. For most materials it is one model with share 1, and a program without blends and
masks goes straight to it. Otherwise the models are visited one after the other, as long as one of
the lanes has another one:

.. math:: f = \sum_i s_i f_i, \qquad p = \sum_i s_i p_i

To sample, one model is chosen with its share as probability; then, unless it is a delta lobe, the
others are evaluated for the direction too.

`materials.layers` holds (start, count) for each material, and from `start` on, for each of its
models: row in the tables, start of its factors, number of factors. A factor is 2 slot + 1 if the
number in that slot is to be taken from 1.

Source: Veach and Guibas, Optimally combining sampling techniques, SIGGRAPH 1995 (one-sample model).
"""

from __future__ import annotations

from alight.bsdfs.flags import DELTA, DELTA_AND_SMOOTH, LAYER
from alight.bsdfs.model import BsdfValue
from alight.bsdfs.switch import (
    MIXED,
    albedo_row,
    evaluate_row,
    has_null,
    is_null,
    material_flags,
    sample_row,
)
from alight.core.constants import ONE_MINUS_EPSILON
from alight.textures.fetch import textured_scalar
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    gather,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    where,
)

#: What programs call it that materials have more than one model.
LAYERED_NAME = "layered"


@kernel
def layer_of(scene, surface, i, more):
    """(row, share) of model number i of a material; share 0 where there are no `more`."""
    layers = scene.materials.layers
    at = gather(layers, 2 * surface.bsdf) + 3 * i
    row = gather(layers, where(more, at, 0))
    factor = gather(layers, where(more, at + 1, 0))
    left = where(more, gather(layers, where(more, at + 2, 0)), 0)
    share = where(more, lanes(1.0), 0.0)
    while any_lane(left != 0):
        code = gather(layers, where(left != 0, factor, 0))
        # A slot is valid in every lane; the share of dead ones stays 0.
        weight = textured_scalar(scene, where(left != 0, code >> 1, 0), surface)
        weight = minimum(maximum(weight, 0.0), 1.0)
        weight = where((code & 1) != 0, 1.0 - weight, weight)
        share = where(left != 0, share * weight, share)
        factor = factor + 1
        left = where(left != 0, left - 1, 0)
    return where(more, row, surface.bsdf), share


@kernel
def count_of_layers(scene, surface):
    """How many models the material of a surface is made of."""
    return gather(scene.materials.layers, 2 * surface.bsdf + 1)


# ---------------------------------------------------------------- evaluate


@specialised
def evaluate_bsdf(program):
    """``(scene, surface, wo, wi, active) -> BsdfValue`` in the local frame."""
    return _evaluate_layers if LAYERED_NAME in program.bsdfs else _evaluate_one


@kernel
def _evaluate_one(scene, surface, wo, wi, active):
    return evaluate_row(scene, surface, surface.bsdf, wo, wi, active)


@kernel
def _evaluate_layers(scene, surface, wo, wi, active):
    total = BsdfValue(lanes_vec3(0.0), lanes(0.0))
    count, i = count_of_layers(scene, surface), lanes_u32(0)
    more = active & (count > i)
    while any_lane(more):
        row, share = layer_of(scene, surface, i, more)
        more = more & (share > 0.0)
        f_cos, pdf = evaluate_row(scene, surface, row, wo, wi, more)
        both = BsdfValue(total.f_cos + f_cos * share, total.pdf + pdf * share)
        total = where(more, both, total)
        i = i + 1
        more = active & (count > i)
    return total


# ---------------------------------------------------------------- sample


@specialised
def sample_bsdf(program):
    """``(scene, surface, wo, u, u2, active) -> BsdfSample`` in the local frame."""
    return _sample_layers if LAYERED_NAME in program.bsdfs else _sample_one


@kernel
def _sample_one(scene, surface, wo, u, u2, active):
    return sample_row(scene, surface, surface.bsdf, wo, u, u2, active)


@kernel
def _choose_layer(scene, surface, u, active):
    """(row, share, u rescaled, number) of one of the models, with its share as probability."""
    row, share, rest, layer = surface.bsdf, lanes(1.0), u, lanes_u32(0)
    count, i, before = count_of_layers(scene, surface), lanes_u32(0), lanes(0.0)
    more = active & (count > i)
    while any_lane(more):
        row_new, share_new = layer_of(scene, surface, i, more)
        # The last one that begins at or before u, so that rounding of the sum leaves no gap.
        mine = more & (share_new > 0.0) & (u >= before)
        row = where(mine, row_new, row)
        share = where(mine, share_new, share)
        rest = where(mine, (u - before) / where(mine, share_new, 1.0), rest)
        layer = where(mine, i, layer)
        before = before + share_new
        i = i + 1
        more = active & (count > i)
    return row, share, minimum(rest, ONE_MINUS_EPSILON), layer


@kernel
def _sample_layers(scene, surface, wo, u, u2, active):
    row, share, rest, layer = _choose_layer(scene, surface, u, active)
    found = sample_row(scene, surface, row, wo, rest, u2, active)
    found = replace(found, pdf=found.pdf * share, flags=found.flags | (layer << LAYER))
    # Of a delta lobe the share cancels: share * f / (share * pmf). A smooth direction might have
    # come from the other models too.
    layered = active & (count_of_layers(scene, surface) > 1)
    smooth = layered & ((found.flags & DELTA) == 0) & (found.pdf > 0.0)
    if any_lane(smooth):
        f_cos, pdf = _evaluate_layers(scene, surface, wo, found.wi, smooth)
        # Rounding may put a direction of the chosen model to where it says 0.
        weight = f_cos * where(pdf > 0.0, 1.0 / where(pdf > 0.0, pdf, 1.0), 0.0)
        found = where(smooth, replace(found, weight=weight, pdf=pdf), found)
    return found


# ---------------------------------------------------------------- further questions


@specialised
def albedo_bsdf(program):
    """``(scene, surface, active) -> Vec3``: the colour of a material, without light and angle."""
    return _albedo_layers if LAYERED_NAME in program.bsdfs else _albedo_one


@kernel
def _albedo_one(scene, surface, active):
    return albedo_row(scene, surface, surface.bsdf, active)


@kernel
def _albedo_layers(scene, surface, active):
    value = lanes_vec3(0.0)
    count, i = count_of_layers(scene, surface), lanes_u32(0)
    more = active & (count > i)
    while any_lane(more):
        row, share = layer_of(scene, surface, i, more)
        value = where(more, value + albedo_row(scene, surface, row, more) * share, value)
        i = i + 1
        more = active & (count > i)
    return value


@specialised
def open_share(program):
    """``(scene, surface, active) -> float``: what part of light continues as if nothing were there.

    1 for `null`, 1 - opacity for a mask.
    """
    if has_null(program) and LAYERED_NAME in program.bsdfs:
        return _open_layers
    return _open_one


@kernel
def _open_one(scene, surface, active):
    return where(is_null(scene, surface.bsdf), lanes(1.0), 0.0)


@kernel
def _open_layers(scene, surface, active):
    value = lanes(0.0)
    count, i = count_of_layers(scene, surface), lanes_u32(0)
    more = active & (count > i)
    while any_lane(more):
        row, share = layer_of(scene, surface, i, more)
        value = where(more & is_null(scene, row), value + share, value)
        i = i + 1
        more = active & (count > i)
    return value


@specialised
def is_mixed(program):
    """``(scene, surface) -> mask``: the material may have both delta and smooth lobes."""
    return _is_mixed if DELTA_AND_SMOOTH in program.bsdfs else _never_mixed


@kernel
def _is_mixed(scene, surface):
    return (material_flags(scene, surface.bsdf) & MIXED) != 0


@kernel
def _never_mixed(scene, surface):
    return lanes_mask(False)
