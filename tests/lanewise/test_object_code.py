"""Root kernels on disk and in memory: arguments, files, and life without the compiler."""

from __future__ import annotations

import pickle
import weakref
from collections import namedtuple

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba.core.errors import UnsupportedError

from lanewise import numba_adapter
from lanewise.application import variable
from lanewise.jit import dispatcher_of, instantiate, kernel
from lanewise.machine_code import C_TYPES, MachineCode, ObjectCode, kind_of, leaves
from lanewise.simd import as_float
from lanewise.vec3 import Vec3
from lanewise.view import View

Inner = namedtuple("Inner", "table number")
Outer = namedtuple("Outer", "inner flag nothing word")


@kernel
def write_arguments(outer, v, small, count, out):
    """Write everything that was given, so that a number in the wrong place is seen."""
    out[0] = as_float(outer.inner.table[outer.inner.table.size - 1])
    out[1] = as_float(outer.inner.number)
    out[2] = as_float(1 if outer.flag else 0)
    out[3] = as_float(outer.word)
    out[4], out[5], out[6] = v.x, v.y, v.z
    out[7] = as_float(small)
    out[8] = as_float(count)


def test_arguments_arrive_in_their_places():
    call, out = instantiate(write_arguments), View(np.zeros(9, np.float32))
    table = View(np.arange(5, dtype=np.int32))
    for flag, number in ((True, 7), (False, -3)):
        outer = Outer(Inner(table, number), flag, (), np.uint32(9))
        call(outer, Vec3(1.5, 2.5, 3.5), np.float32(0.25), 11, out)
        assert out.array.tolist() == [4, number, flag, 9, 1.5, 2.5, 3.5, 0.25, 11]


def test_types_of_arguments_choose_the_code():
    call, out = instantiate(write_arguments), View(np.zeros(9, np.float32))
    for table in (np.int32([4, 6]), np.float32([4.5, 6.5]), np.int64([4, 1 << 40])):
        for small in (3, 2.75, np.float32(0.5)):
            outer = Outer(Inner(View(table), 1.25), False, (), np.uint32(9))
            call(outer, Vec3(0.0, 0.0, 0.0), small, 0, out)
            assert out.array[0] == np.float32(table[-1])
            assert out.array[1] == 1.25 and out.array[7] == small


def test_fixed_calls_see_what_changed():
    call, out = instantiate(write_arguments).fixed(), View(np.zeros(9, np.float32))
    other = View(np.zeros(9, np.float32))
    outer = Outer(Inner(View(np.int32([8])), 1), True, (), np.uint32(2))
    for word, result in ((2, out), (3, out), (3, other)):
        call(outer._replace(word=np.uint32(word)), Vec3(0.0, 0.0, 0.0), 1.0, word, result)
        assert result.array[[0, 3, 8]].tolist() == [8, word, word]
    assert out.array[8] == 3


def test_fixed_calls_keep_no_table_that_is_an_argument_itself():
    """The sums of a film are such a table, and machine code that reads films is kept for ever."""
    call, out = instantiate(write_arguments).fixed(), View(np.zeros(9, np.float32))
    outer = Outer(Inner(View(np.int32([8])), 1), True, (), np.uint32(2))
    call(outer, Vec3(0.0, 0.0, 0.0), 1.0, 5, out)
    memory = weakref.ref(out.shaped)
    del out
    assert memory() is None


def test_a_pickled_kernel_needs_neither_compiler_nor_cache(monkeypatch, tmp_path):
    call, out = instantiate(write_arguments).fixed(), View(np.zeros(9, np.float32))
    outer = Outer(Inner(View(np.int32([8])), 1), True, (), np.uint32(2))
    call(outer, Vec3(0.5, 0.25, 0.0), 1.0, 2, out)
    expected, out.array[:] = out.array.copy(), 0.0
    monkeypatch.setenv(variable("CACHE"), str(tmp_path / "none"))
    again = pickle.loads(pickle.dumps(call))
    again(outer, Vec3(0.5, 0.25, 0.0), 1.0, 2, out)
    np.testing.assert_array_equal(out.array, expected)
    assert not any(tmp_path.iterdir())
    # What it was not called with is not in it.
    with pytest.raises(TypeError, match="was compiled elsewhere, and not for arguments"):
        again.kernel(outer, Vec3(0.5, 0.25, 0.0), 1, 2, out)


