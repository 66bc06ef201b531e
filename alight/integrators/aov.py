"""Layers beside the picture (AOVs): what the camera sees first, without light.

A separate pass over the same samples as the picture's, one layer at a time, so that asking for
layers never changes the picture. Where a ray meets nothing a layer is 0. Layers are means over the
samples of a pixel, weighted by the pixel filter; ids are those of its first sample
(`alight.films.FIRST_SAMPLE_LAYERS`).
"""

from __future__ import annotations

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import albedo_bsdf
from alight.core.constants import INFINITY
from alight.core.jit import kernel
from alight.core.simd import any_lane, lanes, lanes_mask, lanes_vec3, to_float, where
from alight.core.vec import Vec3
from alight.integrators.walk import Path, count_lanes
from alight.shapes.surfaces import make_surface

#: Layers and their channels. ids count from 1; 0 is nothing. depth: metres along the ray.
LAYERS = {
    "albedo": ("R", "G", "B"),
    "normal": ("X", "Y", "Z"),
    "geometric_normal": ("X", "Y", "Z"),
    "position": ("X", "Y", "Z"),
    "depth": ("Z",),
    "uv": ("U", "V"),
    "id": ("shape", "primitive", "bsdf"),
}

ALBEDO, NORMAL, GEOMETRIC_NORMAL, POSITION, DEPTH, UV, ID = range(len(LAYERS))


def layer_number(name: str) -> int:
    """What `Settings.layer` must be for a layer."""
    return list(LAYERS).index(name)


def step(program):
    """The kernel that looks at the first surface of each path."""

    @kernel
    def aov_step(scene, settings, path):
        """The first and only vertex of each path."""
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        active = path.active & (hit.t < INFINITY)
        value = lanes_vec3(0.0)
        if any_lane(active):
            surface = make_surface(scene, hit, path.o, path.d, active)
            if settings.layer == ALBEDO:
                value = albedo_bsdf(scene, surface, active)
            elif settings.layer == NORMAL:
                value = surface.ns
            elif settings.layer == GEOMETRIC_NORMAL:
                value = surface.ng
            elif settings.layer == POSITION:
                value = surface.p
            elif settings.layer == DEPTH:
                value = Vec3(hit.t, lanes(0.0), lanes(0.0))
            elif settings.layer == UV:
                value = Vec3(surface.u, surface.v, lanes(0.0))
            else:
                first = (path.sampler.index == 0) & (path.sampler.scramble == 0)
                ids = Vec3(
                    to_float(hit.shape + 1), to_float(hit.prim + 1), to_float(surface.bsdf + 1)
                )
                value = where(first, ids, 0.0)
        weight = lanes_vec3(1.0)
        if settings.layer != ID:
            weight = path.beta
        L = where(active, value * weight, path.L)
        return Path(
            path.o,
            path.d,
            path.p,
            L,
            L,
            path.beta,
            path.pdf,
            path.delta,
            path.depth + 1,
            path.sampler,
            lanes_mask(False),
            path.rays + count_lanes(path.active),
        )

    return aov_step
