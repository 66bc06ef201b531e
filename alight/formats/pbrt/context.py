"""What the converters of all kinds of directives share: names, places, files, problems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from alight.formats.pbrt.colors import Colors
from alight.formats.reading.context import Conversion, Data


@dataclass
class Context(Conversion):
    """State of one conversion; see `alight.formats.reading.context.Conversion`.

    Attributes
    ----------
    old : bool
        Whether the scene is one of pbrt 3.
    sees_media : bool
        Whether the integrator of the file does.
    exposure : float
        Factor of all light: what the film makes of a radiance of 1.
    coats : dict
        What takes the place of materials with an inside where none can be, by key path.
    textures, materials : mapping
        What converts textures and materials, by pbrt's name.
    """

    JOINT: ClassVar[str] = " "

    old: bool = False
    sees_media: bool = True
    exposure: float = 1.0
    coats: dict[str, Data] = field(default_factory=dict)
    textures: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    materials: Mapping[str, Callable[[Any], Data]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Open the tables."""
        self.colors = Colors(self.report, self.reach)
        self.tables = {"textures": {}, "bsdfs": {}, "prototypes": {}}
