"""Lights that move while the shutter is open, seen at the times of paths.

They only shift and turn (`alight.scene.moving` refuses others), so distances, angles, solid angles
and hence densities are those at rest: the lit point goes there, the direction comes back.
"""

from __future__ import annotations

from collections.abc import Callable

from alight.core.motion import (
    direction_at_rest,
    inverse_rows,
    matrix_at,
    point_at_rest,
    turned,
)
from alight.core.vec import normalize
from alight.lights.tables import LightSample
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, gather, lanes_u32, where


def moving_sample(sample: Callable) -> Callable:
    """The kernel `sample` of a light type of which some lights move."""

    @kernel
    def sample_moving(scene, index, p, u, u2):
        number = lanes_u32(0) + gather(scene.motions.of_light, index)
        moving = number != 0
        if any_lane(moving):
            w = inverse_rows(matrix_at(scene.motions, where(moving, number - 1, 0), scene.time))
            p = where(moving, point_at_rest(w, p), p)
        s = sample(scene, index, p, u, u2)
        wi = s.wi
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            wi = where(moving, normalize(turned(m, wi)), wi)
        return LightSample(
            wi=wi,
            distance=s.distance,
            radiance=s.radiance,
            pdf=s.pdf,
            delta=s.delta,
            cosine=s.cosine,
            error=s.error,
        )

    return sample_moving


def moving_pdf(pdf: Callable) -> Callable:
    """The kernel `pdf` of area lights, of which some move."""

    @kernel
    def pdf_moving(scene, index, p, hit):
        number = lanes_u32(0) + gather(scene.motions.of_light, index)
        moving = number != 0
        if any_lane(moving):
            w = inverse_rows(matrix_at(scene.motions, where(moving, number - 1, 0), scene.time))
            p = where(moving, point_at_rest(w, p), p)
            hit = replace(hit, wi=where(moving, direction_at_rest(w, hit.wi), hit.wi))
        return pdf(scene, index, p, hit)

    return pdf_moving
