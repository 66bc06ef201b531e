"""What `import alight` offers: every name is there, and comes when it is asked for."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import alight
from alight.core import errors

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", alight.__all__)
def test_every_public_name_is_there(name):
    assert name in dir(alight)
    assert getattr(alight, name) is not None


def test_all_errors_that_a_user_can_mend_are_public():
    family = [errors.AlightError, *errors.AlightError.__subclasses__()]
    public = {e.__name__ for e in family if e.__module__ == "alight.core.errors"}
    assert public == {name for name in alight.__all__ if name.endswith("Error")}
    for name in public:
        assert getattr(alight, name) is getattr(errors, name)


def test_errors_are_light():
    """To catch one costs no compiler, and `import alight` not even the module."""
    heavy = "set(sys.modules) & {'numba', 'pydantic', 'numpy'}"
    code = f"import alight, sys; print({heavy}); alight.AlightError; print({heavy})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["set()", "set()"]


def test_the_example_of_the_readme_catches_what_is_wrong(tmp_path, monkeypatch, capsys):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (code,) = (b for b in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "except" in b)
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text("alight: 1\ncamera: {type: pinhol}\n")
    exec(compile(code, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert said.startswith("scene.yaml:2:16 camera.type unknown camera")
    assert 'did you mean "pinhole"?' in said
