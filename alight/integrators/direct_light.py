"""Light sampling where a path meets a surface: the other technique of multiple importance sampling.

The light that directions of the BSDF happen to find is in `alight.integrators.reach`.
"""

from __future__ import annotations

from alight.accel import is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.switch import has_null
from alight.core.vec import max_component
from alight.integrators.guided import is_guided, mixed_density
from alight.integrators.interiors.body_walk import enters_body, lit_side
from alight.integrators.interiors.enclosing import bodies_beyond, dimmed, left_along
from alight.integrators.shadow_rays import transmittance_through_holes
from alight.integrators.walk import (
    LIGHT_CHOICE,
    LIGHT_POINT,
    count_lanes,
    gather_light,
    gather_unguided,
    to_local,
    vertex_dimension,
)
from alight.lights.sampling import sample_light, shadow_ray
from alight.samplers.sampling import get_1d, get_2d
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, lanes, lanes_u32


def write_add_direct_light(program, light_weight, by_light, listeners):
    """Light sampling, ``(scene, settings, path, surface, wo, active, here) -> path``.

    Only delta lights count unless `by_light`.
    """
    recorded, sample = listeners.sample is not None, listeners.sample
    holes, guided = has_null(program), is_guided(program)

    @kernel
    def add_direct_light(scene, settings, path, surface, wo, active, here):
        rays, depth = path.rays, path.depth + 1
        dimension = vertex_dimension(depth)
        n = lit_side(scene, surface, wo)
        light = sample_light(
            scene, surface.p, n, get_1d(path.sampler, dimension + LIGHT_CHOICE),
            get_2d(path.sampler, dimension + LIGHT_POINT), active,
        )  # fmt: skip
        lit = active & (light.pdf > 0.0)
        if not by_light:
            lit = lit & light.delta
        # What lies inside is for walks there to find.
        lit = lit & ~enters_body(scene, surface, light.wi)
        if any_lane(lit):
            wi = to_local(surface, light.wi)
            f_cos, pdf = evaluate_bsdf(scene, surface, wo, wi, lit)
            of_bsdf = pdf
            if guided:
                pdf = mixed_density(settings, here, light.wi, pdf, lit)
            lit = lit & ~(max_component(f_cos) <= 0.0)
            o, end = shadow_ray(surface, light)
            passed, share = lanes_u32(0), lanes(1.0)
            around = bodies_beyond(scene, path.bodies, surface, path.d, light.wi)
            if holes:
                # A hole is the end of an edge, for paths and so for shadow rays too.
                most = passed + settings.max_depth - depth - 1
                ray = o, light.wi, end, around
                share, left, passed, rays = transmittance_through_holes(scene, ray, most, lit, rays)
                lit = lit & (share > 0.0)
                w = share * light_weight(light, pdf)
            else:
                rays += count_lanes(lit)
                lit = lit & ~is_occluded(scene, o, light.wi, end, lit)
                w, left = light_weight(light, pdf), left_along(around, end, lit)
            Le = dimmed(light.radiance, left)
            Ld = path.beta * f_cos * Le * (w / light.pdf)
            path = gather_light(path, Ld, lit, depth + passed <= 1)
            if guided:
                w = share * light_weight(light, of_bsdf)
                Lu = path.beta * f_cos * Le * (w / light.pdf)
                path = gather_unguided(path, Lu, lit)
            if recorded:
                sample(scene, path, surface.p, n, passed, lit, Ld)
        return replace(path, rays=rays)

    return add_direct_light
