"""The lobes of `principled`, evaluated and sampled; see `alight.bsdfs.disney.view`."""

from __future__ import annotations

from alight.bsdfs.disney.parameters import COAT, GLASS, SHEEN
from alight.bsdfs.disney.sheen import sheen_f_cos
from alight.bsdfs.disney.view import (
    COAT_IOR,
    film_reflectance,
    mixed,
    rows_from,
    schlick,
)
from alight.bsdfs.microfacets.albedo_table import (
    place_of,
    read_bounced,
)
from alight.core.constants import INV_PI, INV_TWO_PI
from alight.core.frame import mirrored_if
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import Facets, ggx_density, ggx_visible_area, sample_ggx_visible
from alight.core.vec import (
    Vec3,
    dot,
    lerp,
    luminance,
    normalize,
    reflect,
    renormalize,
)
from alight.core.warps import square_to_cosine_hemisphere, square_to_uniform_hemisphere
from alight.shapes.hit import OWN_COAT
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    absolute,
    lanes,
    lanes_mask,
    lanes_vec3,
    maximum,
    minimum,
    where,
)

# ---------------------------------------------------------------- facets of the base


@kernel
def _facet_terms(params, view, cosine):
    """(metal, dielectric, F): Fresnel's terms at a facet, and the dielectric's plain one."""
    plain, _ = fresnel_dielectric(cosine, view.side.eta)
    dielectric = view.fresnel.a + view.fresnel.b * plain
    # At the normal a black tint leaves only the rounding of a + b F, at the rim F is 1.
    dielectric = Vec3(_unit(dielectric.x), _unit(dielectric.y), _unit(dielectric.z))
    metal = schlick(cosine, params.base_color)
    share, film = film_reflectance(params, view.side.inside, view.fresnel.a, view.fresnel.b, cosine)
    return mixed(share, metal, film), mixed(share, dielectric, film), plain


@kernel
def _unit(x):
    return minimum(maximum(x, 0.0), 1.0)


@specialised
def _chance_of_reflection(program):
    """``(params, view, metal, dielectric) -> probability`` of reflection at a facet."""
    if GLASS not in program.bsdfs:
        return _all_reflected

    @kernel
    def chance(params, view, metal, dielectric):
        rest = 1.0 - params.metallic
        f = luminance(dielectric)
        opaque = where(view.side.inside, 0.0, params.metallic * luminance(metal))
        plastic = where(view.side.inside, params.transmission, 1.0) * rest
        back = opaque + plastic * f
        through = rest * params.transmission * maximum(1.0 - f, 0.0) * luminance(params.base_color)
        return back / maximum(back + through, 1e-9)

    return chance


@kernel
def _all_reflected(params, view, metal, dielectric):
    return lanes(1.0)


@kernel
def _reflection_factor(params, view, metal, dielectric):
    """Of the facets' mirrored light: metal, plastic and glass."""
    rest, t = 1.0 - params.metallic, params.transmission
    opaque = metal * view.factors.metal * params.metallic + dielectric * (rest * (1.0 - t))
    opaque = where(view.side.inside, lanes_vec3(0.0), opaque)
    return opaque + dielectric * view.factors.glass * (rest * t)


@kernel
def mirrored_by(facets, wo, wi):
    """(cosine, G1(wi), pdf) at the facets that mirror wo to wi."""
    wm = normalize(wo + wi)
    pdf = 0.25 * ggx_density(facets, wm) / ggx_visible_area(facets, wo)
    return minimum(maximum(dot(wo, wm), 0.0), 1.0), wi.z / ggx_visible_area(facets, wi), pdf


@specialised
def _facets_f_cos(program):
    """``(params, view, wi) -> (f_cos, pdf)`` of the base's facets, without the layers above."""
    return _facets_of_glass if GLASS in program.bsdfs else _facets_above


@kernel
def _facets_above(params, view, wi):
    cosine, masking, pdf = mirrored_by(params.brush.facets, view.side.wo, wi)
    metal, dielectric, _ = _facet_terms(params, view, cosine)
    factor = _reflection_factor(params, view, metal, dielectric)
    return factor * (masking * pdf), pdf