def test_kinds_and_leaves():
    view = View(np.zeros(3, np.float32))
    value = Outer(Inner(view, 2.0), True, (), np.uint32(5))
    assert list(leaves(value)) == [view.address, 3, 2.0, True, 5]
    kinds = [kind_of(v) for v in (1, 1.0, True, np.uint32(1), np.float32(1), view, (1,), (1, 1))]
    assert len(set(kinds)) == len(kinds)
    # The fields matter, not only the values: kernels name them.
    assert kind_of(Inner(view, 2.0)) != kind_of((view, 2.0))


def test_kernels_return_nothing():
    @kernel
    def returns(out):
        return out[0]

    with pytest.raises(TypeError, match="must return nothing"):
        instantiate(returns)(View(np.zeros(1, np.float32)))


def test_code_that_calls_numbas_own_functions_is_refused(monkeypatch):
    """All of them are named, though each name ends where the next one begins."""
    library, table = numba_adapter.OptimisedLibrary, View(np.zeros(1, np.float32))
    made = library.object_code
    names = b"\0numba_frexp\0not_numba_ldexp\0numba_gil_ensure\0numba_unpickle\0"
    monkeypatch.setattr(library, "object_code", lambda self: made(self) + names)
    said = ""
    try:
        numba_adapter.object_code(dispatcher_of(scaled_by(0.5)), (table,))
    except UnsupportedError as error:
        said = str(error)
    assert said.endswith("when a kernel runs: numba_frexp, numba_gil_ensure, numba_unpickle")


def scaled_by(factor):
    @kernel
    def scale(out):
        out[0] = factor * out[0]

    return scale


def test_texts_that_differ_by_a_closure_differ_on_disk(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    for factor in (2.0, 3.0, 2.0):
        out = View(np.ones(1, np.float32))
        instantiate(scaled_by(factor))(out)
        assert out.array[0] == factor
    assert len(list(tmp_path.rglob("*.kernel"))) == 2


def test_files_from_different_processes_may_share_names(tmp_path, monkeypatch):
    """Numba counts the functions of a process; the next one begins at 1 again."""
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    one = View(np.ones(1, np.float32))
    first, second = (instantiate(scaled_by(f)).compile_for((one,)) for f in (2.0, 3.0))
    while len(first.symbol) != len(second.symbol):
        first, second = (instantiate(scaled_by(f)).compile_for((one,)) for f in (2.0, 3.0))
    same = second.code.replace(second.symbol.encode(), first.symbol.encode())
    second = second._replace(symbol=first.symbol, code=same)
    results = []
    for compiled in (first, second, first):
        out = View(np.ones(1, np.float32))
        MachineCode("scale", str(len(results)), lambda _, compiled=compiled: compiled)(out)
        results.append(float(out.array[0]))
    assert results == [2.0, 3.0, 2.0]


def test_damaged_files_are_compiled_again(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    instantiate(scaled_by(5.0))(View(np.ones(1, np.float32)))
    (path,) = tmp_path.rglob("*.kernel")
    whole = path.read_bytes()
    middle = len(whole) // 2
    for damaged in (b"", whole[:middle], whole[:middle] + b"?" + whole[middle + 1 :], b"{}\n"):
        path.write_bytes(damaged)
        out = View(np.ones(1, np.float32))
        instantiate(scaled_by(5.0))(out)
        assert out.array[0] == 5.0
        assert len(path.read_bytes()) > middle
    assert list(path.parent.iterdir()) == [path]


def test_without_room_on_disk_it_is_compiled_each_time(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("no folder can be made in here")
    monkeypatch.setenv(variable("CACHE"), str(blocked))
    calls = []

    def compile_for(arguments):
        calls.append(arguments)
        return compiled

    text = scaled_by(7.0)
    compiled = instantiate(text).compile_for((View(np.ones(1, np.float32)),))
    assert isinstance(compiled, ObjectCode) and set(compiled.arguments) <= set(C_TYPES)
    for n in (1, 2):
        out = View(np.ones(1, np.float32))
        MachineCode("scale", "seven", compile_for)(out)
        assert out.array[0] == 7.0 and len(calls) == n


def test_the_same_machine_code_is_loaded_once(monkeypatch):
    def call():
        out = View(np.zeros(9, np.float32))
        outer = Outer(Inner(View(np.int32([8])), 1), True, (), np.uint32(2))
        instantiate(write_arguments)(outer, Vec3(0.0, 0.0, 0.0), 1.0, 5, out)
        return out.array[8]

    engines, make = [], llvm.create_mcjit_compiler
    monkeypatch.setattr(llvm, "create_mcjit_compiler", lambda *a: engines.append(a) or make(*a))
    assert (call(), call()) == (5, 5)
    assert len(engines) <= 1
