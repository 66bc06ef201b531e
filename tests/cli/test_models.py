"""``alight models``: every key of scene files, as the code checks them."""

import re

import pytest
import yaml
from typer.testing import CliRunner

from alight.cli.main import app
from alight.core.errors import OptionError, SceneError
from alight.core.registration import unregister
from alight.core.registry import FAMILIES_OF_SCENES, specs
from alight.scene.keys import find, keys_of, known_models
from tests.extension.models import LAMBERT


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


MODELS = [
    pytest.param(model, id=f"{family}-{name}")
    for family, known in known_models().items()
    for name, model in known.items()
]


@pytest.mark.parametrize("model", MODELS)
def test_every_key_says_what_it_takes_and_is(model):
    for key in keys_of(model):
        assert len(key.text) > 3, f"{key.name} of {model.type_name()} is not explained"
        assert key.takes
        assert "Undefined" not in key.default


@pytest.mark.parametrize("model", MODELS)
def test_ranges_are_those_that_are_checked(model):
    """A number beyond a bound that is told is refused, in the words that are told."""
    for key in keys_of(model):
        found = re.match(r"number in \[(\S+), (\S+)\]", key.takes)
        if found:
            with pytest.raises(SceneError) as raised:
                model(**{key.name: 1.01 * float(found[2]) + 0.01})
            assert f"must be in [{found[1]}, {found[2]}]" in str(raised.value)


def test_all_models_are_listed():
    lines = run("models").stdout.splitlines()
    named = {line.split()[0] for line in lines if line.startswith("  ")}
    assert {name for family in FAMILIES_OF_SCENES for name in specs(family)} < named


def test_one_family_and_one_model():
    family = run("models", "filters").stdout
    assert family.startswith("filters:\n") and "gaussian" in family and "sphere" not in family
    shown = run("models", "rough_conductor").stdout
    assert "alpha: number in [0.0001, 1] or texture" in shown
    assert "METALS: " in shown and "gold" in shown
    assert len(find("constant")) == 2
    assert run("models", "constant").stdout.count("constant (") == 2


def test_what_must_be_given_is_said():
    required = [k.name for _, model in find("ies") for k in keys_of(model) if k.required]
    shown = run("models", "ies").stdout
    assert required == re.findall(r"^  (\w+): .*, required$", shown, re.MULTILINE)


def test_names_that_are_none_have_the_nearest():
    with pytest.raises(OptionError, match='did you mean "rough_conductor"'):
        find("rogh_conductor")
    result = run("models", "rogh_conductor")
    assert result.exit_code == 2 and 'did you mean "rough_conductor"' in result.stderr


def test_models_of_a_plugin(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(f"{LAMBERT}\nimport alight\nalight.register(__name__)\n")
    try:
        shown = run("models", "lambert", "--plugin", script)
        assert shown.exit_code == 0 and shown.stdout.startswith("lambert (bsdfs): ")
    finally:
        unregister("bsdfs", "lambert")
    missing = run("models", "--plugin", tmp_path / "none.py")
    assert missing.exit_code == 2 and "there is no file" in missing.stderr


@pytest.mark.parametrize("model", MODELS)
def test_defaults_can_be_copied_into_a_file(model):
    """As YAML they are the values that the code has, or a description of the same."""
    for key in keys_of(model):
        default = model.model_fields[key.name].default
        if isinstance(default, bool | int | str):
            assert yaml.safe_load(key.default) == default
        elif isinstance(default, tuple) and all(isinstance(item, int | float) for item in default):
            read = yaml.safe_load(key.default)
            if not isinstance(read, list):
                assert key.takes.startswith("number or ")
                read = [read] * len(default)
            assert tuple(read) == default
