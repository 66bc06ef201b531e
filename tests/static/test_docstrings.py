"""Every module says what it is for, and public functions and classes say what they do."""

import ast

from tests.static.sources import Function, package_files, place, tree

WANTED = 0.95


def _public(path):
    """Public functions and classes of a file, and public methods of those classes."""
    found = []
    for node in tree(path).body:
        if not isinstance(node, Function | ast.ClassDef) or node.name.startswith("_"):
            continue
        found.append(node)
        if isinstance(node, ast.ClassDef):
            found += [
                item
                for item in node.body
                if isinstance(item, Function) and not item.name.startswith("_")
            ]
    return found


def test_every_module_has_a_docstring():
    silent = [place(path) for path in package_files() if not ast.get_docstring(tree(path))]
    assert not silent


def test_public_functions_and_classes_have_docstrings():
    nodes = [(path, node) for path in package_files() for node in _public(path)]
    silent = [
        f"{place(path, node.lineno)} {node.name}"
        for path, node in nodes
        if not ast.get_docstring(node)
    ]
    assert len(silent) <= (1 - WANTED) * len(nodes), silent
