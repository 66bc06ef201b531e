"""What lanewise uses of the objects that Numba and llvmlite hand to it."""

#: (class, method or attribute) that other files use -> what is assumed of it. The code generators
#: are given a `BaseContext` as `context`, and unboxing a `PythonAPI` as `c.pyapi`.
METHODS = {
    ("numba.core.base.BaseContext", "cast"): "converts a value to another type",
    ("numba.core.base.BaseContext", "get_constant"): "a Python number as a constant",
    ("numba.core.base.BaseContext", "get_data_type"): "how a type is laid out in memory",
    ("numba.core.base.BaseContext", "get_dummy_value"): "what a call that returns None gives",
    ("numba.core.base.BaseContext", "get_function"): "what emits a call, by operator and signature",
    ("numba.core.base.BaseContext", "get_value_as_data"): "a value as it is laid out in memory",
    ("numba.core.base.BaseContext", "get_value_type"): "the LLVM type of values of a type",
    ("numba.core.base.BaseContext", "make_tuple"): "a tuple of values",
    ("numba.core.pythonapi.PythonAPI", "decref"): "gives a reference back",
    ("numba.core.pythonapi.PythonAPI", "err_occurred"): "not null if Python has raised",
    ("numba.core.pythonapi.PythonAPI", "float_as_double"): "the double in a Python float",
    ("numba.core.pythonapi.PythonAPI", "number_float"): "a number as a Python float",
    ("numba.core.pythonapi.PythonAPI", "object_getattr_string"): "an attribute by its name",
    ("llvmlite.ir.Type", "as_pointer"): "pointers know the type that they point to",
    ("llvmlite.ir.PointerType", "pointee"): "the type that a pointer points to",
}
