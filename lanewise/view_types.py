"""The Numba type of `View` and what kernels do with one: ``View[dtype]``, a pointer and a size.

Only `lanewise.compiler` brings this module in.
"""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

import operator

from numba import from_dtype, types
from numba.extending import (
    NativeValue,
    lower_builtin,
    make_attribute_wrapper,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from lanewise.numba_adapter import AbstractTemplate, cgutils, infer_global, make_struct
from lanewise.view import View


class ViewType(types.Type):
    """A `View` of one element type."""

    def __init__(self, dtype):
        self.dtype = dtype
        super().__init__(name=f"View[{dtype}]")


@register_model(ViewType)
class _ViewModel(models.StructModel):
    def __init__(self, manager, fe_type):
        super().__init__(
            manager, fe_type, [("data", types.CPointer(fe_type.dtype)), ("size", types.int64)]
        )


make_attribute_wrapper(ViewType, "size", "size")


@typeof_impl.register(View)
def _typeof_view(value, c):
    return ViewType(from_dtype(value.dtype))


@unbox(ViewType)
def _unbox_view(kind, value, c):
    def number(name):
        attribute = c.pyapi.object_getattr_string(value, name)
        result = c.unbox(types.int64, attribute).value
        c.pyapi.decref(attribute)
        return result

    pointer = c.context.get_value_type(types.CPointer(kind.dtype))
    data = c.builder.inttoptr(number("address"), pointer)
    return NativeValue(make_struct(c.context, c.builder, kind, data=data, size=number("size")))


@infer_global(operator.getitem)
class _ViewGetItem(AbstractTemplate):
    def generic(self, args, kws):
        if isinstance(args[0], ViewType) and isinstance(args[1], types.Integer):
            return args[0].dtype(args[0], types.int64)
        return None


@infer_global(operator.setitem)
class _ViewSetItem(AbstractTemplate):
    def generic(self, args, kws):
        if isinstance(args[0], ViewType) and isinstance(args[1], types.Integer):
            return types.none(args[0], types.int64, args[0].dtype)
        return None


def pointer_of(context, builder, kind, value):
    """The data pointer of a View, or a pointer as it is."""
    if isinstance(kind, ViewType):
        return cgutils.create_struct_proxy(kind)(context, builder, value=value).data
    return value


@lower_builtin(operator.getitem, ViewType, types.Integer)
def _view_getitem(context, builder, sig, args):
    data = pointer_of(context, builder, sig.args[0], args[0])
    return builder.load(builder.gep(data, [args[1]]))


@lower_builtin(operator.setitem, ViewType, types.Integer, types.Any)
def _view_setitem(context, builder, sig, args):
    data = pointer_of(context, builder, sig.args[0], args[0])
    builder.store(args[2], builder.gep(data, [args[1]]))
    return context.get_dummy_value()
