"""Validated, immutable descriptions: the base class of all models and their field types.

A description is data only. It is checked when it is made, so kernels never check anything.
Numbers are bounded by what float32 kernels can carry: lengths and other signed numbers to
1e15, because their squares must stay finite in float32 (largest number 3.4e38).
"""

from __future__ import annotations

import difflib
import math
import numbers
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, Strict, ValidationError, model_validator
from pydantic_core import PydanticCustomError, core_schema

from alight.core.errors import Issue, SceneError, join_path, show_value, unknown_name

LARGEST = 1e15
SMALLEST = 1e-15


def invalid(message: str) -> PydanticCustomError:
    """Make an error with our wording, for use in validators (braces are taken literally)."""
    return PydanticCustomError("alight", "{message}", {"message": message})


@dataclass(frozen=True)
class Interval:
    """A number in [low, high], or in (low, high) with `open_ends`; metadata of a field type.

    Parameters
    ----------
    low, high : float
        Bounds; infinite ones are replaced by the range of float32 kernels.
    open_ends : bool, default False
        Whether the finite bounds themselves are excluded.
    integer : bool, default False
        Whether only whole numbers are allowed.
    """

    low: float = -math.inf
    high: float = math.inf
    open_ends: bool = False
    integer: bool = False

    def check(self, value: object) -> float | int:
        """Return `value` as a Python number, or raise an error that states the allowed range."""
        if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
            raise invalid(f"must be a {self._noun}, got {show_value(value)}")
        if not math.isfinite(value):
            raise invalid(f"must be finite, got {value}")
        if self.integer and value != int(value):
            raise invalid(f"must be a whole number, got {value}")
        number = int(value) if self.integer else float(value)
        if not self._contains(number):
            raise invalid(f"must be {self.describe()}, got {value}")
        if abs(number) > LARGEST or 0 < number < SMALLEST == self._least:
            raise invalid(f"must be between {SMALLEST:g} and {LARGEST:g} in size, got {value}")
        return number

    @property
    def _noun(self) -> str:
        return "whole number" if self.integer else "number"

    @property
    def _least(self) -> float:
        return SMALLEST if self.open_ends and self.low == 0 else 0.0

    def _contains(self, number: float) -> bool:
        if self.open_ends:
            return self.low < number < self.high
        return self.low <= number <= self.high

    def describe(self) -> str:
        """Put the range in words: ``in [0, 1]``, ``> 0``, ``a number``."""
        if self.low > -math.inf and self.high < math.inf:
            number = "d" if self.integer else "g"
            ends = f"{self.low:{number}}, {self.high:{number}}"
            return f"in ({ends})" if self.open_ends else f"in [{ends}]"
        if self.low > -math.inf:
            return f"> {self.low:g}" if self.open_ends else f">= {self.low:g}"
        return f"a {self._noun}"

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Use `check` alone: pydantic's own conversions accept "1" and True."""
        return core_schema.no_info_plain_validator_function(self.check)


@dataclass(frozen=True)
class Numbers:
    """A fixed count of numbers in one interval; metadata of a field type.

    Parameters
    ----------
    count : int
        How many.
    interval : Interval
        Range of each.
    spread : bool, default False
        Whether a single number means `count` equal ones.
    other : type or tuple of types, default ()
        Values of these types are passed on unchanged (texture names and descriptions).
    """

    count: int
    interval: Interval
    spread: bool = False
    other: tuple[type, ...] = ()

    def check(self, value: object, handler: Callable[[Any], Any]) -> Any:
        """Return `count` Python numbers, or `value` itself where `other` allows it."""
        if self.other and isinstance(value, self.other):
            return value
        if self.spread and isinstance(value, numbers.Real):
            return (self.interval.check(value),) * self.count
        if isinstance(value, np.ndarray) and value.ndim == 1:
            value = value.tolist()
        if not isinstance(value, list | tuple) or len(value) != self.count:
            raise invalid(f"must be {self._describe()}, got {show_value(value)}")
        return handler(tuple(value))

    def _describe(self) -> str:
        noun = "whole numbers" if self.interval.integer else "numbers"
        ways = [f"a list of {self.count} {noun}"]
        if self.spread:
            ways.insert(0, "a number")
        if self.other:
            ways.append("a texture")
        return ", ".join(ways[:-1]) + (" or " if ways[:-1] else "") + ways[-1]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Wrap a tuple schema, so that errors of one component carry its index."""
        item = core_schema.no_info_plain_validator_function(self.interval.check)
        items = core_schema.tuple_schema([item] * self.count)
        return core_schema.no_info_wrap_validator_function(self.check, items)


@dataclass(frozen=True)
class NumberOrTexture:
    """A number in an interval, or something that gives one; metadata of a field type.

    Parameters
    ----------
    interval : Interval
        Range of the number; of a texture, the range that its values must lie in.
    other : tuple of types
        Values of these types are passed on unchanged (texture names and descriptions).
    """

    interval: Interval
    other: tuple[type, ...]

    def check(self, value: object) -> Any:
        """Return a Python number, or `value` itself where `other` allows it."""
        if isinstance(value, self.other):
            return value
        if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
            raise invalid(f"must be a number or a texture, got {show_value(value)}")
        return self.interval.check(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Use `check` alone: a union would put its branches into the error paths."""
        return core_schema.no_info_plain_validator_function(self.check)


