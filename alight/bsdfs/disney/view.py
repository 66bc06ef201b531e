"""The lobes of `principled`: their parameters, and how they are weighed against each other.

What depends on the viewer's direction alone is a `View`. There the viewer is above the surface: if
he is below it, all directions are mirrored at it. Lobes that no material of a program has are not
compiled; their parameters are then a number that nothing reads.
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.disney.parameters import COAT, FILM, GLASS, SHEEN
from alight.bsdfs.disney.sheen import sheen_albedo
from alight.bsdfs.disney.thin_film import film_fresnel
from alight.bsdfs.microfacets.albedo_rows import (
    FILM_COSINES,
    FILM_PARTS,
    MEANS,
    PASSED,
    REFLECTED,
    REFRACTED,
)
from alight.bsdfs.microfacets.albedo_table import (
    facet_rows_at,
    place_of,
    read_bounced,
    read_curve,
    read_number,
    read_plain_curve,
)
from alight.bsdfs.microfacets.facets import ANISOTROPIC
from alight.core.frame import mirrored_if
from alight.core.fresnel import fresnel_dielectric, fresnel_schlick
from alight.core.vec import (
    Vec3,
    lerp,
    luminance,
    max_component,
)
from alight.shapes.hit import OWN_COAT
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    where,
)

#: Index of the clear coat.
COAT_IOR = 1.5
#: Least probability of the facets, before all are scaled to add up to 1.
LEAST_SHARE = 0.02

#: The viewer's direction, above the surface; seen: it is his own, else the normal; below: it was
#: mirrored; inside: and the surface bounds a body; eta: index beyond the surface over that before
#: it.
Side = namedtuple("Side", "wo seen below inside eta")
#: Fresnel's term of plastic and glass is a + b F; film: the film's share in it.
Fresnel = namedtuple("Fresnel", "a b film")
#: By what metal, glass and the diffuse part are multiplied.
Factors = namedtuple("Factors", "metal glass diffuse")
#: What each layer gets of the light.
Layers = namedtuple("Layers", "coat sheen base")
#: Probabilities of sampling them.
Chances = namedtuple("Chances", "coat sheen facets diffuse")
#: What follows from the viewer's direction.
View = namedtuple("View", "side fresnel factors layers chances")
#: The base's albedos from there: where they are stored, and W and R of
#: `alight.bsdfs.microfacets.albedo_rows`.
Albedos = namedtuple("Albedos", "rows place white reflected")


# ---------------------------------------------------------------- frames


@specialised
def along_facets(program):
    """``(turn, w) -> w`` in the frame whose x axis is the facets' long one."""
    return _turned if ANISOTROPIC in program.bsdfs else _as_it_is


@specialised
def from_facets(program):
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
def film_reflectance(program):
    """``(params, inside, a, b, cosine) -> (share, F)`` of the film, one for metal and plastic."""
    if FILM not in program.bsdfs:
        return _no_film

    @kernel
    def film(params, inside, a, b, cosine):
        root = (params.eta - 1.0) / (params.eta + 1.0)
        f0 = lerp(params.metallic, a + b * (root * root), params.base_color)
        found = film_fresnel(
            cosine, params.film.iridescence_ior, params.film.iridescence_thickness, f0
        )
        return where(inside, 0.0, params.film.iridescence), found

    return film


@kernel
def _no_film(params, inside, a, b, cosine):
    return lanes(0.0), lanes_vec3(0.0)


@kernel
def schlick(cosine, f0):
    """Schlick's term from a colour at the normal."""
    return Vec3(
        fresnel_schlick(cosine, f0.x), fresnel_schlick(cosine, f0.y), fresnel_schlick(cosine, f0.z)
    )


@specialised
def mixed(program):
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


@kernel
def rows_from(params, w):
    """Where the base's albedos are stored, seen from w."""
    return facet_rows_at(params.rows, params.brush.facets, params.brush.turn.anisotropy, w)


@specialised
def _glass_scale(program):
    """``(params, albedos, fresnel, inside, taken) -> Vec3``: what makes it lossless.

    `taken` is what is reflected where there is a film.
    """
    if GLASS not in program.bsdfs:
        return _no_glass

    @kernel
    def scale(params, albedos, fresnel, inside, taken):
        rows, place, white, _ = albedos
        side = where(inside, lanes_u32(3), lanes_u32(0))
        reflected = read_curve(rows, side + REFLECTED, place)
        refracted = read_curve(rows, side + REFRACTED, place)
        passed = read_curve(rows, side + PASSED, place)
        total = passed + fresnel.a * (white - passed)
        total = total + fresnel.b * (reflected + refracted - passed)
        # Facets under a film let through in proportion to what they let in.
        entering = refracted / maximum(white - reflected, 1e-3)
        total = mixed(fresnel.film, total, taken + (lanes_vec3(1.0) * white - taken) * entering)
        total = where(params.thin, lanes_vec3(1.0) * white, total)
        # Without transmission nothing of this is used, and nothing may pass at all.
        needed = params.compensated & (params.transmission > 0.0)
        return where(needed, 1.0 / where(needed, total, lanes_vec3(1.0)), 1.0)

    return scale


