r"""Layers (AOVs): what the camera sees first, without light.

A separate pass over the same samples as the picture's, one layer at a time, so that asking for
layers never changes the picture. Where a ray meets nothing a layer is 0. Layers are means over the
samples of a pixel, weighted by the pixel filter; ids are those of its first sample
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

Source: the documentation of Intel Open Image Denoise, "Albedos" and "Normals": features of the
first hit, or of the first diffuse or glossy one behind perfect reflections and refractions.
"""

from __future__ import annotations

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import albedo_bsdf, is_mixed, sample_bsdf
from alight.bsdfs.flags import DELTA
from alight.core.constants import INFINITY
from alight.core.vec import Vec3, max_component
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    count_lanes,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, lanes, lanes_mask, lanes_vec3, to_float, where

#: Layers and their channels. ids count from 1; 0 is nothing. depth: metres along the ray.
LAYERS = {
    "albedo": ("R", "G", "B"),
    "normal": ("X", "Y", "Z"),
    "geometric_normal": ("X", "Y", "Z"),
    "position": ("X", "Y", "Z"),
    "depth": ("Z",),
    "uv": ("U", "V"),
    "id": ("shape", "primitive", "bsdf"),
    "albedo_through": ("R", "G", "B"),
    "normal_through": ("X", "Y", "Z"),
}

ALBEDO, NORMAL, GEOMETRIC_NORMAL, POSITION, DEPTH, UV, ID, ALBEDO_THROUGH, NORMAL_THROUGH = range(
    len(LAYERS)
)

#: Layers that follow delta lobes, and what programs that have them say among their AOVs.
THROUGH_LAYERS = frozenset({"albedo_through", "normal_through"})
THROUGH = "through"

#: Delta lobes that are followed at most: in and out of three glasses behind one another, a window
#: of two panes and a mirror behind it.
MOST_BOUNCES = 8


def layer_number(name: str) -> int:
    """What `Settings.layer` must be for a layer."""
    return list(LAYERS).index(name)


@kernel
def first_hit(scene, settings, path, hit, surface, active):
    """Value of a layer that looks at the first surface only."""
    value = lanes_vec3(0.0)
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
        ids = Vec3(to_float(hit.shape + 1), to_float(hit.prim + 1), to_float(surface.bsdf + 1))
        value = where(first, ids, 0.0)
    weight = lanes_vec3(1.0)
    if settings.layer != ID:
        weight = path.beta
    return value * weight


@kernel
def follow_delta(scene, settings, path, surface, wo, active):
    """Value of a layer that looks through delta lobes, and how paths continue at those."""
    dimension = vertex_dimension(path.depth + 1)
    wi, weight, _, flags = sample_bsdf(
        scene,
        surface,
        wo,
        get_1d(path.sampler, dimension + BSDF_CHOICE),
        get_2d(path.sampler, dimension + BSDF_DIRECTION),
        active,
    )
    passes = active & ((flags & DELTA) != 0) & (path.depth < MOST_BOUNCES)
    if settings.layer == ALBEDO_THROUGH:
        # Beside delta lobes the albedo of the whole material would count them twice.
        smooth = is_mixed(scene, surface) & ((flags & DELTA) == 0)
        value = path.beta * where(smooth, weight, albedo_bsdf(scene, surface, active))
        return value, wi, path.beta * weight, passes & ~(max_component(weight) <= 0.0)
    return path.beta * surface.ns, wi, path.beta, passes & ~(max_component(weight) <= 0.0)


def step(program):
    """The kernel that looks at the next surface of each path."""
    through = THROUGH in program.aovs

    @kernel
    def aov_step(scene, settings, path):
        """One more vertex of each path; but for layers through delta lobes it is the only one."""
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        active = path.active & (hit.t < INFINITY)
        L, o, d, beta, passes = path.L, path.o, path.d, path.beta, lanes_mask(False)
        if any_lane(active):
            surface = make_surface(scene, hit, path.o, path.d, active)
            if through and settings.layer >= ALBEDO_THROUGH:
                wo = to_local(surface, -path.d)
                value, wi, beta, passes = follow_delta(scene, settings, path, surface, wo, active)
                d = to_world(surface, wi)
                o = spawn_origin(surface.p, surface.error, surface.ng, d)
                L = where(active & ~passes, value, L)
            else:
                L = where(active, first_hit(scene, settings, path, hit, surface, active), L)
        rays = path.rays + count_lanes(path.active)
        return replace(
            path, o=o, d=d, L=L, L_direct=L, beta=beta, depth=path.depth + 1, active=passes,
            rays=rays,
        )  # fmt: skip

    return aov_step
