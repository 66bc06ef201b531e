"""Which tests concern a file of the package, the most telling first.

First those that import the file itself or have the name of its folder, then the folders of tests
that stand for its part of the package, the cheapest first: closed-form values and the NumPy twin
before whole pictures.
"""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

#: Part of the package: folders of tests.
FOLDERS = {
    "accel": "accel shapes motion scene images",
    "bsdfs": "unit sampling physics edges laws estimators extension rendering fuzz images",
    "cameras": "cameras laws unit motion rendering images",
    "compiled": "compiled scene lights motion shapes estimators",
    "core": "unit lanewise core sampling shapes samplers lights textures media physics motion "
    "accel images",
    "films": "film metrics known_error rendering outputs",
    "filters": "filters laws cameras film images",
    "formats": "formats meshes scene shapes textures",
    "guiding": "guiding estimators rendering media images",
    "integrators": "estimators media rendering lights physics edges motion laws fuzz images",
    "lab": "lab metrics",
    "laws": "laws extension sampling physics edges lights samplers textures media",
    "lights": "lights edges laws media motion rendering scene fuzz images",
    "media": "media laws estimators edges motion fuzz images",
    "meshes": "meshes formats scene shapes",
    "metrics": "metrics known_error lab",
    "options": "options scene rendering known_error",
    "outputs": "outputs film textures rendering view lab",
    "phases": "media laws sampling edges extension images",
    "rendering": "known_error film rendering metrics lab",
    "samplers": "samplers core estimators rendering images",
    "scene": "scene motion shapes formats media physics lights",
    "shapes": "shapes laws unit accel sampling lights edges motion images",
    "textures": "textures laws edges physics sampling images",
    "tone_curves": "outputs film view",
    "view": "view outputs rendering",
}

#: Answers are recorded of every part.
RECORDED = "recorded"

#: Tests of the project rather than of its numbers, and those that need the files as they are.
ELSEWHERE = {"cli", "determinism", "docs", "mutants", "static"}


def select_tests(root: Path, file: str) -> tuple[list[str], list[str]]:
    """Test files that import a file of the package, and the others that concern it."""
    module = "alight." + file.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    files = _test_files(root)
    # Readers of one format have a folder of tests, which call them by the names of files.
    own = root / "tests" / Path(file).parent if file.count("/") > 1 else None
    near = {path for path in files if module in _imports(root, path) or path.parent == own}
    folders = [RECORDED, *FOLDERS[file.partition("/")[0]].split()]
    telling = sorted(near, key=lambda path: (_place(files[path], folders), path))
    far = [
        path
        for folder in folders
        for path, its_folder in files.items()
        if its_folder == folder and path not in near
    ]
    return [str(p.relative_to(root)) for p in telling], [str(p.relative_to(root)) for p in far]


@cache
def _test_files(root: Path) -> dict[Path, str]:
    """Tests of the package's numbers in the order of their names, with the folder of each."""
    tests = root / "tests"
    paths = {path: path.relative_to(tests).parts[0] for path in sorted(tests.rglob("test_*.py"))}
    return {path: folder for path, folder in paths.items() if folder not in ELSEWHERE}


def _place(folder: str, folders: list[str]) -> int:
    return folders.index(folder) if folder in folders else len(folders)


@cache
def _imports(root: Path, path: Path) -> frozenset[str]:
    """Modules of the package that a test names, also through what it shares with other tests."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            if name.startswith("alight."):
                found.add(name)
            elif name.startswith("tests."):
                shared = root / (name.replace(".", "/") + ".py")
                if shared.is_file() and shared != path:
                    found |= _imports(root, shared)
    return frozenset(found)


@cache
def models_of(root: Path, file: str) -> frozenset[str]:
    """First words of the names of a file and of those in its folder that build on it."""
    folder = root / "alight" / Path(file).parent
    names = {path: _imports(root, path) for path in folder.glob("*.py")}
    found = {root / "alight" / file}
    while True:
        modules = {".".join(path.relative_to(root).with_suffix("").parts) for path in found}
        wider = found | {path for path, imported in names.items() if imported & modules}
        if wider == found:
            # Tables of all models build on everything.
            stems = {path.stem for path in found} - {"__init__", "dispatch", "switch"}
            return frozenset(stem.partition("_")[0] for stem in stems)
        found = wider
