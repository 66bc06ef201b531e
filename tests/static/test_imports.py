"""Imports run one way, make no cycles, and leave heavy packages for later."""

import graphlib
import subprocess
import sys

import grimp
import pytest
from importlinter.cli import lint_imports

from tests.static.sources import PACKAGE, ROOT

HEAVY = ("numba", "llvmlite", "trimesh", "OpenEXR", "PIL", "matplotlib", "scipy")


def test_the_contracts_of_pyproject_are_kept(capsys):
    status = lint_imports(config_filename=str(ROOT / "pyproject.toml"), cache_dir=None)
    assert status == 0, capsys.readouterr().out


def test_every_folder_of_the_package_has_its_layer():
    contract = (ROOT / "pyproject.toml").read_text(encoding="utf-8").split("[tool.importlinter]")[1]
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    missing = {name for name in folders if f"alight.{name}" not in contract}
    assert not missing, f"folders without a layer in pyproject.toml: {sorted(missing)}"


def test_no_import_cycles():
    graph = grimp.build_graph(
        "alight", "lanewise", exclude_type_checking_imports=True, cache_dir=None
    )
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    try:
        graphlib.TopologicalSorter(imports).prepare()
    except graphlib.CycleError as error:
        pytest.fail("import cycle: " + " -> ".join(error.args[1]))


LIGHT = {
    "import": "import alight",
    "load": "import alight; alight.load('cornell-box')",
    "help": "import alight.cli.main",
}


@pytest.mark.parametrize("code", LIGHT.values(), ids=LIGHT.keys())
def test_light_commands_leave_heavy_packages_alone(code):
    probe = f"{code}\nimport sys\nprint(*sorted(set(sys.modules) & set({HEAVY!r})))"
    done = subprocess.run(
        [sys.executable, "-c", probe], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == ""


def test_readers_of_other_programs_are_imported_with_their_first_file():
    folders = ("gltf", "materialx", "mitsuba", "obj", "pbrt", "usd")
    code = "import alight.rendering, alight.formats, sys; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert not set(done.stdout.split()) & {f"alight.formats.{folder}" for folder in folders}
