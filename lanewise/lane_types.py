"""Numba types of the SPMD text, their operators, and `Vec3` as kernels see it.

Only `lanewise.compiler` brings this module in. Types:

- ``f32xN``, ``u32xN``, ``maskN``: a packet's lanes as one LLVM vector;
- ``Vec3[f32]``, ``Vec3[f32xN]``: three of them.
"""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.extending import (
    NativeValue,
    lower_builtin,
    make_attribute_wrapper,
    models,
    register_model,
    type_callable,
    typeof_impl,
    unbox,
)

from lanewise.machine import lanes_of_machine
from lanewise.numba_adapter import (
    AbstractTemplate,
    cgutils,
    infer_global,
    lower_constant,
    make_struct,
)
from lanewise.vec3 import Vec3

N = lanes_of_machine()

F32, I1, I8, I32, I64 = ir.FloatType(), ir.IntType(1), ir.IntType(8), ir.IntType(32), ir.IntType(64)


# ---------------------------------------------------------------- types


class LaneType(types.Type):
    """Lanes of one scalar type: a vector register (or several)."""

    def __init__(self, scalar: types.Type, llvm: ir.Type, prefix: str, n: int):
        self.scalar, self.llvm, self.n = scalar, llvm, n
        super().__init__(name=f"{prefix}x{n}")

    @property
    def vector(self) -> ir.VectorType:
        """The LLVM type."""
        return ir.VectorType(self.llvm, self.n)


class Floats(LaneType):
    """float32 lanes."""

    def __init__(self, n: int):
        super().__init__(types.float32, F32, "f32", n)


class Uints(LaneType):
    """uint32 lanes."""

    def __init__(self, n: int):
        super().__init__(types.uint32, I32, "u32", n)


class Mask(LaneType):
    """One bit a lane."""

    def __init__(self, n: int):
        super().__init__(types.boolean, I1, "mask", n)


for _class in (Floats, Uints, Mask):

    @register_model(_class)
    class _LaneModel(models.PrimitiveModel):
        def __init__(self, manager, fe_type):
            super().__init__(manager, fe_type, fe_type.vector)


class Vec3Type(types.Type):
    """Vec3 whose components are float32 or float32 lanes."""

    def __init__(self, component: types.Type):
        self.component = component
        super().__init__(name=f"Vec3[{component}]")


@register_model(Vec3Type)
class _Vec3Model(models.StructModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, [(c, fe_type.component) for c in "xyz"])


for _c in "xyz":
    make_attribute_wrapper(Vec3Type, _c, _c)

FLOATS, UINTS, MASK = Floats(N), Uints(N), Mask(N)
f32 = types.float32


# ---------------------------------------------------------------- values: scalars become lanes


def splat(builder, value, n):
    """A scalar in every lane."""
    vector = ir.VectorType(value.type, n)
    undefined = ir.Constant(vector, ir.Undefined)
    one = builder.insert_element(undefined, value, ir.Constant(I32, 0))
    return builder.shuffle_vector(one, undefined, ir.Constant(ir.VectorType(I32, n), [0] * n))


def convert(context, builder, value, source, target):
    """Lift a number, or a Vec3 of numbers, to lanes; anything to its own type as it is."""
    if source == target:
        return value
    if isinstance(target, Vec3Type):
        parts = []
        for i in range(3):
            if isinstance(source, Vec3Type):
                part, kind = builder.extract_value(value, i), source.component
            else:
                part, kind = value, source
            parts.append(convert(context, builder, part, kind, target.component))
        return make_vec3(context, builder, target, parts)
    if isinstance(target, LaneType):
        return splat(builder, scalar(context, builder, value, source, target), target.n)
    return context.cast(builder, value, source, target)


def scalar(context, builder, value, source, target):
    """A number cast to the scalar of the lane type `target`."""
    if isinstance(target, Uints):
        # By way of int64: whole numbers wrap modulo 2^32 as in the twin.
        value = context.cast(builder, value, source, types.int64)
        return builder.trunc(value, I32)
    value = context.cast(builder, value, source, target.scalar)
    return builder.trunc(value, I1) if isinstance(target, Mask) and value.type != I1 else value


def make_vec3(context, builder, kind, parts):
    """A Vec3 of type `kind` from its three components."""
    return make_struct(context, builder, kind, **dict(zip("xyz", parts, strict=True)))


def is_number(kind) -> bool:
    """True for Numba's scalar types."""
    return isinstance(kind, (types.Number, types.Boolean))


def widest(kinds):
    """The type that an operation on `kinds` is carried out in; None if it is not ours."""
    lanes = [k.component if isinstance(k, Vec3Type) else k for k in kinds]
    if not all(isinstance(k, LaneType) or is_number(k) for k in lanes):
        return None
    wide = [k for k in lanes if isinstance(k, LaneType)]
    if len(set(wide)) > 1:
        return None
    vec = any(isinstance(k, Vec3Type) for k in kinds)
    if vec and wide and not isinstance(wide[0], Floats):
        return None
    element = wide[0] if wide else f32
    return Vec3Type(element) if vec else element if wide else None


def emit(context, builder, kinds, values, target, make):
    """Lift all values to `target` and apply ``make(builder, *values)`` to each component."""
    lifted = [convert(context, builder, v, k, target) for v, k in zip(values, kinds, strict=True)]
    if not isinstance(target, Vec3Type):
        return make(builder, *lifted)
    parts = [make(builder, *(builder.extract_value(v, i) for v in lifted)) for i in range(3)]
    return make_vec3(context, builder, target, parts)


