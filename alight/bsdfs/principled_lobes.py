"""The lobes of `principled`: how they are weighed against each other, evaluated and sampled.

What depends on the viewer's direction alone is a `View`. There the viewer is above the surface: if
he is below it, all directions are mirrored at it. Lobes that no material of a program has are not
compiled; their parameters are then a number that nothing reads.
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.albedo_table import (
    MEANS,
    PASSED,
    REFLECTED,
    REFRACTED,
    ROW,
    WHITE,
    place_of,
    read_curve,
    read_row,
    rows_at,
)
from alight.bsdfs.facets import ANISOTROPIC
from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.bsdfs.sheen import sheen_albedo, sheen_f_cos
from alight.bsdfs.thin_film import film_fresnel
from alight.core.constants import INV_PI, INV_TWO_PI
from alight.core.fresnel import fresnel_dielectric, fresnel_schlick
from alight.core.jit import kernel, specialised
from alight.core.microfacet import Facets, ggx_density, ggx_visible_area, sample_ggx_visible
from alight.core.simd import (
    absolute,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    where,
)
from alight.core.vec import (
    Vec3,
    dot,
    lerp,
    luminance,
    max_component,
    normalize,
    reflect,
    renormalize,
)
from alight.core.warps import square_to_cosine_hemisphere, square_to_uniform_hemisphere

#: What programs call lobes that not every material has.
GLASS, COAT = "principled:glass", "principled:coat"
SHEEN, FILM = "principled:sheen", "principled:film"
#: Index of the clear coat.
COAT_IOR = 1.5
#: Least probability of the facets, before all are scaled to add up to 1.
LEAST_SHARE = 0.02

#: Parameters at a point: base and specular_color are colours, facets and table those of the base,
#: thin and compensated masks; the last three are lobes or nothing.
Params = namedtuple(
    "PrincipledParams",
    "base metallic facets turn table eta specular specular_color transmission thin compensated "
    "coat sheen film",
)
#: Where the facets' long axis lies: sine and cosine of its angle from the tangent.
Turn = namedtuple("Turn", "sine cosine")
NO_TURN = Turn(0.0, 1.0)
Coat = namedtuple("Coat", "strength facets rows")
Sheen = namedtuple("Sheen", "color roughness rows")
Film = namedtuple("Film", "share ior thickness")

#: What follows from the viewer's direction `wo`, which is above the surface. rows: of the
#: albedos from there; seen: from `wo`, which is the normal where not; below: wo was mirrored;
#: inside: and the surface bounds a body; eta: index beyond the surface over that before it; a, b:
#: Fresnel's term of plastic and glass is a + b F; metal, glass, diffuse: their factors; coat,
#: sheen, base: what each layer gets of the light; to_coat, to_sheen, to_facets, to_diffuse:
#: probabilities.
View = namedtuple(
    "View",
    "wo rows seen below inside eta a b metal glass diffuse coat sheen base "
    "to_coat to_sheen to_facets to_diffuse",
)


@kernel
def _mirrored(mask, w):
    """w with its height turned over where the mask holds."""
    return Vec3(w.x, w.y, where(mask, -w.z, w.z))


# ---------------------------------------------------------------- frames


@specialised
def _along_facets(program):
    """``(turn, w) -> w`` in the frame whose x axis is the facets' long one."""
    return _turned if ANISOTROPIC in program.bsdfs else _as_it_is


@specialised
def _from_facets(program):
    """``(turn, w) -> w``: the way back."""
    return _turned_back if ANISOTROPIC in program.bsdfs else _as_it_is


@kernel
def _turned(turn, w):
    return Vec3(turn.cosine * w.x + turn.sine * w.y, turn.cosine * w.y - turn.sine * w.x, w.z)


@kernel
def _turned_back(turn, w):
    return Vec3(turn.cosine * w.x - turn.sine * w.y, turn.cosine * w.y + turn.sine * w.x, w.z)


