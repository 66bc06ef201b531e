r"""Directions of a guide and of the BSDF, as one sample of their mixture.

With the probability :math:`\alpha` of the leaf a direction is drawn from the guide's density
:math:`p_g`, else from the BSDF's :math:`p_b`; whoever drew it, its density is

.. math:: p = \alpha\, p_g + (1 - \alpha)\, p_b ,

which also replaces the BSDF in the weights of multiple importance sampling. Directions of delta
lobes remain the BSDF's: they are drawn with the probability :math:`1 - \alpha`, or always where a
material has nothing else.

Source: Müller, Gross and Novák, Practical path guiding, EGSR 2017.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from alight.bsdfs.dispatch import evaluate_bsdf, is_mixed, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL, REFLECTION, TRANSMISSION
from alight.core.vec import luminance
from alight.guiding.lookup import direction_density, draw_direction, place_at
from alight.guiding.records import Drawn, record_vertices
from alight.guiding.tables import GUIDED, LEAF_ROW
from alight.integrators.roulette import MAX_SURVIVAL
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    ROULETTE,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.samplers.sampling import get_1d, get_2d
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import (
    absolute,
    any_lane,
    bits_float,
    gather,
    gather_row,
    lanes,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    minimum_u32,
    to_float,
    to_uint,
    where,
)

#: A path goes on for sure while what it may add is 1 / `WINDOW` of what a sample of its pixel may
#: be (root mean squares), and with the probability `LEAST` at least.
WINDOW, LEAST = 6.0, 0.05

#: Place of the choice between guide and BSDF among the numbers of a vertex.
GUIDE = 8

#: Where a path scatters. p: point; surface, wo: as of `sample_bsdf`; dimension: first one of its
#: random numbers; collided: mask, in a medium and not at the surface, or empty without media.
Vertex = namedtuple("Vertex", "p surface wo dimension collided")

#: The guide at a vertex: `Place`, and the numbers of its leaf (`alight.guiding.tables`); `NOWHERE`
#: without one.
Here = namedtuple("Here", "place share gain")
NOWHERE: Any = ()


def is_guided(program) -> bool:
    """Whether kernels are given a guide."""
    return program.option(GUIDED, False)


@kernel
def guide_at(settings, p):
    """What the guide has for the point p."""
    place = place_at(settings.guide, p)
    share, gain = gather_row(settings.guide.leaves, place.leaf * LEAF_ROW, 2)
    return Here(place, share, gain)


@kernel
def mixed(share, of_guide, of_bsdf):
    """Density of the mixture."""
    return of_bsdf + share * (of_guide - of_bsdf)


@kernel
def mixed_density(settings, here, w, of_bsdf, active):
    """Density with which a vertex draws the unit direction w, in world space."""
    asked = active & (here.share > 0.0)
    of_guide = direction_density(settings.guide, here.place, w, asked)
    return mixed(here.share, of_guide, of_bsdf)


@kernel
def sample_at_surface(scene, path, vertex, u, u2):
    """A direction of active paths by the BSDF: `BsdfSample`, and in world space."""
    found = sample_bsdf(scene, vertex.surface, vertex.wo, u, u2, path.active)
    return found, to_world(vertex.surface, found.wi)


@kernel
def evaluate_at_surface(scene, path, vertex, w, wi, active):
    """The BSDF's `BsdfValue` for the unit direction w in world space, wi in the shading frame."""
    return evaluate_bsdf(scene, vertex.surface, vertex.wo, wi, active)


