"""Media of any registered kind, as thick as their place needs them."""

from __future__ import annotations

from typing import Any

from alight.core.registry import Models as Registry
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import of_model
from alight.media.coefficients import extinction

Corner = tuple[float, float, float]


def any_medium(chance: Chance, thickness: float, across: float) -> Any:
    """A medium without borders of its own; light falls to exp(-thickness) on the way across."""
    names = [name for name in Registry("media") if "low" not in _fields(name)]
    return _thick(of_model(chance, Registry("media")[chance.choose(names)]), thickness, across)


def boxed_medium(chance: Chance, thickness: float, low: Corner, high: Corner) -> Any:
    """A medium for a box of the world, on a grid or even."""
    spec = of_model(chance, Registry("media")[chance.choose(list(Registry("media")))])
    if "low" in dict(spec):
        shape = tuple(chance.whole(1, 5) for _ in range(3))
        values = chance.numbers(*shape) ** 2
        # A grid that is empty everywhere is no medium.
        values[0, 0, 0] = 1.0
        changes: dict[str, Any] = {"low": low, "high": high, "matrix": None, "values": values}
        if spec.albedo_values is not None:
            changes["albedo_values"] = chance.numbers(*shape)
        if spec.emission_values is not None:
            changes["emission_values"] = chance.numbers(*shape, 3)
        spec = spec.replaced(file=None, **changes)
    across = max(b - a for a, b in zip(low, high, strict=True))
    return _thick(spec, thickness, across)


def _thick(spec: Any, thickness: float, across: float) -> Any:
    largest = max(extinction(spec))
    if largest <= 0.0:
        return _thick(
            type(spec)(**({"values": spec.values} if "values" in dict(spec) else {})), 1, 1
        )
    scale = spec.scale * thickness / (largest * across)
    changes: dict[str, Any] = {"scale": float(f"{scale:.4g}")}
    # Fire is the exception: what shines everywhere outshines the lamps.
    if max(spec.emission) > 1.0:
        changes["emission"] = tuple(channel / max(spec.emission) for channel in spec.emission)
    return spec.replaced(**changes)


def _fields(name: str) -> set[str]:
    return set(type(Registry("media")[name].EXAMPLES[0]).model_fields)