@kernel
def _as_it_is(turn, w):
    return w


# ---------------------------------------------------------------- Fresnel's terms


@kernel
def _plain_terms(params, inside):
    """(a, b) of the term a + b F: tinted at the normal, white towards the rim."""
    root = (params.eta - 1.0) / (params.eta + 1.0)
    f0 = root * root
    tinted = params.specular_color * f0
    tinted = Vec3(minimum(tinted.x, 1.0), minimum(tinted.y, 1.0), minimum(tinted.z, 1.0))
    b = (lanes_vec3(1.0) - tinted) * (params.specular / (1.0 - f0))
    a = tinted * params.specular - b * f0
    # From inside nothing is tinted: all of the light must be reflected where none can pass.
    return where(inside, lanes_vec3(0.0), a), where(inside, lanes_vec3(1.0), b)


@specialised
def _film_reflectance(program):
    """``(params, inside, a, b, cosine) -> (share, F)`` of the film, one for metal and plastic."""
    if FILM not in program.bsdfs:
        return _no_film

    @kernel
    def film(params, inside, a, b, cosine):
        root = (params.eta - 1.0) / (params.eta + 1.0)
        f0 = lerp(params.metallic, a + b * (root * root), params.base)
        found = film_fresnel(cosine, params.film.ior, params.film.thickness, f0)
        return where(inside, 0.0, params.film.share), found

    return film


@kernel
def _no_film(params, inside, a, b, cosine):
    return lanes(0.0), lanes_vec3(0.0)


@kernel
def _schlick(cosine, f0):
    return Vec3(
        fresnel_schlick(cosine, f0.x), fresnel_schlick(cosine, f0.y), fresnel_schlick(cosine, f0.z)
    )


@specialised
def _mixed(program):
    """``(share, a, b) -> a + share (b - a)``, a alone where there is no film."""
    return lerp if FILM in program.bsdfs else _first


@kernel
def _first(share, a, b):
    return a


# ---------------------------------------------------------------- what the viewer's side decides


@specialised
def _sides(program):
    """``(params, wo) -> (below, inside)``."""
    return _two_sides if GLASS in program.bsdfs else _one_side


@kernel
def _two_sides(params, wo):
    below = (wo.z < 0.0) & (params.thin | (params.transmission > 0.0))
    return below, below & ~params.thin


@kernel
def _one_side(params, wo):
    return lanes_mask(False), lanes_mask(False)


@specialised
def _rows_from(program):
    """``(params, w) -> Rows`` of the base's albedos, seen from w."""
    return _rows_of_anisotropic if ANISOTROPIC in program.bsdfs else _rows_of_isotropic


@kernel
def _rows_of_isotropic(params, w):
    return rows_at(params.table, sqrt(params.facets.alpha_x), ROW)


@kernel
def _rows_of_anisotropic(params, w):
    # Isotropic facets that lose less than these do, from any side: a fit from below.
    ax, ay = params.facets.alpha_x, params.facets.alpha_y
    part = 0.4 * w.z * minimum(4.0 * w.z, 1.0)
    squared = ay * ay + part * (ax * ax - ay * ay)
    # Seen edge-on they lose even less than the smoother ones.
    edge = 1.0 - 0.75 * (1.0 - ay / ax) * maximum(1.0 - 8.0 * w.z, 0.0)
    squared = squared * (edge * edge)
    return rows_at(params.table, sqrt(sqrt(maximum(squared, 0.0))), ROW)


