"""Where a node looks its texture up: a set of coordinates, and an affine map of it.

Source: MaterialX 1.39, standard library: place2d, rotate2d (clockwise), tiledimage; Pixar's
UsdTransform2d.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakMethod

import numpy as np

from alight.formats.materialx.nodes import MOST_DEEP, Input, Node
from alight.formats.materialx.values import Plain, Value

Matrix = Any


@dataclass(frozen=True)
class Place:
    """A set of texture coordinates by its name, and the (3, 3) map of them."""

    name: str
    matrix: Matrix

    def moved(self, matrix: Matrix) -> Place:
        """The place after a further step."""
        return replace(self, matrix=matrix @ self.matrix)

    @property
    def steps(self) -> dict[str, Any]:
        """The keys of a texture that it gives."""
        if np.array_equal(self.matrix, np.eye(3)):
            return {}
        return {"to_uv": {"matrix": self.matrix[:2].tolist()}}


class NoPlaceError(ValueError):
    """Coordinates that are no affine map of a set of them; the message says why."""


def scale(pair: Sequence[float]) -> Matrix:
    """Factors of u and v."""
    return np.diag([*_pair(pair), 1.0])


def shift(pair: Sequence[float]) -> Matrix:
    """Numbers added to u and v."""
    matrix = np.eye(3)
    matrix[:2, 2] = _pair(pair)
    return matrix


def rotate(degrees: float) -> Matrix:
    """Clockwise."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def inverse(pair: Sequence[float]) -> tuple[float, ...]:
    """1 over each; of 0 there is none."""
    if not all(_pair(pair)):
        raise NoPlaceError("are divided by 0")
    return tuple(1.0 / x for x in _pair(pair))


def negative(pair: Sequence[float]) -> tuple[float, ...]:
    """Of each."""
    return tuple(-x for x in _pair(pair))


def _pair(pair: Sequence[float]) -> tuple[float, float]:
    return float(pair[0]), float(pair[1] if len(pair) > 1 else pair[0])


