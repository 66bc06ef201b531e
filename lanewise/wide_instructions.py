"""The LLVM instructions behind `lanewise.wide`.

Only `lanewise.compiler` imports this module.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from lanewise import simd, wide
from lanewise.instructions import PRIMITIVES
from lanewise.lane_types import (
    I1,
    I8,
    I32,
    I64,
    Floats,
    LaneType,
    Mask,
    Uints,
    call,
    convert,
    f32,
    suffix,
)
from lanewise.numba_adapter import cgutils
from lanewise.permutation import permute, shuffle
from lanewise.view_types import pointer_of


def _stands_for(primitive):
    def register(stand_in):
        PRIMITIVES[primitive] = stand_in
        return stand_in

    return register


def _vector_of(table, n):
    return Floats(n) if table.dtype == f32 else Uints(n)


def _pointer(context, builder, kind, value, index, index_kind, target):
    """Address of ``value[index]`` as a pointer to the LLVM type `target`."""
    data = pointer_of(context, builder, kind, value)
    at = context.cast(builder, index, index_kind, types.int64)
    return builder.bitcast(builder.gep(data, [at]), target.as_pointer())


@_stands_for(simd.packing)
@intrinsic
def _packing(typing, mask):
    kind = Uints(mask.n)

    def codegen(context, builder, sig, args):
        n, floats = mask.n, Floats(mask.n).vector
        numbers = ir.Constant(kind.vector, list(range(n)))
        name = f"llvm.experimental.vector.compress.{suffix(kind.vector)}"
        inside = call(builder, name, kind.vector, [numbers, args[0], numbers])
        outside = call(builder, name, kind.vector, [numbers, builder.not_(args[0]), numbers])
        bits = builder.zext(builder.bitcast(args[0], ir.IntType(n)), I32)
        count = builder.insert_element(
            ir.Constant(kind.vector, ir.Undefined),
            call(builder, "llvm.ctpop.i32", I32, [bits]),
            ir.Constant(I32, 0),
        )
        count = shuffle(builder, count, count, [0] * n)
        behind = builder.and_(builder.sub(numbers, count), ir.Constant(kind.vector, [n - 1] * n))
        moved = permute(builder, builder.bitcast(outside, floats), behind, n)
        first = builder.icmp_unsigned("<", numbers, count)
        return builder.select(first, inside, builder.bitcast(moved, kind.vector))

    return kind(mask), codegen


@_stands_for(simd.permuted)
@intrinsic
def _permuted(typing, x, order):
    if not isinstance(x, Floats | Uints):
        return None

    def codegen(context, builder, sig, args):
        floats = Floats(x.n).vector
        value = permute(builder, builder.bitcast(args[0], floats), args[1], x.n)
        return builder.bitcast(value, x.vector)

    return x(x, order), codegen


@_stands_for(wide.compressed)
@intrinsic
def _compressed(typing, x, mask):
    if not isinstance(x, Floats | Uints):
        return None

    def codegen(context, builder, sig, args):
        name = f"llvm.experimental.vector.compress.{suffix(x.vector)}"
        return call(builder, name, x.vector, [args[0], args[1], args[0]])

    return x(x, mask), codegen


@_stands_for(wide.mask_of)
@intrinsic(prefer_literal=True)
def _mask_of(typing, n, bits):
    if not isinstance(n, types.IntegerLiteral):
        return None
    result = Mask(n.literal_value)

    def codegen(context, builder, sig, args):
        word = context.cast(builder, args[1], bits, types.int64)
        return builder.bitcast(builder.trunc(word, ir.IntType(result.n)), result.vector)

    return result(n, bits), codegen


@_stands_for(wide.wide)
@intrinsic(prefer_literal=True)
def _wide(typing, n, x):
    if not isinstance(n, types.IntegerLiteral):
        return None
    result = Floats(n.literal_value)
    return result(n, x), lambda context, builder, sig, args: convert(
        context, builder, args[1], sig.args[1], result
    )


@_stands_for(wide.four)
@intrinsic
def _four(typing, a, b, c, d):
    result = Floats(4)

    def codegen(context, builder, sig, args):
        vector = ir.Constant(result.vector, ir.Undefined)
        for i, (value, kind) in enumerate(zip(args, sig.args, strict=True)):
            number = context.cast(builder, value, kind, f32)
            vector = builder.insert_element(vector, number, ir.Constant(I32, i))
        return vector

    return result(a, b, c, d), codegen


@_stands_for(wide.load_wide)
@intrinsic(prefer_literal=True)
def _load_wide(typing, n, table, i):
    if not isinstance(n, types.IntegerLiteral):
        return None
    result = _vector_of(table, n.literal_value)

    def codegen(context, builder, sig, args):
        load = builder.load(
            _pointer(context, builder, sig.args[1], args[1], args[2], sig.args[2], result.vector)
        )
        load.align = 4
        return load

    return result(n, table, i), codegen


@_stands_for(wide.store_wide)
@intrinsic
def _store_wide(typing, table, i, x):
    def codegen(context, builder, sig, args):
        store = builder.store(
            args[2],
            _pointer(context, builder, sig.args[0], args[0], args[1], sig.args[1], x.vector),
        )
        store.align = 4
        return context.get_dummy_value()

    return types.void(table, i, x), codegen


@_stands_for(wide.lane)
@intrinsic
def _lane(typing, x, i):
    if not isinstance(x, Floats | Uints):
        return None

    def codegen(context, builder, sig, args):
        return builder.extract_element(args[0], context.cast(builder, args[1], i, types.int64))

    return x.scalar(x, i), codegen


def _half(primitive, first):
    @intrinsic
    def stand_in(typing, x):
        m = x.n // 2
        order = [i + first * m for i in range(m)]
        return type(x)(m)(x), lambda context, builder, sig, args: shuffle(
            builder, args[0], args[0], order
        )

    PRIMITIVES[primitive] = stand_in


_half(wide.low_half, 0)
_half(wide.high_half, 1)


@_stands_for(wide.join)
@intrinsic
def _join(typing, a, b):
    if not isinstance(a, LaneType) or a != b:
        return None
    return type(a)(2 * a.n)(a, b), lambda context, builder, sig, args: shuffle(
        builder, args[0], args[1], list(range(2 * a.n))
    )


@_stands_for(wide.shuffled)
@intrinsic(prefer_literal=True)
def _shuffled(typing, x, order):
    if not all(isinstance(k, types.IntegerLiteral) for k in order):
        return None
    constants = [k.literal_value for k in order]
    return type(x)(len(constants))(x, order), lambda context, builder, sig, args: shuffle(
        builder, args[0], args[0], constants
    )


@_stands_for(wide.gather_near)
@intrinsic
def _gather_near(typing, table, k, index):
    if not isinstance(index, Uints) or table.dtype != f32:
        return None
    result = Floats(index.n)

    def codegen(context, builder, sig, args):
        four = ir.VectorType(result.llvm, 4)
        load = builder.load(
            _pointer(context, builder, sig.args[0], args[0], args[1], sig.args[1], four)
        )
        load.align = 4
        repeated = shuffle(builder, load, load, [i % 4 for i in range(index.n)])
        return permute(builder, repeated, args[2], index.n)

    return result(table, k, index), codegen


@_stands_for(simd.gather_row)
@intrinsic(prefer_literal=True)
def _gather_row(typing, view, index, n):
    if not isinstance(n, types.IntegerLiteral):
        return None
    count, kind = n.literal_value, view.dtype
    if isinstance(index, Uints):
        kind = Floats(index.n) if kind == f32 else Uints(index.n)

    def codegen(context, builder, sig, args):
        element = context.get_value_type(view.dtype)
        data = builder.bitcast(pointer_of(context, builder, view, args[0]), element.as_pointer())
        if not isinstance(index, Uints):
            at = context.cast(builder, args[1], index, types.int64)
            row = _row(builder, builder.gep(data, [at]), count)
            found = [builder.extract_element(row, ir.Constant(I32, k)) for k in range(count)]
        else:
            indices = builder.zext(args[1], ir.VectorType(I64, index.n))
            each = [builder.extract_element(indices, ir.Constant(I32, i)) for i in range(index.n)]
            rows = [_row(builder, builder.gep(data, [at]), count) for at in each]
            found = _columns(builder, rows, count)
        return context.make_tuple(builder, sig.return_type, found)

    return types.UniTuple(kind, count)(view, index, n), codegen


def _row(builder, pointer, count):
    """A vector of `count` neighbours, of four where there are three."""
    vector = ir.VectorType(pointer.type.pointee, count + count % 2)
    pointer = builder.bitcast(pointer, vector.as_pointer())
    if count != 3:
        load = builder.load(pointer)
        load.align = 4
        return load
    # The fourth may be behind the end of the table.
    mask = ir.Constant(ir.VectorType(I1, 4), [1, 1, 1, 0])
    name = f"llvm.masked.load.{suffix(vector)}.p0{suffix(vector)}"
    undefined = ir.Constant(vector, ir.Undefined)
    return call(builder, name, vector, [pointer, ir.Constant(I32, 4), mask, undefined])


def _columns(builder, rows, count):
    """The transpose of a list of vectors: a list of `count` vectors of their number."""
    n, width = len(rows), rows[0].type.count
    if n < 4:
        columns = []
        for k in range(count):
            column = ir.Constant(ir.VectorType(rows[0].type.element, n), ir.Undefined)
            for i, row in enumerate(rows):
                one = builder.extract_element(row, ir.Constant(I32, k))
                column = builder.insert_element(column, one, ir.Constant(I32, i))
            columns.append(column)
        return columns
    if width == 2:
        # Rows 0 1, 4 5, ... in one vector, rows 2 3, 6 7, ... in another.
        a, b = (
            _joined(builder, [row for i, row in enumerate(rows) if i % 4 // 2 == half])
            for half in (0, 1)
        )
        return [_in_fours(builder, a, b, [k, 2 + k, n + k, n + 2 + k]) for k in range(2)]
    a, b, c, d = (_joined(builder, rows[first::4]) for first in range(4))
    columns = []
    for k in (0, 2):
        ab, cd = (
            _in_fours(builder, *two, [k, n + k, k + 1, n + k + 1]) for two in ((a, b), (c, d))
        )
        columns.append(_in_fours(builder, ab, cd, [0, 1, n, n + 1]))
        columns.append(_in_fours(builder, ab, cd, [2, 3, n + 2, n + 3]))
    return columns[:count]


def _in_fours(builder, a, b, order):
    """The same shuffle of every four lanes of two vectors."""
    n = a.type.count
    return shuffle(builder, a, b, [i + k for i in range(0, n, 4) for k in order])


def _joined(builder, vectors):
    """Vectors one behind the other."""
    while len(vectors) > 1:
        m = 2 * vectors[0].type.count
        vectors = [
            shuffle(builder, a, b, list(range(m)))
            for a, b in zip(vectors[::2], vectors[1::2], strict=True)
        ]
    return vectors[0]


@_stands_for(wide.prefetch)
@intrinsic
def _prefetch(typing, table, i):
    def codegen(context, builder, sig, args):
        address = _pointer(context, builder, table, args[0], args[1], i, I8)
        # For reading, with high locality, data.
        flags = [ir.Constant(I32, 0), ir.Constant(I32, 3), ir.Constant(I32, 1)]
        kind = ir.FunctionType(ir.VoidType(), [address.type, I32, I32, I32])
        name = "llvm.prefetch.p0i8"
        builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [address, *flags])
        return context.get_dummy_value()

    return types.void(table, i), codegen


@_stands_for(wide.smaller)
@intrinsic
def _smaller(typing, a, b):
    if not isinstance(a, Floats) or a != b:
        return None

    def codegen(context, builder, sig, args):
        kind = ir.FunctionType(a.vector, [a.vector, a.vector])
        name = f"llvm.minnum.v{a.n}f32"
        function = cgutils.get_or_insert_function(builder.module, kind, name)
        return builder.call(function, args, fastmath=("nnan", "nsz"))

    return a(a, b), codegen
