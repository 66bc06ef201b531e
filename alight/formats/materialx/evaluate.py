"""Nodes -> values: constants folded, textures where alight has them, pictures computed anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any
from weakref import WeakMethod

import numpy as np

from alight.core.errors import quote
from alight.core.uv_sets import MOST_SETS
from alight.formats.materialx.baking import NotBakedError, baked, texels_of
from alight.formats.materialx.nodes import MOST_DEEP, WIDTHS, Input, Node
from alight.formats.materialx.pictures import PATTERNS, as_plain
from alight.formats.materialx.placing import NoPlaceError, Places
from alight.formats.materialx.pointwise import LUMA, POINTWISE, folded
from alight.formats.materialx.protocols import Evaluates, Host
from alight.formats.materialx.rules import RULES
from alight.formats.materialx.spaces import SPACES, to_linear
from alight.formats.materialx.values import (
    Plain,
    Value,
    Varying,
    alpha_of,
    channels_of,
    is_positive,
    limited,
    part,
    parts_of,
    positive,
    spread,
    textured,
)
from alight.formats.reading.report import did_you_mean

#: Textures that a value is made of: a material takes 64, and adds some of its own.
MOST_PARTS = 20
#: Texels that are computed anew for a material: 12 bytes each.
MOST_COMPUTED = 2**25
#: Nodes whose fourth channel is that of their first input.
_OF_COLORS = ("colorcorrect", "hsvadjust", "hsvtorgb", "luminance", "rgbtohsv", "saturate")
#: Defaults of inputs that are colours, of those nodes.
_COLORS = (LUMA, (0.0, 1.0, 1.0))
_INDICES = {"r": 0, "g": 1, "b": 2, "a": 3, "x": 0, "y": 1, "z": 2, "w": 3}


class Evaluator:
    """Evaluates the network of one material.

    Parameters
    ----------
    host : Host

    Attributes
    ----------
    sets : list of str
        Names of the sets of coordinates of all textures so far, each once.
    """

    def __init__(self, host: Host) -> None:
        self.host = host
        self.sets: list[str] = []
        # In a cycle the host's stage would outlive its reader, and another one might be open then.
        self.places = Places(host.coordinates, host.set_name, WeakMethod(self.value))
        self._known: dict[tuple[int, str], Value] = {}
        self._open: list[Node] = []
        self._computed = 0

    def say(self, node: Node, text: str) -> None:
        """Remark on what is not quite what a node says."""
        self.host.report.approximate(f"{node.place}: {node.name}: {text}")

    def value(self, node: Node, name: str, default: Any) -> Value:
        """The value of an input of a node."""
        entry = node.inputs.get(name)
        if entry is None:
            return Plain(as_plain(default))
        if entry.source is not None:
            return self._converted(entry)
        if entry.value is None or isinstance(entry.value, str):
            return Plain(as_plain(default))
        numbers = as_plain(entry.value)
        if entry.kind.startswith("color") and entry.space not in SPACES:
            text = f"{name}: colour space {quote(entry.space)} is not covered"
            self.say(node, f"{text}: taken for linear Rec. 709")
        if entry.kind.startswith("color") and SPACES.get(entry.space, "linear") != "linear":
            linear = to_linear(np.array([numbers[:3]]), entry.space)[0].tolist()
            numbers = (*linear, *numbers[3:])
        return Plain(numbers)

    def _converted(self, entry: Input) -> Value:
        assert entry.source is not None
        value = self.output(entry.source, entry.output)
        width = WIDTHS.get(entry.kind, 0)
        return spread(value, width) if width and channels_of(value) > width else value

    def output(self, node: Node, name: str) -> Value:
        """The value of an output of a node."""
        key = (id(node), name)
        if key not in self._known:
            if node in self._open or len(self._open) >= MOST_DEEP:
                text = "contains itself" if node in self._open else f"is {MOST_DEEP} nodes deep"
                self.host.report.problem(node.place, node.name, text)
                return Plain((0.0,) * WIDTHS.get(node.kind, 3))
            self._open.append(node)
            try:
                self._known[key] = self._small(node, self._evaluated(node, name))
            finally:
                self._open.pop()
        return self._known[key]

    def _small(self, node: Node, value: Value) -> Value:
        """A value of a few textures: of more, one picture is computed."""
        if isinstance(value, Plain) or parts_of(value.texture, MOST_PARTS) <= MOST_PARTS:
            return value
        kept = spread(value, min(value.width, 3))
        instead = Plain((0.5,) * value.width)
        found = self.computed(node, lambda x: x, [kept], instead, value.width)
        return replace(found, alpha=value.alpha) if isinstance(found, Varying) else found

    def _evaluated(self, node: Node, output: str) -> Value:
        if node.category in PATTERNS:
            found = PATTERNS[node.category](self, node)
            index = _INDICES.get(output) if node.category == "UsdUVTexture" else None
            return found if index is None else part(found, index)
        if node.category in ("separate2", "separate3", "separate4"):
            whole = self.value(node, "in", (0.0,) * 4)
            return part(whole, _INDICES.get(output.removeprefix("out"), 0))
        if node.category in _SHAPED:
            return _SHAPED[node.category](self, node)
        if node.category in POINTWISE:
            return self._pointwise(node)
        return self._unknown(node)

    def _unknown(self, node: Node) -> Value:
        known = sorted([*PATTERNS, *_SHAPED, *POINTWISE])
        hint = did_you_mean(node.category, known)
        text = f"node {quote(node.category)} is not covered{hint}"
        inputs = [name for name in ("in", "in1", "fg", "default") if name in node.inputs]
        if inputs:
            self.say(node, f"{text}: its input {inputs[0]} is taken")
            return spread(self.value(node, inputs[0], (0.0,)), WIDTHS.get(node.kind, 3))
        self.say(node, f"{text}: 0.5 is taken")
        return Plain((0.5,) * WIDTHS.get(node.kind, 3))

    def _pointwise(self, node: Node) -> Value:
        _, arguments = POINTWISE[node.category]
        values = [self.value(node, name, default) for name, default in arguments]
        width = WIDTHS.get(node.kind, max(channels_of(v) for v in values))
        return self._applied(node, node.category, values, width)

    def _applied(self, node: Node, category: str, values: list[Value], width: int) -> Value:
        function, arguments = POINTWISE[category]
        if category in _OF_COLORS:
            widths = [3 if i == 0 or default in _COLORS else 1 for i, (_, default) in
                      enumerate(arguments)]  # fmt: skip
            widths[0] = max(channels_of(values[0]), 3)
        else:
            widths = [max(channels_of(v) for v in values)] * len(values)
        values = [
            v if v.width == 1 and category not in _OF_COLORS else spread(v, w)
            for v, w in zip(values, widths, strict=True)
        ]
        plain = [v for v in values if isinstance(v, Plain)]
        if len(plain) == len(values):
            return _folded(category, function, plain, width)
        rule = RULES.get(category)
        found = None if rule is None else rule(self, node, values, width)
        if found is not None:
            return found
        found = self.computed(node, function, values, values[0], width)
        if width == 4 and isinstance(found, Varying) and category not in (*_OF_COLORS, "normalize"):
            alphas = [v if v.width == 1 else alpha_of(v) for v in values]
            return replace(found, alpha=self.apply(node, category, *alphas))
        return found

    def computed(
        self,
        node: Node,
        function: Callable[..., Any],
        values: list[Value],
        instead: Value,
        width: int | None = None,
    ) -> Value:
        """A picture computed anew; another value where that cannot be, with a remark."""
        width = instead.width if width is None else width
        colors = [spread(v, min(v.width, 3)) if v.width > 1 else v for v in values]
        try:
            if self._computed > MOST_COMPUTED:
                raise NotBakedError("its material has computed enough pictures")
            found: Value = baked(function, colors, self.host.files, width)
            self._computed += texels_of(found.texture)
        except NotBakedError as error:
            taken = "0.5" if isinstance(instead, Plain) else "its first input"
            text = f"{quote(node.category)} is left out: {error}; {taken} is taken"
            self.say(node, text)
            return spread(instead, width)
        if width == 4 and isinstance(found, Varying):
            return replace(found, alpha=alpha_of(values[0]))
        if width == 2:
            return spread(found, 2)
        return found

    def mixed(self, node: Node, low: Value, high: Value, share: Value) -> Value:
        """Low where the share is 0, high where it is 1."""
        return self.apply(node, "mix", high, low, share)

    def apply(self, node: Node, category: str, *values: Value) -> Value:
        """What a node of a category would make of its first inputs."""
        _, arguments = POINTWISE[category]
        rest = [Plain(as_plain(default)) for _, default in arguments[len(values) :]]
        width = max(channels_of(v) for v in values)
        return self._applied(node, category, [*values, *rest], width)

    def constant(self, node: Node, value: Value, width: int) -> tuple[float, ...]:
        """The numbers of what must not vary."""
        if isinstance(value, Varying):
            self.say(node, "a number that varies is taken as 1")
            return (1.0,) * width
        numbers = spread(value, width)
        assert isinstance(numbers, Plain)
        return numbers.numbers

    def set_number(self, node: Node, name: str) -> int:
        """The number of a set of coordinates by its name."""
        if name not in self.sets:
            if len(self.sets) == MOST_SETS:
                text = f"{name} is one set of coordinates too many; {self.sets[0]} is used"
                self.say(node, text)
                return 0
            self.sets.append(name)
        return self.sets.index(name)

    def described(self, node: Node, name: str, value: Value, high: float = 1.0) -> Any:
        """A value as a number, a colour or a texture of the native format, in [0, high]."""
        if isinstance(value, Plain):
            numbers = [min(max(n, 0.0), min(high, 1e30)) for n in value.numbers[:3]]
            if numbers != list(value.numbers[:3]):
                text = f"{name} was cut to {f'[0, {high:g}]' if high < 1e30 else 'at least 0'}"
                self.say(node, text)
            return numbers[0] if value.width == 1 else (numbers * 3)[:3]
        if not is_positive(value):
            value = self.floored(node, name, value)
        if max(top for _, top in value.ends) > high * (1.0 + 1e-6) and value.most <= 1.0:
            top = max(top for _, top in value.ends)
            self.say(node, f"{name} may reach {top:g}: it is cut at {high:g}")
        return limited(value, high)

    def floored(self, node: Node, name: str, value: Varying) -> Varying:
        """A value cut at 0."""
        try:
            kept = spread(value, min(value.width, 3))
            width = kept.width
            found = baked(lambda x: np.maximum(x, 0.0), [kept], self.host.files, width)
        except NotBakedError:
            low = min(low for low, _ in value.ends)
            self.say(node, f"{name} begins at {low:g}: it is moved up to 0")
            pairs = zip(value.factor, value.offset, strict=True)
            ends = [(max(o, 0.0), max(o + f, 0.0)) for f, o in pairs]
            factor, offset = (b - a for a, b in ends), (a for a, _ in ends)
            return replace(value, factor=tuple(factor), offset=tuple(offset), most=1.0)
        return found


def _folded(category: str, function: Any, values: list[Plain], width: int) -> Value:
    """What a node makes of numbers."""
    if category in _OF_COLORS and width == 4:
        alpha = alpha_of(values[0])
        numbers = folded(function, [v.numbers[:3] for v in values])
        return Plain((*numbers, alpha.offset[0]))
    numbers = folded(function, [v.numbers for v in values])
    return spread(Plain(numbers), width) if len(numbers) == 1 else Plain(numbers[:width])


def _converted(e: Evaluates, node: Node) -> Value:
    return spread(e.value(node, "in", (0.0,)), WIDTHS.get(node.kind, 3))


def _passed(e: Evaluates, node: Node) -> Value:
    return e.value(node, "in", (0.0,) * WIDTHS.get(node.kind, 3))


def _combined(e: Evaluates, node: Node) -> Value:
    """One value of several."""
    count = int(node.category[-1])
    values = [e.value(node, f"in{i + 1}", (0.0,)) for i in range(count)]
    width = WIDTHS.get(node.kind, count)
    sizes = [1] * count
    if width > count:
        # Four of two: the second has what the first lacks.
        first = values[0].width if "in1" in node.inputs else width - values[1].width
        sizes = [min(max(first, 1), 3), width]
    parts = [part(v, i) for v, size in zip(values, sizes, strict=True) for i in range(size)]
    parts = (parts + [Plain((0.0,))] * 4)[:width]
    return joined(e, node, parts)


def joined(e: Evaluates, node: Node, parts: list[Value]) -> Value:
    """One value of its channels."""
    if all(isinstance(p, Plain) for p in parts):
        return Plain(tuple(p.offset[0] for p in parts))
    colors, alpha = parts[:3], parts[3] if len(parts) > 3 else None
    varying = [p for p in colors if isinstance(p, Varying)]
    if not varying:
        # Only the fourth channel varies.
        flat = {"type": "constant", "color": [0.0] * 3}
        numbers = tuple(p.offset[0] for p in colors)
        return Varying(flat, (0.0,) * 3, numbers, 1.0, alpha)
    wholes = [_whole(p, i) for i, p in enumerate(colors)]
    if wholes[0] is not None and all(w == wholes[0] for w in wholes):
        texture, grey = wholes[0], False
    elif all(p.texture == varying[0].texture for p in varying):
        texture, grey = varying[0].texture, True
    else:
        return _summed(e, node, colors, alpha)
    factor = tuple(p.factor[0] for p in colors)
    offset = tuple(p.offset[0] for p in colors)
    return Varying(texture, factor, offset, max(p.most for p in varying), alpha, grey)


def _whole(value: Value, index: int) -> Any:
    """The texture whose channel of that index a value is."""
    texture = value.texture if isinstance(value, Varying) else {}
    if texture.get("type") == "channel" and texture["channel"] == "rgb"[index]:
        return texture["texture"]
    return None


def _summed(e: Evaluates, node: Node, colors: list[Value], alpha: Value | None) -> Value:
    """A colour of textures that have nothing to do with each other."""
    total: Any = None
    most = 0.0
    for i, value in enumerate(colors):
        mask = [float(i == k) for k in range(3)]
        if isinstance(value, Varying):
            kept = value if is_positive(value) else e.floored(node, "a channel", value)
            term: Any = {"type": "multiply", "a": mask, "b": positive(kept)}
            most = max(most, kept.ends[0][1])
        else:
            term = [m * max(value.numbers[0], 0.0) for m in mask]
            most = max(most, value.numbers[0])
        total = term if total is None else {"type": "add", "a": total, "b": term}
    return replace(textured(total, len(colors), most, alpha), is_grey=False)


def _swizzled(e: Evaluates, node: Node) -> Value:
    """``swizzle`` of 1.38: channels by their letters."""
    value = e.value(node, "in", (0.0,) * 4)
    letters = str(node.plain("channels", "")) or "rgba"[: WIDTHS.get(node.kind, 3)]
    parts: list[Value] = [
        Plain((float(c),)) if c in "01" else part(value, _INDICES.get(c, 0)) for c in letters
    ]
    return parts[0] if len(parts) == 1 else joined(e, node, parts)


def _switched(e: Evaluates, node: Node) -> Value:
    width = WIDTHS.get(node.kind, 3)
    try:
        which = int(e.places.numbers(node, "which", (0.0,))[0])
    except NoPlaceError:
        e.say(node, "which of its inputs it shows varies: the first one is taken")
        which = 0
    return spread(e.value(node, f"in{which + 1}", (0.0,) * width), width)


def _premultiplied(e: Evaluates, node: Node) -> Value:
    value = e.value(node, "in", (0.0, 0.0, 0.0, 1.0))
    category = "multiply" if node.category == "premult" else "divide"
    colors = e.apply(node, category, spread(value, 3), alpha_of(value))
    if isinstance(colors, Varying):
        return replace(colors, alpha=alpha_of(value))
    return Plain((*colors.numbers, alpha_of(value).offset[0]))


_SHAPED: dict[str, Callable[[Evaluates, Node], Value]] = {
    "combine2": _combined,
    "combine3": _combined,
    "combine4": _combined,
    "convert": _converted,
    "dot": _passed,
    "premult": _premultiplied,
    "switch": _switched,
    "swizzle": _swizzled,
    "unpremult": _premultiplied,
}
#: All nodes that give values.
COVERED = (*PATTERNS, "separate2", "separate3", "separate4", *_SHAPED, *POINTWISE)
