"""Functions of kernels on disk: found by their text, never in place of another."""

from __future__ import annotations

from collections import namedtuple
from types import FunctionType

import llvmlite.binding as llvm
import numpy as np
import pytest

from lanewise import jit, machine, numba_adapter
from lanewise.application import variable
from lanewise.jit import instantiate, kernel, specialised
from lanewise.machine import functions_folder, lanes_of_machine
from lanewise.simd import LANES, load_lanes, sqrt, store_lanes
from lanewise.source_digest import digests_of_text
from lanewise.vec3 import Vec3
from lanewise.view import View

Pair = namedtuple("Pair", "a b")
SHIFT = 0.5
SCALES = (2.0, 3.0)
WHITE = Vec3(1.0, 2.0, 3.0)


@kernel
def inner(x):
    """The same in both programs."""
    return sqrt(x) + SHIFT


@specialised
def changing(program):
    """Different in each program."""

    @kernel
    def text(x):
        return inner(x) * program

    return text


@kernel
def root(table):
    """Call both."""
    x = load_lanes(table, 0)
    store_lanes(table, 0, changing(x) + inner(x))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache, and nothing compiled in this process."""
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    monkeypatch.setattr(jit, "_SHARED", {})
    return tmp_path


@pytest.fixture
def compiled(monkeypatch):
    """Names of the kernels that are compiled from now on."""
    names = []
    run_pass = numba_adapter.LowerToLibrary.run_pass

    def look(self, state):
        names.append(state.func_id.func_name)
        return run_pass(self, state)

    monkeypatch.setattr(numba_adapter.LowerToLibrary, "run_pass", look)
    return names


def table():
    return View(np.arange(1, 1 + int(LANES), dtype=np.float32))


def code_of(program):
    """What the processor gets: all of an object file but names."""
    return sections_of(instantiate(root, program).compile_for((table(),)))


def sections_of(made):
    """Of an object file."""
    sections = llvm.ObjectFileRef.from_data(made.code).sections()
    found = [(part.name(), bytes(part.data())) for part in sections]
    return [part for part in found if part[0] not in (".strtab", ".symtab", b".strtab", b".symtab")]


def test_only_what_is_new_is_compiled(folder, compiled, monkeypatch):
    code_of(2.0)
    assert sorted(compiled) == ["inner", "root", "text"]
    for program, expected in ((2.0, []), (3.0, ["text"]), (3.0, [])):
        monkeypatch.setattr(jit, "_SHARED", {})
        compiled.clear()
        code_of(program)
        assert sorted(compiled) == expected


def test_found_or_compiled_it_is_the_same_machine_code(folder, tmp_path, monkeypatch):
    """Callers are optimised together with what they call, so this holds only if both are equal."""
    compiled_alone = code_of(3.0)
    for earlier in (3.0, 2.0):
        monkeypatch.setenv(variable("CACHE"), str(tmp_path / str(earlier)))
        monkeypatch.setattr(jit, "_SHARED", {})
        code_of(earlier)
        monkeypatch.setattr(jit, "_SHARED", {})
        assert code_of(3.0) == compiled_alone
    assert code_of(2.0) != compiled_alone


def test_a_root_alone_is_optimised_as_a_whole(folder, monkeypatch):
    """The time of doing so for each function grows with the depth of calls, for no other code."""
    names = []
    optimise = numba_adapter.JITCodeLibrary._optimize_final_module

    def look(self):
        names.append(self.name)
        return optimise(self)

    monkeypatch.setattr(numba_adapter.JITCodeLibrary, "_optimize_final_module", look)
    for program in (2.0, 3.0):  # compiled, and linked with another callee
        monkeypatch.setattr(jit, "_SHARED", {})
        code_of(program)
    assert names == ["root", "root"]


def test_what_is_found_computes_what_the_text_says(folder, monkeypatch):
    for program in (2.0, 3.0, 2.0):
        monkeypatch.setattr(jit, "_SHARED", {})
        numbers, width = table(), lanes_of_machine()
        expected = (np.sqrt(numbers.array[:width]) + np.float32(0.5)) * (1 + program)
        instantiate(root, program)(numbers)
        np.testing.assert_allclose(numbers.array[:width], expected, rtol=1e-6)


def test_damaged_files_are_compiled_again(folder, compiled, monkeypatch):
    whole = code_of(2.0)
    for path in functions_folder().iterdir():
        kept = path.read_bytes()
        path.write_bytes(kept[: len(kept) // 2] + b"?" + kept[len(kept) // 2 + 1 :])
    monkeypatch.setattr(jit, "_SHARED", {})
    compiled.clear()
    assert code_of(2.0) == whole
    assert sorted(compiled) == ["inner", "root", "text"]


def write_operation(operation):
    @kernel
    def text(x):
        return operation(x)

    return text


def doubled(x):
    return x + x


def constant(x):
    return 2.0


OPERATIONS = {"root": sqrt, "double": kernel(doubled), "constant": kernel(constant)}


@specialised
def left(program):
    """The first of the operations that a program names."""
    return write_operation(OPERATIONS[program[0]])


@specialised
def right(program):
    """The second one; the very kernel that is `left` where a program names no second."""
    return write_operation(OPERATIONS[program[1]]) if len(program) > 1 else left


@kernel
def both(table):
    """Name two kernels, and one that is always the same."""
    x = load_lanes(table, 0)
    store_lanes(table, 0, inner(left(x) - 3.0 * right(x) + 100.0))


@pytest.mark.parametrize(
    ("earlier", "program", "expected"),
    [
        (("root", "double"), ("double", "root"), []),
        (("root",), ("root", "double"), ["both", "doubled", "text"]),
        (("root", "double"), ("root",), ["both"]),
        (("root", "double"), ("root", "constant"), ["both", "constant", "text"]),
        (("constant", "double"), ("root", "double"), ["both", "text"]),
    ],
    ids=["swapped", "one-becomes-two", "two-become-one", "another-type", "and-back"],
)
def test_text_is_linked_with_other_callees_only_where_they_fit(
    folder, compiled, monkeypatch, tmp_path, earlier, program, expected
):
    instantiate(both, earlier).compile_for((table(),))
    monkeypatch.setattr(jit, "_SHARED", {})
    compiled.clear()
    made = instantiate(both, program)
    linked = made.compile_for((table(),))
    assert sorted(compiled) == expected

    numbers = table()
    x = numbers.array[: lanes_of_machine()].astype(np.float64)
    values = {"root": np.sqrt(x), "double": 2.0 * x, "constant": 2.0}
    a, b = values[program[0]], values[program[-1]]
    made(numbers)
    expected = np.sqrt(a - 3.0 * b + 100.0) + SHIFT
    np.testing.assert_allclose(numbers.array[: len(x)], expected, rtol=1e-5)

    monkeypatch.setenv(variable("CACHE"), str(tmp_path / "another"))
    monkeypatch.setattr(jit, "_SHARED", {})
    assert sections_of(instantiate(both, program).compile_for((table(),))) == sections_of(linked)


def pair_of(fields):
    """A record that is always found under the same name."""
    kind = namedtuple("Pair", fields)
    kind.__module__ = __name__
    return kind


Pair = pair_of("a b")


@kernel
def make_pair(x):
    """A record, by the names of its fields."""
    return Pair(a=x, b=x + x)


@kernel
def difference(table):
    """Read a record that another kernel has made."""
    pair = make_pair(load_lanes(table, 0))
    store_lanes(table, 0, pair.b - pair.a)


def test_text_is_not_linked_with_a_record_whose_fields_are_elsewhere(folder, monkeypatch):
    """The types are those that they were, and the fields' places are in the text's code."""
    x = table().array[: lanes_of_machine()].copy()
    for fields in ("a b", "b a"):
        monkeypatch.setattr(jit, "_SHARED", {})
        monkeypatch.setitem(globals(), "Pair", pair_of(fields))
        numbers = table()
        made = instantiate(difference, ())
        made.compile_for((table(),))
        made(numbers)
        np.testing.assert_allclose(numbers.array[: len(x)], x, rtol=1e-6)


@kernel
def applied(x, operation):
    """Call what is given."""
    return operation(x) + SHIFT


@kernel
def over(x):
    """Give the first operation, which the text names, to another kernel."""
    return applied(x, left)


@kernel
def giving(table):
    """Through one call more, so that `over` can be linked with another `left`."""
    store_lanes(table, 0, over(load_lanes(table, 0)))


def test_a_kernel_that_is_given_to_another_is_part_of_what_is_kept(folder, monkeypatch):
    """A function that takes a kernel is told from one that takes another by nothing but that."""
    for program, expected in ((("root",), 1.5), (("double",), 2.5), (("root",), 1.5)):
        monkeypatch.setattr(jit, "_SHARED", {})
        numbers = View(np.ones(lanes_of_machine(), np.float32))
        instantiate(giving, program)(numbers)
        assert set(numbers.array) == {np.float32(expected)}


def copy_of(function, names=None, defaults=None, closure=None):
    """The same code with other surroundings."""
    scope = {**function.__globals__, **(names or {})}
    made = FunctionType(
        function.__code__, scope, function.__name__, defaults, closure or function.__closure__
    )
    made.__qualname__, made.__module__ = function.__qualname__, function.__module__
    return kernel(made)


def digest(text, words=(), callee=lambda value: value.__name__):
    found = digests_of_text(text, callee, *words)
    return found and found[0]


def of_names(x):
    """Name one of each: a number, a tuple, a vector, a record, a kernel."""
    pair = Pair(x * SHIFT, SCALES)
    return inner(pair.a) + WHITE.x


class Opaque:
    """Something that a digest cannot be made of."""


@pytest.mark.parametrize(
    "names",
    [
        {"SHIFT": 0.25},
        {"SHIFT": np.float32(0.5)},
        {"SHIFT": -0.5},
        {"SCALES": (2.0, 3.5)},
        {"SCALES": (2.0, 3.0, 4.0)},
        {"WHITE": Vec3(1.0, 2.0, 4.0)},
        {"WHITE": (1.0, 2.0, 3.0)},
        {"Pair": namedtuple("Pair", "b a")},
        {"inner": kernel(lambda x: x)},
    ],
    ids=["value", "type", "sign", "item", "items", "vector", "class", "fields", "kernel"],
)
def test_what_a_text_names_is_in_its_digest(names):
    assert digest(copy_of(of_names, names)) != digest(copy_of(of_names)) is not None


def test_what_a_text_calls_is_in_one_of_its_digests():
    """In the other one everything else is."""
    one, alone = digests_of_text(of_names, lambda value: "inner")
    two, same = digests_of_text(of_names, lambda value: "another")
    _, other = digests_of_text(copy_of(of_names, {"SHIFT": 0.25}), lambda value: "inner")
    assert one != two
    assert alone == same != other


def test_circumstances_closures_defaults_and_code_are_in_its_digest():
    def text_of(factor, default=1.0):
        @kernel
        def text(x, y=default):
            return factor * x + y

        return text

    def other(x):
        pair = Pair(x * SHIFT, SCALES)
        return inner(pair.a) - WHITE.x

    other.__qualname__, other.__name__ = "of_names", "of_names"
    digests = [
        digest(text_of(1.0)), digest(text_of(2.0)), digest(text_of(1.0, 2.0)), digest(of_names),
        digest(of_names, [True]), digest(of_names, [False]), digest(other),
        digest(of_names, callee=lambda value: "another"),
    ]  # fmt: skip
    assert None not in digests and len(set(digests)) == len(digests)
    assert digest(text_of(1.0)) == digests[0]


OTHERWISE = {
    "Numba": ("importlib.metadata.version", lambda name: f"another {name}"),
    "Python": ("platform.python_version", lambda: "4.0"),
    "platform": ("llvmlite.binding.get_process_triple", lambda: "z80-unknown-cpm"),
    "processor": ("llvmlite.binding.get_host_cpu_name", lambda: "z80"),
    "features": ("llvmlite.binding.get_host_cpu_features", llvm.FeatureMap),
    "lanes": ("lanewise.machine._native_lanes", lambda: 4),
    "sources": ("lanewise.machine._digest_of_sources", lambda packages: "others"),
    "target": ("lanewise.machine._target", "portable"),
}


@pytest.mark.parametrize("what", OTHERWISE)
def test_functions_are_kept_for_one_compiler_and_one_kind_of_code(what, monkeypatch):
    def folder_now():
        machine._describe_compiler.cache_clear()
        machine._compiler_name.cache_clear()
        return functions_folder()

    own = folder_now()
    monkeypatch.setattr(*OTHERWISE[what])
    other = folder_now()
    monkeypatch.undo()
    assert folder_now() == own != other


def test_texts_of_which_no_digest_can_be_made_are_not_kept(folder):
    for value in (Opaque(), len.__self__.__dict__, test_damaged_files_are_compiled_again):
        assert digest(copy_of(of_names, {"SCALES": value})) is None
    assert digest(of_names, callee=lambda value: None) is None


def test_fields_of_records_are_in_the_description_of_a_type():
    from numba import typeof

    from lanewise.unlinked import description

    turned = namedtuple("Pair", "b a")
    kinds = [Pair(1, 2.0), turned(1, 2.0), (1, 2.0), Pair(1, 2), Pair((1,), 2.0), 1, np.float32(1)]
    found = [description(typeof(kind)) for kind in kinds]
    assert len(set(found)) == len(found)
