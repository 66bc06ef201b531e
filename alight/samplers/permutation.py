"""Random permutations of 0 ... n - 1 by hashing: each value is computed alone, without a table.

A keyed bijection of the smallest power of two that holds n is applied again and again until the
value is below n ("cycle walking"), which makes a permutation of the values below n.

Sources: Kensler, Correlated multi-jittered sampling, Pixar technical memo 13-01 (2013), for the
idea; Black and Rogaway, Ciphers with arbitrary finite domains (2002), for cycle walking.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from lanewise.jit import kernel
from lanewise.simd import any_lane, where

_ROUNDS = 4


@cache
def make_permute(n: int) -> Callable:
    """Kernel ``permute(i, key)`` for u32 lanes i < n and a random word `key`."""
    if n == 1:
        return _only_one
    bits = (n - 1).bit_length()
    mask, shift = (1 << bits) - 1, (bits + 1) // 2

    @kernel
    def scatter(i, key):
        # Multiplication by an odd number, addition and xorshift are bijections of `bits` bits.
        for _ in range(_ROUNDS):
            i = ((i ^ key) * ((key >> 15) | 1) + (key >> 8)) & mask
            i ^= i >> shift
            key = (key ^ (key >> 13)) * 0x9E3779B1
        return i

    if n == mask + 1:
        return scatter

    @kernel
    def permute(i, key):
        i = scatter(i, key)
        outside = i >= n
        while any_lane(outside):
            i = where(outside, scatter(i, key), i)
            outside = i >= n
        return i

    return permute


@kernel
def _only_one(i, key):
    return i