def write_guided_scatter(roulette, sample, evaluate):
    """``(scene, settings, path, here, vertex, going) -> (BsdfSample, w, unguided)``.

    Directions of active paths from the mixture, w in world space; unguided: `Unguided` with the
    BSDF's own density (behind holes the last one), and as rare as the choice makes it. It plays
    roulette, if there is one. Training paths leave a record where they are `going`. `sample` and
    `evaluate` are kernels as `sample_at_surface` and `evaluate_at_surface`.
    """

    @kernel
    def guided_scatter(scene, settings, path, here, vertex, going):
        active, guide = path.active, settings.guide
        surface, wo, dimension = vertex.surface, vertex.wo, vertex.dimension
        u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
        u = get_1d(path.sampler, dimension + BSDF_CHOICE)
        found, w = sample(scene, path, vertex, u, u2)
        delta = (found.flags & DELTA) != 0
        # A material has delta lobes only, or none, or both, whatever was drawn.
        only_delta = delta & ~is_mixed(scene, surface)
        share = where(only_delta, 0.0, here.share)

        survived, survival = active, lanes(1.0)
        if roulette:
            survival = survival_of(settings, path, here, only_delta)
            survived = active & (get_1d(path.sampler, dimension + ROULETTE) < survival)
            path = replace(path, beta=path.beta * (1.0 / survival))

        led = survived & (get_1d(path.sampler, dimension + GUIDE) < share)
        smooth = survived & (led | ~delta)
        w, of_guide = draw_direction(guide, here.place, led, u2, w, smooth)
        f_cos, of_bsdf = found.weight * found.pdf, found.pdf
        if any_lane(led):
            wi = to_local(surface, w)
            value = evaluate(scene, path, vertex, w, wi, led)
            f_cos, of_bsdf = where(led, value.f_cos, f_cos), where(led, value.pdf, of_bsdf)
            side = where(wo.z * wi.z > 0.0, lanes_u32(REFLECTION), lanes_u32(TRANSMISSION))
            found = replace(found, wi=where(led, wi, found.wi), flags=where(led, side, found.flags))

        pdf = mixed(share, of_guide, of_bsdf)
        possible = pdf > 0.0
        weight = where(possible, f_cos / where(possible, pdf, 1.0), lanes_vec3(0.0))
        weight = where(smooth, weight, found.weight / (1.0 - share))
        if settings.log.rows.size > 0:
            drawn = Drawn(p=vertex.p, d=w, pdf=pdf, of_bsdf=of_bsdf, weight=weight)
            record_vertices(settings.log, path, drawn, smooth & possible & going)
        weight = where(survived, weight / survival, lanes_vec3(0.0))
        # A delta lobe waits until the guide does not draw.
        likelier = where(of_bsdf > 0.0, pdf / where(of_bsdf > 0.0, of_bsdf, 1.0), 1.0)
        likelier = where(smooth, likelier, 1.0 - share)
        # Behind a hole the last vertex still looks for light.
        turned = active & ((found.flags & NULL) == 0)
        unguided = replace(
            path.unguided,
            pdf=where(turned, of_bsdf, path.unguided.pdf),
            rarity=where(
                active, path.unguided.rarity * (likelier * survival), path.unguided.rarity
            ),
        )
        return replace(found, weight=weight, pdf=where(smooth, pdf, found.pdf)), w, unguided

    return guided_scatter


@kernel
def survival_of(settings, path, here, only_delta):
    """Probability with which paths go on from a vertex.

    Those that will add little to their pixel end. Where only delta lobes scatter light, which leave
    no records, most go on.
    """
    left = (
        absolute(luminance(path.beta)) * here.gain / pixel_luminance(settings.guide, path.sampler)
    )
    # Without anything learnt, ordinary roulette is played (`alight.integrators.path`).
    playing = (here.gain > 0.0) & (path.depth > 0)
    survival = where(playing, minimum(maximum(left * WINDOW, LEAST), 1.0), 1.0)
    in_glass = where(path.depth >= settings.rr_depth, MAX_SURVIVAL, 1.0)
    return where(only_delta & (here.gain > 0.0), in_glass, survival)


@kernel
def pixel_luminance(guide, sampler):
    """Root mean square of what training saw around the pixel of a sample."""
    across = bits_float(gather(guide.blocks, lanes_u32(1)))
    down = bits_float(gather(guide.blocks, lanes_u32(2)))
    column, row = to_uint(to_float(sampler.x) * across), to_uint(to_float(sampler.y) * down)
    last = lanes_u32(guide.picture.size - 1)
    return gather(guide.picture, minimum_u32(row * guide.blocks[0] + column, last))


def write_surface_scatter(roulette):
    """``(scene, settings, path, here, surface, wo) -> (BsdfSample, unguided)``: with a guide."""
    guided_scatter = write_guided_scatter(roulette, sample_at_surface, evaluate_at_surface)

    @kernel
    def next_direction(scene, settings, path, here, surface, wo):
        vertex = Vertex(surface.p, surface, wo, vertex_dimension(path.depth + 1), ())
        found, _, unguided = guided_scatter(scene, settings, path, here, vertex, path.active)
        return found, unguided

    return next_direction
