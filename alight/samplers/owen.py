r"""Owen's nested uniform scrambling in base 2, by hashing.

Each bit of a number in [0, 1) is flipped or not, at random, depending on all the bits above it:
equidistributed points stay so, and each becomes uniform. A multiplication only carries upwards,
so on the *reversed* word each bit of a sum of products depends on the more significant digits
alone: exactly the dependence that is wanted.

Sources: Owen, Randomly permuted (t, m, s)-nets and (t, s)-sequences (1995); Laine and Karras,
Stratified sampling for stochastic transparency, EGSR 2011; Burley, Practical hash-based Owen
scrambling, JCGT 9(4) (2020); the constants are those of Vegdahl, Building a better LK hash (2021).
"""

from __future__ import annotations

from lanewise.jit import kernel
from lanewise.simd import reverse_bits


@kernel
def scramble_reversed(word, seed):
    """Nested uniform scramble of a bit-reversed word (lowest bit = first binary digit)."""
    word = (word ^ (word * 0x3D20ADEA)) + seed
    word = word * ((seed >> 16) | 1)
    word = word ^ (word * 0x05526C56)
    return word ^ (word * 0x53A22864)


@kernel
def shuffle_index(index, seed):
    """Random permutation of u32 that maps each aligned block of 2^k indices onto such a block."""
    return reverse_bits(scramble_reversed(reverse_bits(index), seed))