@kernel
def _no_glass(params, albedos, fresnel, inside, taken):
    return lanes_vec3(1.0)


@specialised
def _taken_by_film(program):
    """``(params, albedos, fresnel, needed) -> Vec3``: what facets with a film do not let in.

    Where it is not `needed` it is anything.
    """
    if FILM not in program.bsdfs:
        return _no_taken

    @kernel
    def taken(params, albedos, fresnel, needed):
        rows, place, white, reflected = albedos
        left, i = lanes_vec3(0.0), lanes_u32(0)
        needed = needed & (params.film.iridescence > 0.0)
        while any_lane(needed & (i < FILM_PARTS)):
            cosine = read_curve(rows, FILM_COSINES + i, place)
            plain, _ = fresnel_dielectric(minimum(maximum(cosine, 0.0), 1.0), params.eta)
            _, film = film_reflectance(params, lanes_mask(False), fresnel.a, fresnel.b, cosine)
            left = left + (lanes_vec3(1.0) - film) * (1.0 / maximum(1.0 - plain, 1e-3))
            i = i + 1
        left = left * ((white - reflected) * (1.0 / FILM_PARTS))
        left = Vec3(minimum(left.x, white), minimum(left.y, white), minimum(left.z, white))
        return lanes_vec3(1.0) * white - left

    return taken


@kernel
def _no_taken(params, albedos, fresnel, needed):
    return lanes_vec3(0.0)


@specialised
def _coat_part(program):
    """``(params, place, inside) -> (strength, albedo)`` of the coat."""
    if COAT not in program.bsdfs:
        return _no_layer
    if OWN_COAT in program.bsdfs:
        return _own_coat_part

    @kernel
    def part(params, place, inside):
        found = read_plain_curve(params.coat.rows, lanes_u32(REFLECTED), place)
        return where(inside, 0.0, params.coat.strength), found

    return part


@kernel
def _own_coat_part(params, place, inside):
    """Of a coat that the viewer sees at another angle."""
    cosine = params.own_coat.cosine
    place = place_of(minimum(maximum(cosine, 0.0), 1.0))
    found = read_plain_curve(params.coat.rows, lanes_u32(REFLECTED), place)
    return where(inside | (cosine <= 0.0), 0.0, params.coat.strength), found


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
def view_from(params, wo):
    """The `View` from wo, in the facets' frame."""
    below, inside = _sides(params, wo)
    wo = mirrored_if(below, wo)
    seen = wo.z > 0.0
    wo = where(seen, wo, Vec3(0.0, 0.0, 1.0))
    eta = where(inside, 1.0 / params.eta, params.eta)
    place, rows = place_of(wo.z), rows_from(params, wo)
    white, reflected = read_bounced(rows, place)
    white = maximum(white, 1e-3)
    albedos = Albedos(rows, place, white, reflected)
    a, b = _plain_terms(params, inside)
    share, film = film_reflectance(params, inside, a, b, wo.z)
    rest = 1.0 - params.metallic
    matte = where(inside, 0.0, rest * (1.0 - params.transmission))
    fresnel = Fresnel(a, b, share)
    by_film = _taken_by_film(params, albedos, fresnel, rest > 0.0)
    taken = mixed(share, a * white + b * reflected, by_film)
    glass = _glass_scale(params, albedos, fresnel, inside, by_film)
    f0 = mixed(share, params.base_color, film)
    given = where(params.compensated, (1.0 - white) / white, 0.0)
    metal = lanes_vec3(1.0) + f0 * given
    # What each layer gets.
    coat, coat_albedo = _coat_part(params, place, inside)
    sheen, sheen_own = _sheen_part(params, wo, inside)
    under_coat = 1.0 - coat * coat_albedo
    base = under_coat * (1.0 - max_component(sheen) * sheen_own)
    mean = a * read_number(rows, lanes_u32(MEANS))
    mean = mean + b * read_number(rows, lanes_u32(MEANS + 1))
    # What a film takes is not split between both directions.
    split = mixed(share, lanes_vec3(1.0) - mean, lanes_vec3(1.0))
    diffuse = params.base_color * (lanes_vec3(1.0) - taken) * matte / split
    # Probabilities, by how much light each lobe sends out.
    to_coat = coat * coat_albedo
    to_sheen = under_coat * luminance(sheen) * sheen_own
    facets = params.metallic * luminance(schlick(wo.z, f0))
    facets = facets + rest * (params.transmission + (1.0 - params.transmission) * luminance(taken))
    facets = maximum(base * facets, LEAST_SHARE)
    matte_light = base * matte * luminance(params.base_color) * (1.0 - luminance(taken))
    per_total = 1.0 / (to_coat + to_sheen + facets + maximum(matte_light, 0.0))
    to_diffuse = maximum(matte_light, 0.0) * per_total
    return View(
        Side(wo, seen, below, inside, eta),
        fresnel,
        Factors(metal, glass, diffuse),
        Layers(coat, sheen * under_coat, base),
        Chances(to_coat * per_total, to_sheen * per_total, facets * per_total, to_diffuse),
    )
