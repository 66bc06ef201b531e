"""Types of the fields of descriptions: what values they take, and in which words they refuse.

Numbers are bounded by what float32 kernels can carry: lengths and other signed numbers to
1e15, because their squares must stay finite in float32 (largest number 3.4e38).
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Strict
from pydantic_core import PydanticCustomError, core_schema

from alight.core.errors import show_value

LARGEST = 1e15
SMALLEST = 1e-15

Truth = Annotated[bool, Strict()]


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
        try:
            finite = math.isfinite(value)
        except OverflowError:
            # Python's whole numbers have no end.
            raise invalid(f"must be at most {LARGEST:g} in size, got {show_value(value)}") from None
        if not finite:
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
        Whether a single number stands for `count` equal ones.
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
        Whether a name may stand for a description.
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
