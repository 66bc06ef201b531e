"""One file and one line: the models of extending.md, put into their registries, render."""

import subprocess
import sys

import pytest

from tests.docs.pages import ROOT, blocks

FAMILY_OF = {
    "minnaert": "bsdfs",
    "downlight": "lights",
    "kronecker": "samplers",
    "headlight": "integrators",
    "exponential": "tone_curves",
    "log_error": "metrics",
}

# What the lines of the registries would do: each module joins the tuple before it is used.
PLUG_IN = """
import importlib.util, sys
for name, family in {family_of!r}.items():
    spec = importlib.util.spec_from_file_location(f"alight.{{family}}.{{name}}", f"{{name}}.py")
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    package = importlib.import_module(f"alight.{{family}}")
    spec.loader.exec_module(module)
    package.MODELS += (module,)
import alight
from alight.formats import loads
"""

SCENE = """
alight: 1
camera: {type: pinhole, fov: 60, transform: {look_at: {origin: [0, 1, 4], target: [0, 1, 0]}}}
film: {size: [16, 16]}
sampler: kronecker
integrator: {type: %s}
nodes:
  lamp: {light: {type: downlight, intensity: 20}, transform: {translate: [0, 4, 0]}}
  ball: {shape: {type: sphere, center: [0, 1, 0]}, bsdf: {type: minnaert, exponent: 2}}
"""

RENDER = """
for scene in {scenes!r}:
    image = alight.render(loads(scene), spp=4, threads=1).image
    ball, corner = image[:, 8], image[0, 0]
    print(ball.max() > 0.01, corner.max() == 0.0)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files that a reader of extending.md would have written."""
    path = tmp_path_factory.mktemp("models")
    page = ROOT / "docs" / "extending.md"
    for name in FAMILY_OF:
        [text] = [text for text in blocks(page, "python") if f'type: Literal["{name}"]' in text]
        (path / f"{name}.py").write_text(text, encoding="utf-8")
    return path


def test_new_models_are_one_file_and_one_line(folder, monkeypatch):
    # The usual cache folder is named by the sources of the package, which these are not.
    monkeypatch.setenv("ALIGHT_CACHE", str(folder / "cache"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    scenes = [SCENE % integrator for integrator in ("path", "headlight")]
    code = PLUG_IN.format(family_of=FAMILY_OF) + RENDER.format(scenes=scenes)
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["True"] * 4
