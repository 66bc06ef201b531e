"""Sums without rounding: every sample becomes a whole number before it is added.

A sample value v is rounded once, to the nearest multiple of 2^-48 (ties to even: unbiased), and
kept as two whole numbers, v ~ hi 2^-8 + lo 2^-48. Whole numbers add exactly, so a film's sums are
associative: any order of lanes, tiles, threads, resumed parts and workers gives the same bits.

=============  ==================================================================================
range          |v| <= 2^36 per sample; beyond it the value saturates and is counted
resolution     2^-48 absolute; float32 values of at least 2^-25 are kept without any rounding
room           `MAX_SAMPLES` = 2^19 - 1 samples at full range before an int64 could overflow
=============  ==================================================================================

Both limbs of one float32 are float32 themselves: `hi` has at most the 24 leading bits of v, `lo`
the rest. So a kernel splits lanes in float32 and only the addition itself is done in int64.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lanewise.jit import kernel
from lanewise.simd import (
    LANES,
    absolute,
    copysign,
    floor,
    is_finite,
    minimum,
    rint,
    store_lanes,
    where,
)

#: Limb 0 counts units of 2^-8, limb 1 units of 2^-48.
LOW_BITS = 40
HIGH_SCALE = 2.0**8
HIGH_UNIT = 2.0**-8
LOW_SCALE = 2.0**48
LOW_UNIT = 2.0**-48

#: Largest magnitude of one sample: 2^36 / 2^-8 = 2^44 units leave 2^19 samples of room in an int64.
MAX_VALUE = 2.0**36
MAX_SAMPLES = 2**19 - 1

LOW_MASK = (1 << LOW_BITS) - 1


class Limbs(NamedTuple):
    """One value split for a film: the limbs are float32 lanes that hold whole numbers."""

    hi: np.ndarray
    lo: np.ndarray
    invalid: np.ndarray
    saturated: np.ndarray


@kernel(strict=True)
def split(value):
    """Limbs of a float32: v = hi 2^-8 + lo 2^-48 to within 2^-49; NaN and infinity give 0."""
    finite = is_finite(value)
    v = where(finite, value, 0.0)
    size = absolute(v)
    saturated = size > MAX_VALUE
    size = minimum(size, MAX_VALUE)
    # Truncation towards 0, not floor: then the remainder is a tail of the bits of v, hence exact.
    # Both give the same sum, because ties to even does not depend on the (even) multiple 2^40.
    whole = floor(size * HIGH_SCALE)
    rest = rint((size - whole * HIGH_UNIT) * LOW_SCALE)
    return Limbs(copysign(whole, v), copysign(rest, v), ~finite, saturated)


@kernel(strict=True)
def put_limbs(limbs, channel, value):
    """Store both limbs of one channel; returns where it was saturated."""
    parts = split(value)
    store_lanes(limbs, (2 * channel) * LANES, parts.hi)
    store_lanes(limbs, (2 * channel + 1) * LANES, parts.lo)
    return parts.saturated


def to_limbs(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Split an array on the host, by the same text as the kernels.

    Parameters
    ----------
    values : ndarray of float32, any shape

    Returns
    -------
    sums : ndarray of int64, shape (..., 2)
        Canonical.
    invalid, saturated : ndarray of bool, shape (...)
    """
    values = np.asarray(values, np.float32)
    limbs = split(values.reshape(-1))
    sums = np.stack([limbs.hi.astype(np.int64), limbs.lo.astype(np.int64)], axis=-1)
    carry(sums)
    shape = values.shape
    return sums.reshape((*shape, 2)), limbs.invalid.reshape(shape), limbs.saturated.reshape(shape)


def carry(sums: np.ndarray) -> None:
    """Bring sums to their one canonical form in place: 0 <= limb 1 < 2^40.

    Parameters
    ----------
    sums : ndarray of int64, shape (..., 2)
    """
    sums[..., 0] += sums[..., 1] >> LOW_BITS
    sums[..., 1] &= LOW_MASK


@kernel(strict=True)
def add_rows(target, start, stride, sums, rows, values):
    """Add a table of sums to a window of a larger one, in one pass over memory.

    Parameters
    ----------
    target : View of int64
        Canonical before and after. Row y of the window begins at ``start + stride * y``.
    sums : View of int64
        `rows` times `values` sums of two limbs in any form.
    """
    for y in range(rows):
        a, b = start + stride * y, 2 * values * y
        for k in range(values):
            low = target[a + 2 * k + 1] + sums[b + 2 * k + 1]
            target[a + 2 * k] += sums[b + 2 * k] + (low >> LOW_BITS)
            target[a + 2 * k + 1] = low & LOW_MASK


def to_float(sums: np.ndarray) -> np.ndarray:
    """Give the value of canonical sums, within 2 units in the last place of float64.

    Parameters
    ----------
    sums : ndarray of int64, shape (..., 2)

    Returns
    -------
    ndarray of float64, shape (...)
    """
    # The limbs of a small negative number have opposite signs (-2^-48 = -1, 2^40 - 1), but both
    # are exact in float64 there, so the sum is rounded once and nothing cancels.
    return sums[..., 0] * HIGH_UNIT + sums[..., 1] * LOW_UNIT


def total(sums: np.ndarray, axis: int) -> np.ndarray:
    """Give the value of the sum over one axis; the sum itself may exceed an int64.

    Parameters
    ----------
    sums : ndarray of int64, shape (..., 2)
        Canonical, fewer than 2^23 along `axis`.
    axis : int
        Counted from the front; not the axis of the limbs.

    Returns
    -------
    ndarray of float64
    """
    hi, lo = sums[..., 0], sums[..., 1]
    low = lo.sum(axis)
    # Halves of limb 0 apart: R sums of nearly 2^63 each would overflow together.
    middle = (hi & 0xFFFFFFFF).sum(axis) + (low >> LOW_BITS)
    top = (hi >> 32).sum(axis) + (middle >> 32)
    whole = top * (2.0**32 * HIGH_UNIT) + (middle & 0xFFFFFFFF) * HIGH_UNIT
    return whole + (low & LOW_MASK) * LOW_UNIT
