"""What the parts of the evaluation need of each other, and of a network's file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from alight.formats.materialx.nodes import Input, Node
from alight.formats.materialx.placing import Places
from alight.formats.materialx.values import Value, Varying
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.scene.files import Files
from alight.textures.images import Image


class Host(Protocol):
    """What an evaluator needs of a network's file."""

    report: Report
    files: Files
    reach: Reach
    #: Colour space of pictures that name none.
    space: str
    #: Length of the file's unit.
    meters: float
    #: Name of the set of coordinates where a network gives none.
    coordinates: str

    def picture(self, node: Node, entry: Input, is_color: bool) -> str | Image | None:
        """The picture that an input names; None where it is missing."""
        ...

    def primvar(self, node: Node, name: str, width: int) -> Value | None:
        """The value of a property of the mesh; None where it has none."""
        ...

    def set_name(self, index: int) -> str:
        """Name of a set of coordinates by its number."""
        ...


class Evaluates(Protocol):
    """An evaluator, as the readers of single nodes see it; see `evaluate.Evaluator`."""

    host: Host
    places: Places

    def say(self, node: Node, text: str) -> None:
        """Remark on what is not quite what a node says."""
        ...

    def value(self, node: Node, name: str, default: Any) -> Value:
        """The value of an input of a node."""
        ...

    def apply(self, node: Node, category: str, *values: Value) -> Value:
        """What a node of a category would make of its first inputs."""
        ...

    def mixed(self, node: Node, low: Value, high: Value, share: Value) -> Value:
        """Low where the share is 0, high where it is 1."""
        ...

    def computed(
        self,
        node: Node,
        function: Callable[..., Any],
        values: list[Value],
        instead: Value,
        width: int | None = None,
    ) -> Value:
        """A picture computed anew; another value where that cannot be, with a remark."""
        ...

    def constant(self, node: Node, value: Value, width: int) -> tuple[float, ...]:
        """The numbers of what must not vary."""
        ...

    def set_number(self, node: Node, name: str) -> int:
        """The number of a set of coordinates by its name."""
        ...

    def floored(self, node: Node, name: str, value: Varying) -> Varying:
        """A value cut at 0."""
        ...
