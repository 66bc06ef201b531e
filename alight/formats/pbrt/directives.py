"""Words -> directives with their parameters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from alight.core.errors import quote, unknown_name
from alight.formats.pbrt.words import BrokenError, Word, Words, number_of

#: Quoted words and numbers that each directive begins with, and whether parameters follow.
#: -1 numbers: 16, mostly in brackets.
SHAPES: dict[str, tuple[int, int, bool]] = {
    "Accelerator": (1, 0, True),
    "ActiveTransform": (0, 0, False),
    "AreaLightSource": (1, 0, True),
    "Attribute": (1, 0, True),
    "AttributeBegin": (0, 0, False),
    "AttributeEnd": (0, 0, False),
    "Camera": (1, 0, True),
    "ColorSpace": (1, 0, False),
    "ConcatTransform": (0, 16, False),
    "CoordSysTransform": (1, 0, False),
    "CoordinateSystem": (1, 0, False),
    "Film": (1, 0, True),
    "Identity": (0, 0, False),
    "Import": (1, 0, False),
    "Include": (1, 0, False),
    "Integrator": (1, 0, True),
    "LightSource": (1, 0, True),
    "LookAt": (0, 9, False),
    "MakeNamedMaterial": (1, 0, True),
    "MakeNamedMedium": (1, 0, True),
    "Material": (1, 0, True),
    "MediumInterface": (1, 0, False),
    "NamedMaterial": (1, 0, False),
    "ObjectBegin": (1, 0, False),
    "ObjectEnd": (0, 0, False),
    "ObjectInstance": (1, 0, False),
    "Option": (0, 0, True),
    "PixelFilter": (1, 0, True),
    "ReverseOrientation": (0, 0, False),
    "Rotate": (0, 4, False),
    "Sampler": (1, 0, True),
    "Scale": (0, 3, False),
    "Shape": (1, 0, True),
    "Texture": (3, 0, True),
    "Transform": (0, 16, False),
    "TransformBegin": (0, 0, False),
    "TransformEnd": (0, 0, False),
    "TransformTimes": (0, 2, False),
    "Translate": (0, 3, False),
    "WorldBegin": (0, 0, False),
    "WorldEnd": (0, 0, False),
}

#: Types of parameters by the names that versions 3 and 4 give them.
KINDS = {
    "blackbody": "blackbody", "bool": "bool", "color": "rgb", "float": "float",
    "integer": "integer", "normal": "normal", "normal3": "normal", "point": "point",
    "point2": "point2", "point3": "point", "rgb": "rgb", "spectrum": "spectrum",
    "string": "string", "texture": "texture", "vector": "vector", "vector2": "vector2",
    "vector3": "vector", "xyz": "xyz",
}  # fmt: skip
_OF_TEXTS = ("string", "texture")
_TRUTHS = {"true": True, "false": False}
MOST_PARAMETERS = 1000


@dataclass(eq=False)
class Parameter:
    """One parameter.

    Attributes
    ----------
    kind : str
        One of the values of `KINDS`.
    name : str
    values : ndarray of float64, or list of str, or list of bool
    place : str
        ``file:line:column``.
    """

    kind: str
    name: str
    values: Any
    place: str

    @property
    def label(self) -> str:
        """The parameter as messages show it."""
        return quote(f"{self.kind} {self.name}")

    @property
    def is_text(self) -> bool:
        """Whether it holds texts."""
        return len(self.values) > 0 and isinstance(self.values[0], str)


@dataclass(eq=False)
class Directive:
    """One directive.

    Attributes
    ----------
    name : str
        The word that it begins with.
    place : str
        ``file:line:column``.
    texts : list of str
        Quoted words before the parameters.
    numbers : (n,) float64
    parameters : list of Parameter
    """

    name: str
    place: str
    texts: list[str] = field(default_factory=list)
    numbers: np.ndarray = field(default_factory=lambda: np.zeros(0))
    parameters: list[Parameter] = field(default_factory=list)

    @property
    def type(self) -> str:
        """What kind of shape, light and so on it asks for."""
        return self.texts[-1] if self.texts else ""

    @property
    def label(self) -> str:
        """The directive as messages show it."""
        return " ".join([self.name, *(quote(text) for text in self.texts)])


def directives(words: Words, broken: list[BrokenError]) -> Iterator[Directive]:
    """Read a file.

    Parameters
    ----------
    words : Words
    broken : list of BrokenError
        Receives what is no directive; reading goes on with the next one.
    """
    while True:
        try:
            word = words.take()
            if word is None:
                return
            directive = _directive(words, word)
        except BrokenError as error:
            broken.append(error)
            if not _skip(words, broken):
                return
            continue
        yield directive


def _skip(words: Words, broken: list[BrokenError]) -> bool:
    """Go on to the next directive; False at the end."""
    while True:
        try:
            word = words.peek()
        except BrokenError as error:
            # A quote that is never closed: the rest is lost.
            broken.append(error)
            return False
        if word is None or (not word.quoted and word.text in SHAPES):
            return word is not None
        words.take()


def _directive(words: Words, word: Word) -> Directive:
    place = words.place(word.at)
    if word.quoted or word.text in "[]" or word.text not in SHAPES:
        text = unknown_name("directive", word.text, SHAPES, listed_as="directives")
        raise BrokenError(text.partition("  (")[0], place)
    text_count, number_count, has_parameters = SHAPES[word.text]
    result = Directive(word.text, place)
    for _ in range(text_count):
        result.texts.append(_text(words, result))
    if word.text == "MediumInterface":
        # A lone name stands for both sides.
        following = words.peek()
        result.texts.append(
            _text(words, result) if following and following.quoted else result.texts[0]
        )
    if word.text == "ActiveTransform":
        following = words.take()
        # The one directive whose argument stands without quotes.
        result.texts.append("" if following is None else following.text)
    if number_count:
        result.numbers = _numbers(words, result, number_count)
    if has_parameters:
        _parameters(words, result)
    return result


def _text(words: Words, directive: Directive) -> str:
    word = words.peek()
    if word is None or not word.quoted:
        found = "the end of the file" if word is None else quote(word.text)
        place = directive.place if word is None else words.place(word.at)
        raise BrokenError(f"{directive.name} needs a text in quotes, got {found}", place)
    words.take()
    return word.text


def _numbers(words: Words, directive: Directive, count: int) -> np.ndarray:
    word = words.peek()
    in_brackets = word is not None and not word.quoted and word.text == "["
    if in_brackets:
        words.take()
    found: list[float] = []
    while len(found) < count:
        word = words.peek()
        number = None if word is None else number_of(word)
        if word is None or number is None:
            got = "the end of the file" if word is None else quote(word.text)
            place = directive.place if word is None else words.place(word.at)
            text = f"{directive.name} needs {count} finite numbers, got {got} as number"
            raise BrokenError(f"{text} {len(found) + 1}", place)
        words.take()
        found.append(number)
    if in_brackets:
        closing = words.take()
        if closing is None or closing.text != "]":
            raise BrokenError(f"{directive.name} needs {count} numbers, got more", directive.place)
    return np.array(found)


def _parameters(words: Words, directive: Directive) -> None:
    names: set[str] = set()
    while True:
        word = words.peek()
        while word is None and words.after is not None:
            # An included file may end within a directive, which goes on behind the Include.
            words = words.after
            word = words.peek()
        if word is None or not word.quoted:
            return
        words.take()
        place = words.place(word.at)
        kind, name = _declaration(word, place)
        if name in names:
            raise BrokenError(f"{quote(name)} is given twice", place)
        if len(names) >= MOST_PARAMETERS:
            raise BrokenError(f"there are more than {MOST_PARAMETERS} parameters", place)
        names.add(name)
        values = _values(words, kind, place, word.text)
        directive.parameters.append(Parameter(kind, name, values, place))


def _declaration(word: Word, place: str) -> tuple[str, str]:
    parts = word.text.split()
    if len(parts) != 2:
        text = f'a parameter must be declared as "type name", got {quote(word.text)}'
        raise BrokenError(text, place)
    if parts[0] not in KINDS:
        text = unknown_name("type of parameter", parts[0], KINDS, listed_as="types")
        raise BrokenError(text, place)
    return KINDS[parts[0]], parts[1]


def _values(words: Words, kind: str, place: str, declared: str) -> Any:
    word = words.take()
    if word is None:
        raise BrokenError(f"{quote(declared)} needs a value, got the end of the file", place)
    if word.quoted or word.text != "[":
        return _checked(words, kind, [word], declared)
    numbers = None if kind in _OF_TEXTS or kind == "bool" else words.take_numbers()
    if numbers is not None:
        return numbers
    found: list[Word] = []
    while True:
        word = words.take()
        if word is None:
            raise BrokenError(f"{quote(declared)}: this list has no closing bracket", place)
        if not word.quoted and word.text == "]":
            return _checked(words, kind, found, declared)
        found.append(word)


def _checked(words: Words, kind: str, found: list[Word], declared: str) -> Any:
    """Turn words into values of their kind."""
    if kind == "bool":
        return [_TRUTHS[_wanted(words, w, w.text in _TRUTHS, "true or false")] for w in found]
    if kind in _OF_TEXTS or (kind == "spectrum" and found and found[0].quoted):
        return [_wanted(words, word, word.quoted, "a text in quotes") for word in found]
    numbers = [number_of(word) for word in found]
    for word, number in zip(found, numbers, strict=True):
        if number is None:
            wanted = "a finite number"
            text = f"{quote(declared)} must be {wanted}, got {quote(word.text)}"
            raise BrokenError(text, words.place(word.at))
    return np.array(numbers, np.float64)


def _wanted(words: Words, word: Word, is_right: bool, wanted: str) -> str:
    if not is_right:
        raise BrokenError(f"must be {wanted}, got {quote(word.text)}", words.place(word.at))
    return word.text
