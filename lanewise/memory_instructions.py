"""The LLVM instructions behind memory in `lanewise.simd`: gathers, rows of lanes, scratch space."""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from lanewise import simd
from lanewise.instructions import HAS_AVX512, PRIMITIVES, stands_for
from lanewise.lane_types import (
    FLOATS,
    I1,
    I8,
    I32,
    I64,
    UINTS,
    Floats,
    N,
    Uints,
    call,
    convert,
    f32,
)
from lanewise.numba_adapter import cgutils, make_struct
from lanewise.view import part_of
from lanewise.view_types import ViewType, pointer_of


@stands_for(simd.gather)
@intrinsic
def _gather(typing, view, index):
    element = view.dtype
    if not isinstance(index, Uints):

        def load_one(context, builder, sig, args):
            data = pointer_of(context, builder, view, args[0])
            at = context.cast(builder, args[1], index, types.int64)
            return builder.load(builder.gep(data, [at]))

        return element(view, index), load_one

    result = Floats(index.n) if element == f32 else Uints(index.n)

    def codegen(context, builder, sig, args):
        data = builder.bitcast(pointer_of(context, builder, view, args[0]), I8.as_pointer())
        n, vector = index.n, result.vector
        x86 = {16: "llvm.x86.avx512.mask.gather.dps.512", 8: "llvm.x86.avx512.mask.gather3siv8.sf"}
        if result.llvm == I32:
            x86 = {
                16: "llvm.x86.avx512.mask.gather.dpi.512",
                8: "llvm.x86.avx512.mask.gather3siv8.si",
            }
        if n in x86 and N == 16 and HAS_AVX512:
            zero = ir.Constant(vector, [0] * n)
            ones = ir.Constant(ir.VectorType(I1, n), [1] * n)
            return call(builder, x86[n], vector, [zero, data, args[1], ones, ir.Constant(I32, 4)])
        # Elsewhere a load per lane: AVX2's gather is no faster, NEON has none.
        out = ir.Constant(vector, ir.Undefined)
        typed = builder.bitcast(data, result.llvm.as_pointer())
        for i in range(n):
            lane = builder.zext(builder.extract_element(args[1], ir.Constant(I32, i)), I64)
            one = builder.load(builder.gep(typed, [lane]))
            out = builder.insert_element(out, one, ir.Constant(I32, i))
        return out

    return result(view, index), codegen


@stands_for(part_of)
@intrinsic
def _part_of(typing, view, first, size):
    if not isinstance(view, ViewType):
        return None

    def codegen(context, builder, sig, args):
        data = pointer_of(context, builder, view, args[0])
        at = context.cast(builder, args[1], sig.args[1], types.int64)
        count = context.cast(builder, args[2], sig.args[2], types.int64)
        return make_struct(context, builder, view, data=builder.gep(data, [at]), size=count)

    return view(view, first, size), codegen


def _allocator(primitive, element, lanes=1):
    @intrinsic(prefer_literal=True)
    def stand_in(typing, n):
        if not isinstance(n, types.IntegerLiteral):
            return None

        def codegen(context, builder, sig, args):
            size = ir.Constant(I32, lanes * n.literal_value)
            memory = cgutils.alloca_once(builder, context.get_data_type(element), size=size)
            memory.align = 64
            return memory

        return types.CPointer(element)(n), codegen

    PRIMITIVES[primitive] = stand_in


_allocator(simd.local_floats, f32)
_allocator(simd.local_uints, types.uint32)
_allocator(simd.local_longs, types.int64)
_allocator(simd.lane_floats, f32, N)
_allocator(simd.lane_uints, types.uint32, N)


def _lane_pointer(context, builder, sig, args, vector):
    data = pointer_of(context, builder, sig.args[0], args[0])
    at = context.cast(builder, args[1], sig.args[1], types.int64)
    return builder.bitcast(builder.gep(data, [at]), vector.as_pointer())


@stands_for(simd.store_lanes)
@intrinsic
def _store_lanes(typing, buffer, i, x):
    kind = FLOATS if buffer.dtype == f32 else UINTS

    def codegen(context, builder, sig, args):
        value = convert(context, builder, args[2], x, kind)
        store = builder.store(value, _lane_pointer(context, builder, sig, args, kind.vector))
        store.align = 4
        return context.get_dummy_value()

    return types.void(buffer, i, x), codegen


@stands_for(simd.load_lanes)
@intrinsic
def _load_lanes(typing, buffer, i):
    kind = FLOATS if buffer.dtype == f32 else UINTS

    def codegen(context, builder, sig, args):
        load = builder.load(_lane_pointer(context, builder, sig, args, kind.vector))
        load.align = 4
        return load

    return kind(buffer, i), codegen
