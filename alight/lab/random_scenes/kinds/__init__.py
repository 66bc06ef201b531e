"""Kinds of random scenes, one a file: they differ in where their noise is.

A new kind is one file with a function `build`, and one line here. The first line of its docstring
is what ``alight scene random --kind list`` shows.
"""

from __future__ import annotations

from types import ModuleType

from alight.lab.random_scenes.kinds import (
    caustic,
    door,
    fog,
    heap,
    landscape,
    many_lamps,
    moving,
    room,
    street,
    studio,
    tabletop,
    textures,
    window,
)

#: By name, in the order of help.
KINDS: dict[str, ModuleType] = {
    "room": room,
    "window": window,
    "door": door,
    "landscape": landscape,
    "studio": studio,
    "tabletop": tabletop,
    "textures": textures,
    "many-lamps": many_lamps,
    "street": street,
    "caustic": caustic,
    "fog": fog,
    "heap": heap,
    "moving": moving,
}


def summary(kind: str) -> str:
    """What there is to see in a kind of scene, in a line."""
    return (KINDS[kind].__doc__ or "").splitlines()[0]