@specialised
def _glass_scale(program):
    """``(params, rows, place, inside, a, b, W, share) -> Vec3``: what makes glass lossless."""
    if GLASS not in program.bsdfs:
        return _no_glass

    @kernel
    def scale(params, rows, place, inside, a, b, white, share):
        side = where(inside, lanes_u32(3), lanes_u32(0))
        reflected = read_curve(rows, side + REFLECTED, place)
        refracted = read_curve(rows, side + REFRACTED, place)
        passed = read_curve(rows, side + PASSED, place)
        total = passed + a * (white - passed) + b * (reflected + refracted - passed)
        # A film's share of the light is not known here; neither way loses less than this.
        total = _mixed(share, total, lanes_vec3(1.0) * maximum(white, passed))
        total = where(params.thin, lanes_vec3(1.0) * white, total)
        compensated = params.compensated
        return where(compensated, 1.0 / where(compensated, total, lanes_vec3(1.0)), 1.0)

    return scale


@kernel
def _no_glass(params, rows, place, inside, a, b, white, share):
    return lanes_vec3(1.0)


@specialised
def _coat_part(program):
    """``(params, place, inside) -> (strength, albedo)`` of the coat."""
    if COAT not in program.bsdfs:
        return _no_layer

    @kernel
    def part(params, place, inside):
        found = read_curve(params.coat.rows, lanes_u32(REFLECTED), place)
        return where(inside, 0.0, params.coat.strength), found

    return part


@kernel
def _no_layer(params, place, inside):
    return lanes(0.0), lanes(0.0)


@specialised
def _sheen_part(program):
    """``(params, wo, inside) -> (color, albedo)`` of the sheen."""
    if SHEEN not in program.bsdfs:
        return _no_sheen

    @kernel
    def part(params, wo, inside):
        color = where(inside, lanes_vec3(0.0), params.sheen.color)
        return color, sheen_albedo(params.sheen.rows, wo.z)

    return part


@kernel
def _no_sheen(params, wo, inside):
    return lanes_vec3(0.0), lanes(0.0)


@kernel
def _view(params, wo):
    """The `View` from wo, in the facets' frame."""
    below, inside = _sides(params, wo)
    wo = _mirrored(below, wo)
    seen = wo.z > 0.0
    wo = where(seen, wo, Vec3(0.0, 0.0, 1.0))
    eta = where(inside, 1.0 / params.eta, params.eta)
    place, rows = place_of(wo.z), _rows_from(params, wo)
    white = maximum(read_curve(rows, lanes_u32(WHITE), place), 1e-3)
    reflected = read_curve(rows, lanes_u32(REFLECTED), place)
    a, b = _plain_terms(params, inside)
    share, film = _film_reflectance(params, inside, a, b, wo.z)
    glass = _glass_scale(params, rows, place, inside, a, b, white, share)
    # Rough facets see a film at other angles too: a margin, so that no light is made.
    margin = 0.1 * maximum(params.facets.alpha_x, params.facets.alpha_y)
    bright = film + margin
    bright = Vec3(minimum(bright.x, 1.0), minimum(bright.y, 1.0), minimum(bright.z, 1.0))
    taken = _mixed(share, a * white + b * reflected, bright * white)
    f0 = _mixed(share, params.base, film)
    given = where(params.compensated, (1.0 - white) / white, 0.0)
    metal = lanes_vec3(1.0) + f0 * given
    # What each layer gets.
    coat, coat_albedo = _coat_part(params, place, inside)
    sheen, sheen_own = _sheen_part(params, wo, inside)
    under_coat = 1.0 - coat * coat_albedo
    base = under_coat * (1.0 - max_component(sheen) * sheen_own)
    rest = 1.0 - params.metallic
    matte = where(inside, 0.0, rest * (1.0 - params.transmission))
    mean = a * read_row(rows, lanes_u32(MEANS))
    mean = mean + b * read_row(rows, lanes_u32(MEANS + 1))
    # What a film takes is not split between both directions.
    split = _mixed(share, lanes_vec3(1.0) - mean, lanes_vec3(1.0))
    diffuse = params.base * (lanes_vec3(1.0) - taken) * matte / split
    # Probabilities, by how much light each lobe sends out.
    to_coat = coat * coat_albedo
    to_sheen = under_coat * luminance(sheen) * sheen_own
    facets = params.metallic * luminance(_schlick(wo.z, f0))
    facets = facets + rest * (params.transmission + (1.0 - params.transmission) * luminance(taken))
    facets = maximum(base * facets, LEAST_SHARE)
    matte_light = base * matte * luminance(params.base) * (1.0 - luminance(taken))
    per_total = 1.0 / (to_coat + to_sheen + facets + maximum(matte_light, 0.0))
    return View(
        wo, rows, seen, below, inside, eta, a, b, metal, glass, diffuse,
        coat, sheen * under_coat, base,
        to_coat * per_total, to_sheen * per_total, facets * per_total,
        maximum(matte_light, 0.0) * per_total,
    )  # fmt: skip


