r"""Counter-based random numbers: a hash of (pixel, sample, dimension), without any state.

Two keys of 32 bits identify a stream; a number is a hash of the keys and a counter. A counter in
place of a state means that any number can be drawn in any order, by any lane or machine.

The hash is a multiply-xorshift chain: xorshifts carry high bits down and multiplications by odd
constants carry low bits up, and each step is a bijection, so that a stream's 2^32 first words are
(nearly) all different. The second key enters half-way: streams whose first keys lie close together
are then not shifted copies of each other.

Sources: Jarzynski and Olano, Hash functions for GPU rendering, JCGT 9(3) (2020), for `pcg4d`;
Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC 2011, for the counter; the constants
of the chain were found by search (Wellons, hash-prospector), bias of its avalanche 0.11 %.
"""

from __future__ import annotations

from lanewise.jit import kernel
from lanewise.simd import lanes_u32, to_float

# Multipliers of the two-round chain, and those of the round that makes a second word.
M1 = 0x21F0AAAD
M2 = 0xD35A2D97
M3 = 0x846CA68B
M4 = 0x7FEB352D

TO_UNIT = 2.0**-24


@kernel
def pcg4d(x, y, z, w):
    """Hash of four words to four words (a bijection of 128 bits)."""
    x = x * 1664525 + 1013904223
    y = y * 1664525 + 1013904223
    z = z * 1664525 + 1013904223
    w = w * 1664525 + 1013904223
    x += y * w
    y += z * x
    z += x * y
    w += y * z
    x ^= x >> 16
    y ^= y >> 16
    z ^= z >> 16
    w ^= w >> 16
    x += y * w
    y += z * x
    z += x * y
    w += y * z
    return x, y, z, w


@kernel
def mix(x):
    """Hash of one word to one word (a bijection): every input bit flips every output bit."""
    x = (x ^ (x >> 16)) * M1
    x = (x ^ (x >> 15)) * M2
    return x ^ (x >> 15)


@kernel
def pixel_keys(x, y, scramble, seed):
    """Keys of a pixel's stream in one replicate.

    Parameters
    ----------
    x, y : u32 lanes
        Pixel coordinates on the full film.
    scramble, seed : u32 lanes or uniform int
        Replicate; seed of the picture.

    Returns
    -------
    a, b : u32 lanes
    """
    # Sums keep the four words apart (the map is invertible) and lift uniform ones to lanes.
    _, _, r, s = pcg4d(x, y, y + lanes_u32(scramble), x + lanes_u32(seed))
    # pcg4d's low bits depend on the inputs' low bits alone: one more round spreads the others.
    r = (r ^ (r >> 16)) * M3
    s = (s ^ (s >> 16)) * M4
    return r ^ (r >> 15), s ^ (s >> 15)


@kernel
def sample_keys(a, b, index):
    """Keys of one sample's stream, from its pixel's keys."""
    return mix(a + index), b + (index + a) * M3


@kernel
def hash_1(a, b, counter):
    """One word: number `counter` (u32 lanes or uniform int) of the stream with keys a, b."""
    h = a + lanes_u32(counter)
    h = (h ^ (h >> 16)) * M1 + b
    h = (h ^ (h >> 15)) * M2
    return h ^ (h >> 15)


@kernel
def hash_2(a, b, counter):
    """Two words: that of `hash_1`, and a second one for the same counter."""
    first = hash_1(a, b, counter)
    # b again: the pairs of one stream do not all lie on one curve.
    second = (first + b) * M3
    second = (second ^ (second >> 16)) * M4
    return first, second ^ (second >> 15)


@kernel
def unit_float(word):
    """A word as a number in [0, 1): its upper 24 bits, all that a float32 holds evenly."""
    return to_float(word >> 8) * TO_UNIT
