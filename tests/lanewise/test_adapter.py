"""What is private to Numba stands in one file, says what is assumed of it, and can be tried."""

import ast
import inspect

import llvmlite.binding as llvm
import numba.core.base
import numba.core.codegen
import numba.core.errors
import numba.core.ir
import pytest

from lanewise import (
    canary,
    canary_checks,
    canary_instructions,
    dispatchers,
    numba_adapter,
    numba_shortcuts,
    remembered_answers,
)
from tests.static.sources import COMPILER, place, tree

OTHERS = [path for path in sorted(COMPILER.rglob("*.py")) if path not in canary.ADAPTERS]
#: What Numba and llvmlite document, and other packages may use.
PUBLIC = {"numba", "numba.extending", "llvmlite", "llvmlite.binding"}


def imported(path):
    """(module, line) of the imports of a file, wherever they stand."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom):
            yield node.module, node.lineno
        elif isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)


def test_no_other_file_imports_from_the_inside_of_numba():
    inside = [
        f"{place(path, line)} {module}"
        for path in OTHERS
        for module, line in imported(path)
        if module.split(".")[0] in ("numba", "llvmlite") and module not in PUBLIC
    ]
    assert not inside


def test_no_other_file_touches_what_is_marked_private():
    """Attributes with an underscore, but for an object's own and those of named tuples."""
    touched = [
        f"{place(path, node.lineno)} {ast.unparse(node)}"
        for path in OTHERS
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Attribute)
        and node.attr.startswith("_")
        and not node.attr.startswith("__")
        and node.attr not in ("_replace", "_fields", "_asdict", "_make")
        and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls"))
    ]
    assert not touched


def used_of_objects(path):
    """What a file uses of the contexts that Numba hands to it, and of typed pointers."""
    owners = {
        "context": "numba.core.base.BaseContext",
        "c.context": "numba.core.base.BaseContext",
        "c.pyapi": "numba.core.pythonapi.PythonAPI",
    }
    pointers = {"as_pointer": "llvmlite.ir.Type", "pointee": "llvmlite.ir.PointerType"}
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute):
            owner = pointers.get(node.attr) or owners.get(ast.unparse(node.value))
            if owner:
                yield owner, node.attr


def test_what_is_used_of_numbas_objects_is_listed():
    used = {found for path in OTHERS for found in used_of_objects(path)}
    assert used == set(numba_adapter.METHODS)


def test_every_private_name_says_what_is_assumed():
    names = canary.private_names()
    assert len(names) > 15
    silent = [name for (_, name), assumed in names.items() if len(assumed) < 10]
    assert not silent


def test_every_part_of_the_adapter_can_be_tried():
    parts = {
        name
        for module in (numba_adapter, numba_shortcuts, dispatchers, remembered_answers)
        for name, part in vars(module).items()
        if getattr(part, "__module__", "") == module.__name__
        and (inspect.isclass(part) or inspect.isfunction(part))
    }
    assert parts == set(canary.CHECKS) - {"instructions"}
    assert all(check.__doc__ for check in canary.CHECKS.values())


def test_all_assumptions_hold(capsys):
    assert canary.main() == 0, capsys.readouterr().out
    said = capsys.readouterr().out
    assert " 0 broken" in said and "numba.core.codegen.JITCodeLibrary" in said


def test_a_name_that_is_gone_is_told(monkeypatch, capsys):
    monkeypatch.delattr(numba.core.codegen, "JITCodeLibrary")
    assert canary.main() == 1
    said = capsys.readouterr().out
    assert "BROKEN  numba.core.codegen.JITCodeLibrary" in said
    assert "numba.core.codegen has no JITCodeLibrary" in said
    assert "the parts of the adapter were not tried" in said
    assert said.endswith(" 1 broken\n")


def test_a_method_that_is_gone_is_told(monkeypatch):
    monkeypatch.delattr(numba.core.base.BaseContext, "get_dummy_value")
    [row] = [row for row in canary.try_methods() if row.broken]
    assert row.broken == "numba.core.base.BaseContext has no get_dummy_value"


def test_a_step_that_does_nothing_is_told(monkeypatch):
    monkeypatch.setattr(numba_adapter.Float32Constants, "run_pass", lambda self, state: False)
    with pytest.raises(AssertionError, match="float64"):
        canary.CHECKS["Float32Constants"]()


def complaint_of(check, *arguments):
    """What a check says is wrong, "" if it finds nothing."""
    try:
        check(*arguments)
    except AssertionError as error:
        return str(error)
    return ""


def test_instructions_that_do_nothing_are_told(monkeypatch):
    """Each of them is tried, and no comparison is left out."""
    tried, try_one = [], canary_instructions.try_elementwise
    monkeypatch.setattr(canary_instructions, "try_elementwise", lambda *what: tried.append(what))
    canary.CHECKS["instructions"]()
    elementwise = canary_instructions.ELEMENTWISE.items()
    assert tried == [(function, count) for count, some in elementwise for function in some]
    for checks in (canary_checks, canary_instructions):
        monkeypatch.setattr(checks, "instantiate", lambda text: lambda *arguments: None)
    for name in ("instructions", "object_code"):
        assert complaint_of(canary.CHECKS[name]), f"{name} compares nothing"
    for function, count in tried:
        assert function.__name__ in complaint_of(try_one, function, count)


def test_numba_is_told_of_locks_again_when_a_kernel_fails():
    told = llvm.ffi.lib._lock._cblist
    assert told, "nobody was told in the first place"
    with pytest.raises(ZeroDivisionError), numba_shortcuts.untold_of_locks():
        assert not llvm.ffi.lib._lock._cblist
        raise ZeroDivisionError
    assert llvm.ffi.lib._lock._cblist is told


def test_numba_is_as_before_when_a_kernel_fails():
    places = (
        (numba.core.errors, "_termcolor_inst"),
        (numba.core.ir.Inst, "_rec_list_vars"),
        (numba.core.base, "_has_loc"),
    )
    before = [getattr(*place) for place in places]
    with pytest.raises(ZeroDivisionError), numba_shortcuts.shortcuts():
        assert all(getattr(*place) is not now for place, now in zip(places, before, strict=True))
        raise ZeroDivisionError
    assert [getattr(*place) for place in places] == before
