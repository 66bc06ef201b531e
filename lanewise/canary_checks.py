"""What the canary tries of `lanewise.numba_adapter`, part by part.

Each function tries one part. Its docstring is what is assumed.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from types import FunctionType
from typing import Any

import numpy as np

from lanewise.canary_instructions import numbers, try_instructions
from lanewise.jit import dispatcher_of, instantiate, kernel, load_compiler
from lanewise.machine import lanes_of_machine
from lanewise.machine_code import MachineCode
from lanewise.simd import (
    LANES,
    any_lane,
    as_float,
    lanes,
    load_lanes,
    store_lanes,
    where,
)
from lanewise.vec3 import Vec3
from lanewise.view import View

Check = Callable[[], None]
CHECKS: dict[str, Check] = {"instructions": try_instructions}


def _check(part: str) -> Callable[[Check], Check]:
    def register(function: Check) -> Check:
        CHECKS[part] = function
        return function

    return register


@kernel
def _half(x):
    return x * 0.5


@kernel
def _doubled(x):
    return x + x


@kernel
def _times(x, n):
    return x * n


@kernel
def _two_times(x):
    return _times(x, 2) + _times(x, 3)


@kernel
def _root(table):
    total = lanes(0.0)
    for i in range(0, table.size, LANES):
        x = load_lanes(table, i)
        while any_lane(x > 1.0):
            x = where(x > 1.0, _half(x), x)
        total = total + _two_times(x) * x
        store_lanes(table, i, total)


@kernel(strict=True)
def _strict_root(table):
    _root(table)


@kernel
def _one_of_two(table):
    table[1] = as_float(1 if table[0] in (2.0, 5.0) else 0)


def _fresh(text: FunctionType, stock: bool = False) -> Any:
    """A dispatcher of a copy: what was compiled before would not be compiled again."""
    from lanewise.numba_adapter import NullCache, look_in

    copy = FunctionType(text.__code__, text.__globals__, text.__name__)
    copy.__dict__.update(text.__dict__)
    dispatcher = dispatcher_of(copy, stock=stock)
    look_in(dispatcher, NullCache())
    return dispatcher


def _llvm(text: FunctionType) -> str:
    """Optimised LLVM IR of a root kernel with one table."""
    dispatcher = _fresh(text)
    load_compiler().object_code(dispatcher, (numbers(),))
    [found] = dispatcher.inspect_llvm().values()
    return found


def _compiled(text: FunctionType, *arguments: Any, stock: bool = False) -> Any:
    from numba import typeof

    dispatcher = _fresh(text, stock)
    dispatcher.compile(tuple(map(typeof, arguments)))
    return dispatcher


def _type_of_result(text: FunctionType, *arguments: Any, stock: bool = False) -> str:
    dispatcher = _compiled(text, *arguments, stock=stock)
    return str(dispatcher.nopython_signatures[0].return_type)


def _run_root(run: Callable) -> None:
    table, x = numbers(), numbers().array.reshape(4, -1)
    run(table)
    while (x > 1.0).any():
        x = np.where(x > 1.0, 0.5 * x, x)
    expected = np.cumsum(5.0 * x * x, axis=0).reshape(-1)
    np.testing.assert_allclose(table.array, expected, rtol=1e-5)


@_check("make_struct")
def _try_make_struct() -> None:
    """A struct proxy takes its fields by name and gives its value by `_getvalue`."""

    def text(table):
        v = Vec3(table[0], table[1], table[2])
        table[3] = v.x + 2.0 * v.y + 4.0 * v.z

    table = View(np.float32([1.0, 2.0, 3.0, 0.0]))
    instantiate(kernel(text))(table)
    assert table.array[3] == 17.0, f"17 expected, got {table.array[3]}"


@_check("Float32Constants")
def _try_constants() -> None:
    """Constants of the text can be replaced before types are inferred."""
    found = _type_of_result(_half, np.float32(1.0))
    assert found == "float32", f"float32 times a constant is {found}"


@_check("OptimisedLibrary")
def _try_library() -> None:
    """A finalised module gives object code; Numba's engine need not have it, nor its runtime."""
    dispatcher = _fresh(_strict_root)
    made = load_compiler().object_code(dispatcher, (numbers(),))
    [compiled] = dispatcher.overloads.values()
    assert len(compiled.library.linked) == 1, "linked with more than what it calls"
    assert compiled.library.alone, "what was lowered for it is not one module"
    assert made.symbol.encode() in made.code, "the object code lacks its symbol"
    _run_root(MachineCode("canary", secrets.token_hex(8), lambda arguments: made))


