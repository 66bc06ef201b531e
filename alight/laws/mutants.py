"""Classical bugs of path tracers, to be planted in a copy of alight that `check` then tests.

A bug is a change of text in one or more files of the package. It is planted in a copy in a folder
of its own, which another process imports with a kernel cache of its own: this process and its
machine code never know of it. Both have the functions that the bug does not touch, which are kept
by their text.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from alight.core.errors import AlightError, OptionError, unknown_name
from lanewise.machine import functions_folder


class Mutant(NamedTuple):
    """One bug.

    Attributes
    ----------
    words : str
        What is wrong.
    edits : tuple of (str, str, str)
        File inside the package, text that occurs exactly once there, what takes its place.
    shows : str
        In which scenes it makes a difference.
    """

    words: str
    edits: tuple[tuple[str, str, str], ...]
    shows: str


_PATH = "integrators/path.py"
_DIRECT_LIGHT = "integrators/direct_light.py"
_WEIGHTS = "integrators/mis_weights.py"
_NO_COSINE = """f_cos, pdf = evaluate_bsdf(scene, surface, wo, wi, lit)
            f_cos = f_cos * (1.0 / where(wi.z > 0.0, wi.z, 1e-6 - wi.z))"""
_PER_AREA = """density = pdf_of_shape(scene, index, p, hit)
        density = density * where(hit.cosine > 0.0, hit.cosine, 0.0) / (distance * distance)"""

MUTANTS = {
    "dropped-cosine": Mutant(
        "light sampling forgets the cosine at the lit surface",
        (
            (
                _DIRECT_LIGHT,
                "f_cos, pdf = evaluate_bsdf(scene, surface, wo, wi, lit)",
                _NO_COSINE,
            ),
            (
                _DIRECT_LIGHT,
                "from lanewise.simd import any_lane, lanes, lanes_u32\n",
                "from lanewise.simd import any_lane, lanes, lanes_u32, where\n",
            ),
        ),
        "with lights that light sampling finds",
    ),
    "pdf-per-area": Mutant(
        "where a ray hits a lamp, its density is taken per area for per solid angle",
        (
            (
                "lights/hits.py",
                "density = pdf_of_shape(scene, index, p, hit)",
                _PER_AREA,
            ),
        ),
        "with area lights",
    ),
    "u-for-root-u": Mutant(
        "points of the disk have the radius u for sqrt(u), so directions crowd at the normal",
        (
            (
                "core/warps.py",
                "x, y = square_to_disk_concentric(u2)",
                "s, c = sincos_2pi(u2[1])\n    x, y = u2[0] * c, u2[0] * s",
            ),
        ),
        "with matte or plastic materials",
    ),
    "mis-on-one-side": Mutant(
        "light sampling counts in full, and BSDF sampling by its weight on top",
        ((_WEIGHTS, "where(light.delta, 1.0, heuristic(light.pdf, bsdf_pdf))", "lanes(1.0)"),),
        "with lights that have a size",
    ),
    "no-survival": Mutant(
        "survivors of Russian roulette do not carry the light of the others",
        (("integrators/roulette.py", "beta / survival", "beta"),),
        "with paths of three edges and more",
    ),
    "eta-for-eta2": Mutant(
        "radiance behind a refracting surface falls by 1 / eta for 1 / eta^2",
        (
            (
                "bsdfs/dielectrics/dielectric.py",
                "where(reflects, 1.0, 1.0 / (eta * eta))",
                "where(reflects, 1.0, 1.0 / eta)",
            ),
        ),
        "with materials of type dielectric",
    ),
    "reused-dimension": Mutant(
        "every vertex of a path uses the same random numbers",
        (
            (
                "integrators/walk.py",
                "CAMERA_DIMENSIONS + (depth - 1) * VERTEX_DIMENSIONS",
                "CAMERA_DIMENSIONS + 0 * depth",
            ),
        ),
        "always",
    ),
    "depth-off-by-one": Mutant(
        "the longest path is one edge longer than max_depth",
        ((_PATH, "depth < settings.max_depth", "depth <= settings.max_depth"),),
        "always",
    ),
    "light-choice-forgotten": Mutant(
        "light sampling forgets the probability of having chosen this light",
        (("lights/sampling.py", "pdf = s.pdf * choice.mis_pmf", "pdf = s.pdf"),),
        "with two lights and more",
    ),
    "both-ways-in-full": Mutant(
        "light sampling and BSDF sampling both count in full",
        (
            (_WEIGHTS, "where(light.delta, 1.0, heuristic(light.pdf, bsdf_pdf))", "lanes(1.0)"),
            (_WEIGHTS, "where(path.delta, 1.0, heuristic(path.pdf, light_pdf))", "lanes(1.0)"),
        ),
        "with lights that have a size",
    ),
}

#: What the other process runs: the copy in the folder that is its first argument.
_RUN = """
import sys
from pathlib import Path
folder = sys.argv.pop(1)
sys.path.insert(0, folder)
import alight
if not Path(alight.__file__).is_relative_to(folder):
    sys.exit("error: another alight is imported than the copy with the planted bug")
from alight.cli.main import app
app(prog_name="alight")
"""


def find_mutant(name: str) -> Mutant:
    """The bug of a name.

    Raises
    ------
    OptionError
        If there is none, with a list of all.
    """
    if name in MUTANTS:
        return MUTANTS[name]
    problem = unknown_name("bug", name, MUTANTS) if name else "name one of these bugs"
    raise OptionError(problem + "\n" + "\n".join(mutant_lines()), "--mutant")


def mutant_lines() -> list[str]:
    """A line for each bug."""
    return [f"  {name:<24}{m.words} (shows {m.shows})" for name, m in MUTANTS.items()]


def plant(mutant: Mutant, folder: Path) -> None:
    """Copy the package into a folder and change the copy.

    Raises
    ------
    AlightError
        If the package is not made of the source files that the bug was written for.
    """
    package = Path(__file__).resolve().parents[1]
    shutil.copytree(package, folder / "alight", ignore=shutil.ignore_patterns("__pycache__"))
    for file, old, new in mutant.edits:
        path = folder / "alight" / file
        text = path.read_text("utf-8")
        if text.count(old) != 1:
            raise AlightError(f"the bug does not fit {path.name}: {old!r} must occur there once")
        path.write_text(text.replace(old, new), "utf-8")


def _share_functions(cache: Path) -> None:
    """What the bug does not touch need not be compiled again: functions are kept by their text.

    Files are linked one by one, so what the bug adds goes with its folder. They are never written
    to, but replaced.
    """
    functions = functions_folder()
    (cache / functions.name).mkdir(parents=True)
    # Without links, as between some file systems, all is compiled.
    with suppress(OSError):
        for kept in functions.iterdir():
            os.link(kept, cache / functions.name / kept.name)


def run_with(mutant: Mutant, arguments: Sequence[str]) -> int:
    """Run the command line of a copy of alight with a bug; its exit code."""
    with tempfile.TemporaryDirectory(prefix="alight-mutant-") as name:
        folder = Path(name).resolve()
        plant(mutant, folder)
        _share_functions(folder / "cache")
        environment = {
            **os.environ,
            "ALIGHT_CACHE": str(folder / "cache"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        command = [sys.executable, "-c", _RUN, str(folder), *arguments]
        return subprocess.run(command, env=environment, check=False).returncode
