"""What the browser and the server say to each other, over one WebSocket.

**From the browser**: one JSON object a message, with ``do`` and exactly the keys of that word.
Lengths are shares of the height of the picture, right and down positive; angles are radians;
``x`` and ``y`` of pixels are whole numbers from the upper left corner of the picture.

::

    {"do": "orbit", "x": 0.1, "y": 0}       turn about the pivot
    {"do": "pan", "x": 0.1, "y": 0}         move across the view, with what is at the pivot
    {"do": "dolly", "by": 0.1}              towards the pivot, by this share of the distance
    {"do": "fly", "right": 0, "up": 0, "ahead": 0.1}    by shares of the distance to the pivot
    {"do": "roll", "by": 0.1}               about the view, clockwise
    {"do": "widen", "by": 0.1}              the field of view, by this share
    {"do": "rest"}                          the camera has come to rest
    {"do": "pivot", "x": 3, "y": 4}         put the pivot on what this pixel shows
    {"do": "focus", "x": 3, "y": 4}         put the plane of focus there
    {"do": "camera", "name": "cameras/top"} one of the scene's cameras; "" is the first one
    {"do": "show", "layer": "error"}        a layer
    {"do": "develop", "exposure": 0, "tone_map": "none", "white_balance": "none"}
    {"do": "denoise", "on": true}           when the picture rests
    {"do": "contrast", "way": "difference"} how it is compared with the other picture
    {"do": "pixel", "x": 3, "y": 4}         ask for the values of a pixel
    {"do": "trace", "x": 3, "y": 4, "sample": 0}     one path through a pixel
    {"do": "why", "x": 3, "y": 4, "width": 9, "height": 9}       why a region is noisy
    {"do": "region", "x": 3, "y": 4, "width": 9, "height": 9}    render this part only
    {"do": "whole"}                         render the whole picture again
    {"do": "keep"}                          keep this picture, to compare with
    {"do": "drop"}                          compare no more
    {"do": "more"}                          twice the samples per pixel
    {"do": "stop"}                          end the render here
    {"do": "tree"}                          ask for the parts of the scene
    {"do": "fields", "item": "bsdfs.ball"}  ask for what can be changed of one
    {"do": "edit", "item": "bsdfs.ball", "path": "bsdfs.ball.alpha", "value": "0.2"}    JSON
    {"do": "add step", "item": "nodes.ball", "step": "translate"}    to its transform
    {"do": "undo"}                          take back the last edit
    {"do": "redo"}                          make it again
    {"do": "command"}                       ask for the command that renders this picture

**From the server**: JSON objects with ``is``: ``state`` (everything that the page shows around the
picture; see `alight.view.session.Session.state`); answers to the one that asked: ``pixel``,
``trace``, ``why`` (`alight.view.inspection`), ``focus`` (``distance``, or ``why`` not),
``command`` (``text`` and ``notes``, or ``why`` there is none), ``tree``, ``fields``, ``edited``,
``wrong`` (a value that a scene cannot have: ``path`` and ``why``) and ``refused`` (with ``why``,
for a message that is none of the above). Binary messages are frames: four little-endian uint32
(which picture: 0 or, of what is compared with or of how both differ, 1; width; height; number of
the view), then RGBA bytes, the top row first. Of frames and states only the newest is sent to a
browser that cannot keep up.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, fields
from typing import Any, ClassVar

#: Characters of the longest message.
LONGEST = 4096

#: Largest length, angle or share, and largest coordinate of a pixel.
LARGEST, FARTHEST = 1e3, 2**28


class RefusedError(ValueError):
    """A message that is not one of the protocol; its text says why."""


@dataclass(frozen=True)
class Event:
    """What the browser asks for; the fields are the keys of the message."""

    word: ClassVar[str]


@dataclass(frozen=True)
class Orbit(Event):
    """Turn about the pivot."""

    word = "orbit"
    x: float
    y: float


@dataclass(frozen=True)
class Pan(Event):
    """Move across the view."""

    word = "pan"
    x: float
    y: float


@dataclass(frozen=True)
class Dolly(Event):
    """Move towards the pivot."""

    word = "dolly"
    by: float


@dataclass(frozen=True)
class Fly(Event):
    """Move freely."""

    word = "fly"
    right: float
    up: float
    ahead: float


@dataclass(frozen=True)
class Roll(Event):
    """Turn about the view."""

    word = "roll"
    by: float


@dataclass(frozen=True)
class Widen(Event):
    """Change the field of view."""

    word = "widen"
    by: float


@dataclass(frozen=True)
class Rest(Event):
    """The camera has come to rest."""

    word = "rest"


@dataclass(frozen=True)
class Pivot(Event):
    """Put the pivot on what a pixel shows."""

    word = "pivot"
    x: int
    y: int


@dataclass(frozen=True)
class ChooseCamera(Event):
    """Look through one of the scene's cameras."""

    word = "camera"
    name: str


