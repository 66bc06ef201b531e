"""The LLVM instructions behind `where`, of numbers and of records, and `lanewise.records`.

Only `lanewise.compiler` imports this module.
"""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

from inspect import Parameter, Signature
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, lower_builtin

from lanewise import records, simd
from lanewise.instructions import PRIMITIVES
from lanewise.lane_types import (
    I1,
    I32,
    Floats,
    LaneType,
    Mask,
    Uints,
    Vec3Type,
    emit,
    f32,
    is_number,
    make_vec3,
    splat,
    widest,
)
from lanewise.numba_adapter import AbstractTemplate, TypingError, cgutils, infer_global
from lanewise.permutation import permute
from lanewise.view_types import pointer_of

# ---------------------------------------------------------------- where


def _blend_type(mask, a, b):
    """What `where` gives for these types; None where it has no meaning."""
    if isinstance(a, types.BaseTuple):
        return _blend_type_of_records(mask, a, b)
    kind = widest((a, b))
    lanes = isinstance(mask, Mask)
    if kind is None:
        if not (is_number(a) and is_number(b)):
            return a if a == b and not lanes else None
        both_bool = isinstance(a, types.Boolean) and isinstance(b, types.Boolean)
        real = isinstance(a, types.Float) or isinstance(b, types.Float)
        if lanes:
            return Mask(mask.n) if both_bool else Floats(mask.n) if real else Uints(mask.n)
        return types.boolean if both_bool else f32 if real else types.int64
    if lanes and kind == Vec3Type(f32):
        return Vec3Type(Floats(mask.n))
    return kind


def _blend_type_of_records(mask, a, b):
    """Field by field, for records of one class."""
    class_of_a, class_of_b = (getattr(kind, "instance_class", None) for kind in (a, b))
    if not isinstance(b, types.BaseTuple) or class_of_a != class_of_b or len(a) != len(b):
        return None
    kinds = [_blend_type(mask, x, y) for x, y in zip(a, b, strict=True)]
    if None in kinds:
        return None
    return types.BaseTuple.from_types(kinds, class_of_a) if kinds else a


def is_record(kind: Any) -> bool:
    """True for tuples, named ones too."""
    return isinstance(kind, types.BaseTuple)


def _blend(context: Any, builder: Any, mask: Any, kinds: Any, values: Any, target: Any) -> Any:
    """``where`` for a mask of bits, one (lanes or not) for all fields of a record."""
    if is_record(target):
        parts = [
            _blend(
                context, builder, mask, (x, y), [builder.extract_value(v, i) for v in values], part
            )
            for i, (x, y, part) in enumerate(zip(*kinds, target.types, strict=True))
        ]
        return context.make_tuple(builder, target, parts)
    element = target.component if isinstance(target, Vec3Type) else target
    if isinstance(element, LaneType) and not isinstance(mask.type, ir.VectorType):
        mask = splat(builder, mask, element.n)
    return emit(context, builder, kinds, values, target, lambda b, x, y: b.select(mask, x, y))


@intrinsic
def _where(typing, mask, a, b):
    kind = _blend_type(mask, a, b)
    if kind is None:
        return None

    def codegen(context, builder, sig, args):
        condition = args[0]
        if not isinstance(sig.args[0], Mask):
            condition = context.cast(builder, condition, sig.args[0], types.boolean)
            condition = context.get_value_as_data(builder, types.boolean, condition)
            condition = builder.trunc(condition, I1) if condition.type != I1 else condition
        return _blend(context, builder, condition, sig.args[1:], args[1:], kind)

    return kind(mask, a, b), codegen


PRIMITIVES[simd.where] = _where


# ---------------------------------------------------------------- replace


def replace(record, **fields):
    """What `records.replace` is to Numba: a name that the template below knows."""


PRIMITIVES[records.replace] = replace


@infer_global(replace)
class _Replace(AbstractTemplate):
    def generic(self, args, kws):
        if len(args) != 1 or not isinstance(args[0], types.BaseTuple) or not kws:
            return None
        record = args[0]
        names = getattr(record, "fields", ())
        unknown = sorted(set(kws) - set(names))
        if unknown:
            raise TypingError(f"{record} has no field {', '.join(unknown)}")
        kinds = [kws.get(name, kind) for name, kind in zip(names, record, strict=True)]
        result = types.BaseTuple.from_types(kinds, record.instance_class)
        # Lowering is given the values in the order of this signature, which also names them.
        parameters = [Parameter("record", Parameter.POSITIONAL_ONLY)]
        parameters += [Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in kws]
        return result(record, *kws.values()).replace(pysig=Signature(parameters))