@dataclass(frozen=True)
class Model:
    """Another description, or the name of one; metadata of a field type.

    Parameters
    ----------
    kind : str
        What it is, in messages.
    family : str
        Package of its models.
    named : bool, default False
        Whether a name may replace a description.
    """

    kind: str
    family: str
    named: bool = False

    def check(self, value: object) -> Any:
        """Return `value` if it is a description of this family or an allowed name."""
        if getattr(type(value), "family", None) == self.family:
            return value
        if self.named and isinstance(value, str):
            return value
        names = f" or the name of a {self.kind}" if self.named else ""
        raise invalid(f"must be a {self.kind}{names}, got {show_value(value)}")

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Use `check` alone: a union would put its branches into the error paths."""
        return core_schema.no_info_plain_validator_function(self.check)


@dataclass(frozen=True)
class Models(Model):
    """A list of descriptions, or of names of them; metadata of a field type.

    Parameters
    ----------
    count : int
        How many.
    """

    count: int = 2

    def check(self, value: object) -> Any:
        """Return a tuple if all are descriptions of this family or allowed names."""
        if not isinstance(value, list | tuple) or len(value) != self.count:
            raise invalid(self.problem(value))
        return tuple(super(Models, self).check(item) for item in value)

    def problem(self, value: object) -> str:
        """Say what a value should be that is not such a list."""
        return f"must be a list of {self.count} {self.kind}s, got {show_value(value)}"


Truth = Annotated[bool, Strict()]


class Spec(BaseModel):
    """Base class of all model descriptions: immutable, unknown keys refused.

    Attributes
    ----------
    family : str
        Package that holds the models of this kind, for instance ``bsdfs``.
    kind : str
        Singular of the family, used in messages.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    family: ClassVar[str] = ""
    kind: ClassVar[str] = ""

    def __init__(self, /, **data: Any) -> None:
        """Make a description from its fields.

        Raises
        ------
        SceneError
            With one issue for each field that is wrong.
        """
        try:
            self.__pydantic_validator__.validate_python(data, self_instance=self)
        except ValidationError as error:
            raise SceneError(
                [issue.under(self.type_name()) for issue in translate(type(self), error)]
            ) from None

    # pydantic then skips this constructor when it validates, as for its own base class.
    __init__.__pydantic_base_init__ = True  # pyright: ignore[reportFunctionMemberAccess]

    @classmethod
    def type_name(cls) -> str:
        """Name in scene files, or the class name where there is no choice of type."""
        field = cls.model_fields.get("type")
        return field.default if field else cls.__name__.lower()

    def replaced(self, **changes: Any) -> Self:
        """Make a checked copy with some fields changed."""
        return type(self)(**{**dict(self), **changes})


class Bsdf(Spec):
    """Base class of scattering models; the reflectances `shares` are together at most 1."""

    family: ClassVar[str] = "bsdfs"
    kind: ClassVar[str] = "bsdf"
    transmissive: ClassVar[bool] = False
    shares: ClassVar[tuple[str, ...]] = ()


def _is_color(marker: object) -> bool:
    """Whether the metadata of a field say that it holds an amount of light in three channels."""
    return isinstance(marker, Numbers) and marker.count == 3 and marker.interval.low == 0.0


