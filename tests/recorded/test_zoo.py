"""Every model of the project is in a recorded scene, with every key at another value than usual."""

from functools import cache
from importlib import import_module

import pytest

from alight.core.errors import SceneError
from alight.core.registry import FAMILIES_OF_SCENES, type_name_of
from alight.core.spec import Spec
from tests.recorded.zoo import all_scenes

MODELS = {
    (family, type_name_of(module)): type(module.EXAMPLES[0])
    for family in FAMILIES_OF_SCENES
    for module in import_module(f"alight.{family}").MODELS
}
#: Files are read by cases of their own, and a switch that must be off has one value.
LEFT_OUT = {
    *((family, name, "file") for family, name in MODELS),
    ("bsdfs", "measured", "data"),
    ("shapes", "curves", "flip_normals"),
}


def specs_in(value):
    """All descriptions in one, itself too."""
    if isinstance(value, Spec):
        yield value
        value = [field for _, field in value]
    elif isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from specs_in(item)


@cache
def usual_texts(model):
    """What each key is by default, as text."""
    try:
        usual = dict(model())
    except SceneError:
        # It cannot be without some key.
        usual = {name: field.default for name, field in model.model_fields.items()}
    return {name: str(value) for name, value in usual.items()}


@pytest.fixture(scope="module")
def changed_keys():
    """By family and name of each model that is used: keys that have another value somewhere."""
    found = {}
    for scene in all_scenes().values():
        for spec in specs_in(scene):
            if (family := getattr(type(spec), "family", None)) is None:
                continue
            usual = usual_texts(type(spec))
            keys = found.setdefault((family, type(spec).type_name()), set())
            keys |= {name for name, value in spec if str(value) not in ("None", usual.get(name))}
    return found


def test_every_model_is_in_a_scene(changed_keys):
    assert MODELS.keys() - changed_keys.keys() == set()


@pytest.mark.parametrize("model", MODELS, ids="-".join)
def test_every_key_has_another_value_than_by_default_in_a_scene(model, changed_keys):
    keys = {*MODELS[model].model_fields} - {"type"}
    keys = {key for key in keys if (*model, key) not in LEFT_OUT}
    assert keys - changed_keys[model] == set()
