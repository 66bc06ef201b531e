"""Media as kernels see them: tables, flights through them, and their random numbers.

Rows are numbered from 1: row 0 means empty space and is blank, so that lanes outside all
media read valid numbers.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.maths import exp
from alight.core.rng import hash_2, sample_keys, unit_float
from alight.core.vec import Vec3
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes_vec3, maximum, where

#: info, data: a row a medium; voxels: values of all grids; borders: for each shape the media on its
#: inner and outer side (`KEEP` where it is no border); start: the medium of the camera.
MediaTables = namedtuple("MediaTables", "info data voxels borders start")

#: Words of `MediaTables.info` a medium: kind, kind of its phase function; of a grid the start of
#: its densities and their counts along x, y, z, then those of its albedos + 1 (0: none) and counts,
#: and likewise of its emission.
INFO = 16
KIND, PHASE, DENSITIES, ALBEDOS, EMISSIONS = 0, 1, 2, 6, 10

#: Numbers of `MediaTables.data` a medium: extinction (3), albedo (3), parameter of the phase
#: function, largest density, the matrix (3 rows of 4) from the world to a grid's unit cube, and
#: emission (3).
STRIDE = 32
EXTINCTION, ALBEDO, PARAMETER, LARGEST, MATRIX, EMISSION = 0, 3, 6, 7, 8, 20

#: In `MediaTables.borders`: light stays in the medium that it is in.
KEEP = 0xFFFFFFFF

#: What programs call it that the channels of a medium are extinguished differently.
CHROMATIC = "chromatic"

#: What programs call it that a medium shines.
EMISSIVE = "emissive"

#: A part of a ray between two surfaces: o, d: origin and unit direction; length: metres; medium
#: (u32): row of the tables, 0 for empty space; channel (u32), which chooses distances; stream: a
#: `Stream` of random numbers.
Segment = namedtuple("Segment", "o d length medium channel stream")

#: What a path did on its way to a surface.
#: scattered: mask, it was scattered at the distance t before; factor (Vec3): throughput, and the
#: densities of this in the three channels, over the density in the channel that chose the distance;
#: light (Vec3): those of light sampling, which would have come here by ratio tracking, over the
#: same; albedo (Vec3): further factor of the throughput where it was scattered.
Flight = namedtuple("Flight", "scattered t factor light albedo")

#: How light comes through on the way of a shadow ray. passed (Vec3): transmittance; light (Vec3):
#: density of what was chosen on the way; both over that density in the channel that chose;
#: weight: further factor of the transmittance, from roulette and from holes in surfaces.
Crossing = namedtuple("Crossing", "passed light weight")

#: Names a stream of random numbers for the steps of a tracking: keys, and the first counter.
Stream = namedtuple("Stream", "a b first")

#: Sets the streams apart from the numbers that samplers take from the same keys.
_SALT = 0x5BD1E995
#: Steps of one stream before it runs into the next one's numbers.
_LENGTH = 1 << 16

#: Distances are cut here, so that an extinction of 0 times a distance is 0.
FARTHEST = 1e30


@kernel
def stream_of(sampler, number):
    """The stream with a number (u32) of a sample."""
    a, b = sample_keys(sampler.a, sampler.b, sampler.index)
    return Stream(a ^ _SALT, b, number * _LENGTH)


@kernel
def segment_of(stream, number):
    """The stream of the segment with a number (u32) of a shadow ray.

    It has keys of its own: there may be any number of segments, each as long as a whole flight.
    """
    a, b = sample_keys(stream.a, stream.b, number)
    return Stream(a, b, stream.first)


@kernel
def step_numbers(stream, step):
    """Two numbers in [0, 1) for a step of a tracking."""
    first, second = hash_2(stream.a, stream.b, stream.first + step)
    return unit_float(first), unit_float(second)


@specialised
def pick(program):
    """``pick(v, channel)``: a channel of v; where all are alike, the first."""
    if CHROMATIC in program.media:

        @kernel
        def one_of_three(v, channel):
            return where(channel == 0, v.x, where(channel == 1, v.y, v.z))

        return one_of_three

    @kernel
    def the_first(v, channel):
        return v.x

    return the_first


@specialised
def decay(program):
    """``decay(extinction, chosen, distance)``: transmittances over that of the chosen channel."""
    if CHROMATIC in program.media:

        @kernel
        def by_channel(extinction, chosen, distance):
            return Vec3(
                exp((chosen - extinction.x) * distance),
                exp((chosen - extinction.y) * distance),
                exp((chosen - extinction.z) * distance),
            )

        return by_channel

    @kernel
    def alike(extinction, chosen, distance):
        return lanes_vec3(1.0)

    return alike


@specialised
def share(program):
    """``share(extinction, chosen)``: extinctions over that of the chosen channel."""
    if CHROMATIC in program.media:

        @kernel
        def by_channel(extinction, chosen):
            return extinction * (1.0 / maximum(chosen, 1e-30))

        return by_channel

    @kernel
    def alike(extinction, chosen):
        return lanes_vec3(1.0)

    return alike