class Places:
    """Follows coordinates to the set that they come from.

    Parameters
    ----------
    default : str
        Name of the set where a network gives none.
    named : callable
        From the index of a set to its name.
    value : weakref.WeakMethod
        Evaluates an input that is no coordinates.
    """

    def __init__(
        self,
        default: str,
        named: Callable[[int], str],
        value: WeakMethod[Callable[[Node, str, Any], Value]],
    ) -> None:
        self.default = default
        self.named = named
        self._value = value
        self._deep = 0

    def of(self, node: Node, name: str = "texcoord") -> Place:
        """The coordinates of an input of a node.

        Raises
        ------
        NoPlaceError
        """
        entry = node.inputs.get(name)
        if entry is None or (entry.source is None and entry.value is None):
            return Place(self.default, np.eye(3))
        if entry.source is None:
            raise NoPlaceError("are one point")
        return self._from(entry)

    def _from(self, entry: Input) -> Place:
        self._deep += 1
        try:
            if self._deep > MOST_DEEP:
                raise NoPlaceError(f"come through more than {MOST_DEEP} nodes, or from themselves")
            return self._through(entry)
        finally:
            self._deep -= 1

    def _through(self, entry: Input) -> Place:
        node = entry.source
        assert node is not None
        category = node.category
        if category in ("texcoord", "in"):
            return Place(self.named(int(node.plain("index", 0))), np.eye(3))
        if category in ("geompropvalue", "UsdPrimvarReader"):
            key = "geomprop" if category == "geompropvalue" else "varname"
            return Place(str(node.plain(key, "")) or self.default, np.eye(3))
        if category in ("dot", "convert"):
            return self.of(node, "in")
        found = _STEPS.get(category)
        if found is None:
            raise NoPlaceError(f"come from <{category}>")
        return found(self, node)

    def numbers(self, node: Node, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """The same numbers everywhere that an input has."""
        evaluate = self._value()
        assert evaluate is not None
        value = evaluate(node, name, default)
        if not isinstance(value, Plain):
            raise NoPlaceError(f"depend on {name}, which varies")
        return value.numbers

    def scaled(self, node: Node) -> Place:
        """Coordinates times numbers, in either order."""
        for first, second in (("in1", "in2"), ("in2", "in1")):
            if (entry := node.inputs.get(first)) is not None and entry.source is not None:
                return self.of(node, first).moved(scale(self.numbers(node, second, (1.0,))))
        raise NoPlaceError("are one point")

    def shifted(self, node: Node) -> Place:
        """Coordinates plus numbers, in either order."""
        for first, second in (("in1", "in2"), ("in2", "in1")):
            if (entry := node.inputs.get(first)) is not None and entry.source is not None:
                return self.of(node, first).moved(shift(self.numbers(node, second, (0.0,))))
        raise NoPlaceError("are one point")

    def subtracted(self, node: Node) -> Place:
        """Coordinates minus numbers, or numbers minus coordinates."""
        entry = node.inputs.get("in1")
        if entry is not None and entry.source is not None:
            return self.of(node, "in1").moved(shift(negative(self.numbers(node, "in2", (0.0,)))))
        other = self.numbers(node, "in1", (0.0,))
        return self.of(node, "in2").moved(scale((-1.0,))).moved(shift(other))

    def divided(self, node: Node) -> Place:
        """Coordinates over numbers."""
        return self.of(node, "in1").moved(scale(inverse(self.numbers(node, "in2", (1.0,)))))

    def rotated(self, node: Node) -> Place:
        """Coordinates turned about (0, 0)."""
        return self.of(node, "in").moved(rotate(self.numbers(node, "amount", (0.0,))[0]))

    def placed(self, node: Node) -> Place:
        """``place2d``: scale, rotation and offset about a pivot, in either order."""
        pivot = self.numbers(node, "pivot", (0.0, 0.0))
        size = scale(inverse(self.numbers(node, "scale", (1.0, 1.0))))
        turned = rotate(self.numbers(node, "rotate", (0.0,))[0])
        moved = shift(negative(self.numbers(node, "offset", (0.0, 0.0))))
        steps = [size, turned, moved]
        if self.numbers(node, "operationorder", (0.0,))[0] != 0.0:
            steps.reverse()
        place = self.of(node).moved(shift(negative(pivot)))
        for step in steps:
            place = place.moved(step)
        return place.moved(shift(pivot))

    def transformed(self, node: Node) -> Place:
        """``UsdTransform2d``: scale, then counter-clockwise rotation, then translation."""
        place = self.of(node, "in").moved(scale(self.numbers(node, "scale", (1.0, 1.0))))
        place = place.moved(rotate(-self.numbers(node, "rotation", (0.0,))[0]))
        return place.moved(shift(self.numbers(node, "translation", (0.0, 0.0))))

    def tiled(self, node: Node) -> Place:
        """``tiledimage`` and ``checkerboard``: coordinates times a number, minus another."""
        count = 8.0 if node.category == "checkerboard" else 1.0
        place = self.of(node).moved(scale(self.numbers(node, "uvtiling", (count, count))))
        place = place.moved(shift(negative(self.numbers(node, "uvoffset", (0.0, 0.0)))))
        image = inverse(self.numbers(node, "realworldimagesize", (1.0, 1.0)))
        tile = self.numbers(node, "realworldtilesize", (1.0, 1.0))
        return place.moved(scale(image)).moved(scale(tile))


_STEPS: dict[str, Callable[[Places, Node], Place]] = {
    "UsdTransform2d": Places.transformed,
    "add": Places.shifted,
    "divide": Places.divided,
    "multiply": Places.scaled,
    "place2d": Places.placed,
    "rotate2d": Places.rotated,
    "subtract": Places.subtracted,
}
