"""What scene files may say: the keys of every model, their values, defaults and meaning.

All of it comes from the descriptions themselves: what checks a field knows what it takes, and the
docstrings of a class and its bases say what it is.
"""

from __future__ import annotations

import inspect
import math
import re
from types import UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

import yaml
from pydantic import AfterValidator, BeforeValidator
from pydantic_core import PydanticUndefined

from alight.core.errors import OptionError, unknown_name
from alight.core.fields import Interval, Model, Models, NumberOrTexture, Numbers
from alight.core.registry import FAMILIES_OF_SCENES, specs
from alight.core.spec import Spec, Texture
from alight.scene.description import (
    CameraField,
    FilmSettings,
    Named,
    Node,
    Scene,
    TransformField,
)
from alight.scene.transform import IDENTITY
from alight.textures.uv import UvTransform

#: What is not a model of a family, by the name under which it is listed.
PARTS: dict[str, type[Spec]] = {"scene": Scene, "node": Node, "film": FilmSettings}


class Key(NamedTuple):
    """A key of a scene file.

    Attributes
    ----------
    name : str
    takes : str
        Its values, in words.
    default : str
        As a scene file writes it; "" if the key must be given or is left out.
    text : str
        What it is, as the docstring has it.
    required : bool
        Whether it must be given.
    """

    name: str
    takes: str
    default: str
    text: str
    required: bool


def known_models() -> dict[str, dict[str, type[Spec]]]:
    """Families, with the descriptions of their models by name; first what is no model (`PARTS`)."""
    return {"parts": dict(PARTS), **{family: specs(family) for family in FAMILIES_OF_SCENES}}


def find(name: str) -> list[tuple[str, type[Spec]]]:
    """The families that have a model of a name, with its description.

    Raises
    ------
    OptionError
        If there is none.
    """
    found = [(family, known[name]) for family, known in known_models().items() if name in known]
    if not found:
        known = [
            *FAMILIES_OF_SCENES,
            *dict.fromkeys(n for each in known_models().values() for n in each),
        ]
        raise OptionError(unknown_name("model", name, known, listed_as="models"))
    return found


def keys_of(model: type[Spec]) -> tuple[Key, ...]:
    """The keys of a model but ``type``, its own after those of its bases.

    Examples
    --------
    >>> keys_of(PARTS["film"])[0].takes
    '2 whole numbers in [1, 268435456]'
    """
    texts, tables = _field_texts(model), tables_of(model)
    return tuple(
        Key(
            name,
            _takes(name, field),
            _default(field, tables),
            texts.get(name, ""),
            field.is_required(),
        )
        for name, field in model.model_fields.items()
        if name != "type"
    )


def summary_of(model: type[Spec]) -> str:
    """What a model is, in a line."""
    first, _, _ = inspect.cleandoc(model.__doc__ or "").partition("\n\n")
    return " ".join(first.split())


def _field_texts(model: type[Spec]) -> dict[str, str]:
    """What the docstrings of a class and its bases say of each field."""
    texts: dict[str, str] = {}
    for base in model.__mro__:
        _, _, section = inspect.cleandoc(base.__doc__ or "").partition("Parameters\n----------\n")
        section = re.split(r"\n\n\w+\n-+\n", section)[0]
        # Entries begin in the first column; "a, b" without a type refers to a base class.
        for head, text in re.findall(r"^(\w.*)\n((?:[ ]+.*\n?|\n)*)", section, re.MULTILINE):
            names, colon, _ = head.partition(" : ")
            for name in names.split(", ") if colon else ():
                texts.setdefault(name, " ".join(text.split()))
    return texts


def tables_of(model: type[Spec]) -> dict[str, dict[str, Any]]:
    """Tables of names that the fields of a class know: constants of its modules."""
    found: dict[str, dict[str, Any]] = {}
    for base in model.__mro__:
        module = inspect.getmodule(base)
        for name, value in vars(module).items() if module else ():
            if name.isupper() and isinstance(value, dict) and value:
                first = next(iter(value.values()))
                if isinstance(first, float) or (isinstance(first, tuple) and len(first) in (2, 6)):
                    found[name] = value
    return found