# ---------------------------------------------------------------- facets of the base


@kernel
def _facet_terms(params, view, cosine):
    """(metal, dielectric, F): Fresnel's terms at a facet, and the dielectric's plain one."""
    plain, _ = fresnel_dielectric(cosine, view.eta)
    dielectric = view.a + view.b * plain
    metal = _schlick(cosine, params.base)
    share, film = _film_reflectance(params, view.inside, view.a, view.b, cosine)
    return _mixed(share, metal, film), _mixed(share, dielectric, film), plain


@specialised
def _share_reflected(program):
    """``(params, view, metal, dielectric) -> probability`` of reflection at a facet."""
    if GLASS not in program.bsdfs:
        return _all_reflected

    @kernel
    def share(params, view, metal, dielectric):
        rest = 1.0 - params.metallic
        f = luminance(dielectric)
        opaque = where(view.inside, 0.0, params.metallic * luminance(metal))
        plastic = where(view.inside, params.transmission, 1.0) * rest
        back = opaque + plastic * f
        through = rest * params.transmission * maximum(1.0 - f, 0.0) * luminance(params.base)
        return back / maximum(back + through, 1e-9)

    return share


@kernel
def _all_reflected(params, view, metal, dielectric):
    return lanes(1.0)


@kernel
def _reflection_factor(params, view, metal, dielectric):
    """Of the facets' mirrored light: metal, plastic and glass."""
    rest, t = 1.0 - params.metallic, params.transmission
    opaque = metal * view.metal * params.metallic + dielectric * (rest * (1.0 - t))
    return where(view.inside, lanes_vec3(0.0), opaque) + dielectric * view.glass * (rest * t)


@specialised
def _facets_f_cos(program):
    """``(params, view, wi) -> (f_cos, pdf)`` of the base's facets, without the layers above."""
    return _facets_of_glass if GLASS in program.bsdfs else _facets_above


@kernel
def _facets_above(params, view, wi):
    wm = normalize(view.wo + wi)
    cosine = minimum(maximum(dot(view.wo, wm), 0.0), 1.0)
    pdf = 0.25 * ggx_density(params.facets, wm) / ggx_visible_area(params.facets, view.wo)
    metal, dielectric, _ = _facet_terms(params, view, cosine)
    masking = wi.z / ggx_visible_area(params.facets, wi)
    factor = _reflection_factor(params, view, metal, dielectric)
    return factor * (masking * pdf), pdf


