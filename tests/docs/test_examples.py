"""The scripts of examples/ run, write what they say, and are listed on the page about them."""

import ast
import re
import runpy
import subprocess
import sys

import pytest

from tests.docs.pages import ROOT

FOLDER = ROOT / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))

#: Script -> files that it writes, and a pattern of what it prints.
HERE = {
    "animation": ("throw_0000.png throw_0007.png throw.gif", r"throw\.gif"),
    "compare_pictures": ("", r"same scene: same within noise\ndarker walls: different\n"),
    "mesh_figure": ("figure.png", r"4\d% of it is torus"),
    "product_shot": ("vase.gltf vase.png", r"error \d\.\d%"),
    "promised_error": ("promised.png", r"^met: .*\n(.*\n)*bias: paths end at depth 8"),
    "resume_and_merge": ("box.alight half.alight", r"resumed.*: True\nmerged.*: True\n"),
    "trace_a_pixel": ("", r"mirror-ball mirror(.*\n)*\nbrightest of four: sample \d, \d vertices"),
    "turntable": ("turntable.gif", r"turntable\.gif"),
    "two_arms": ("arms/report.html", r"light and BSDF sampling +[\d.]+ \[.*unbiased"),
}

#: Those that register models or start processes, which is better done elsewhere.
APART = {
    "on_a_cluster": ("", r"the same bits: True\n"),
    "own_bsdf": ("moon.png", r"2\d\d checks, 0 failures\n(.*\n)*.*the rim has 100%"),
    "own_integrator": ("normals.png", r"the back wall is \[0\.5 0\.5 1\. *\]"),
}


def _has(found, folder, files, pattern):
    assert re.search(pattern, found), found
    assert all((folder / name).stat().st_size > 0 for name in files.split())


@pytest.mark.parametrize("name", HERE)
def test_script_runs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(FOLDER))
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    _has(capsys.readouterr().out, tmp_path, *HERE[name])


@pytest.mark.parametrize(
    "name", [pytest.param("on_a_cluster", marks=pytest.mark.proofs), "own_bsdf", "own_integrator"]
)
def test_script_runs_in_a_process_of_its_own(name, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    command = [sys.executable, str(FOLDER / f"{name}.py")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    _has(done.stdout, tmp_path, *APART[name])


def test_every_script_is_run_and_listed_with_what_it_says_of_itself():
    assert {path.stem for path in SCRIPTS} == {*HERE, *APART}
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    listed = dict(re.findall(r"^\* `(\w+)\.py`: (.+)$", page, re.MULTILINE))
    said = {}
    for path in SCRIPTS:
        told = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
        said[path.stem] = told.split("\n\n")[0].replace("\n", " ")
    assert listed == said