def call(builder, name, result, arguments):
    """Call an LLVM intrinsic by name."""
    kind = ir.FunctionType(result, [a.type for a in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)


def suffix(kind) -> str:
    """The type part of an LLVM intrinsic's name: v16f32, f32, v16i32, i64 ..."""
    if isinstance(kind, ir.VectorType):
        return f"v{kind.count}{suffix(kind.element)}"
    return "f32" if kind == F32 else "f64" if kind == ir.DoubleType() else f"i{kind.width}"


# ---------------------------------------------------------------- operators


def _register_operator(op, instruction, classes, result=None):
    """Teach Numba ``op`` on lanes (and Vec3) of the given classes; scalars are lifted."""

    @infer_global(op)
    class Template(AbstractTemplate):
        def generic(self, args, kws):
            if kws or len(args) not in (1, 2):
                return None
            target = widest(args)
            element = target.component if isinstance(target, Vec3Type) else target
            vec_of_numbers = isinstance(target, Vec3Type) and element == f32
            if not (isinstance(element, classes) or (vec_of_numbers and Floats in classes)):
                return None
            if isinstance(target, Vec3Type) and result is not None:
                return None
            return (result(target) if result else target)(*args)

    def lower(context, builder, sig, args):
        return emit(context, builder, sig.args, args, widest(sig.args), instruction)

    kinds = (*classes, Vec3Type) if Floats in classes else classes
    for kind in kinds:
        if op in (operator.neg, operator.invert):
            lower_builtin(op, kind)(lower)
            continue
        lower_builtin(op, kind, kind)(lower)
        for other in (types.Number, types.Boolean):
            lower_builtin(op, kind, other)(lower)
            lower_builtin(op, other, kind)(lower)
    if Floats in classes and op is not operator.neg:
        lower_builtin(op, Vec3Type, Floats)(lower)
        lower_builtin(op, Floats, Vec3Type)(lower)


def _method(name):
    return lambda builder, *values: getattr(builder, name)(*values)


for _op, _inplace, _name in (
    (operator.add, operator.iadd, "fadd"),
    (operator.sub, operator.isub, "fsub"),
    (operator.mul, operator.imul, "fmul"),
    (operator.truediv, operator.itruediv, "fdiv"),
):
    _register_operator(_op, _method(_name), (Floats,))
    _register_operator(_inplace, _method(_name), (Floats,))
_register_operator(operator.neg, _method("fneg"), (Floats,))

for _op, _inplace, _name in (
    (operator.add, operator.iadd, "add"),
    (operator.sub, operator.isub, "sub"),
    (operator.mul, operator.imul, "mul"),
    (operator.lshift, operator.ilshift, "shl"),
    (operator.rshift, operator.irshift, "lshr"),
    (operator.floordiv, operator.ifloordiv, "udiv"),
    (operator.mod, operator.imod, "urem"),
):
    _register_operator(_op, _method(_name), (Uints,))
    _register_operator(_inplace, _method(_name), (Uints,))
for _op, _inplace, _name in (
    (operator.and_, operator.iand, "and_"),
    (operator.or_, operator.ior, "or_"),
    (operator.xor, operator.ixor, "xor"),
):
    _register_operator(_op, _method(_name), (Uints, Mask))
    _register_operator(_inplace, _method(_name), (Uints, Mask))
_register_operator(operator.invert, _method("not_"), (Uints, Mask))

for _op, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):

    def _compare(builder, a, b, sign=_sign):
        if a.type.element == F32:
            # Unordered "!=": NaN differs from everything, as in NumPy.
            ordered = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
            return ordered(sign, a, b)
        return builder.icmp_unsigned(sign, a, b)

    _register_operator(_op, _compare, (Floats, Uints), lambda target: Mask(target.n))


# ---------------------------------------------------------------- Vec3 at the border


@typeof_impl.register(Vec3)
def _typeof_vec3(value, c):
    return Vec3Type(f32)


@lower_constant(Vec3Type)
def _constant_vec3(context, builder, kind, value):
    parts = [context.get_constant(f32, float(getattr(value, c))) for c in "xyz"]
    return ir.Constant.literal_struct(parts)


@type_callable(Vec3)
def _type_vec3(context):
    def typer(x, y, z):
        target = widest((x, y, z))
        if target is None and all(is_number(k) for k in (x, y, z)):
            target = f32
        return Vec3Type(target) if target == f32 or isinstance(target, Floats) else None

    return typer


@lower_builtin(Vec3, types.Any, types.Any, types.Any)
def _construct_vec3(context, builder, sig, args):
    component = sig.return_type.component
    parts = [
        convert(context, builder, v, k, component) for v, k in zip(args, sig.args, strict=True)
    ]
    return make_vec3(context, builder, sig.return_type, parts)


@unbox(Vec3Type)
def _unbox_vec3(kind, value, c):
    parts = []
    for name in "xyz":
        part = c.pyapi.object_getattr_string(value, name)
        number = c.pyapi.number_float(part)
        parts.append(c.builder.fptrunc(c.pyapi.float_as_double(number), F32))
        c.pyapi.decref(number)
        c.pyapi.decref(part)
    return NativeValue(
        make_vec3(c.context, c.builder, kind, parts),
        is_error=cgutils.is_not_null(c.builder, c.pyapi.err_occurred()),
    )