@kernel
def _facets_of_glass(params, view, wi):
    reflects = wi.z > 0.0
    # A sheet lets pass what it would reflect, mirrored to its other side.
    bends = ~reflects & ~params.thin
    w = _mirrored(~reflects & params.thin, wi)
    wm = view.wo + where(bends, view.eta, 1.0) * w
    wm = normalize(where(wm.z < 0.0, -wm, wm))
    cos_o, cos_i = dot(view.wo, wm), dot(w, wm)
    metal, dielectric, _ = _facet_terms(params, view, minimum(maximum(cos_o, 0.0), 1.0))
    # Density of wi over that of wm, as in `alight.bsdfs.rough_dielectric`.
    projected = cos_o + view.eta * cos_i
    stretched = view.eta / where(projected == 0.0, 1.0, projected)
    refracted = -cos_o * cos_i * (stretched * stretched)
    jacobian = where(bends, refracted, 0.25)
    pdf = jacobian * ggx_density(params.facets, wm) / ggx_visible_area(params.facets, view.wo)
    turned = (bends & (cos_i < 0.0)) | (~bends & (cos_i > 0.0))
    pdf = where(turned & (cos_o > 0.0), pdf, 0.0)
    masking = absolute(wi.z) / ggx_visible_area(params.facets, wi)
    masking = where(bends, masking / (view.eta * view.eta), masking)
    clear = lanes_vec3(1.0) - dielectric
    through = clear * view.glass * params.base * ((1.0 - params.metallic) * params.transmission)
    factor = where(reflects, _reflection_factor(params, view, metal, dielectric), through)
    share = _share_reflected(params, view, metal, dielectric)
    return factor * (masking * pdf), pdf * where(reflects, share, 1.0 - share)


# ---------------------------------------------------------------- layers


@specialised
def _coat_f_cos(program):
    """``(params, view, wi) -> (f_cos, pdf)`` of the coat, as a number."""
    if COAT not in program.bsdfs:
        return _nothing

    @kernel
    def coat(params, view, wi):
        facets = params.coat.facets
        wm = normalize(view.wo + wi)
        cosine = minimum(maximum(dot(view.wo, wm), 0.0), 1.0)
        pdf = 0.25 * ggx_density(facets, wm) / ggx_visible_area(facets, view.wo)
        fresnel, _ = fresnel_dielectric(cosine, lanes(COAT_IOR))
        masking = wi.z / ggx_visible_area(facets, wi)
        return view.coat * (fresnel * masking * pdf), view.to_coat * pdf

    return coat


@specialised
def _sheen_f_cos(program):
    """``(params, view, wi) -> (f_cos, pdf)`` of the sheen."""
    if SHEEN not in program.bsdfs:
        return _nothing

    @kernel
    def sheen(params, view, wi):
        value = sheen_f_cos(params.sheen.rows, params.sheen.roughness, view.wo, wi)
        return view.sheen * value, view.to_sheen * INV_TWO_PI

    return sheen


@kernel
def _nothing(params, view, wi):
    return lanes(0.0), lanes(0.0)


@kernel
def _diffuse_factor(params, view, wi):
    """f / (diffuse / pi): what enters the plastic on the way of wi."""
    place, rows = place_of(wi.z), _rows_from(params, wi)
    white = read_curve(rows, lanes_u32(WHITE), place)
    reflected = read_curve(rows, lanes_u32(REFLECTED), place)
    left = lanes_vec3(1.0) - (view.a * white + view.b * reflected)
    return _without_film(params, left)


@specialised
def _without_film(program):
    """``(params, left) -> left``, and 1 for the film's share, which only looks at the viewer."""
    if FILM not in program.bsdfs:
        return _left_alone

    @kernel
    def without(params, left):
        return _mixed(params.film.share, left, lanes_vec3(1.0))

    return without


@kernel
def _left_alone(params, left):
    return left


# ---------------------------------------------------------------- all together


