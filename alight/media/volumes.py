"""Numbers on a regular grid in a cube: checked once, never changed.

Values are at the centres of the cells. In scene files small grids can be written out as
nested lists, ``[z][y][x]``, each value a number or three.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import core_schema

from alight.core.errors import show_value
from alight.core.fields import LARGEST, invalid
from alight.core.spec import Spec

#: Limits of one grid: it takes at most half a gigabyte.
MOST_SIDE, MOST_CELLS = 2**12, 2**27


@dataclass(frozen=True, eq=False)
class Volume:
    """Values of a grid.

    Parameters
    ----------
    values : (nz, ny, nx, c) float32
        Read-only; c is 1 or 3. Finite and in [0, 1e15].

    Attributes
    ----------
    digest : str
        SHA-256 of values and shape; grids with equal digests are equal.
    """

    values: NDArray[np.float32]
    digest: str = field(init=False)

    def __post_init__(self) -> None:
        """Freeze the values."""
        self.values.setflags(write=False)
        digest = hashlib.sha256(f"{self.values.shape}".encode())
        digest.update(self.values.data)
        object.__setattr__(self, "digest", digest.hexdigest())

    def __eq__(self, other: object) -> bool:
        """Compare the contents."""
        return isinstance(other, Volume) and self.digest == other.digest

    def __hash__(self) -> int:
        """Hash the contents."""
        return hash(self.digest)

    def __repr__(self) -> str:
        """Name the contents, for messages and for the hash of a scene's content."""
        nz, ny, nx, channels = self.values.shape
        return f"Volume({nx}x{ny}x{nz}, {channels}, {self.digest})"

    @property
    def cells(self) -> int:
        """How many values there are in a channel."""
        return self.values[..., 0].size

    def plain(self) -> list[Any]:
        """Write the values out as scene files hold them."""

        def written(part: NDArray[np.float32]) -> Any:
            if part.ndim > 1:
                return [written(row) for row in part]
            numbers = [float(str(number)) for number in part]
            return numbers[0] if len(numbers) == 1 else numbers

        return written(self.values)


def as_volume(value: object) -> Volume:
    """Make a grid of an array or of nested lists.

    Parameters
    ----------
    value : Volume, array or list
        Shape (nz, ny, nx) or (nz, ny, nx, c) with c = 1 or 3.

    Raises
    ------
    PydanticCustomError
        If it is no grid, too large, or holds numbers that are no densities.
    """
    if isinstance(value, Volume):
        return value
    if isinstance(value, list | tuple):
        try:
            value = np.array(value, np.float64)
        except (ValueError, TypeError, OverflowError):
            raise invalid("must be nested lists of equal lengths, [z][y][x]") from None
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "biuf":
        found = f"an array of {value.dtype}" if isinstance(value, np.ndarray) else show_value(value)
        raise invalid(f"must be an array of numbers, got {found}")
    array = value[..., None] if value.ndim == 3 else value
    if array.ndim != 4 or array.shape[3] not in (1, 3) or 0 in array.shape:
        raise invalid(f"must have the shape (nz, ny, nx) or (nz, ny, nx, 3), got {value.shape}")
    problem = size_problem(*array.shape[:3])
    if problem:
        raise invalid(problem)
    with np.errstate(over="ignore", invalid="ignore"):
        bad = ~((array >= 0.0) & (array <= LARGEST))
    if bad.any():
        z, y, x, c = (int(i) for i in np.argwhere(bad)[0])
        raise invalid(
            f"values must be finite, >= 0 and at most {LARGEST:g}, "
            f"got {array[z, y, x, c]} at z {z}, y {y}, x {x}"
        )
    return Volume(np.array(array, np.float32, order="C"))


def size_problem(nz: int, ny: int, nx: int) -> str | None:
    """Say so if a grid has no cells or too many."""
    sides = (nz, ny, nx)
    if min(sides) >= 1 and max(sides) <= MOST_SIDE and nz * ny * nx <= MOST_CELLS:
        return None
    return (
        f"must have 1 to {MOST_SIDE} cells along each side and at most {MOST_CELLS} in all, "
        f"got {nx} x {ny} x {nz}"
    )


@dataclass(frozen=True)
class ValuesField:
    """Metadata of a field that holds a `Volume`."""

    def check(self, value: object) -> Volume:
        """Accept what `as_volume` takes."""
        return as_volume(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


Values = Annotated[Volume, ValuesField()]


def holds_volume(spec: Spec) -> bool:
    """Whether a description has the fields `file` and `values`."""
    return {"file", "values"} <= set(type(spec).model_fields)
