r"""Where a texture is looked up: affine maps of the surface parameters (u, v).

.. math:: (s, t) = M (u, v), \qquad M = \begin{pmatrix} a & b & c \\ d & e & f \end{pmatrix}

    to_uv: {scale: 4}
    to_uv: [{scale: [4, 2]}, {rotate: 30}, {translate: [0.5, 0]}]
    to_uv: {matrix: [[4, 0, 0.5], [0, 2, 0]]}

A list is applied from left to right, as the steps of a node's transform. Scaling by 4 repeats a
picture four times. Rotations are in degrees, from u to v about (0, 0). (s, t) are right to the
rounding of float32, so a picture that repeats a thousand times is placed to 1/10 000 of its width.

Meshes may have several sets of (u, v); ``uv_set: 1`` next to `to_uv` selects the second one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic_core import PydanticCustomError, core_schema

from alight.core.errors import show_value, unknown_name
from alight.core.fields import LARGEST, Interval, Numbers, invalid
from alight.core.parameters import Slots
from alight.core.uv_sets import uv_of_texture
from alight.core.vec import gather_vec3
from lanewise.jit import kernel

STEPS = ("translate", "scale", "rotate", "matrix")
MOST_STEPS = 100

_PAIR, _FACTORS = Numbers(2, Interval()), Numbers(2, Interval(), spread=True)
_ROW = Numbers(3, Interval())


@dataclass(frozen=True)
class UvTransform:
    """An affine map of (u, v), with the steps that it was made of.

    Parameters
    ----------
    steps : tuple of (str, value)
        Name of the step; a pair of numbers, an angle in degrees, or two or rows of three numbers.
    """

    steps: tuple[tuple[str, Any], ...] = ()

    @classmethod
    def of_matrix(cls, rows: ArrayLike) -> UvTransform:
        """Make a map of a (2, 3) matrix, or of a (3, 3) one whose last row is (0, 0, 1)."""
        top, middle = np.asarray(rows, np.float64)[:2].tolist()
        return cls((("matrix", (tuple(top), tuple(middle))),))

    @property
    def matrix(self) -> np.ndarray:
        """The (2, 3) float64 matrix."""
        result = np.eye(3)
        with np.errstate(over="ignore", invalid="ignore"):
            for name, value in self.steps:
                result = _matrix(name, value) @ result
        return result[:2]

    def plain(self) -> Any:
        """Write it as `parse_uv_transform` reads it: a step, or a list of them."""
        steps = [{name: _plain(value)} for name, value in self.steps]
        return steps[0] if len(steps) == 1 else steps


def _matrix(name: str, value: Any) -> np.ndarray:
    result = np.eye(3)
    if name == "translate":
        result[:2, 2] = value
    elif name == "scale":
        result[0, 0], result[1, 1] = value
    elif name == "matrix":
        result[:2] = value
    else:
        cosine, sine = math.cos(math.radians(value)), math.sin(math.radians(value))
        if value % 90.0 == 0.0:
            cosine, sine = round(cosine), round(sine)
        result[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return result


def _plain(value: Any) -> Any:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def parse_uv_transform(value: object) -> UvTransform:
    """Make a map of a step, a list of steps, or what is one already.

    Raises
    ------
    PydanticCustomError
        If a step is none, or the numbers become too large for float32.
    """
    if isinstance(value, UvTransform):
        return value
    steps = value if isinstance(value, list | tuple) else [value]
    if len(steps) > MOST_STEPS:
        raise invalid(f"must have at most {MOST_STEPS} steps, got {len(steps)}")
    made = UvTransform(tuple(_step(step) for step in steps))
    if not (np.abs(made.matrix) <= LARGEST).all():
        raise invalid(f"its steps together must stay below {LARGEST:g} in size")
    return made


def _step(step: object) -> tuple[str, Any]:
    if not isinstance(step, Mapping) or len(step) != 1:
        names = ", ".join(STEPS)
        raise invalid(f"each step must have exactly one of {names}, got {show_value(step)}")
    ((name, value),) = step.items()
    if name not in STEPS:
        raise invalid(unknown_name("step", str(name), STEPS))
    try:
        return name, _argument(name, value)
    except PydanticCustomError as error:
        raise invalid(f"{name} {error.message()}") from None


def _argument(name: str, value: object) -> Any:
    if name == "rotate":
        return Interval().check(value)
    if name == "matrix":
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise invalid(f"must be 2 rows of 3 numbers, got {show_value(value)}")
        return tuple(_checked(_ROW, row) for row in value)
    return _checked(_FACTORS if name == "scale" else _PAIR, value)


def _checked(kind: Numbers, value: object) -> tuple[float, ...]:
    return kind.check(value, lambda items: tuple(kind.interval.check(item) for item in items))


@dataclass(frozen=True)
class UvField:
    """Metadata of a field that holds a `UvTransform`."""

    def check(self, value: object) -> UvTransform:
        """Accept what `parse_uv_transform` takes."""
        return parse_uv_transform(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


ToUv = Annotated[UvTransform, UvField()]
IDENTITY = UvTransform()


@kernel
def _lookup_point(scene, slot, surface):
    """(s, t): a matrix, row by row, applied to (u, v) of the set whose number follows it."""
    data = scene.materials.texture_data
    u, v = uv_of_texture(scene, slot + 6, surface)
    across, down = gather_vec3(data, slot), gather_vec3(data, slot + 3)
    return across.x * u + across.y * v + across.z, down.x * u + down.y * v + down.z


#: Field of a record of parameters: the point (s, t) of a texture that a surface shows.
LookupPoint = Annotated[Any, Slots(_lookup_point, {"to_uv": 6, "uv_set": 1})]