@dataclass(frozen=True)
class Show(Event):
    """Show a layer."""

    word = "show"
    layer: str


@dataclass(frozen=True)
class Develop(Event):
    """Show linear values in another way."""

    word = "develop"
    exposure: float
    tone_map: str
    white_balance: str


@dataclass(frozen=True)
class Denoise(Event):
    """Show the picture denoised when it rests, or as it is."""

    word = "denoise"
    on: bool


@dataclass(frozen=True)
class Contrast(Event):
    """Compare in another way."""

    word = "contrast"
    way: str


@dataclass(frozen=True)
class AskPixel(Event):
    """Ask for the values of a pixel."""

    word = "pixel"
    x: int
    y: int


@dataclass(frozen=True)
class AskTrace(Event):
    """Ask for one path through a pixel."""

    word = "trace"
    x: int
    y: int
    sample: int


@dataclass(frozen=True)
class AskWhy(Event):
    """Ask why a region is noisy."""

    word = "why"
    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class Region(Event):
    """Render this part only."""

    word = "region"
    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class Whole(Event):
    """Render the whole picture again."""

    word = "whole"


@dataclass(frozen=True)
class Keep(Event):
    """Keep this picture, to compare with."""

    word = "keep"


@dataclass(frozen=True)
class Drop(Event):
    """Compare no more."""

    word = "drop"


@dataclass(frozen=True)
class More(Event):
    """Twice the samples per pixel."""

    word = "more"


@dataclass(frozen=True)
class Stop(Event):
    """End the render here."""

    word = "stop"


@dataclass(frozen=True)
class AskTree(Event):
    """Ask for the parts of the scene."""

    word = "tree"


@dataclass(frozen=True)
class AskFields(Event):
    """Ask for what can be changed of a part."""

    word = "fields"
    item: str


@dataclass(frozen=True)
class Edit(Event):
    """Change a value of the scene; it is given as JSON."""

    word = "edit"
    item: str
    path: str
    value: str


@dataclass(frozen=True)
class AddStep(Event):
    """Append a step to a transform."""

    word = "add step"
    item: str
    step: str


@dataclass(frozen=True)
class Undo(Event):
    """Take back the last edit."""

    word = "undo"


@dataclass(frozen=True)
class Redo(Event):
    """Make it again."""

    word = "redo"


@dataclass(frozen=True)
class Focus(Event):
    """Put the plane of focus through what a pixel shows."""

    word = "focus"
    x: int
    y: int


@dataclass(frozen=True)
class AskCommand(Event):
    """Ask for the command line that renders the picture."""

    word = "command"


#: Words that move the camera.
MOVES = (Orbit, Pan, Dolly, Fly, Roll, Widen)

#: Words about the scene itself.
OF_THE_SCENE = (ChooseCamera, AskTree, AskFields, Edit, AddStep, Undo, Redo, Region, Whole)

#: Words whose answers take long: others do not wait for them.
SLOW = (AskTrace, AskWhy, Focus, AskCommand)

EVENTS: dict[str, type[Event]] = {
    event.word: event
    for event in (
        *MOVES, *OF_THE_SCENE, *SLOW, Rest, Pivot, Show, Develop, Denoise, Contrast, AskPixel, Keep,
        Drop, More, Stop,
    )
}  # fmt: skip


def parse(text: str) -> Event:
    """Read a message of the browser.

    Raises
    ------
    RefusedError
        If it is longer than `LONGEST`, no JSON object, of an unknown word, or of wrong keys or
        values.
    """
    if len(text) > LONGEST:
        raise RefusedError(f"messages have at most {LONGEST} characters, got {len(text)}")
    try:
        message = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError):
        raise RefusedError("this is no JSON") from None
    if not isinstance(message, dict):
        raise RefusedError("a message must be an object")
    word = message.pop("do", None)
    if not isinstance(word, str) or word not in EVENTS:
        raise RefusedError(f"do must be one of {', '.join(EVENTS)}")
    event = EVENTS[word]
    wanted = {one.name: str(one.type) for one in fields(event)}
    if set(message) != set(wanted):
        raise RefusedError(f"{word} has the keys {', '.join(wanted) or 'of no value'}")
    return event(**{name: _checked(name, message[name], kind) for name, kind in wanted.items()})


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


def _checked(name: str, value: Any, kind: str) -> Any:
    """Give a value of a message as its field has it; `kind` is the name of its type."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if kind == "float" and number and abs(value) <= LARGEST and math.isfinite(value):
        return float(value)
    if kind == "int" and number and isinstance(value, int) and 0 <= value < FARTHEST:
        return value
    if kind == "bool" and isinstance(value, bool):
        return value
    if kind == "str" and isinstance(value, str):
        return value
    ranges = {
        "float": f"a number in [-{LARGEST:g}, {LARGEST:g}]",
        "int": "a whole number >= 0", "str": "a text", "bool": "true or false",
    }  # fmt: skip
    raise RefusedError(f"{name} must be {ranges[kind]}")