@lower_builtin(replace, types.BaseTuple, types.VarArg(types.Any))
def _lower_replace(context, builder, sig, args):
    record, *values = args
    given = dict(zip(list(sig.pysig.parameters)[1:], values, strict=True))
    parts = [
        given.get(name, builder.extract_value(record, i))
        for i, name in enumerate(sig.args[0].fields)
    ]
    return context.make_tuple(builder, sig.return_type, parts)


# ---------------------------------------------------------------- memory


def _count_rows(kind: Any) -> int:
    """How many lanes a value of this type holds; none in what is uniform."""
    if isinstance(kind, Vec3Type):
        return 3 * _count_rows(kind.component)
    if is_record(kind):
        return sum(_count_rows(part) for part in kind)
    return 1 if isinstance(kind, LaneType) else 0


def _parts_of(kind: Any) -> tuple:
    """Types of the fields of a record, or of the components of a Vec3."""
    return (kind.component,) * 3 if isinstance(kind, Vec3Type) else tuple(kind)


@intrinsic(prefer_literal=True)
def _local_records(typing, room, like):
    if not isinstance(room, types.IntegerLiteral):
        return None

    def codegen(context, builder, sig, args):
        size = ir.Constant(I32, room.literal_value * _count_rows(like))
        memory = cgutils.alloca_once(builder, I32, size=size)
        memory.align = 64
        return memory

    return types.CPointer(types.uint32)(room, like), codegen


class _Rows:
    """Addresses of one row after another, from a place in each."""

    def __init__(self, context, builder, sig, args):
        self._builder = builder
        data = pointer_of(context, builder, sig.args[0], args[0])
        room, at = (context.cast(builder, args[i], sig.args[i], types.int64) for i in (1, 2))
        self._next, self._room = builder.gep(data, [at]), room

    def next(self, vector):
        """A pointer to the lanes of the next row."""
        here = self._next
        self._next = self._builder.gep(here, [self._room])
        return self._builder.bitcast(here, vector.as_pointer())


def _store(builder, rows, order, kind, value):
    """All lanes of a value, each to a row of its own."""
    if isinstance(kind, Vec3Type) or is_record(kind):
        for i, part in enumerate(_parts_of(kind)):
            _store(builder, rows, order, part, builder.extract_value(value, i))
    elif isinstance(kind, LaneType):
        floats, uints = Floats(kind.n).vector, Uints(kind.n).vector
        if isinstance(kind, Mask):
            value = builder.zext(value, uints)
        value = permute(builder, builder.bitcast(value, floats), order, kind.n)
        builder.store(value, rows.next(floats)).align = 4


def _load(context, builder, rows, kind, value):
    """The value with its lanes from one row after another."""
    if isinstance(kind, Vec3Type) or is_record(kind):
        parts = [
            _load(context, builder, rows, part, builder.extract_value(value, i))
            for i, part in enumerate(_parts_of(kind))
        ]
        if isinstance(kind, Vec3Type):
            return make_vec3(context, builder, kind, parts)
        return context.make_tuple(builder, kind, parts)
    if not isinstance(kind, LaneType):
        return value
    vector = Uints(kind.n).vector if isinstance(kind, Mask) else kind.vector
    loaded = builder.load(rows.next(vector))
    loaded.align = 4
    if isinstance(kind, Mask):
        return builder.icmp_unsigned("!=", loaded, ir.Constant(vector, [0] * kind.n))
    return loaded


@intrinsic
def _put_records(typing, memory, room, at, order, record):
    def codegen(context, builder, sig, args):
        _store(builder, _Rows(context, builder, sig, args), args[3], record, args[4])
        return context.get_dummy_value()

    return types.void(memory, room, at, order, record), codegen


@intrinsic
def _records_at(typing, memory, room, at, like):
    def codegen(context, builder, sig, args):
        return _load(context, builder, _Rows(context, builder, sig, args), like, args[3])

    return like(memory, room, at, like), codegen


PRIMITIVES[records.local_records] = _local_records
PRIMITIVES[records.put_records] = _put_records
PRIMITIVES[records.records_at] = _records_at
