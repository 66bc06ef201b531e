"""What docstrings and comments refer to exists: members of modules, pages, files, decisions."""

import re

from tests.docs.names import import_path
from tests.docs.pages import ROOT

SOURCES = [
    (path, path.read_text(encoding="utf-8"))
    for folder in ("alight", "lanewise", "benchmarks", "examples", "docs/figures", "docs/site")
    for path in sorted((ROOT / folder).rglob("*.py"))
]


def unknown(pattern, exists):
    """Places of what a pattern finds and nobody has."""
    return [
        f"{path.relative_to(ROOT)}: {found}"
        for path, text in SOURCES
        for found in sorted(set(re.findall(pattern, text)))
        if not exists(found)
    ]


def resolves(name):
    try:
        import_path(name)
    except LookupError:
        return False
    return True


def test_names_in_docstrings_resolve():
    assert unknown(r"`((?:alight|lanewise)(?:\.\w+)+)", resolves) == []


def test_files_in_docstrings_exist():
    pattern = r"\b((?:docs|tests|benchmarks|examples)/[\w/.-]+\.(?:md|py|yaml|txt))"
    assert unknown(pattern, lambda name: (ROOT / name).exists()) == []


def test_decisions_in_docstrings_exist():
    known = {int(page.name[:4]) for page in (ROOT / "docs/decisions").glob("[0-9]*.md")}
    assert unknown(r"[Dd]ecision (\d+)\b", lambda number: int(number) in known) == []
