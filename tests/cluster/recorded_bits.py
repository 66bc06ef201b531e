"""Bits of portable films, recorded on one processor, for any other to be compared with.

    python -m tests.cluster.recorded_bits

renders them and writes `recorded_bits.json`. To be repeated whenever kernels, samplers or built-in
scenes are meant to have other bits than before.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from alight.films import Film

RECORD = Path(__file__).with_suffix(".json")
SCENES = "cornell-box", "rough-metals", "cloud"

#: Renders as the process's target says, and tells for which processor LLVM would compile.
SCRIPT = """
import sys
import alight
for name in sys.argv[2:]:
    film = alight.render(name, target="portable", size=(24, 16), spp=4, threads=1)
    film.save(f"{sys.argv[1]}-{name}.alight")
import llvmlite.binding as llvm
print(llvm.get_host_cpu_name())
"""


def run(folder: Path, *words: object, before: Sequence[str] = ()) -> str:
    """Run Python, or an emulator that runs Python, and return what it prints."""
    environment = {**os.environ, "PYTHONPATH": str(Path.cwd())}
    done = subprocess.run(
        [*before, sys.executable, *map(str, words)], cwd=folder, env=environment,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def compilers() -> dict[str, str]:
    """Versions of what decides the bits besides our own text."""
    return {name: version(name) for name in ("llvmlite", "numba", "numpy")}


def render(folder: Path, word: str, before: Sequence[str] = ()) -> tuple[dict[str, Film], str]:
    """Films by scene, and the processor that they were rendered on, or that was emulated."""
    told = run(folder, "-c", SCRIPT, word, *SCENES, before=before)
    films = {name: Film.load(folder / f"{word}-{name}.alight") for name in SCENES}
    return films, told.split()[-1]


def digests(films: dict[str, Film]) -> dict[str, str]:
    """SHA-256 of the sums of each film."""
    return {name: hashlib.sha256(film.sums.tobytes()).hexdigest() for name, film in films.items()}


def main() -> None:
    """Render and record."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        films, processor = render(Path(folder), "own")
    record = {"compilers": compilers(), "processor": processor, "films": digests(films)}
    RECORD.write_text(json.dumps(record, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