@specialised
def _values(program):
    """``(params, view, wi) -> (f_cos, pdf)``, wi mirrored as the viewer is."""
    glass = GLASS in program.bsdfs

    @kernel
    def values(params, view, wi):
        above = view.seen & (wi.z > 0.0)
        valid = above
        if glass:
            valid = above | (view.seen & (wi.z < 0.0))
        # Elsewhere the overhead direction stands in: nothing there is used.
        wi = where(valid, wi, Vec3(0.0, 0.0, 1.0))
        f_cos, pdf = _facets_f_cos(params, view, wi)
        f_cos, pdf = f_cos * view.base, pdf * view.to_facets
        # Lobes of the viewer's own side.
        w = _mirrored(wi.z < 0.0, wi)
        upper = above & ~view.inside
        matte = view.diffuse * _diffuse_factor(params, view, w) * (view.base * INV_PI * w.z)
        coat, coat_pdf = _coat_f_cos(params, view, w)
        sheen, sheen_pdf = _sheen_f_cos(params, view, w)
        f_cos = f_cos + where(upper, matte + sheen + coat, lanes_vec3(0.0))
        others = coat_pdf + sheen_pdf + view.to_diffuse * INV_PI * w.z
        pdf = pdf + where(upper, others, 0.0)
        return where(valid, f_cos, 0.0), where(valid, pdf, 0.0)

    return values


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    view = _view(params, _along_facets(params.turn, wo))
    return _values(params, view, _mirrored(view.below, _along_facets(params.turn, wi)))


@specialised
def _facets_to_sample(program):
    """``(params, coat) -> Facets``: those of the coat where the mask holds."""
    if COAT not in program.bsdfs:
        return _base_facets

    @kernel
    def either(params, coat):
        along = where(coat, params.coat.facets.alpha_x, params.facets.alpha_x)
        across = where(coat, params.coat.facets.alpha_y, params.facets.alpha_y)
        return Facets(along, across, lanes(0.0))

    return either


@kernel
def _base_facets(params, coat):
    return params.facets


@specialised
def _facet_direction(program):
    """``(params, view, wm, u, coat) -> (wi, passes)``: mirrored at a facet, or let through."""
    if GLASS not in program.bsdfs:
        return _mirrored_at_facet

    @kernel
    def direction(params, view, wm, u, coat):
        cos_o = minimum(maximum(dot(view.wo, wm), 0.0), 1.0)
        metal, dielectric, _ = _facet_terms(params, view, cos_o)
        passes = (u >= _share_reflected(params, view, metal, dielectric)) & ~coat
        _, cos_t = fresnel_dielectric(cos_o, view.eta)
        mirrored = reflect(view.wo, wm)
        refracted = (cos_o / view.eta - cos_t) * wm - view.wo / view.eta
        through = where(params.thin, _mirrored(params.thin, mirrored), refracted)
        wi = renormalize(where(passes, through, mirrored))
        above = wi.z > 0.0
        right = (above & ~passes) | (~above & passes)
        # In the surface it has neither density nor weight.
        return where(right, wi, Vec3(1.0, 0.0, 0.0)), passes

    return direction


@kernel
def _mirrored_at_facet(params, view, wm, u, coat):
    return renormalize(reflect(view.wo, wm)), lanes_mask(False)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the lobes, chosen by u."""
    view = _view(params, _along_facets(params.turn, wo))
    to_coat = view.to_facets + view.to_coat
    to_sheen = to_coat + view.to_sheen
    facets, coat = u < view.to_facets, (u >= view.to_facets) & (u < to_coat)
    wm = sample_ggx_visible(_facets_to_sample(params, coat), view.wo, u2)
    mirrored, passes = _facet_direction(params, view, wm, u / view.to_facets, coat)
    wi = where(u < to_sheen, square_to_uniform_hemisphere(u2), square_to_cosine_hemisphere(u2))
    wi = where(facets | coat, mirrored, wi)
    f_cos, pdf = _values(params, view, wi)
    weight = f_cos * where(pdf > 0.0, 1.0 / where(pdf > 0.0, pdf, 1.0), 0.0)
    flags = where(facets & passes, lanes_u32(TRANSMISSION), lanes_u32(REFLECTION))
    return _from_facets(params.turn, _mirrored(view.below, wi)), weight, pdf, flags


@kernel
def albedo(params):
    """A colour, without light and angle."""
    root = (params.eta - 1.0) / (params.eta + 1.0)
    return lerp(params.metallic, params.base * (1.0 - root * root), params.base)
