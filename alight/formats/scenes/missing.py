"""Stand-ins for missing files of scenes in the native format, for ``--lenient``."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from alight.core.errors import Issue, join_path
from alight.formats.materials.textures import CHECKERED, DARK, FLAT, GREY_SKY, LEVEL, MISSING
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.scene.builtin.pictures import is_builtin
from alight.scene.source import Remarks, Source

#: Type of what names a file -> its remark.
_STAND_INS = {
    "bitmap": CHECKERED,
    "environment": DARK,
    "mesh": "the shape is left out",
}


def replace_missing(data: dict[str, Any], source: Source, reach: Reach) -> Source:
    """Replace files that a description names and that do not exist.

    Parameters
    ----------
    data : dict
        As of a native file; pictures, skies and meshes in it are replaced.
    source : Source
        Knows the places of keys.
    reach : Reach
        Where files may lie.

    Returns
    -------
    Source
        With a remark on each.
    """
    report = Report(lenient=True)
    stack: list[tuple[tuple[str | int, ...], Any]] = [((), data)]
    while stack:
        path, value = stack.pop()
        items = list(value.items() if isinstance(value, dict) else enumerate(value))[::-1]
        for key, item in items:
            if isinstance(item, list):
                stack.append(((*path, key), item))
            elif isinstance(item, dict):
                error = _lacks(item, reach)
                if error is None:
                    stack.append(((*path, key), item))
                    continue
                place = source.located(Issue(join_path(*path, key, "file"), "")).place
                kind = item.get("type")
                is_number = kind == "bitmap" and item.get("color_space") == "linear"
                said = FLAT if is_number else _STAND_INS[kind]
                report.lacks_at(place, join_path(*path, key, "file"), error, said)
                value[key] = _stand_in(kind, item)
                if value[key] is None:
                    del value[key]
                    if key == "shape" and isinstance(value, dict):
                        _forget_what_needs_it(value)
    return replace(source, remarks=Remarks(warnings=tuple(report.warnings)))


def _lacks(item: dict[str, Any], reach: Reach) -> OutOfReachError | None:
    """Why the file of a description cannot be had; None where it can, or nothing stands for it."""
    name = item.get("file")
    kind = item.get("type")
    if (
        not isinstance(kind, str)
        or kind not in _STAND_INS
        or not isinstance(name, str)
        or is_builtin(name)
    ):
        return None
    try:
        reach.find(name)
    except OutOfReachError as error:
        return error
    return None


def _stand_in(kind: str, item: dict[str, Any]) -> dict[str, Any] | None:
    if kind == "bitmap":
        rest = {key: value for key, value in item.items() if key != "file"}
        if item.get("color_space") == "linear":
            return {"type": "constant", "color": LEVEL}
        return {**rest, "pixels": MISSING}
    if kind == "environment":
        return {"type": "constant", "radiance": GREY_SKY}
    return None


def _forget_what_needs_it(node: dict[str, Any]) -> None:
    """Leave out what a node can only have with a shape."""
    light = node.get("light")
    if light == "area" or (isinstance(light, dict) and light.get("type") == "area"):
        del node["light"]
    for medium in ("interior", "exterior"):
        node.pop(medium, None)
