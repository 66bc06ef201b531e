r"""Layers (AOVs): what the camera sees first, without light.

One pass of its own over the same samples as the picture's, for all layers together, so that asking
for layers never changes the picture. Where a ray meets nothing a layer is 0. Layers are means over
the samples of a pixel, weighted by the pixel filter; ids are those of its first sample
(`alight.films.FIRST_SAMPLE_LAYERS`).

The layers ``albedo_through`` and ``normal_through`` are for denoisers: they follow mirrors and
glass, that is delta lobes, to the first surface that is not one, where the structure of the picture
comes from:

.. math:: \text{albedo} = \Big( \prod_k w_k \Big)\, \rho(x_n), \qquad
    \text{normal} = n_s(x_n), \qquad n \le 1 + \mathtt{MOST\_BOUNCES}

with the weights w of the delta lobes, among them the colour of a mirror. At glass one lobe is
chosen at random with its probability, from the very random numbers of the picture: the mean is the
blend of what is reflected and what is refracted by Fresnel's factors, for one ray a bounce, and the
layer shows the same edges as the picture at few samples too. (Always following the likelier lobe
would lose reflections altogether and put seams where Fresnel's factor is 1/2.) Of a material with
both delta and smooth lobes the smooth part counts with the weight of its sample. Normals are
those of the surface that is seen, in the world, not mirrored back: they tell surfaces apart, and
mirroring them would need one convention a lobe. The surface at which the number of bounces is used
up counts as it is.

The layer ``alpha`` is coverage (`alight.integrators.coverage`): the share of the pixel's samples
that meet a surface.

The layer ``guide_share`` looks through the same delta lobes: it is the probability with which the
guide, and not the BSDF, draws the direction at the first surface that scatters light smoothly
(`alight.integrators.guided`), and 0 in pictures without a guide.

Source: the documentation of Intel Open Image Denoise, "Albedos" and "Normals": features of the
first hit, or of the first diffuse or glossy one behind perfect reflections and refractions.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterable

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import albedo_bsdf, is_mixed, sample_bsdf
from alight.bsdfs.flags import DELTA
from alight.cameras.table import origin_in_world
from alight.core.constants import INFINITY
from alight.core.vec import Vec3, max_component
from alight.films.fixed_point import put_limbs
from alight.integrators.coverage import write_cover
from alight.integrators.guided import guide_at, is_guided
from alight.integrators.moments import at_times_of
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    LANES,
    any_lane,
    as_int,
    count_bits,
    is_finite,
    lanes,
    lanes_vec3,
    local_floats,
    local_uints,
    mask_bits,
    store_lanes,
    to_float,
    trailing_zeros,
    where,
)

#: Layers and their channels. ids count from 1; 0 is nothing. depth: metres along the ray.
LAYERS = {
    "albedo": ("R", "G", "B"),
    "normal": ("X", "Y", "Z"),
    "geometric_normal": ("X", "Y", "Z"),
    "position": ("X", "Y", "Z"),
    "depth": ("Z",),
    "uv": ("U", "V"),
    "id": ("shape", "primitive", "bsdf"),
    "alpha": ("A",),
    "albedo_through": ("R", "G", "B"),
    "normal_through": ("X", "Y", "Z"),
    "guide_share": ("A",),
}

ALBEDO, NORMAL, GEOMETRIC_NORMAL, POSITION, DEPTH, UV, ID, ALPHA = range(8)
ALBEDO_THROUGH, NORMAL_THROUGH, GUIDE_SHARE = range(8, len(LAYERS))

#: The layers of the first hit, as bits of `LayerFilm.wanted`.
FIRST_HIT = (1 << ALPHA) - 1

#: Layers that follow delta lobes, and what programs that have them say among their AOVs.
THROUGH_LAYERS = frozenset({"albedo_through", "normal_through", "guide_share"})
THROUGH = "through"

#: The layer that asks the guide, if there is one.
ASKS_GUIDE = "guide_share"

#: The layer of coverage, whose rays go on through holes.
COVERAGE = "alpha"

#: What a tile keeps: the `Tile`; its wanted layers as bits; sums, whole numbers: for each of them,
#: in the order of `LAYERS`, the two limbs of three channels a pixel.
LayerFilm = namedtuple("LayerFilm", "tile wanted sums")

#: Delta lobes that are followed at most: in and out of three glasses behind one another, a window
#: of two panes and a mirror behind it.
MOST_BOUNCES = 8


def layer_bits(names: Iterable[str]) -> int:
    """What `LayerFilm.wanted` must be for these layers."""
    return sum(1 << number for number, name in enumerate(LAYERS) if name in names)


@specialised
def add_layers(program):
    """``add_layers(scene, settings, film, path)``: those of a packet of camera rays, to a film.

    film: `LayerFilm`.
    """
    look_at_others = _write_look_and_follow(program) if THROUGH in program.aovs else look_once
    if COVERAGE not in program.aovs:
        return look_at_others
    cover = write_cover(program, add_alpha)

    @kernel
    def look_and_cover(scene, settings, film, path):
        if film.wanted != (1 << ALPHA):
            look_at_others(scene, settings, film, path)
        if film.wanted & (1 << ALPHA) != 0:
            cover(at_times_of(scene, path.sampler), film, path)

    return look_and_cover


@kernel
def look_once(scene, settings, film, path):
    """`add_layers` of the first surfaces."""
    seen = at_times_of(scene, path.sampler)
    hit = intersect_closest(seen, path.o, path.d, lanes(INFINITY), path.active)
    active = path.active & (hit.t < INFINITY)
    surface = make_surface(seen, hit, path.o, path.d, active)
    for layer in range(ALPHA):
        if film.wanted & (1 << layer) != 0:
            value = first_hit(seen, layer, path, hit, surface)
            add_layer(film, layer, path, value, active)


def _write_look_and_follow(program):
    follow_delta = _write_follow_delta(program)

    @kernel
    def look_and_follow(scene, settings, film, path):
        if film.wanted & FIRST_HIT != 0:
            look_once(scene, settings, film, path)
        follow_delta(at_times_of(scene, path.sampler), settings, film, path)

    return look_and_follow


@kernel
def first_hit(scene, layer, path, hit, surface):
    """Value of a layer that looks at the first surface only."""
    value = lanes_vec3(0.0)
    if layer == ALBEDO:
        wo = to_local(surface, -path.d)
        value = albedo_bsdf(scene, surface, wo, path.active & (hit.t < INFINITY))
    elif layer == NORMAL:
        value = surface.ns
    elif layer == GEOMETRIC_NORMAL:
        value = surface.ng
    elif layer == POSITION:
        value = surface.p + origin_in_world(scene.camera)
    elif layer == DEPTH:
        value = Vec3(hit.t, lanes(0.0), lanes(0.0))
    elif layer == UV:
        value = Vec3(surface.u, surface.v, lanes(0.0))
    else:
        first = (path.sampler.index == 0) & (path.sampler.scramble == 0)
        ids = Vec3(to_float(hit.shape + 1), to_float(hit.prim + 1), to_float(surface.bsdf + 1))
        value = where(first, ids, 0.0)
    weight = lanes_vec3(1.0)
    if layer != ID:
        weight = path.beta
    return value * weight


def _write_follow_delta(program):
    """``(scene, settings, film, path)``: add the layers that look through delta lobes."""
    guided = is_guided(program)

    @kernel
    def follow_delta(scene, settings, film, path):
        white = path.beta
        while any_lane(path.active):
            hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
            active = path.active & (hit.t < INFINITY)
            surface = make_surface(scene, hit, path.o, path.d, active)
            wo = to_local(surface, -path.d)
            dimension = vertex_dimension(path.depth + 1)
            u = get_1d(path.sampler, dimension + BSDF_CHOICE)
            u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
            wi, weight, _, flags = sample_bsdf(scene, surface, wo, u, u2, active)
            passes = active & ((flags & DELTA) != 0) & (path.depth < MOST_BOUNCES)
            passes = passes & ~(max_component(weight) <= 0.0)
            # Beside delta lobes the albedo of the whole material would count them twice.
            smooth = is_mixed(scene, surface) & ((flags & DELTA) == 0)
            albedo = where(smooth, weight, albedo_bsdf(scene, surface, wo, active))
            for layer in range(ALBEDO_THROUGH, NORMAL_THROUGH + 1):
                if film.wanted & (1 << layer) != 0:
                    value = white * surface.ns
                    if layer == ALBEDO_THROUGH:
                        value = path.beta * albedo
                    add_layer(film, layer, path, value, active & ~passes)
            if guided:
                share = Vec3(guide_at(settings, surface.p).share, lanes(0.0), lanes(0.0))
                # Delta lobes alone ask no guide.
                asks = is_mixed(scene, surface) | ((flags & DELTA) == 0)
                if film.wanted & (1 << GUIDE_SHARE) != 0:
                    add_layer(film, GUIDE_SHARE, path, white * share, active & ~passes & asks)
            d = to_world(surface, wi)
            o = spawn_origin(surface.p, surface.error, surface.ng, d)
            beta, depth = path.beta * weight, path.depth + 1
            path = replace(path, o=o, d=d, beta=beta, depth=depth, active=passes)

    return follow_delta


@kernel
def add_alpha(film, path, hit, mask):
    """Add the layer of coverage where the picture's path has met a surface."""
    add_layer(film, ALPHA, path, path.beta, mask)


@kernel(strict=True)
def add_layer(film, layer, path, value, mask):
    """Add one layer of the samples in the lanes of the mask, exactly, as the picture is added up.

    A value with one channel that is not a number adds nothing to the others either.
    """
    limbs, pixels = local_floats(16 * 6), local_uints(16)
    valid = is_finite(value.x) & is_finite(value.y) & is_finite(value.z)
    value = where(valid, value, lanes_vec3(0.0))
    put_limbs(limbs, 0, value.x)
    put_limbs(limbs, 1, value.y)
    put_limbs(limbs, 2, value.z)
    tile = film.tile
    width = tile.x1 - tile.x0
    store_lanes(pixels, 0, (path.sampler.y - tile.y0) * width + (path.sampler.x - tile.x0))
    start = count_bits(film.wanted & ((1 << layer) - 1)) * width * (tile.y1 - tile.y0)
    bits = mask_bits(mask)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = (start + as_int(pixels[lane])) * 6
        for i in range(6):
            film.sums[at + i] += as_int(limbs[i * LANES + lane])
