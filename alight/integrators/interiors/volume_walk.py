"""What paths through media keep beyond a `PathState`, and how they cross borders.

**The rule of borders.** A path is in one medium. A shape with an interior or an exterior is a
border: whoever leaves it against its outer normal, in whatever way, is in its interior then, and
whoever leaves it along the normal in its exterior. Other shapes change nothing.

**Three channels.** Where media extinguish red, green and blue differently, one channel chooses all
distances of a path. The densities with which each of the three would have chosen the same path are
carried along, over that of the one that did, and contributions are weighted by the balance
heuristic over the channels and over light sampling.

Source: Wilkie et al., Hero wavelength spectral sampling, EGSR 2014; Miller, Georgiev and Jarosz, A
null-scattering path integral formulation of light transport, SIGGRAPH 2019; PBR4 section 14.2.2.
"""

from __future__ import annotations

from collections import namedtuple

from alight.integrators.walk import PathState, begin_paths, no_paths
from alight.media.tables import CHROMATIC, KEEP
from alight.samplers.sampling import get_1d
from alight.shapes.hit import side_of
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    gather,
    lanes_u32,
    lanes_vec3,
    to_uint,
    where,
)

#: A `PathState`, and: medium (u32), row of the tables that the path is in, 0 for none; channel
#: (u32), which chooses distances; steps (u32), surfaces and collisions so far, borders too; ours
#: (Vec3): densities of the path so far in the three channels; lights (Vec3): those with light
#: sampling at its last vertex; both over the density that it was chosen with, for `lights` that of
#: the last direction included.
VolumePathState = namedtuple(
    "VolumePathState", (*PathState._fields, "medium", "channel", "steps", "ours", "lights")
)

#: Dimension of the camera that chooses the channel; place of the free flight among a vertex's.
CHANNEL = 5
FREE_FLIGHT = 7


@kernel
def empty_paths():
    """Paths, none of them active."""
    path, zero = no_paths(), lanes_u32(0)
    return VolumePathState(
        o=path.o, d=path.d, p=path.p, L=path.L, L_direct=path.L_direct, beta=path.beta,
        pdf=path.pdf, delta=path.delta, depth=path.depth, sampler=path.sampler,
        active=path.active, rays=path.rays, unguided=path.unguided, bodies=path.bodies,
        monochromatic=path.monochromatic, chain=path.chain, medium=zero, channel=zero, steps=zero,
        ours=lanes_vec3(1.0), lights=lanes_vec3(0.0),
    )  # fmt: skip


@kernel
def start_paths(new, o, d, weight, sampler, path):
    """As `alight.integrators.walk.begin_paths`; in which medium, the first step finds out."""
    path = begin_paths(new, o, d, weight, sampler, path)
    begun = replace(
        path, channel=first_channel(sampler), steps=lanes_u32(0), ours=lanes_vec3(1.0),
        lights=lanes_vec3(0.0),
    )  # fmt: skip
    return replace(where(new, begun, path), sampler=sampler, rays=path.rays)


@specialised
def first_channel(program):
    """``first_channel(sampler)``: each of the three with probability 1/3, where they differ."""
    if CHROMATIC in program.media:

        @kernel
        def one_of_three(sampler):
            return to_uint(3.0 * get_1d(sampler, CHANNEL))

        return one_of_three

    @kernel
    def the_first(sampler):
        return lanes_u32(0)

    return the_first


@kernel
def mean(v):
    """Mean of three channels."""
    return (v.x + v.y + v.z) * (1.0 / 3.0)


# ---------------------------------------------------------------- borders


@specialised
def medium_beyond(program):
    """``medium_beyond(scene, surface, w, medium)``: what rays are in that leave along w."""
    if not program.media:

        @kernel
        def empty(scene, surface, w, medium):
            return medium

        return empty

    @kernel
    def by_side(scene, surface, w, medium):
        at = 2 * surface.shape
        inner, outer = gather(scene.media.borders, at), gather(scene.media.borders, at + 1)
        found = where(side_of(w, surface.ng) < 0.0, inner, outer)
        return where(found == KEEP, medium, found)

    return by_side
