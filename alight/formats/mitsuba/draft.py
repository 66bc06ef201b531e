"""A description of the native format in the making, from the parameters of one element."""

from __future__ import annotations

from typing import Any

from alight.core.errors import join_path
from alight.formats.mitsuba.colors import Role
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.properties import Properties
from alight.formats.reading.xml import Element


class Draft:
    """Collects the keys of a description.

    Parameters
    ----------
    context : Context
    element : Element
        What it is made from.
    path : str
        Its key path.
    type_name : str, optional
        Of the native model.
    """

    def __init__(
        self, context: Context, element: Element, path: str, type_name: str | None = None
    ) -> None:
        self.context = context
        self.element = element
        self.path = path
        self.properties = Properties(element, context.report)
        self.data: Data = {} if type_name is None else {"type": type_name}
        context.places[path] = element.place

    def put(self, key: str, value: Any, name: str | None = None) -> None:
        """Set a key; None leaves the native default."""
        if value is None:
            return
        self.data[key] = value
        source = self.properties.named.get(name or key, self.element)
        self.context.places[join_path(self.path, key)] = source.place

    def number(self, key: str, default: float | None = None, name: str | None = None) -> None:
        """Set a key to a number."""
        self.put(key, self.properties.number(name or key, default), name)

    def color(
        self, key: str, default: float | None = None, name: str | None = None, role: Role = "light"
    ) -> None:
        """Set a key to a colour."""
        element = self.properties.find(name or key)
        color = None if element is None else self.context.colors.read(element, role)
        if color is None and default is not None:
            color = [default] * 3
        self.put(key, color, name)
