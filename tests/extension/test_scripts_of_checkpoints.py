"""Scripts that a checkpoint names are asked for, and never run by themselves."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import FilmError
from alight.core.registration import unregister
from alight.core.registry import REGISTERED
from alight.outputs.display import Display
from alight.rendering.writing import Targets
from tests.extension.models import LAMBERT, SCENE


@pytest.fixture(autouse=True)
def forget():
    """No test's model reaches another one."""
    yield
    if "lambert" in REGISTERED["bsdfs"]:
        unregister("bsdfs", "lambert")


def invoke(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_checkpoint_runs_no_scripts_but_those_that_are_asked_for(tmp_path):
    """Neither in Python nor on the command line; its message says which ones it needs."""
    script, scene, film = (tmp_path / name for name in ("my_model.py", "scene.yaml", "a.alight"))
    ran = tmp_path / "ran"
    mark = f"import pathlib\npathlib.Path({str(ran)!r}).touch()\n"
    script.write_text(f"{LAMBERT}\nimport alight\nalight.register(__name__)\n{mark}")
    scene.write_text(SCENE % "lambert")
    first = alight.render(scene, spp=1, checkpoint=film, plugins=script)
    unregister("bsdfs", "lambert")
    ran.unlink()
    asked = f"a checkpoint runs no scripts; it was rendered with --plugin {script}"
    done = invoke("resume", film, "--spp", 2)
    assert done.exit_code == 2 and asked in done.output
    with pytest.raises(FilmError, match='unknown bsdf "lambert"') as caught:
        alight.resume(film, spp=2)
    assert asked in str(caught.value)
    assert not ran.exists()
    again = alight.resume(film, spp=2, plugins=script)
    assert ran.exists() and again.spp == 2 == 2 * first.spp


def test_the_printed_command_asks_for_the_scripts():
    """What an interrupted render says can be copied and goes on."""
    targets = Targets([], Display(), checkpoint=Path("a.alight"), plugins=[Path("my model.py")])
    assert targets.resuming() == "alight resume a.alight --plugin 'my model.py'"
    assert Targets.noted(targets.notes()).plugins == [Path("my model.py").absolute()]
