"""A model file that is not in its registry would be untested; so there is none."""

from importlib import import_module

import pytest

from tests.static.sources import FAMILIES, PACKAGE, assigned_names


def _model_files(family):
    """Files that hold a model: those that give EXAMPLES of it."""
    files = sorted((PACKAGE / family).glob("*.py"))
    return {path.stem for path in files if "EXAMPLES" in assigned_names(path)}


@pytest.mark.parametrize("family", FAMILIES)
def test_every_model_file_is_registered(family):
    models = import_module(f"alight.{family}").MODELS
    assert isinstance(models, tuple)
    assert {module.__name__.rpartition(".")[2] for module in models} == _model_files(family)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_model_has_examples_of_one_description(family):
    for module in import_module(f"alight.{family}").MODELS:
        classes = {type(example) for example in module.EXAMPLES}
        assert len(classes) == 1, module.__name__
        assert len(module.EXAMPLES) <= 6, module.__name__


@pytest.mark.parametrize("family", FAMILIES)
def test_models_of_a_family_have_different_names(family):
    names = [type(m.EXAMPLES[0]).type_name() for m in import_module(f"alight.{family}").MODELS]
    assert len(names) == len(set(names))
