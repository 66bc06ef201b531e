"""Nodes that textures of alight compute, for values that are not the same everywhere.

A rule gives None where it does not apply; the node is then computed texel by texel.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from alight.formats.materialx.nodes import Node
from alight.formats.materialx.protocols import Evaluates
from alight.formats.materialx.values import (
    Plain,
    Value,
    Varying,
    affine,
    alpha_of,
    is_positive,
    limited,
    positive,
    spread,
    textured,
)


def _numbers(value: Value, width: int) -> tuple[float, ...]:
    found = spread(value, width)
    assert isinstance(found, Plain)
    return found.numbers


def _by_channels(
    e: Evaluates, node: Node, rule: Any, values: list[Value], width: int
) -> Value | None:
    """A rule for colours and their alphas apart."""
    colors = rule(e, node, [spread(v, 3) for v in values], 3)
    alphas = [alpha_of(v) if v.width != 1 else v for v in values]
    alpha = rule(e, node, alphas, 1)
    if alpha is None and all(isinstance(a, Plain) for a in alphas):
        alpha = e.apply(node, node.category, *alphas)
    if not isinstance(colors, Varying) or alpha is None:
        return None
    return Varying(colors.texture, colors.factor, colors.offset, colors.most, alpha, colors.is_grey)


def add(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A sum with numbers, or of two textures."""
    a, b = values
    if isinstance(a, Plain) and isinstance(b, Plain):
        return None
    if width == 4:
        return _by_channels(e, node, add, values, width)
    for first, second in ((a, b), (b, a)):
        if isinstance(second, Plain) and isinstance(first, Varying):
            return affine(spread(first, width), (1.0,) * width, _numbers(second, width))
    return _both(a, b, width, "add")