def _takes(name: str, field: Any) -> str:
    """Type and range of a field in words, from what checks it."""
    kinds, metadata = _parts(field)
    named = any(isinstance(mark, BeforeValidator | AfterValidator) for mark in metadata)
    for mark in metadata:
        text = _described(mark)
        if text:
            return f"{text}, or a name" if named else text
    for kind in kinds:
        if get_origin(kind) is Literal:
            return " or ".join(f"`{value}`" for value in get_args(kind))
    if bool in kinds:
        return "`true` or `false`"
    if UvTransform in kinds:
        return "transform of (u, v)"
    if str in kinds:
        return "file name" if name == "file" else "text"
    return "array"


def _parts(field: Any) -> tuple[list[Any], list[Any]]:
    """The types that a field may have, and the metadata of all of them."""
    kinds, metadata = [], list(field.metadata)
    left = [field.annotation]
    while left:
        kind = left.pop()
        metadata += getattr(kind, "__metadata__", ())
        if get_origin(kind) in (Union, UnionType) or hasattr(kind, "__metadata__"):
            left += [part for part in get_args(kind) if part is not None]
        else:
            kinds.append(kind)
    return kinds, metadata


def _described(mark: object) -> str:
    """A marker of a field's type in words, or nothing."""
    if isinstance(mark, Models):
        return f"list of {mark.count} {mark.kind}s or names of them"
    if isinstance(mark, Model):
        return f"{mark.kind} or the name of one" if mark.named else mark.kind
    if isinstance(mark, NumberOrTexture):
        return f"{f'number {_range(mark.interval)}'.rstrip()} or texture"
    if isinstance(mark, Numbers):
        noun = "whole numbers" if mark.interval.integer else "numbers"
        texture = ", or texture" if Texture in mark.other else ""
        text = f"{mark.count} {noun} {_range(mark.interval)}".rstrip()
        return f"{'number or ' if mark.spread else ''}{text}{texture}"
    if isinstance(mark, Interval):
        noun = "whole number" if mark.integer else "number"
        return f"{noun} {_range(mark)}".rstrip()
    if isinstance(mark, Named):
        return f"{mark.family or 'nodes'} by name"
    if isinstance(mark, TransformField):
        return "transform"
    if isinstance(mark, CameraField):
        return "camera, or the path of a node with one"
    return ""


def _range(interval: Interval) -> str:
    text = interval.describe()
    return "" if text.startswith("a ") else text


def _default(field: Any, tables: dict[str, dict[str, Any]]) -> str:
    value = field.default
    if value in (None, PydanticUndefined, {}):
        return ""
    if value == IDENTITY or value == UvTransform():
        return "identity"
    for names in tables.values():
        for name, number in names.items():
            if isinstance(value, float) and number == value:
                return name
    return flow(value, spread=_spreads(field))


def _spreads(field: Any) -> bool:
    """Whether one number stands for several equal ones."""
    return any(isinstance(mark, Numbers) and mark.spread for mark in _parts(field)[1])


def flow(value: Any, *, spread: bool = True) -> str:
    """A value as a scene file writes it, on one line; `spread`: three equal numbers as one."""
    if isinstance(value, Spec):
        known = type(value).model_fields
        fields = [
            f"{name}: {flow(item, spread=_spreads(known[name]))}"
            for name, item in value
            if name == "type" or item != known[name].default
        ]
        if not fields:
            return ""
        return "{" + ", ".join(sorted(fields, key=lambda text: not text.startswith("type:"))) + "}"
    if isinstance(value, tuple):
        if spread and len(value) == 3 and value.count(value[0]) == 3:
            return flow(value[0])
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return ".inf" if value == math.inf else f"{value:g}"
    text = str(value)
    if isinstance(value, int):
        return text
    # Words such as null are values of their own in YAML.
    return text if yaml.safe_load(text) == text else f'"{text}"'