@_check("InlinedLibrary")
def _try_inlining() -> None:
    """A library's module for linking is a copy whose functions may be given attributes."""
    calls = re.findall(r"call [^\n]*@_Z[^\n]*", _llvm(_one_of_two))
    assert not calls, f"not inlined: {calls[0]}"


@_check("unused_entry")
@_check("bare_descriptor")
@_check("as_compiled")
@_check("look_in")
def _try_bitcode() -> None:
    """A dispatcher asks its cache first, and takes names, types and bitcode for a function."""
    from lanewise import numba_adapter as adapter

    class Kept(adapter.NullCache):
        saved: list[Any] = []

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            if not self.saved:
                return None
            descriptor, bitcode = self.saved
            library = adapter.OptimisedLibrary(target_context.codegen(), descriptor.qualname)
            library.load(bitcode)
            return adapter.as_compiled(descriptor, library, target_context)

        def save_overload(self, sig: Any, cres: Any) -> None:
            self.saved += [adapter.bare_descriptor(cres), cres.library.bitcode()]

    made = []
    for _ in range(2):
        dispatcher = _fresh(_root)
        adapter.look_in(dispatcher, Kept())
        made.append(load_compiler().object_code(dispatcher, (numbers(),)))
    assert made[0].symbol == made[1].symbol, "the second was compiled"
    _run_root(MachineCode("canary", secrets.token_hex(8), lambda arguments: made[1]))


@_check("LowerToLibrary")
def _try_lowering() -> None:
    """A kernel without an entry for Python can be called by others, and is inlined."""
    calls = re.findall(r"call [^\n]*_(?:half|times)[^\n]*", _llvm(_root))
    assert not calls, f"not inlined: {calls[0]}"


@_check("RememberingContext")
def _try_remembering() -> None:
    """What a call is depends on the function and the types of its arguments only."""
    kinds = [_type_of_result(_doubled, x) for x in (np.float32(1), np.float64(1), np.float32(1))]
    assert kinds == ["float32", "float64", "float32"], str(kinds)


@_check("KernelTypeInference")
def _try_inference() -> None:
    """Type inference asks the typing context of its state, and no other, about calls."""
    answers = import_module("lanewise.remembered_answers").ANSWERS
    answers.clear()
    _compiled(kernel(lambda x: x - x), np.float32(1))
    assert answers, "nothing was asked"
    [compiled] = _compiled(_two_times, np.float32(1)).overloads.values()
    asked = {kernel.__name__ for (kernel, _, _), _ in compiled.library.calls}
    assert asked == {"_times"}, f"asked about {asked or 'no kernel'}"


@_check("LeanCompiler")
def _try_lean() -> None:
    """Ten passes, Numba's or made of its own, in this order, are enough for kernel text."""
    made = load_compiler().object_code(_fresh(_root), (numbers(),))
    _run_root(MachineCode("canary", secrets.token_hex(8), lambda arguments: made))
    llvm = _llvm(_root)
    doubles = re.findall(r"f(?:add|sub|mul|div|pext)[^\n]*\bdouble\b[^\n]*", llvm)
    assert not doubles, f"double arithmetic: {doubles[0]}"
    assert "NRT_incref" not in llvm, "references are counted"


@_check("StockCompiler")
def _try_stock() -> None:
    """Numba's own pipeline takes one more pass, behind the processing of its IR."""
    found = _type_of_result(_half, np.float32(1.0), stock=True)
    assert found == "float32", f"float32 times a constant is {found}"
    _run_root(_fresh(_root, stock=True))


