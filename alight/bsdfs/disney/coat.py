"""`principled` evaluated and sampled, with coats that have normals of their own.

Where no coat has (`alight.bsdfs.normals.coat_normals`) all lobes are those of one frame, and the
coat is among them. Elsewhere it is taken out of them and added beside them, in its own frame.
"""

from __future__ import annotations

from alight.bsdfs.disney.lobes import direction, mirrored_by, values
from alight.bsdfs.disney.view import COAT_IOR, along_facets, from_facets, view_from
from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.bsdfs.normals.coat_normals import (
    axes_of,
    below_coat,
    from_below_coat,
    left_below,
    left_of_coat,
    seen_from,
)
from alight.core.frame import mirrored_if, to_local, to_world
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import sample_ggx_visible
from alight.core.vec import Vec3, quotient, reflect, renormalize
from alight.shapes.hit import OWN_COAT
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import lanes, lanes_u32, lanes_vec3, where


@specialised
def evaluate(program):
    """``(params, wo, wi) -> (f cos theta_i, pdf per steradian)``."""
    return _evaluate_apart if OWN_COAT in program.bsdfs else _evaluate


@kernel
def _evaluate(params, wo, wi):
    view = view_from(params, along_facets(params.brush.turn, wo))
    return values(params, view, mirrored_if(view.side.below, along_facets(params.brush.turn, wi)))


@specialised
def sample(program):
    """``(params, wo, u, u2) -> (wi, f cos theta_i / pdf, pdf per steradian, flags)``.

    One of the lobes is chosen by u.
    """
    return _sample_apart if OWN_COAT in program.bsdfs else _sample


@kernel
def _sample(params, wo, u, u2):
    view = view_from(params, along_facets(params.brush.turn, wo))
    wi, passes = direction(params, view, u, u2)
    f_cos, pdf = values(params, view, wi)
    wi = from_facets(params.brush.turn, mirrored_if(view.side.below, wi))
    return wi, quotient(f_cos, pdf), pdf, _flags(passes)


@kernel
def _flags(passes):
    return where(passes, lanes_u32(TRANSMISSION), lanes_u32(REFLECTION))


# ---------------------------------------------------------------- coats with normals of their own


@kernel
def _seen_apart(params, wo):
    """(params, view) of what is below a coat, with the coat as it is seen."""
    own = seen_from(params.own_coat, mirrored_if(wo.z < 0.0, wo))
    params = replace(params, own_coat=own)
    w = below_coat(own, wo)
    # Where what is below turns away it is cut (`left_below`), and says nothing of the coat's side.
    w = where(w.z * wo.z > 0.0, w, wo)
    return params, view_from(params, along_facets(params.brush.turn, w))


@kernel
def _values_apart(params, view, wo, wi):
    own, below = params.own_coat, view.side.below
    w = along_facets(params.brush.turn, below_coat(own, wi))
    f_cos, pdf = values(params, view, mirrored_if(below, w))
    left = left_below(own, wo, wi)
    f_cos, pdf = f_cos * left, where(left > 0.0, pdf, 0.0)
    coat, coat_pdf = _coat_apart(params, view, mirrored_if(below, wo), mirrored_if(below, wi))
    return f_cos + lanes_vec3(1.0) * coat, pdf + coat_pdf


@kernel
def _over_coat(params, view, wo, wi):
    """(mask: both are above the surface and the coat, wo, wi in the coat's frame)."""
    s, t, n = axes_of(params.own_coat)
    o, i = to_local(s, t, n, wo), to_local(s, t, n, wi)
    valid = (wo.z > 0.0) & (wi.z > 0.0) & (o.z > 0.0) & (i.z > 0.0) & ~view.side.inside
    up = Vec3(lanes(0.0), lanes(0.0), lanes(1.0))
    return valid, where(valid, o, up), where(valid, i, up)


@kernel
def _coat_apart(params, view, wo, wi):
    """(f_cos, pdf) of the coat, as a number, in the surface's own frame."""
    valid, o, i = _over_coat(params, view, wo, wi)
    cosine, masking, pdf = mirrored_by(params.coat.facets, o, i)
    fresnel, _ = fresnel_dielectric(cosine, lanes(COAT_IOR))
    value = view.layers.coat * (fresnel * masking * pdf) * left_of_coat(params.own_coat, wi)
    return where(valid, value, 0.0), where(valid, view.chances.coat * pdf, 0.0)


@kernel
def _evaluate_apart(params, wo, wi):
    params, view = _seen_apart(params, wo)
    return _values_apart(params, view, wo, wi)


@kernel
def _sample_apart(params, wo, u, u2):
    params, view = _seen_apart(params, wo)
    below = view.side.below
    w, passes = direction(params, view, u, u2)
    w = from_facets(params.brush.turn, mirrored_if(below, w))
    wi = from_below_coat(params.own_coat, w)
    mirrored, coat = _direction_of_coat(params, view, mirrored_if(below, wo), u, u2)
    wi = renormalize(where(coat, mirrored_if(below, mirrored), wi))
    # One that its own lobe does not send out has failed, whatever the other frame's lobes do there.
    over, _, _ = _over_coat(params, view, mirrored_if(below, wo), mirrored_if(below, wi))
    # A direction in the surface of what is below may have any sign here, by rounding.
    below_sends = (w.z * wi.z > 0.0) & (left_below(params.own_coat, wo, wi) > 0.0)
    sent = where(coat, over, below_sends)
    wi = where(sent, wi, Vec3(lanes(1.0), lanes(0.0), lanes(0.0)))
    f_cos, pdf = _values_apart(params, view, wo, wi)
    f_cos, pdf = where(sent, f_cos, 0.0), where(sent, pdf, 0.0)
    return wi, quotient(f_cos, pdf), pdf, _flags(passes & ~coat)


@kernel
def _direction_of_coat(params, view, wo, u, u2):
    """(wi, mask: chosen by u): mirrored at a facet of the coat."""
    chosen = (u >= view.chances.facets) & (u < view.chances.facets + view.chances.coat)
    s, t, n = axes_of(params.own_coat)
    o = to_local(s, t, n, wo)
    o = where(o.z > 0.0, o, Vec3(lanes(0.0), lanes(0.0), lanes(1.0)))
    wm = sample_ggx_visible(params.coat.facets, o, u2)
    return to_world(s, t, n, reflect(o, wm)), chosen
