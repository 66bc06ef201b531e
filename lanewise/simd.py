"""The SPMD primitives that kernel text is written in, and their NumPy meaning.

A kernel is one plain Python function with two lives. Called from Python it runs on NumPy arrays
(lanes are 1-D arrays of one common length): the functions below are what it then calls. Compiled
by Numba it runs on packets of `LANES` lanes: `lanewise.instructions` maps each function below to
machine instructions. Both lives are compared by tests.

The idea is that of ISPC (Pharr and Mark 2012, "ispc: A SPMD compiler for high-performance CPU
programming").
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lanewise.vec3 import Vec3


class LaneCount(int):
    """The packet width; a type of its own, so that the compiler can put the machine's in place."""


#: Lanes of the widest packet that a processor has: what kernels provide memory for.
WIDEST = 16

#: Lanes of a packet: 16 in the NumPy twin, unless more are asked for (`lanewise.jit.instantiate`);
#: compiled code uses the processor's width.
LANES = LaneCount(WIDEST)

#: Lanes from which on the twin selects bits: for fewer, `numpy.where` is as fast.
MANY = 1 << 14


def where(mask, a, b) -> Any:
    """Lane-wise choice: `a` where `mask`, else `b` (scalars, lanes, Vec3, tuples of them).

    Of a record every field is chosen, those of records in it too. A field that is the same number
    in all lanes becomes lanes, so `records.replace` puts back what must stay uniform.
    """
    if isinstance(a, tuple):
        if type(a) is not type(b):
            raise TypeError(f"{type(a).__name__} and {type(b).__name__} are different records")
        parts = [where(mask, x, y) for x, y in zip(a, b, strict=True)]
        return type(a)(*parts) if hasattr(a, "_fields") else tuple(parts)
    if isinstance(a, Vec3) or isinstance(b, Vec3):
        ax, ay, az = (a.x, a.y, a.z) if isinstance(a, Vec3) else (a, a, a)
        bx, by, bz = (b.x, b.y, b.z) if isinstance(b, Vec3) else (b, b, b)
        return Vec3(where(mask, ax, bx), where(mask, ay, by), where(mask, az, bz))
    if isinstance(a, (bool, int, float)) and isinstance(b, (bool, int, float)):
        # Two Python numbers would become float64 or int64 lanes.
        kind = np.float32 if isinstance(a, float) or isinstance(b, float) else np.uint32
        if isinstance(a, bool) and isinstance(b, bool):
            kind = np.bool_
        return np.where(mask, kind(a), kind(b))
    if getattr(mask, "size", 1) >= MANY:
        return _where_many(mask, a, b)
    return np.where(mask, a, b)


def _where_many(mask, a, b) -> Any:
    """`numpy.where`, of 32 bits by exclusive or: no branch to mispredict."""
    x, y = (_as_kind_of(p, q) for p, q in ((a, b), (b, a)))
    shapes = {mask.shape, ()}
    if x is None or y is None or not {x.shape, y.shape} <= shapes or mask.dtype != np.bool_:
        return np.where(mask, a, b)
    bits = np.negative(mask.view(np.int8), dtype=np.int32)
    bits &= x.view(np.int32) ^ y.view(np.int32)
    bits ^= y.view(np.int32)
    return bits.view(x.dtype)


def _as_kind_of(x, other) -> Any:
    """Lanes or a number of 32 bits as the kind that NumPy gives it beside the other; else None."""
    if type(x) is int or (type(x) is float and other.dtype == np.float32):
        x = other.dtype.type(x)
    kind = getattr(x, "dtype", None)
    if kind is None or kind.itemsize != 4 or getattr(other, "dtype", kind) != kind:
        return None
    return x


def any_lane(mask):
    """True if the mask holds in at least one lane (a uniform bool: may be branched on)."""
    return bool(np.any(mask))


def all_lanes(mask):
    """True if the mask holds in every lane (a uniform bool: may be branched on)."""
    return bool(np.all(mask))


def sqrt(x):
    """Square root, correctly rounded."""
    return np.sqrt(np.float32(x))


def rsqrt(x):
    """1 / sqrt(x) within 2 units in the last place, for x in [1e-30, 1e30]; not strict.

    Several times faster than a square root and a division where the processor estimates it.
    """
    return np.float32(1.0) / np.sqrt(np.float32(x))


def floor(x):
    """Largest whole number not above x."""
    return np.floor(np.float32(x))


def rint(x):
    """Nearest whole number, ties to even."""
    return np.rint(np.float32(x))


def absolute(x):
    """Absolute value."""
    return np.abs(np.float32(x))


def minimum(a, b):
    """The smaller one; `b` if the comparison is unordered (as x86's minps)."""
    return where(np.less(a, b), a, b)


def maximum(a, b):
    """The larger one; `b` if the comparison is unordered (as x86's maxps)."""
    return where(np.greater(a, b), a, b)


def minimum_u32(a, b):
    """The smaller one of two unsigned lanes."""
    return np.minimum(np.uint32(a), np.uint32(b))


def copysign(x, sign):
    """|x| with the sign bit of `sign`."""
    return np.copysign(np.float32(x), np.float32(sign))


def is_finite(x):
    """True where x is neither infinite nor NaN."""
    return np.isfinite(x)


def fma(a, b, c):
    """a * b + c, rounded once where the machine can (float64 imitates it here)."""
    product = np.multiply(a, b, dtype=np.float64)
    return np.add(product, c, dtype=np.float64).astype(np.float32)


def lanes(x):
    """A float32 lane variable that starts as x in every lane."""
    return np.float32(x)


def lanes_u32(x):
    """A uint32 lane variable that starts as x in every lane (modulo 2^32)."""
    return np.uint32(int(x) & 0xFFFFFFFF) if np.ndim(x) == 0 else np.asarray(x).astype(np.uint32)