@_check("jit")
def _try_options() -> None:
    """njit takes a pipeline, a set of fast-math flags, and what not to wrap."""
    fast, strict = _llvm(_root), _llvm(_strict_root)
    assert re.search(r"fmul [^\n]*contract", fast), "no fast-math"
    assert not re.search(r"f(mul|add) [^\n]*(nnan|ninf|fast)", fast), "NaN would not be kept"
    assert not re.search(r"f(mul|add) [^\n]*(contract|reassoc)", strict), "strict text is not"
    assert f"<{lanes_of_machine()} x float>" in fast, "no packets"


@_check("call_template")
def _try_call_template() -> None:
    """A call with constants can be typed as one with numbers; TypingError says where not."""
    inner = _compiled(_two_times, np.float32(1)).py_func.__globals__["_times"]
    numbers = {str(signature[1]) for signature in inner.signatures}
    assert numbers == {"int64"}, f"compiled for {numbers}"


@_check("untold_of_locks")
def _try_locks() -> None:
    """LLVM's lock has a list of those who are told when it is taken, which may be another one."""
    import llvmlite.binding as llvm

    event, short = import_module("numba.core.event"), import_module("lanewise.numba_shortcuts")
    with event.install_recorder("numba:llvm_lock") as seen, short.untold_of_locks():
        llvm.parse_assembly("")
    assert not seen.buffer, "Numba was told"
    with event.install_recorder("numba:llvm_lock") as seen:
        llvm.parse_assembly("")
    assert seen.buffer, "Numba is not told any more"


@_check("KernelLower")
def _try_operators() -> None:
    """An operator of operands that are no constants has its code by its function and signature."""
    short = import_module("lanewise.numba_shortcuts")
    short.OPERATORS.clear()
    _compiled(_two_times, np.float32(1))
    found = {operator.__name__ for operator, _ in short.OPERATORS}
    assert found == {"add"}, f"lowered {found or 'no operator'}"


@_check("shortcuts")
def _try_shortcuts() -> None:
    """What Numba has in these places is there again afterwards."""
    short = import_module("lanewise.numba_shortcuts")
    places = (short.errors, "_termcolor_inst"), (short.ir.Inst, "_rec_list_vars")
    before = [getattr(*place) for place in (*places, (short.base, "_has_loc"))]
    with short.shortcuts():
        assert getattr(*places[0]) is not before[0], "messages are coloured"
    assert [getattr(*place) for place in (*places, (short.base, "_has_loc"))] == before


@_check("Uncoloured")
def _try_uncoloured() -> None:
    """Numba's messages are the same text without colours."""
    short = import_module("lanewise.numba_shortcuts")
    with short.shortcuts():
        assert str(short.errors.TypingError("no $x")) == "no $x"


@_check("variables_in")
def _try_variables() -> None:
    """An instruction names the same variables in the same order as by Numba's own method."""
    short, run = import_module("lanewise.numba_shortcuts"), import_module("numba.core.compiler")
    its = vars(short.ir.Inst)["_rec_list_vars"]
    for block in run.run_frontend(_times).blocks.values():
        for one in block.body:
            assert short.variables_in(one, vars(one)) == its(one, vars(one)), str(one)


@_check("leave_scipy_alone")
def _try_leaving_scipy() -> None:
    """Where SciPy is, Numba asks for its linear algebra once more when it needs it."""
    import_module("lanewise.numba_shortcuts").leave_scipy_alone()
    arraymath, linalg = import_module("numba.np.arraymath"), import_module("numba.np.linalg")
    assert arraymath.ensure_blas is linalg.ensure_blas, "Numba goes on without SciPy"
    has_blas = vars(arraymath)["_HAVE_BLAS"]
    assert has_blas == bool(find_spec("scipy")), "Numba is wrong about SciPy"


@_check("object_code")
def _try_object_code() -> None:
    """A C function takes the leaves of its arguments in order, behind two pointers."""

    def text(pair, flag, v, x, table):
        table[0], table[1], table[2] = as_float(pair[1]), v.y, as_float(x)
        table[3] = as_float(1 if flag else 0) + pair[0][0]

    table = View(np.zeros(4, np.float32))
    pair = (View(np.float32([0.5])), np.uint32(7))
    instantiate(kernel(text))(pair, True, Vec3(1.0, 2.0, 3.0), np.float32(0.25), table)
    assert table.array.tolist() == [7.0, 2.0, 0.25, 1.5], str(table.array)
