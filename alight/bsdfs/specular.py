"""Mirrors and clear glass: which models have such lobes, and the lobes of a material one by one.

What happens at a surface on the way of a chain is an *event*: the light is reflected, transmitted,
or goes straight on through a hole, and of a material that is a sum of models, one of them does it.
An event is a number: its kind in the lower bits, then the number of the model.
"""

from __future__ import annotations

from alight.bsdfs import dirac
from alight.bsdfs.dispatch import LAYERED_NAME, count_of_layers, layer_of, sample_bsdf
from alight.bsdfs.flags import DELTA_AND_SMOOTH, LAYER, NULL, REFLECTION, TRANSMISSION
from alight.bsdfs.model import BSDFS
from alight.bsdfs.switch import OPEN, SPECULAR, has_null, material_flags, sample_row
from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.spec import Bsdf
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, lanes, lanes_mask, lanes_u32, minimum, where

#: Kinds of events are `REFLECTION`, `TRANSMISSION` and this, light that passes a hole.
STRAIGHT = REFLECTION | TRANSMISSION
#: Bits of the kind, and all bits of an event. Later models of a material have no events.
KIND_BITS, EVENT_BITS = 2, 5
EVENT_MASK, MOST_LAYERS = (1 << EVENT_BITS) - 1, 1 << (EVENT_BITS - KIND_BITS)


def is_specular(spec: Bsdf) -> bool:
    """Whether a model, not `Nested`, has a lobe of a mirror or of clear glass."""
    model = BSDFS[spec.type_name()]
    clear = model.evaluate is dirac.evaluate and not model.spec.unseen
    return clear or DELTA_AND_SMOOTH in model.features(spec)


@kernel
def event_of(flags):
    """The event of a sample of a delta lobe."""
    straight = (flags & NULL) != 0
    kind = where(straight, lanes_u32(STRAIGHT), flags & STRAIGHT)
    return kind | ((flags >> LAYER) << KIND_BITS)


@kernel
def kind_of(event):
    """`REFLECTION`, `TRANSMISSION` or `STRAIGHT`."""
    return event & STRAIGHT


@specialised
def is_only_open(program):
    """``(scene, surface) -> mask``: light passes some of the material, none of which is a mirror.

    It is no event on the way of a chain, as there is no other one.
    """
    return _is_only_open if has_null(program) else _never


@kernel
def _is_only_open(scene, surface):
    return (material_flags(scene, surface.bsdf) & (OPEN | SPECULAR)) == OPEN


@kernel
def _never(scene, surface):
    return lanes_mask(False)


@specialised
def sample_event(program):
    """``(scene, surface, wo, u, wanted, chance, active) -> BsdfSample`` of a delta lobe.

    Where `chance` holds, it is chosen by u among those that the material has, elsewhere it is
    `wanted`, or fails. ``weight * pdf`` is what the lobe leaves of the light.
    """
    return _event_of_layers if LAYERED_NAME in program.bsdfs else _event_of_one


@kernel
def _number_of(kind, u, chance):
    # Models reflect at the lower numbers and transmit at the upper ones.
    return where(chance, u, where(kind == REFLECTION, lanes(0.0), ONE_MINUS_EPSILON))


@kernel
def _event_of_one(scene, surface, wo, u, wanted, chance, active):
    half = (lanes(0.5), lanes(0.5))
    return sample_bsdf(scene, surface, wo, _number_of(kind_of(wanted), u, chance), half, active)


@kernel
def _event_of_layers(scene, surface, wo, u, wanted, chance, active):
    """One model is chosen, of those with delta lobes in proportion to its share."""
    count, i = count_of_layers(scene, surface), lanes_u32(0)
    row, share, layer, total = surface.bsdf, lanes(0.0), i, lanes(0.0)
    alone = count == 1
    more = active & (count > i)
    while any_lane(more):
        row_new, share_new = layer_of(scene, surface, i, more)
        clear = alone | ((material_flags(scene, row_new) & (SPECULAR | OPEN)) != 0)
        able = more & clear & (share_new > 0.0)
        total = where(able, total + share_new, total)
        ratio = share_new / where(able, total, 1.0)
        # The later one of two, by the upper numbers.
        later = u >= 1.0 - ratio
        mine = able & where(chance, later, (wanted >> KIND_BITS) == i)
        rest = where(later, (u - (1.0 - ratio)) / ratio, u / (1.0 - ratio))
        u = where(able & chance, minimum(rest, ONE_MINUS_EPSILON), u)
        row, share = where(mine, row_new, row), where(mine, share_new, share)
        layer = where(mine, i, layer)
        i = i + 1
        more = active & (count > i)
    half = (lanes(0.5), lanes(0.5))
    number = _number_of(kind_of(wanted), u, chance)
    found = sample_row(scene, surface, row, wo, number, half, active & (share > 0.0))
    fine = (share > 0.0) & (layer < MOST_LAYERS)
    return replace(
        found, pdf=where(fine, found.pdf * share, 0.0), flags=found.flags | (layer << LAYER)
    )
