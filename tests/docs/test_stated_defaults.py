"""What a model's docstring says of its defaults is what they are: each stands in two places."""

import inspect
import re
from fractions import Fraction

import pytest

from alight.core.registry import specs_of
from alight.core.spec import Bsdf, Camera, Filter, Light, Sampler, Shape, Texture, ToneCurve

MODELS = {
    f"{family.__name__}-{name}": spec
    for family in (Bsdf, Camera, Filter, Light, Sampler, Shape, Texture, ToneCurve)
    for name, model in specs_of(family).items()
    if (spec := getattr(model, "spec", model)).__doc__
}
#: Words for numbers.
NAMED = {"air": 1.000277}
#: ``fov, width : float, degrees, defaults 45 and 2``.
STATED = re.compile(r"^(\w+(?:, \w+)*) : .*?\bdefaults? (.+)$", re.MULTILINE)


def stated(spec):
    """Name of a field, and the number or the word that it is said to be by default."""
    for names, said in STATED.findall(inspect.cleandoc(spec.__doc__)):
        fields = names.split(", ")
        values = said.split(" and ") if " and " in said else [said] * len(fields)
        for name, value in zip(fields, values, strict=True):
            if re.fullmatch(r"-?[\d.]+(e-?\d+)?|\d/\d", value):
                yield name, float(Fraction(value))
            elif re.fullmatch(r'"\w+"', value):
                yield name, value.strip('"')


@pytest.mark.parametrize("name", MODELS)
def test_defaults_are_as_stated(name):
    for field, value in stated(MODELS[name]):
        default = MODELS[name].model_fields[field].get_default()
        # Of a colour, or of a size along three axes, one number says all.
        every = default if isinstance(default, tuple) else (default,)
        wanted = NAMED.get(value, value) if isinstance(value, str) else value
        assert {*every} == {wanted}, field


def test_most_defaults_are_stated():
    assert sum(len([*stated(spec)]) for spec in MODELS.values()) > 140