def _is_dark(color: Triple | Texture | str) -> bool:
    """Whether a colour is 0; what names and unread files hold is not known yet."""
    if isinstance(color, Texture):
        return getattr(color, "file", None) is None and color.maximum() == (0.0, 0.0, 0.0)
    return color == (0.0, 0.0, 0.0)


class Light(Spec):
    """Base class of lights; `placement` is where a scene may place one."""

    family: ClassVar[str] = "lights"
    kind: ClassVar[str] = "light"
    placement: ClassVar[Literal["node", "shape", "environment"]] = "node"

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing: all of its colours are 0, as far as textures are known."""
        fields = type(self).model_fields
        colors = [value for name, value in self if any(map(_is_color, fields[name].metadata))]
        return bool(colors) and all(map(_is_dark, colors))


class Texture(Spec):
    """Base class of textures: colours that vary over a surface."""

    family: ClassVar[str] = "textures"
    kind: ClassVar[str] = "texture"

    def maximum(self) -> tuple[float, float, float]:
        """Largest value of each channel."""
        return (1.0, 1.0, 1.0)

    def mean(self) -> tuple[float, float, float]:
        """Mean of each channel over the square of (u, v); above 0 where any value is."""
        return self.maximum()


class Shape(Spec):
    """Base class of shapes; `finite` ones can be lights."""

    family: ClassVar[str] = "shapes"
    kind: ClassVar[str] = "shape"
    finite: ClassVar[bool] = True
    flip_normals: Truth = False


class PhaseFunction(Spec):
    """Base class of phase functions: where light goes that a medium scatters."""

    family: ClassVar[str] = "phases"
    kind: ClassVar[str] = "phase function"


class Medium(Spec):
    """Base class of media: what fills the space between surfaces."""

    family: ClassVar[str] = "media"
    kind: ClassVar[str] = "medium"


class Camera(Spec):
    """Base class of cameras.

    `medium` surrounds the camera, if not the scene's own; `shutter` are the times at which it
    opens and closes, in the unit of the keyframes of what moves.
    """

    family: ClassVar[str] = "cameras"
    kind: ClassVar[str] = "camera"
    medium: Annotated[Medium | str, Model("medium", "media", named=True)] | None = None
    shutter: Annotated[tuple[float, float], Numbers(2, Interval())] = (0.0, 1.0)

    @model_validator(mode="after")
    def _closes_after_opening(self) -> Self:
        begin, end = self.shutter
        if end < begin:
            text = "shutter [open, close] must not close before it opens"
            raise invalid(f"{text}, got [{begin:g}, {end:g}]")
        return self


class Sampler(Spec):
    """Base class of samplers; made for `block` samples, doubled any number of times."""

    family: ClassVar[str] = "samplers"
    kind: ClassVar[str] = "sampler"
    block: ClassVar[int] = 1


class Filter(Spec):
    """Base class of pixel filters."""

    family: ClassVar[str] = "filters"
    kind: ClassVar[str] = "filter"


class Integrator(Spec):
    """Base class of integrators.

    Without `needs_light` even a dark scene gives a picture; those that follow light must say by
    `sees_media` whether they know of media.
    """

    family: ClassVar[str] = "integrators"
    kind: ClassVar[str] = "integrator"
    needs_light: ClassVar[bool] = True
    sees_media: ClassVar[bool] = False


NonNegative = Annotated[float, Interval(low=0.0)]
Positive = Annotated[float, Interval(low=0.0, open_ends=True)]
UnitInterval = Annotated[float, Interval(0.0, 1.0)]
Degrees = Annotated[float, Interval()]
FieldOfView = Annotated[float, Interval(0.0, 180.0, open_ends=True)]
# Below 1 lie only X-rays and metals; above 5 no clear material is known.
IndexOfRefraction = Annotated[float, Interval(1.0, 5.0)]
# A sampler's block of strata squared samples stays below 2^20, an integrator's depth below 2^16
# dimensions of 16 per vertex; a filter narrower than 0.1 pixels would sample a point.
Strata = Annotated[int, Interval(1, 1024, integer=True)]
Depth = Annotated[int, Interval(1, 4000, integer=True)]
FilterRadius = Annotated[float, Interval(0.1, 16.0)]

Triple = tuple[float, float, float]
Vector2 = Annotated[tuple[float, float], Numbers(2, Interval())]
Vector3 = Annotated[Triple, Numbers(3, Interval())]
Scale2 = Annotated[tuple[float, float], Numbers(2, Interval(), spread=True)]
Color = Annotated[Triple, Numbers(3, Interval(low=0.0), spread=True)]
PositiveColor = Annotated[Triple, Numbers(3, Interval(low=0.0, open_ends=True), spread=True)]
Reflectance = Annotated[Triple, Numbers(3, Interval(0.0, 1.0), spread=True)]
ColorTexture = Annotated[
    Triple | Texture | str, Numbers(3, Interval(0.0, 1.0), spread=True, other=(str, Texture))
]
RadianceTexture = Annotated[
    Triple | Texture | str, Numbers(3, Interval(low=0.0), spread=True, other=(str, Texture))
]
UnitTexture = Annotated[
    float | Texture | str, NumberOrTexture(Interval(0.0, 1.0), other=(str, Texture))
]
# Smoother surfaces are mirrors to float32; kernels raise smaller values of textures to it.
SMOOTHEST = 1e-4
Roughness = Annotated[
    float | Texture | str, NumberOrTexture(Interval(SMOOTHEST, 1.0), other=(str, Texture))
]
ScalarTexture = Annotated[
    float | Texture | str, NumberOrTexture(Interval(low=0.0), other=(str, Texture))
]
NestedBsdf = Annotated[Bsdf | str, Model("bsdf", "bsdfs", named=True)]
NestedBsdfs = Annotated[tuple[Bsdf | str, ...], Models("bsdf", "bsdfs", named=True)]


@cache
def texture_interval(spec: type[Spec], name: str) -> Interval | None:
    """Range of the values that a texture in a field may have; None if it takes no textures."""
    info = spec.model_fields[name]
    found = [*info.metadata]
    # In ``X | None`` the metadata of X are inside.
    for part in get_args(info.annotation):
        found.extend(getattr(part, "__metadata__", ()))
    return next((item.interval for item in found if Texture in getattr(item, "other", ())), None)


def energy_problem(**parts: Triple | Texture | str) -> str | None:
    """Say so if reflectances, each at its largest, add up to more than 1 in a channel.

    Names of textures count as 0 here; they are checked again once the scene resolves them.
    """
    colors = [part.maximum() if isinstance(part, Texture) else part for part in parts.values()]
    known = [color for color in colors if not isinstance(color, str)]
    sums = [sum(channel) for channel in zip(*known, strict=True)]
    # A few rounding errors of sums such as 0.7 + 0.2 + 0.1 are no offence.
    if max(sums, default=0.0) <= 1.0 + 1e-9:
        return None
    shown = ", ".join(f"{channel:g}" for channel in sums)
    return f"{' + '.join(parts)} must be at most 1 in each channel, got ({shown})"


def translate(spec: type[BaseModel], error: ValidationError) -> list[Issue]:
    """Put pydantic's errors in our words: one issue each, paths relative to the description."""
    return [
        Issue(
            join_path(*detail["loc"]),
            _message(spec, detail),
            about_key=detail["type"] == "extra_forbidden",
        )
        for detail in error.errors(include_url=False)
    ]


def _message(spec: type[BaseModel], detail: Mapping[str, Any]) -> str:
    kind, value = detail["type"], detail["input"]
    fields = [name for name in spec.model_fields if name != "type"]
    if kind == "alight":
        return detail["ctx"]["message"]
    if kind == "extra_forbidden":
        return unknown_name("key", str(detail["loc"][-1]), fields, listed_as="keys")
    if kind == "missing":
        return f"is missing  (keys: {', '.join(fields)})"
    if kind == "literal_error":
        return _choice_message(value, re.findall(r"'([^']*)'", detail["ctx"]["expected"]))
    nouns = {"string_type": "a text", "bool_type": "true or false", "dict_type": "a mapping"}
    if kind in nouns:
        return f"must be {nouns[kind]}, got {show_value(value)}"
    if kind == "is_instance_of":
        return f"must be a {detail['ctx']['class'].lower()}, got {show_value(value)}"
    return f"{detail['msg']}, got {show_value(value)}"


def _choice_message(value: object, choices: list[str]) -> str:
    near = difflib.get_close_matches(str(value)[:80], choices, n=1)
    hint = f'; did you mean "{near[0]}"?' if near else ""
    return f"must be one of {', '.join(choices)}, got {show_value(value)}{hint}"
