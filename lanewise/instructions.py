"""The LLVM instructions that the primitives of `lanewise.simd` compile to.

Each intrinsic below takes scalars or lanes; `PRIMITIVES` says which primitive it stands for.
"""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from lanewise import simd
from lanewise.lane_types import (
    FLOATS,
    I1,
    I32,
    I64,
    MASK,
    UINTS,
    Floats,
    LaneType,
    Mask,
    N,
    Uints,
    Vec3Type,
    call,
    convert,
    emit,
    f32,
    suffix,
    widest,
)
from lanewise.machine import features_of_target

PRIMITIVES: dict = {}


def _has_avx512() -> bool:
    features = features_of_target()
    return bool(features.get("avx512f") and features.get("avx512vl"))


HAS_AVX512 = _has_avx512()


def stands_for(primitive):
    """Put an intrinsic into `PRIMITIVES`."""

    def register(stand_in):
        PRIMITIVES[primitive] = stand_in
        return stand_in

    return register


def _arithmetic(primitive, arity, make):
    """An elementwise float32 function of 1, 2 or 3 arguments: scalars, lanes or Vec3."""

    def codegen(context, builder, sig, args):
        return emit(context, builder, sig.args, args, sig.return_type, make)

    def result_of(*kinds):
        return widest(kinds) or f32

    # Numba reads the number of arguments off the function.
    def of_one(typing, x):
        return result_of(x)(x), codegen

    def of_two(typing, x, y):
        return result_of(x, y)(x, y), codegen

    def of_three(typing, x, y, z):
        return result_of(x, y, z)(x, y, z), codegen

    PRIMITIVES[primitive] = intrinsic({1: of_one, 2: of_two, 3: of_three}[arity])


def _llvm(name):
    return lambda builder, *xs: call(builder, f"llvm.{name}.{suffix(xs[0].type)}", xs[0].type, xs)


for _primitive, _arity, _name in (
    (simd.sqrt, 1, "sqrt"),
    (simd.floor, 1, "floor"),
    (simd.rint, 1, "rint"),
    (simd.absolute, 1, "fabs"),
    (simd.copysign, 2, "copysign"),
    (simd.fma, 3, "fma"),
):
    _arithmetic(_primitive, _arity, _llvm(_name))


def _rsqrt_lanes(builder, x):
    if HAS_AVX512 and isinstance(x.type, ir.VectorType) and x.type.count in (8, 16):
        # 14 bits of the processor's estimate, and one step of Newton's iteration.
        n, bits = x.type.count, 32 * x.type.count
        mask = ir.Constant(ir.IntType(n), -1)
        y = call(builder, f"llvm.x86.avx512.rsqrt14.ps.{bits}", x.type, [x, x, mask])
        half = builder.fmul(x, ir.Constant(x.type, [-0.5] * n))
        correction = call(
            builder,
            f"llvm.fma.{suffix(x.type)}",
            x.type,
            [builder.fmul(half, y), y, ir.Constant(x.type, [1.5] * n)],
        )
        return builder.fmul(y, correction)
    one = ir.Constant(x.type, [1.0] * x.type.count if isinstance(x.type, ir.VectorType) else 1.0)
    root = call(builder, f"llvm.sqrt.{suffix(x.type)}", x.type, [x])
    return builder.fdiv(one, root)


_arithmetic(simd.rsqrt, 1, _rsqrt_lanes)
# A compare and a select are one minps or maxps.
_arithmetic(simd.minimum, 2, lambda b, x, y: b.select(b.fcmp_ordered("<", x, y), x, y))
_arithmetic(simd.maximum, 2, lambda b, x, y: b.select(b.fcmp_ordered(">", x, y), x, y))


# ---------------------------------------------------------------- masks


@stands_for(simd.any_lane)
@intrinsic
def _any_lane(typing, mask):
    if not isinstance(mask, Mask):
        return types.boolean(mask), lambda c, b, sig, args: c.cast(b, args[0], mask, types.boolean)

    def codegen(context, builder, sig, args):
        bits = builder.bitcast(args[0], ir.IntType(mask.n))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(mask), codegen


@stands_for(simd.all_lanes)
@intrinsic
def _all_lanes(typing, mask):
    if not isinstance(mask, Mask):
        return types.boolean(mask), lambda c, b, sig, args: c.cast(b, args[0], mask, types.boolean)

    def codegen(context, builder, sig, args):
        bits = builder.bitcast(args[0], ir.IntType(mask.n))
        return builder.icmp_unsigned("==", bits, ir.Constant(bits.type, -1))

    return types.boolean(mask), codegen


@stands_for(simd.mask_bits)
@intrinsic
def _mask_bits(typing, mask):
    def codegen(context, builder, sig, args):
        return builder.zext(builder.bitcast(args[0], ir.IntType(mask.n)), I64)

    return types.int64(mask), codegen


@stands_for(simd.bits_mask)
@intrinsic
def _bits_mask(typing, bits):
    def codegen(context, builder, sig, args):
        word = builder.trunc(context.cast(builder, args[0], bits, types.int64), ir.IntType(N))
        return builder.bitcast(word, MASK.vector)

    return MASK(bits), codegen


@stands_for(simd.trailing_zeros)
@intrinsic
def _trailing_zeros(typing, bits):
    def codegen(context, builder, sig, args):
        return call(builder, "llvm.cttz.i64", I64, [args[0], ir.Constant(I1, 1)])

    return types.int64(types.int64), codegen


