"""Kernels from the disk cache: the same bits as when they were compiled, and never out of date."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import alight
from lanewise.jit import instantiate, kernel
from lanewise.kept_files import lost
from lanewise.view import View

PACKAGE = Path(alight.__file__).parent

RENDER = """
import hashlib, sys, alight
scene = alight.load("cornell-box", ["film.size=[24,16]", "integrator.type=ambient_occlusion"])
film = alight.render(scene, spp=8)
print(hashlib.sha256(film.sums.tobytes()).hexdigest(), "numba" in sys.modules)
"""


def run(script: str, folder: Path, **environment: str) -> str:
    """What a script prints that is run in `folder` (Python looks there for packages first)."""
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_cached_kernels_give_the_bits_of_compiled_ones_and_need_no_compiler(tmp_path):
    words = {"ALIGHT_CACHE": str(tmp_path), "PYTHONPATH": str(PACKAGE.parent)}
    bits, compiler = run(RENDER, tmp_path, **words).split()
    assert compiler == "True"
    assert list(tmp_path.rglob("*.kernel"))
    assert run(RENDER, tmp_path, **words).split() == [bits, "False"]


def test_the_cache_folder_changes_with_any_callee(tmp_path):
    for package in ("alight", "lanewise"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PACKAGE.parent / package, tmp_path / package, ignore=ignored)
    script = "import alight; from lanewise.machine import cache_folder; print(cache_folder())"
    folders = [run(script, tmp_path, PYTHONPATH=str(tmp_path))]
    for callee in ("alight/core/mis.py", "lanewise/instructions.py"):
        path = tmp_path / callee
        path.write_text(path.read_text() + "\n#\n")
        folders.append(run(script, tmp_path, PYTHONPATH=str(tmp_path)))
    assert len(set(folders)) == 3, folders


@kernel
def _one(out):
    out[0] = 1.0


def test_a_render_says_once_that_its_kernels_cannot_be_kept(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    lost()
    with monkeypatch.context() as context:
        # Below a file no folder can be made, by nobody.
        context.setenv("ALIGHT_CACHE", str(tmp_path / "file" / "below"))
        instantiate(_one)(View(np.zeros(1, np.float32)))
    scene = alight.load("cornell-box", ["film.size=[8,8]"])
    for _ in range(2):
        alight.render(scene, spp=1, threads=1)
    (told,) = caplog.messages
    assert told.startswith("the compiled kernels cannot be kept in ")
    assert "(Not a directory): the next render compiles them again; set ALIGHT_CACHE to" in told
