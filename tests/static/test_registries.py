"""A model file that is not in its registry would be untested; so there is none."""

from dataclasses import MISSING, fields
from importlib import import_module

import pytest

from alight.core.model_form import FORMS
from alight.core.registry import Record
from tests.static.sources import FAMILIES, PACKAGE, assigned_names


def _model_files(family):
    """Files that hold a model: those that give EXAMPLES of it."""
    files = sorted((PACKAGE / family).rglob("*.py"))
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


def _record(family):
    """The class of a family's ``model.py``, if it has one."""
    path = PACKAGE / family / "model.py"
    if not path.is_file():
        return None
    found = vars(import_module(f"alight.{family}.model")).values()
    return next(c for c in found if isinstance(c, type) and issubclass(c, Record) and c != Record)


#: Required too, and checked by themselves.
BY_THEMSELVES = {"samplers": {"make_kernels"}, "integrators": {"step"}}


@pytest.mark.parametrize("family", FAMILIES)
def test_what_registering_asks_for_is_what_the_record_takes(family):
    record = _record(family)
    if record is None:
        return
    asked = {*FORMS[family].names, *BY_THEMSELVES.get(family, ())}
    own = [field for field in fields(record) if field.name not in ("name", "number", "EXAMPLES")]
    assert asked <= {field.name for field in own}
    needed = {f.name for f in own if f.default is MISSING and f.default_factory is MISSING}
    assert needed <= asked