def subtract(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A difference from numbers, or numbers minus a texture."""
    a, b = values
    if width == 4 or isinstance(a, Plain) == isinstance(b, Plain):
        return None
    if isinstance(b, Plain):
        less = tuple(-n for n in _numbers(b, width))
        return affine(spread(a, width), (1.0,) * width, less)
    return affine(spread(b, width), (-1.0,) * width, _numbers(a, width))


def multiply(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A product with numbers, or of two textures."""
    a, b = values
    if isinstance(a, Plain) and isinstance(b, Plain):
        return None
    if width == 4:
        return _by_channels(e, node, multiply, values, width)
    for first, second in ((a, b), (b, a)):
        if isinstance(second, Plain) and isinstance(first, Varying):
            return affine(spread(first, width), _numbers(second, width), (0.0,) * width)
    return _both(a, b, width, "multiply")


def divide(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A texture over numbers."""
    a, b = values
    if isinstance(a, Plain) or isinstance(b, Varying) or width == 4:
        return None
    numbers = _numbers(b, width)
    if 0.0 in numbers:
        return None
    return affine(spread(a, width), tuple(1.0 / n for n in numbers), (0.0,) * width)


def _both(a: Value, b: Value, width: int, operation: str) -> Value | None:
    pair = [spread(v, width) for v in (a, b)]
    varying = [v for v in pair if isinstance(v, Varying)]
    if len(varying) < 2 or not all(is_positive(v) for v in varying):
        return None
    tops = [max(top for _, top in v.ends) for v in varying]
    most = tops[0] * tops[1] if operation == "multiply" else tops[0] + tops[1]
    data = {"type": operation, "a": positive(varying[0]), "b": positive(varying[1])}
    return textured(data, width, most)


def mix(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """From the second to the first, by the third."""
    high, low, share = values
    if all(isinstance(v, Plain) for v in values):
        return None
    if width == 4:
        return _by_channels(e, node, mix, values, width)
    if isinstance(share, Plain):
        part = _numbers(share, width)
        rest = tuple(1.0 - p for p in part)
        a = e.apply(node, "multiply", spread(high, width), Plain(part))
        b = e.apply(node, "multiply", spread(low, width), Plain(rest))
        return add(e, node, [a, b], width)
    if share.width > 1 and not share.is_grey:
        rest = affine(share, (-1.0,) * share.width, (1.0,) * share.width)
        terms = [multiply(e, node, list(p), width) for p in ((high, share), (low, rest))]
        if terms[0] is None or terms[1] is None:
            return None
        return add(e, node, [terms[0], terms[1]], width)
    if isinstance(high, Plain) and isinstance(low, Plain):
        ends = _numbers(low, width), _numbers(high, width)
        span = tuple(b - a for a, b in zip(*ends, strict=True))
        return affine(spread(share, width), span, ends[0])
    grey = spread(share, 1)
    assert isinstance(grey, Varying)
    texture = [_texture(spread(v, width)) for v in (low, high)]
    if texture[0] is None or texture[1] is None or not is_positive(grey):
        return None
    tops = [_top(v) for v in (low, high)]
    data = {"type": "mix", "a": texture[0], "b": texture[1], "weight": limited(grey, 1.0)}
    return textured(data, width, max(tops))


def _texture(value: Value) -> Any:
    if isinstance(value, Plain):
        if min(value.numbers) < 0.0:
            return None
        return value.numbers[0] if value.width == 1 else ([*value.numbers] * 3)[:3]
    return positive(value) if is_positive(value) else None


def _top(value: Value) -> float:
    return max(value.numbers) if isinstance(value, Plain) else max(top for _, top in value.ends)


def invert(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A number minus a texture."""
    return subtract(e, node, values, width)


def contrast(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A texture stretched about a number."""
    value, amount, pivot = values
    if isinstance(value, Plain) or width == 4:
        return None
    if isinstance(amount, Varying) or isinstance(pivot, Varying):
        return None
    factor, center = _numbers(amount, width), _numbers(pivot, width)
    moved = tuple(c - f * c for f, c in zip(factor, center, strict=True))
    return affine(spread(value, width), factor, moved)


def remap(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A texture from one interval to another."""
    value, *ends = values
    plain = [v for v in ends if isinstance(v, Plain)]
    if isinstance(value, Plain) or len(plain) < 4 or width == 4:
        return None
    rows = list(zip(*(_numbers(v, width) for v in plain), strict=True))
    if any(a == b for a, b, _, _ in rows):
        return None
    factor = tuple((d - c) / (b - a) for a, b, c, d in rows)
    moved = tuple(c - a * f for (a, _, c, _), f in zip(rows, factor, strict=True))
    return affine(spread(value, width), factor, moved)


def range_of(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """``range`` without gamma and clamping is a ``remap``."""
    value, low, high, gamma, out_low, out_high, clamped = values
    same = isinstance(gamma, Plain) and set(gamma.numbers) == {1.0}
    if not same or not isinstance(clamped, Plain) or clamped.numbers[0] != 0.0:
        return None
    return remap(e, node, [value, low, high, out_low, out_high], width)


def clamp(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A texture that stays within its limits, or is cut above."""
    value, low, high = values
    if isinstance(value, Plain) or isinstance(low, Varying) or isinstance(high, Varying):
        return None
    least, most = max(_numbers(low, 1)), _numbers(high, width)
    if min(bottom for bottom, _ in value.ends) < least:
        return None
    if max(top for _, top in value.ends) <= min(most):
        return spread(value, width)
    if len(set(most)) > 1 or not is_positive(value) or width == 4:
        return None
    return textured(limited(value, most[0]), width, most[0])


def smallest(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A texture cut above."""
    for value, limit in (values, values[::-1]):
        if isinstance(value, Varying) and isinstance(limit, Plain):
            low = Plain((min(bottom for bottom, _ in value.ends),))
            return clamp(e, node, [value, low, limit], width)
    return None


def largest(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A texture that is nowhere below a number."""
    for value, limit in (values, values[::-1]):
        if isinstance(value, Varying) and isinstance(limit, Plain):
            below = min(bottom for bottom, _ in value.ends)
            return spread(value, width) if max(limit.numbers) <= below else None
    return None


def power(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """The first power of a texture that is nowhere negative."""
    value = values[0]
    if isinstance(value, Varying) and min(low for low, _ in value.ends) < 0.0:
        return None
    return safe_power(e, node, values, width)


def safe_power(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """The first power of a texture."""
    value, exponent = values
    is_one = isinstance(exponent, Plain) and set(exponent.numbers) == {1.0}
    return spread(value, width) if is_one and isinstance(value, Varying) else None


def luminance(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
    """A grey texture has its own, times the sum of the weights."""
    value, weights = values
    alike = len(set(value.factor[:3])) == 1 and len(set(value.offset[:3])) == 1
    if not isinstance(value, Varying) or not value.is_grey or not alike:
        return None
    if isinstance(weights, Varying):
        return None
    total = sum(_numbers(weights, 3))
    return value if abs(total - 1.0) < 1e-6 else affine(value, (total,) * 3, (0.0,) * 3)


def chosen(compare: Callable[[float, float], bool]) -> Any:
    """``ifgreater`` and the like, of numbers."""

    def rule(e: Evaluates, node: Node, values: list[Value], width: int) -> Value | None:
        a, b, first, second = values
        if isinstance(a, Varying) or isinstance(b, Varying):
            return None
        return spread(first if compare(a.numbers[0], b.numbers[0]) else second, width)

    return rule


#: Node -> its rule: the evaluator, the node, its inputs in the order of `POINTWISE`, the width.
RULES: dict[str, Callable[[Any, Any, list[Value], int], Value | None]] = {
    "add": add,
    "clamp": clamp,
    "contrast": contrast,
    "divide": divide,
    "ifequal": chosen(lambda a, b: a == b),
    "ifgreater": chosen(lambda a, b: a > b),
    "ifgreatereq": chosen(lambda a, b: a >= b),
    "invert": invert,
    "luminance": luminance,
    "max": largest,
    "min": smallest,
    "mix": mix,
    "multiply": multiply,
    "power": power,
    "range": range_of,
    "remap": remap,
    "safepower": safe_power,
    "subtract": subtract,
}