@stands_for(simd.count_bits)
@intrinsic
def _count_bits(typing, bits):
    def codegen(context, builder, sig, args):
        return call(builder, "llvm.ctpop.i64", I64, args)

    return types.int64(types.int64), codegen


@stands_for(simd.is_finite)
@intrinsic
def _is_finite(typing, x):
    result = Mask(x.n) if isinstance(x, Floats) else types.boolean

    def codegen(context, builder, sig, args):
        # On the bits: fast-math may assume much, but it cannot touch an integer comparison.
        value = convert(context, builder, args[0], x, x if isinstance(x, Floats) else f32)
        kind = ir.VectorType(I32, x.n) if isinstance(x, Floats) else I32
        bits = builder.and_(builder.bitcast(value, kind), _uniform(kind, 0x7F800000))
        return builder.icmp_unsigned("!=", bits, _uniform(kind, 0x7F800000))

    return result(x), codegen


def _uniform(kind, value):
    """A constant of an integer type or vector."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [value] * kind.count)
    return ir.Constant(kind, value)


# ---------------------------------------------------------------- lanes and conversions


def _starter(primitive, kind):
    @intrinsic
    def stand_in(typing, x):
        if isinstance(x, LaneType):
            return kind(x), lambda context, builder, sig, args: args[0]
        return kind(x), lambda context, builder, sig, args: convert(
            context, builder, args[0], x, kind
        )

    PRIMITIVES[primitive] = stand_in


_starter(simd.lanes, FLOATS)
_starter(simd.lanes_u32, UINTS)
_starter(simd.lanes_mask, MASK)


@stands_for(simd.lanes_vec3)
@intrinsic
def _lanes_vec3(typing, x):
    kind = Vec3Type(FLOATS)
    return kind(x), lambda context, builder, sig, args: convert(context, builder, args[0], x, kind)


@stands_for(simd.lane_index)
@intrinsic
def _lane_index(typing):
    return UINTS(), lambda context, builder, sig, args: ir.Constant(UINTS.vector, list(range(N)))


def _conversion(primitive, source, target, lane_target, operate, cast_first):
    """Between float32 and uint32, scalars or lanes."""

    @intrinsic
    def stand_in(typing, x):
        result = lane_target(x.n) if isinstance(x, LaneType) else target

        def codegen(context, builder, sig, args):
            value = args[0]
            if not isinstance(x, LaneType):
                value = cast_first(context, builder, value, x)
            kind = result.vector if isinstance(result, LaneType) else context.get_value_type(target)
            return operate(builder, value, kind)

        return result(x), codegen

    PRIMITIVES[primitive] = stand_in


def _as_u32(context, builder, value, kind):
    return builder.trunc(context.cast(builder, value, kind, types.int64), I32)


def _as_f32(context, builder, value, kind):
    return context.cast(builder, value, kind, f32)


_conversion(simd.to_float, Uints, f32, Floats, lambda b, v, t: b.sitofp(v, t), _as_u32)
_conversion(simd.to_uint, Floats, types.uint32, Uints, lambda b, v, t: b.fptosi(v, t), _as_f32)
_conversion(simd.float_bits, Floats, types.uint32, Uints, lambda b, v, t: b.bitcast(v, t), _as_f32)
_conversion(simd.bits_float, Uints, f32, Floats, lambda b, v, t: b.bitcast(v, t), _as_u32)


@stands_for(simd.reverse_bits)
@intrinsic
def _reverse_bits(typing, u):
    def codegen(context, builder, sig, args):
        value = args[0] if isinstance(u, Uints) else _as_u32(context, builder, args[0], u)
        return call(builder, f"llvm.bitreverse.{suffix(value.type)}", value.type, [value])

    return (u if isinstance(u, Uints) else types.uint32)(u), codegen


@stands_for(simd.minimum_u32)
@intrinsic
def _minimum_u32(typing, a, b):
    kind = widest((a, b))

    def codegen(context, builder, sig, args):
        return emit(
            context,
            builder,
            sig.args,
            args,
            kind,
            lambda bl, x, y: bl.select(bl.icmp_unsigned("<", x, y), x, y),
        )

    return kind(a, b), codegen


def _uniform_cast(primitive, target):
    @intrinsic
    def stand_in(typing, x):
        return target(x), lambda context, builder, sig, args: context.cast(
            builder, args[0], x, target
        )

    PRIMITIVES[primitive] = stand_in


_uniform_cast(simd.as_float, f32)
_uniform_cast(simd.as_int, types.int64)


@stands_for(simd.as_uint)
@intrinsic
def _as_uint(typing, x):
    return types.uint32(x), lambda context, builder, sig, args: _as_u32(
        context, builder, args[0], x
    )


# ---------------------------------------------------------------- across lanes


def _horizontal(primitive, sign):
    @intrinsic
    def stand_in(typing, x):
        def codegen(context, builder, sig, args):
            value, n = args[0], x.n
            lanes = x.n
            while n > 1:
                n //= 2
                order = [(i + n) % lanes for i in range(lanes)]
                order = ir.Constant(ir.VectorType(I32, lanes), order)
                other = builder.shuffle_vector(value, value, order)
                value = builder.select(builder.fcmp_ordered(sign, value, other), value, other)
            return builder.extract_element(value, ir.Constant(I32, 0))

        return f32(x), codegen

    PRIMITIVES[primitive] = stand_in


_horizontal(simd.horizontal_min, "<")
_horizontal(simd.horizontal_max, ">")
