"""What has many parts is a record with names: few parameters, few fields by position."""

import ast

from tests.static.sources import COMPILER, PACKAGE, package_files, tree

MOST_PARAMETERS = 7
MOST_POSITIONAL = 6
#: Folders of models whose kernels read rows of a table.
OF_TABLES = ("bsdfs", "textures")


def _is_kernel(function):
    """Whether it is kernel text."""
    marks = [mark.func if isinstance(mark, ast.Call) else mark for mark in function.decorator_list]
    return any(isinstance(mark, ast.Name) and mark.id == "kernel" for mark in marks)


def _is_record(node):
    """Whether a statement defines a named tuple."""
    if isinstance(node, ast.ClassDef):
        return any(isinstance(base, ast.Name) and base.id == "NamedTuple" for base in node.bases)
    call = node.value if isinstance(node, ast.Assign) else None
    return isinstance(call, ast.Call) and getattr(call.func, "id", "") == "namedtuple"


def _records():
    """Names of all named tuples of both packages."""
    found = set()
    for path in package_files():
        for node in filter(_is_record, tree(path).body):
            found.add(node.name if isinstance(node, ast.ClassDef) else node.targets[0].id)
    return found


def long_lists(module, records):
    """Kernels and records of a syntax tree that need too many things in the right order."""
    kernels = {
        node.name
        for node in ast.walk(module)
        if isinstance(node, ast.FunctionDef)
        and _is_kernel(node)
        and len(node.args.args) > MOST_PARAMETERS
    }
    return kernels | {
        node.func.id
        for node in ast.walk(module)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in records
        and len(node.args) > MOST_POSITIONAL
    }


def test_kernels_have_few_parameters_and_records_few_positions():
    records = _records()
    found = {
        path.relative_to(PACKAGE).as_posix(): names
        for path in package_files()
        if not path.is_relative_to(COMPILER) and (names := long_lists(tree(path), records))
    }
    assert not found


def numbered_slots(module):
    """Lines on which a kernel names a slot of a row by its number."""
    return [
        node.lineno
        for node in ast.walk(module)
        if isinstance(node, ast.BinOp)
        and isinstance(node.op, ast.Add)
        and getattr(node.left, "id", "") == "base"
        and isinstance(node.right, ast.Constant)
        and isinstance(node.right.value, int)
    ]


def test_slots_of_models_have_names():
    paths = [path for folder in OF_TABLES for path in (PACKAGE / folder).rglob("*.py")]
    assert not {path.name: lines for path in paths if (lines := numbered_slots(tree(path)))}


def test_long_lists_and_numbered_slots_are_found():
    text = """
Path = namedtuple("Path", "a b c d e f g")

@kernel(strict=True)
def many(a, b, c, d, e, f, g, h):
    return gather(a, base + 5), Path(a, b, c, d, e, f, g), Path(a, b, c, d, e, f, g=g)

def plain(a, b, c, d, e, f, g, h):
    return Path(*a)
"""
    module = ast.parse(text)
    assert long_lists(module, {"Path"}) == {"many", "Path"}
    assert long_lists(module, {"Walk"}) == {"many"}
    assert numbered_slots(module) == [6]
    assert any(map(_is_record, module.body))