@kernel
def _facets_of_glass(params, view, wi):
    reflects = wi.z > 0.0
    # A sheet lets pass what it would reflect, mirrored to its other side.
    bends = ~reflects & ~params.thin
    w = mirrored_if(~reflects & params.thin, wi)
    wm = view.side.wo + where(bends, view.side.eta, 1.0) * w
    wm = normalize(where(wm.z < 0.0, -wm, wm))
    cos_o, cos_i = dot(view.side.wo, wm), dot(w, wm)
    metal, dielectric, _ = _facet_terms(params, view, minimum(maximum(cos_o, 0.0), 1.0))
    # Density of wi over that of wm, as in `alight.bsdfs.dielectrics.rough_dielectric`.
    projected = cos_o + view.side.eta * cos_i
    stretched = view.side.eta / where(projected == 0.0, 1.0, projected)
    refracted = -cos_o * cos_i * (stretched * stretched)
    jacobian = where(bends, refracted, 0.25)
    pdf = (
        jacobian
        * ggx_density(params.brush.facets, wm)
        / ggx_visible_area(params.brush.facets, view.side.wo)
    )
    turned = (bends & (cos_i < 0.0)) | (~bends & (cos_i > 0.0))
    pdf = where(turned & (cos_o > 0.0), pdf, 0.0)
    masking = absolute(wi.z) / ggx_visible_area(params.brush.facets, wi)
    masking = where(bends, masking / (view.side.eta * view.side.eta), masking)
    clear = lanes_vec3(1.0) - dielectric
    share_of_glass = (1.0 - params.metallic) * params.transmission
    through = clear * view.factors.glass * params.base_color * share_of_glass
    factor = where(reflects, _reflection_factor(params, view, metal, dielectric), through)
    chance = _chance_of_reflection(params, view, metal, dielectric)
    return factor * (masking * pdf), pdf * where(reflects, chance, 1.0 - chance)


# ---------------------------------------------------------------- layers


@specialised
def _coat_f_cos(program):
    """``(params, view, wi) -> (f_cos, pdf)`` of the coat, as a number."""
    if COAT not in program.bsdfs or OWN_COAT in program.bsdfs:
        return _nothing

    @kernel
    def coat(params, view, wi):
        cosine, masking, pdf = mirrored_by(params.coat.facets, view.side.wo, wi)
        fresnel, _ = fresnel_dielectric(cosine, lanes(COAT_IOR))
        return view.layers.coat * (fresnel * masking * pdf), view.chances.coat * pdf

    return coat


@specialised
def _sheen_f_cos(program):
    """``(params, view, wi) -> (f_cos, pdf)`` of the sheen."""
    if SHEEN not in program.bsdfs:
        return _nothing

    @kernel
    def sheen(params, view, wi):
        value = sheen_f_cos(params.sheen.rows, params.sheen.roughness, view.side.wo, wi)
        return view.layers.sheen * value, view.chances.sheen * INV_TWO_PI

    return sheen


@kernel
def _nothing(params, view, wi):
    return lanes(0.0), lanes(0.0)


@kernel
def _diffuse_factor(params, view, wi):
    """f / (diffuse / pi): what enters the plastic on the way of wi."""
    white, reflected = read_bounced(rows_from(params, wi), place_of(wi.z))
    left = lanes_vec3(1.0) - (view.fresnel.a * white + view.fresnel.b * reflected)
    # The film's share only looks at the viewer.
    return mixed(view.fresnel.film, left, lanes_vec3(1.0))


# ---------------------------------------------------------------- all together


