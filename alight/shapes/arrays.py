"""Shapes with arrays as fields: tables of numbers that never change."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray
from pydantic import PrivateAttr, model_validator
from pydantic_core import core_schema

from alight.core.field_types import Positive
from alight.core.fields import Interval, NumberOrTexture, Truth, invalid
from alight.core.spec import Shape, Spec, Texture
from alight.core.uv_sets import MOST_SETS


@dataclass(frozen=True)
class Rows:
    """A table with `columns` numbers a row; metadata of a field type."""

    columns: int
    dtype: DTypeLike

    def check(self, value: object) -> np.ndarray:
        """Return a read-only copy of shape (n, columns), or the table itself if it is one."""
        table = _as_array(value)
        if table.size == 0 and isinstance(value, list | tuple):
            table = np.zeros((0, self.columns))
        numeric = np.issubdtype(table.dtype, np.number) and not np.iscomplexobj(table)
        if not numeric or table.ndim != 2 or table.shape[1:] != (self.columns,):
            found = f"shape {table.shape}" if table.ndim else type(value).__name__
            raise invalid(f"must be a table of numbers, shape (n, {self.columns}), got {found}")
        return self._kept(table)

    def _kept(self, table: np.ndarray) -> np.ndarray:
        self._check_range(table)
        owned = table.base is None and not table.flags.writeable and table.flags.c_contiguous
        if owned and table.dtype == self.dtype:
            return table
        table = np.array(table, self.dtype, order="C")
        table.setflags(write=False)
        return table

    def _check_range(self, table: np.ndarray) -> None:
        # Conversion alone would wrap large indices around and cut off fractions.
        if np.issubdtype(self.dtype, np.integer):
            limit = np.iinfo(self.dtype).max
            if table.dtype.kind in "iu" and _lies_in(table, 0, limit):
                return
            bad = ~((table >= 0) & (table <= limit) & (table == np.floor(table)))
            wanted = f"whole numbers in [0, {limit}]"
        else:
            if _lies_in(table, -1e15, 1e15):
                return
            bad = ~(np.abs(table) <= 1e15)
            wanted = "finite and at most 1e+15 in size"
        if bad.any():
            place = tuple(int(i) for i in np.argwhere(bad)[0])
            raise invalid(f"must be {wanted}, got {table[place]} in row {place[-2]}")

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Use `check` alone."""
        return core_schema.no_info_plain_validator_function(self.check)


@dataclass(frozen=True)
class Tables(Rows):
    """Several tables of equal length in one array; metadata of a field type."""

    most: int

    def check(self, value: object) -> np.ndarray:
        """Return a read-only copy of shape (k, n, columns), or the array itself if it is one."""
        array = _as_array(value)
        numeric = np.issubdtype(array.dtype, np.number) and not np.iscomplexobj(array)
        shape = array.shape
        if not numeric or len(shape) != 3 or shape[2] != self.columns:
            found = f"shape {shape}" if shape else type(value).__name__
            wanted = f"(k, n, {self.columns})"
            raise invalid(f"must be tables of numbers of equal length, shape {wanted}, got {found}")
        if not 1 <= shape[0] <= self.most:
            raise invalid(f"must be 1 to {self.most} tables, got {shape[0]}")
        return self._kept(array)


def _as_array(value: object) -> np.ndarray:
    try:
        array = np.asarray(value)
        # In float16 the limits of ranges are infinite.
        return array.astype(np.float32) if array.dtype == np.float16 else array
    except ValueError:  # rows of different lengths
        return np.zeros((), object)


def _lies_in(table: np.ndarray, low: float, high: float) -> bool:
    """Whether all numbers do; false if one is NaN."""
    return table.size == 0 or bool(low <= table.min() and table.max() <= high)


Points = Annotated[NDArray[np.float32], Rows(3, np.float32)]
Coordinates = Annotated[NDArray[np.float32], Rows(2, np.float32)]
Sets = Annotated[NDArray[np.float32], Tables(2, np.float32, MOST_SETS - 1)]
Indices = Annotated[NDArray[np.int32], Rows(3, np.int32)]

#: What a texture, or a number, says of a height.
Height = Annotated[float | Texture | str, NumberOrTexture(Interval(), other=(str, Texture))]

#: Fields of a `TriangleShape` that mean something only where the first of them is given.
DISPLACEMENT = (
    "displacement", "displacement_scale", "displacement_midlevel", "displacement_edge",
)  # fmt: skip

#: Fields of a `TriangleShape` that hold arrays.
ARRAYS = ("vertices", "faces", "normals", "uvs", "colors", "more_uvs")


class ArrayShape(Shape):
    """Base class of shapes with arrays."""

    def __eq__(self, other: object) -> bool:
        """Equal fields; arrays count as equal where all of their numbers are."""
        if type(self) is not type(other):
            return NotImplemented
        return all(_same(value, getattr(other, name)) for name, value in self)

    def __hash__(self) -> int:
        """Hash of the array bytes and the other fields."""
        return hash(
            tuple(value.tobytes() if isinstance(value, np.ndarray) else value for _, value in self)
        )


class TriangleShape(ArrayShape):
    """Base class of shapes made of triangles, from arrays or a file."""

    file: str | None = None
    vertices: Points | None = None
    faces: Indices | None = None
    normals: Points | None = None
    uvs: Coordinates | None = None
    more_uvs: Sets | None = None
    colors: Points | None = None
    face_normals: Truth = False
    displacement: Height | None = None
    displacement_scale: Annotated[float, Interval()] = 1.0
    displacement_midlevel: Annotated[float, Interval()] = 0.0
    displacement_edge: Positive | None = None
    _checked: Any = PrivateAttr(None)

    @property
    def checked(self) -> Any:
        """What a check of the arrays has found, handed on to whoever needs it next, or None."""
        return self._checked

    def hand_on(self, checked: object) -> None:
        """Keep what a check of the arrays has found; both are immutable."""
        self._checked = checked

    @model_validator(mode="after")
    def _has_one_source(self) -> Self:
        given = [name for name in ARRAYS if getattr(self, name) is not None]
        if self.file is not None and given:
            raise invalid(f"takes either file or arrays, got file and {', '.join(given)}")
        if self.file is None and not {"vertices", "faces"} <= set(given):
            raise invalid("needs a file, or vertices and faces")
        return self


def _same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return np.array_equal(a, b)
    return type(a) is type(b) and a == b


def in_words(value: object) -> str:
    """What decides a field of a description, as text: an array is known by its digest."""
    if not isinstance(value, np.ndarray):
        return repr(value)
    digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
    return f"{value.dtype}{value.shape} {digest}"


def is_displaced(spec: Spec) -> bool:
    """Whether it is a mesh that shall be displaced."""
    return isinstance(spec, TriangleShape) and spec.displacement is not None
