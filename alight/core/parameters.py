"""Rows of tables as records: a model names its parameters, and kernels read them by these names.

.. code-block:: python

    class Params(NamedTuple):
        diffuse: TexturedColor
        exponent: TexturedScalar


    SLOTS = slots_of(Params)
    load = loader(Params)

A row of the table then holds the numbers of all fields, one after another, and ``load(scene, base,
surface)`` is the record of the row that begins at `base`. Fields that a kernel does not use are not
in its machine code.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from alight.core.registry import Kernel
from lanewise.jit import kernel


@dataclass(frozen=True)
class Slots:
    """Metadata of a field: how it lies in a row, and how it is read.

    Attributes
    ----------
    read : kernel ``(scene, slot, surface) -> value``
        Reads it from where its slots begin.
    widths : int or mapping of str to int, default 1
        How many slots; if they have several names, that of each.
    """

    read: Kernel
    widths: int | Mapping[str, int] = 1


def _fields(record: type, names: dict[str, Any]) -> dict[str, Slots]:
    """The metadata of all fields: annotations are texts, with names of the record's file.

    A notebook's or script's that cannot be imported has those of the caller.
    """
    known = vars(sys.modules[record.__module__]) if record.__module__ in sys.modules else names
    hints = get_type_hints(record, known, include_extras=True)
    return {
        name: next(item for item in hints[name].__metadata__ if isinstance(item, Slots))
        for name in record._fields  # pyright: ignore[reportAttributeAccessIssue]
    }


def slots_of(record: type) -> dict[str, int]:
    """Names and widths of the slots of a row, in their order.

    Parameters
    ----------
    record : class
        A named tuple whose fields are annotated with `Slots`.
    """
    slots: dict[str, int] = {}
    for name, field in _fields(record, sys._getframe(1).f_globals).items():
        slots |= {name: field.widths} if isinstance(field.widths, int) else field.widths
    return slots


def _readers(record: type, names: dict[str, Any]) -> dict[str, tuple[Kernel, int]]:
    """How to read each field, and where in the row."""
    found, start = {}, 0
    for name, field in _fields(record, names).items():
        found[name] = field.read, start
        width = field.widths
        start += width if isinstance(width, int) else sum(width.values())
    return found


def loader(record: type) -> Kernel:
    """Write the kernel ``(scene, base, surface) -> record`` that reads a whole row."""
    readers = _readers(record, sys._getframe(1).f_globals)
    # As text, because kernels take no loops over fields of different types.
    values = [
        f"read_{name}(scene, base + {start}, surface)" for name, (_, start) in readers.items()
    ]
    text = f"def load(scene, base, surface):\n    return record({', '.join(values)})\n"
    scope: dict[str, Any] = {f"read_{name}": read for name, (read, _) in readers.items()}
    scope |= {"record": record, "__name__": record.__module__}
    exec(compile(text, f"<row of {record.__module__}.{record.__qualname__}>", "exec"), scope)
    load = scope["load"]
    load.__doc__ = "The parameters at a point of a surface."
    return kernel(load)


def reader(record: type, name: str) -> Kernel:
    """Write the kernel ``(scene, base, surface) -> value`` that reads one field of a row."""
    read, start = _readers(record, sys._getframe(1).f_globals)[name]

    @kernel
    def read_field(scene, base, surface):
        return read(scene, base + start, surface)

    return read_field