@specialised
def values(program):
    """``(params, view, wi) -> (f_cos, pdf)``, wi mirrored as the viewer is."""
    glass = GLASS in program.bsdfs

    @kernel
    def values(params, view, wi):
        above = view.side.seen & (wi.z > 0.0)
        valid = above
        if glass:
            valid = above | (view.side.seen & (wi.z < 0.0))
        # Elsewhere the overhead direction replaces it; the result is not used.
        wi = where(valid, wi, Vec3(0.0, 0.0, 1.0))
        f_cos, pdf = _facets_f_cos(params, view, wi)
        f_cos, pdf = f_cos * view.layers.base, pdf * view.chances.facets
        # Lobes of the viewer's own side.
        w = mirrored_if(wi.z < 0.0, wi)
        upper = above & ~view.side.inside
        matte = (
            view.factors.diffuse
            * _diffuse_factor(params, view, w)
            * (view.layers.base * INV_PI * w.z)
        )
        coat, coat_pdf = _coat_f_cos(params, view, w)
        sheen, sheen_pdf = _sheen_f_cos(params, view, w)
        f_cos = f_cos + where(upper, matte + sheen + coat, lanes_vec3(0.0))
        others = coat_pdf + sheen_pdf + view.chances.diffuse * INV_PI * w.z
        pdf = pdf + where(upper, others, 0.0)
        return where(valid, f_cos, 0.0), where(valid, pdf, 0.0)

    return values


@specialised
def _facets_to_sample(program):
    """``(params, coat) -> Facets``: those of the coat where the mask holds."""
    if COAT not in program.bsdfs or OWN_COAT in program.bsdfs:
        return _base_facets

    @kernel
    def either(params, coat):
        along = where(coat, params.coat.facets.alpha_x, params.brush.facets.alpha_x)
        across = where(coat, params.coat.facets.alpha_y, params.brush.facets.alpha_y)
        return Facets(along, across, lanes(0.0))

    return either


@kernel
def _base_facets(params, coat):
    return params.brush.facets


@specialised
def _facet_direction(program):
    """``(params, view, wm, u, coat) -> (wi, passes)``: mirrored at a facet, or let through."""
    if GLASS not in program.bsdfs:
        return _mirrored_at_facet

    @kernel
    def direction(params, view, wm, u, coat):
        cos_o = minimum(maximum(dot(view.side.wo, wm), 0.0), 1.0)
        metal, dielectric, _ = _facet_terms(params, view, cos_o)
        _, cos_t = fresnel_dielectric(cos_o, view.side.eta)
        # At total internal reflection nothing is refracted, not even where metal leaves glass no
        # part.
        open_ = (params.thin | (cos_t > 0.0)) & ~coat
        passes = (u >= _chance_of_reflection(params, view, metal, dielectric)) & open_
        mirrored = reflect(view.side.wo, wm)
        refracted = (cos_o / view.side.eta - cos_t) * wm - view.side.wo / view.side.eta
        through = where(params.thin, mirrored_if(params.thin, mirrored), refracted)
        wi = renormalize(where(passes, through, mirrored))
        above = wi.z > 0.0
        right = ((above & ~passes) | (~above & passes)) & (cos_o > 0.0)
        # In the surface it has neither density nor weight.
        return where(right, wi, Vec3(1.0, 0.0, 0.0)), passes

    return direction


@kernel
def _mirrored_at_facet(params, view, wm, u, coat):
    return renormalize(reflect(view.side.wo, wm)), lanes_mask(False)


@kernel
def direction(params, view, u, u2):
    """(wi, mask: it passes through): from one of the lobes, mirrored as the viewer is."""
    to_coat = view.chances.facets + view.chances.coat
    to_sheen = to_coat + view.chances.sheen
    facets, coat = u < view.chances.facets, (u >= view.chances.facets) & (u < to_coat)
    wm = sample_ggx_visible(_facets_to_sample(params, coat), view.side.wo, u2)
    mirrored, passes = _facet_direction(params, view, wm, u / view.chances.facets, coat)
    wi = where(u < to_sheen, square_to_uniform_hemisphere(u2), square_to_cosine_hemisphere(u2))
    wi = where(facets | coat, mirrored, wi)
    return wi, facets & passes


@kernel
def albedo(params):
    """A colour, without light and angle."""
    root = (params.eta - 1.0) / (params.eta + 1.0)
    return lerp(params.metallic, params.base_color * (1.0 - root * root), params.base_color)
