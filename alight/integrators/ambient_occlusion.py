r"""Ambient occlusion: which part of the hemisphere above a point is open.

.. math:: A(x) = \frac{1}{\pi} \int V(x, \omega)\, \cos\theta\, d\omega

V is 1 where nothing is hit within `distance`. Materials and lights play no part.

Source: Zhukov, Iones and Kronin, An ambient light illumination model (1998).
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.accel import intersect_closest, is_occluded
from alight.core.constants import INFINITY
from alight.core.field_types import Positive
from alight.core.spec import Integrator
from alight.core.vec import dot
from alight.core.warps import square_to_cosine_hemisphere
from alight.integrators.walk import BSDF_DIRECTION, count_lanes, to_world, vertex_dimension
from alight.samplers.sampling import get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, lanes, lanes_mask, where


class AmbientOcclusion(Integrator):
    """Openness of each point.

    Parameters
    ----------
    distance : float > 0, metres, optional
        How far an occluder may be; any distance by default.
    """

    needs_light: ClassVar[bool] = False
    type: Literal["ambient_occlusion"] = "ambient_occlusion"
    distance: Positive | None = None


EXAMPLES = (AmbientOcclusion(), AmbientOcclusion(distance=0.5))


def step(program):
    """The kernel that looks at the hemisphere above the first surface."""

    @kernel
    def ambient_occlusion_step(scene, settings, path):
        """The first and only vertex of each path."""
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        rays = path.rays + count_lanes(path.active)
        depth = path.depth + 1
        active = path.active & (hit.t < INFINITY)
        L = path.L
        if any_lane(active):
            surface = make_surface(scene, hit, path.o, path.d, active)
            # cos / pi is the density of these directions: each open one counts 1.
            wi = square_to_cosine_hemisphere(
                get_2d(path.sampler, vertex_dimension(depth) + BSDF_DIRECTION)
            )
            d = to_world(surface, wi)
            # The side that is looked at, whichever way the surface faces.
            d = where(dot(surface.ns, path.d) > 0.0, -d, d)
            o = spawn_origin(surface.p, surface.error, surface.ng, d)
            rays += count_lanes(active)
            shut = is_occluded(scene, o, d, lanes(settings.distance), active)
            L = where(active & ~shut, path.beta, L)
        return replace(path, L=L, L_direct=L, depth=depth, active=lanes_mask(False), rays=rays)

    return ambient_occlusion_step
