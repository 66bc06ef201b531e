"""Reliefs: factors are taken out of textures of heights, where they may be negative."""

from __future__ import annotations

from alight.formats.pbrt.context import Context
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.textures import Source, TextureItem, texture_value


def height_of(source: Source, name: str) -> tuple[float, float | str | None]:
    """Ask for a height: a factor, and the number or texture that it multiplies."""
    found, factor = source.p.find(name), 1.0
    if found is None or found.kind != "texture":
        return factor, source.number(name, None)
    item = source.bound.get(name)
    # Textures hold no values below 0; factors on the way to a picture can be taken out.
    while item is not None and item.directive.type == "scale":
        p = Parameters(item.directive, source.p.report, item.defaults)
        is_old = p.has("tex1") or p.has("tex2")
        names = ("tex1", "tex2") if is_old else ("tex", "scale")
        varying = [key for key in names if key in item.bound and not _is_constant(item.bound[key])]
        if len(varying) != 1:
            break
        [fixed] = set(names) - set(varying)
        item.is_read = True
        factor *= _amount(source, p, item, fixed)
        item = item.bound[varying[0]]
    return factor, None if item is None else _value(source.context, item)


def _is_constant(item: TextureItem) -> bool:
    return item.directive.type == "constant" and not item.bound


def _amount(source: Source, p: Parameters, item: TextureItem, name: str) -> float:
    """The number that is a part of a texture."""
    if name in item.bound:
        inner = item.bound[name]
        inner.is_read = True
        return Parameters(inner.directive, source.p.report, inner.defaults).number("value", 1.0)
    return p.number(name, 1.0)


def _value(context: Context, item: TextureItem) -> float | str:
    value = texture_value(context, item)
    return sum(value) / 3.0 if isinstance(value, list) else value
