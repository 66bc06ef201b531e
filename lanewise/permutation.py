"""LLVM instructions that reorder the lanes of vectors, by constants or by indices.

Only `lanewise.compiler` brings this module in.
"""

from __future__ import annotations

from llvmlite import ir

from lanewise.lane_types import I32, call
from lanewise.machine import features_of_target


def shuffle(builder, a, b, order):
    """Lanes of a and b one behind the other, in a constant order."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(I32, len(order)), order))


def permute(builder, x, order, n):
    """``x[order]`` for n floats."""
    if n == 1:
        return x
    name = {16: "llvm.x86.avx512.permvar.sf.512", 8: "llvm.x86.avx2.permps"}.get(n)
    if name is not None and _HAS_PERMUTATION[n]:
        return call(builder, name, x.type, [x, order])
    if n == 16 and _HAS_PERMUTATION[8]:
        return _permute_halves(builder, x, order)
    out = ir.Constant(x.type, ir.Undefined)
    for i in range(n):
        lane = builder.extract_element(order, ir.Constant(I32, i))
        one = builder.extract_element(x, lane)
        out = builder.insert_element(out, one, ir.Constant(I32, i))
    return out


def _permute_halves(builder, x, order):
    """``x[order]`` for 16 floats, from permutations of 8."""
    low, high = list(range(8)), list(range(8, 16))
    first, second = shuffle(builder, x, x, low), shuffle(builder, x, x, high)
    parts = []
    for half in (low, high):
        k = shuffle(builder, order, order, half)
        bit = builder.and_(k, ir.Constant(k.type, [8] * 8))
        in_second = builder.icmp_unsigned("!=", bit, ir.Constant(k.type, [0] * 8))
        a, b = permute(builder, first, k, 8), permute(builder, second, k, 8)
        parts.append(builder.select(in_second, b, a))
    return shuffle(builder, parts[0], parts[1], low + high)


def _permutation_features() -> dict[int, bool]:
    """Widths at which the processor permutes floats by a vector of indices."""
    features = features_of_target()
    return {16: bool(features.get("avx512f")), 8: bool(features.get("avx2"))}


_HAS_PERMUTATION = _permutation_features()
