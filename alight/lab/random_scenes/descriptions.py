"""Descriptions of any registered model, their parameters drawn from the ranges of their fields.

Nothing here knows a model by name: a model starts as one of its EXAMPLES, and some of its fields
are then redrawn within the metadata of their types. So a model that is registered later
is drawn like all others.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any, Literal, get_args, get_origin

from alight.bsdfs.nesting import Nested, count_leaves, find_transmissive, scatters_inside
from alight.core.errors import SceneError
from alight.core.fields import Interval, Model, Models, NumberOrTexture, Numbers
from alight.core.registry import Models as Registry
from alight.core.spec import Bsdf, Spec, Texture
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.pictures import pattern
from alight.textures.nesting import steps_problem

#: Probability that a number is an end of its range.
EDGE = 0.02
#: Share of the fields that are redrawn.
SHARE = 0.4
#: Probability that a field that takes a texture gets one.
TEXTURED = 0.15
#: Descriptions inside descriptions, at most.
DEEPEST = 2
#: Most models of a material of a random scene.
MOST_LEAVES = 4


def any_model(chance: Chance, family: str, depth: int = DEEPEST) -> Any:
    """A description of any model of a family."""
    modules = list(Registry(family).values())
    for _ in range(20):
        found = of_model(chance, chance.choose(modules), depth)
        # Nothing can hold a body that scatters light inside.
        nested = depth < DEEPEST and isinstance(found, Bsdf) and scatters_inside(found)
        if not nested and (depth > 0 or not _holds_others(found)):
            return found
    return modules[0].EXAMPLES[0]


def of_model(chance: Chance, module: ModuleType, depth: int = DEEPEST) -> Any:
    """A description of one model: one of its examples with some fields redrawn."""
    return varied(chance, chance.choose(module.EXAMPLES), depth)


def varied(
    chance: Chance,
    base: Any,
    depth: int = DEEPEST,
    *,
    keep: tuple[str, ...] = (),
    share: float = SHARE,
    textured: float = TEXTURED,
) -> Any:
    """A valid description of the same model with some fields redrawn.

    Parameters
    ----------
    chance : Chance
    base : Spec
    depth : int
        How many descriptions may be put inside each other.
    keep : tuple of str, optional
        Fields that stay as they are.
    share : float
        Part of the fields that change.
    textured : float
        Probability of a texture where a changed field takes one.
    """
    while share > 0.02:
        changes = {}
        for name, value in base:
            if name != "type" and name not in keep and chance.happens(share):
                changes[name] = _field(chance, type(base), name, value, depth, textured)
        try:
            found = base.replaced(**changes)
        except SceneError:
            # Fields that exclude each other: with fewer changes it works out sooner.
            share *= 0.5
            continue
        if not isinstance(found, Bsdf) or count_leaves(found) <= MOST_LEAVES:
            return found
        share *= 0.5
    return base


def any_texture(chance: Chance, interval: Interval, depth: int = DEEPEST) -> Texture | None:
    """A texture whose values lie in a range; None where none was found in some tries."""
    for _ in range(8):
        found = any_model(chance, "textures", depth - 1)
        if steps_problem(found) is None and max(found.maximum()) <= interval.high:
            return found
    return None


def _field(
    chance: Chance, spec: type[Spec], name: str, value: Any, depth: int, textured: float
) -> Any:
    """Another value for a field of a description; the same where nothing is known of its type."""
    markers = _markers(spec, name)
    choices = _choices(spec, name)
    if value is None:
        return None
    if isinstance(value, bool):
        return chance.happens(0.5)
    if choices:
        return chance.choose(choices)
    for marker in markers:
        if isinstance(marker, Numbers | NumberOrTexture):
            if Texture in marker.other and depth > 0 and chance.happens(textured):
                return any_texture(chance, marker.interval, depth) or value
            return _amount(chance, marker, value)
        if isinstance(marker, Interval):
            # Lists and names that may stand for a number stay.
            return _number(chance, marker, value) if isinstance(value, int | float) else value
        if isinstance(marker, Models):
            return tuple(_nested(chance, marker, inner, depth) for inner in value)
        if isinstance(marker, Model):
            return _nested(chance, marker, value, depth)
    if name == "pixels" and hasattr(value, "texels"):
        return pattern(chance)
    return value


def _markers(spec: type[Spec], name: str) -> list[Any]:
    """Metadata of a field, those inside ``X | None`` too."""
    info = spec.model_fields[name]
    found = [*info.metadata]
    for part in get_args(info.annotation):
        found.extend(getattr(part, "__metadata__", ()))
    return found


def _choices(spec: type[Spec], name: str) -> tuple[str, ...]:
    annotation = spec.model_fields[name].annotation
    return get_args(annotation) if get_origin(annotation) is Literal else ()


def _nested(chance: Chance, marker: Model, value: Any, depth: int) -> Any:
    if depth <= 0 or isinstance(value, str):
        return value
    found = any_model(chance, marker.family, depth - 1)
    # What is two-sided, or lies in a coat, must not let light through.
    if isinstance(found, Bsdf) and find_transmissive(found, {}) is not None:
        return found if chance.happens(0.5) else value
    return found


def _amount(chance: Chance, marker: Numbers | NumberOrTexture, value: Any) -> Any:
    """A number or some; textures and names stay."""
    if isinstance(value, str | Texture):
        return value
    interval = marker.interval
    if isinstance(marker, NumberOrTexture):
        return _number(chance, interval, value)
    if marker.count == 3 and interval.low == 0.0 and interval.high == 1.0:
        return chance.color() if not chance.happens(EDGE) else chance.choose((0.0, 1.0))
    if chance.happens(0.5):
        factor = chance.scaled(0.5, 2.0)
        return tuple(_clipped(interval, factor * number) for number in value)
    return tuple(_number(chance, interval, number) for number in value)


def _number(chance: Chance, interval: Interval, value: float) -> float | int:
    """A number of an interval; near `value` where the interval is wide."""
    low, high = interval.low, interval.high
    is_narrow = high - low <= 200.0 and not interval.integer
    if is_narrow and chance.happens(EDGE) and not interval.open_ends:
        return chance.choose((low, high))
    if is_narrow:
        # Most of a range of more than 1 is far from what is usual: indices of refraction, say.
        power = 1.0 if high - low <= 2.0 else 3.0
        found = low + (high - low) * chance.number() ** power
    elif not math.isfinite(value):
        found = chance.scaled(0.3, 3.0)
    elif low == -math.inf:
        found = value + max(abs(value), 1.0) * chance.within(-1.0, 1.0)
    else:
        found = value * chance.scaled(0.3, 3.0)
    return _clipped(interval, found)


def _clipped(interval: Interval, value: float) -> float | int:
    value = float(f"{value:.4g}")
    if interval.integer:
        return round(min(max(value, interval.low), interval.high))
    margin = 1e-3 if interval.open_ends else 0.0
    return min(max(value, interval.low + margin), interval.high - margin)


def _holds_others(spec: Any) -> bool:
    """Whether a description holds others of its own family."""
    if isinstance(spec, Nested):
        return True
    return isinstance(spec, Texture) and any(isinstance(value, Texture) for _, value in spec)
