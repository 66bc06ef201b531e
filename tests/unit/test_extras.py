"""Commands that install what is missing."""

from importlib import metadata

import pytest

from alight.core import extras

REQUIRED = ["numpy>=2", 'one>=1; extra == "lab"', "two>=1; extra == 'lab'"]


def test_from_a_checkout_the_command_names_its_folder(tmp_path, monkeypatch):
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.setattr(extras, "_ABOVE", tmp_path)
    assert extras.install_command("lab") == f'pip install "{tmp_path}[lab]"'


@pytest.mark.parametrize(
    ("extra", "command"), [("lab", "pip install one two"), ("usd", "pip install usd-core")]
)
def test_elsewhere_it_names_the_packages(tmp_path, monkeypatch, extra, command):
    """No index has alight itself."""
    monkeypatch.setattr(extras, "_ABOVE", tmp_path)
    monkeypatch.setattr(metadata, "requires", lambda name: REQUIRED)
    assert extras.install_command(extra, "usd-core") == command
    assert extras.requirements() == [("numpy", ""), ("one", "lab"), ("two", "lab")]


def test_what_is_not_installed_requires_nothing(monkeypatch):
    def unknown(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "requires", unknown)
    assert extras.requirements() == []
