"""The locked requirements are complete, hashed, and name no package index."""

import re
import tomllib

import pytest

from tests.static.sources import ROOT

FILES = sorted((ROOT / "requirements").glob("*.txt"))


def _pins(path):
    """Package -> its lines, continuation lines joined."""
    text = path.read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return [(re.split(r"[=\[ ]", line)[0].lower().replace("_", "-"), line) for line in lines]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_pin_is_exact_and_hashed(path):
    for name, line in _pins(path):
        assert re.match(r"\S+==\S+ ", line), name
        assert "--hash=sha256:" in line, name


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_no_index_is_named(path):
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"://|--(extra-)?index|--find-links|--trusted-host", text)


def test_every_core_dependency_is_locked():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = {re.split(r"[<>=\[]", line)[0].lower() for line in project["dependencies"]}
    assert wanted <= {name for name, _ in _pins(ROOT / "requirements" / "runtime.txt")}


@pytest.mark.parametrize("name", ["runtime", "docs", "peers"])
def test_the_sets_agree_on_one_version_of_everything(name):
    def versions(path):
        return [(package, re.split(r"[ ;]", line)[0]) for package, line in _pins(path)]

    developers = versions(ROOT / "requirements" / "dev.txt")
    known = {package for package, _ in developers}
    for package, pin in versions(ROOT / "requirements" / f"{name}.txt"):
        assert package not in known or (package, pin) in developers