def lanes_mask(x):
    """A mask that starts as x in every lane."""
    return np.bool_(x)


def lanes_vec3(x):
    """A Vec3 of lanes that starts as (x, x, x)."""
    return Vec3(lanes(x), lanes(x), lanes(x))


def to_float(u):
    """uint32 -> float32 (exact up to 2^24; the value must be below 2^31)."""
    return np.asarray(u).astype(np.float32)[()]


def to_uint(x):
    """float32 -> uint32 by truncation (the value must lie in [0, 2^31))."""
    return np.asarray(x).astype(np.int32).astype(np.uint32)[()]


def float_bits(x):
    """The bit pattern of a float32 as uint32."""
    return np.asarray(x, np.float32).view(np.uint32)[()]


def bits_float(u):
    """The float32 with bit pattern u."""
    return np.asarray(u, np.uint32).view(np.float32)[()]


def reverse_bits(u):
    """Bit i becomes bit 31 - i."""
    u = np.asarray(u, np.uint32)
    u = ((u >> 1) & np.uint32(0x55555555)) | ((u & np.uint32(0x55555555)) << 1)
    u = ((u >> 2) & np.uint32(0x33333333)) | ((u & np.uint32(0x33333333)) << 2)
    u = ((u >> 4) & np.uint32(0x0F0F0F0F)) | ((u & np.uint32(0x0F0F0F0F)) << 4)
    return u.byteswap()[()]


def gather(view, index):
    """``view[index]`` in each lane. Every index must be valid, in dead lanes too.

    Machine code does not check it; here an index out of bounds is an error.
    """
    array, index = getattr(view, "array", view), np.asarray(index)
    # NumPy counts negative ones from the end.
    if index.dtype.kind != "u" and index.size and index.min() < 0:
        raise IndexError(f"index {index.min()} is out of bounds of a table of {len(array)} numbers")
    return array.take(index, axis=0)


def gather_row(view, index, n):
    """``view[index], ..., view[index + n - 1]`` in each lane: a tuple; n is 2, 3 or 4, a constant.

    Every index must be valid, in dead lanes too. One load a lane, and not n: lanes seldom share a
    cache line, but what is looked up together lies together.
    """
    return tuple(gather(view, index + k) for k in range(n))


def lane_index():
    """0, 1, 2, ... across the lanes."""
    return np.arange(int(LANES), dtype=np.uint32)


# ---------------------------------------------------------------- single lanes
# What a kernel needs to leave the packet: bit masks, and small buffers that it can index.


def mask_bits(mask):
    """The mask as a whole number: bit i = lane i."""
    full = np.broadcast_to(np.asarray(mask), (int(LANES),))
    return int.from_bytes(np.packbits(full, bitorder="little").tobytes(), "little")


def bits_mask(bits):
    """The inverse of `mask_bits`."""
    bits = int(bits) & ((1 << int(LANES)) - 1)
    memory = np.frombuffer(bits.to_bytes(int(LANES) // 8, "little"), np.uint8)
    return np.unpackbits(memory, bitorder="little").astype(bool)


def trailing_zeros(bits):
    """Index of the lowest bit that is set; `bits` must not be 0."""
    return (int(bits) & -int(bits)).bit_length() - 1


def count_bits(bits):
    """How many bits are set."""
    return int(bits).bit_count()


def room_for(n):
    """How many numbers memory holds that is large enough if packets have `WIDEST` lanes."""
    return n * max(int(LANES) // WIDEST, 1)


def local_floats(n):
    """Scratch memory of this call: n float32.

    A kernel may return it, but only unwritten: LLVM drops stores to memory that nobody reads until
    the call is over, and does so before it inlines the call.
    """
    return np.zeros(room_for(n), np.float32)


def local_uints(n):
    """Scratch memory of this call: n uint32."""
    return np.zeros(room_for(n), np.uint32)


def local_longs(n):
    """Scratch memory of this call: n int64."""
    return np.zeros(room_for(n), np.int64)


def lane_floats(n):
    """Scratch memory of this call: n float32 for each lane."""
    return np.zeros(room_for(n * WIDEST), np.float32)


def lane_uints(n):
    """Scratch memory of this call: n uint32 for each lane."""
    return np.zeros(room_for(n * WIDEST), np.uint32)


def store_lanes(buffer, i, x):
    """Write the lanes of x to ``buffer[i : i + LANES]``."""
    buffer[i : i + int(LANES)] = x


def load_lanes(buffer, i):
    """Read lanes from ``buffer[i : i + LANES]`` (float32 or uint32 as the buffer is)."""
    return buffer[i : i + int(LANES)].copy()


def packing(mask):
    """The lanes of the mask one after another, then the others: an order for `permuted`."""
    inside = np.broadcast_to(mask, (int(LANES),))
    return np.argsort(~inside, kind="stable").astype(np.uint32)


def permuted(x, order):
    """``x[order[0]], x[order[1]], ...``; the order (u32 lanes, places in x) may be computed."""
    return np.broadcast_to(x, np.shape(order))[order]


def as_uint(i):
    """A uniform whole number as uint32 (to store into a buffer of uint32)."""
    return np.uint32(int(i) & 0xFFFFFFFF)


def as_int(u):
    """A uniform number (uint32, or float32 by truncation) as a whole number."""
    return int(u)


def as_float(i):
    """A uniform whole number as float32."""
    return np.float32(i)


def horizontal_min(x):
    """The smallest lane, as a uniform float32."""
    return np.float32(np.min(x))


def horizontal_max(x):
    """The largest lane, as a uniform float32."""
    return np.float32(np.max(x))
