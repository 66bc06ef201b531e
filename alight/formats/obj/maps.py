"""Pictures of OBJ materials: the statements ``map_...``, their options, and files by old names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from alight.core.errors import quote
from alight.formats.materials.textures import CHECKERED, MISSING, WITHOUT, channel
from alight.formats.materials.udim import find_tiles, is_tiled, lay_out
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report

Data = dict[str, Any]
#: Options of maps and how many numbers follow: least and most.
_OPTIONS = {
    "-s": (1, 3), "-o": (1, 3), "-t": (1, 3), "-mm": (2, 2), "-bm": (1, 1), "-boost": (1, 1),
    "-texres": (1, 1),
}  # fmt: skip
_WORDS = {"-clamp", "-blendu", "-blendv", "-cc", "-imfchan", "-type"}
#: Options that play no part; others that are not covered change the picture.
_HARMLESS = {"-blendu", "-blendv", "-boost", "-texres"}
#: Statements, and whether their pictures are colours or numbers.
MAPS = {
    "map_kd": "color", "map_ks": "color", "map_ke": "color", "map_d": "number",
    "map_pr": "number", "map_pm": "number", "map_ps": "number", "map_pc": "number",
    "map_pcr": "number", "map_bump": "number", "bump": "number", "norm": "number",
    "map_tr": "number",
}  # fmt: skip


@dataclass
class Map:
    """A picture with its options: description, multiplier of bumps, and the requested channel."""

    data: Data
    file: str
    multiplier: float = 1.0
    channel: str = ""


def read_map(key: str, words: list[str], place: str, reach: Reach, report: Report) -> Map | None:
    """The picture of a map statement."""
    data: Data = {"type": "bitmap"}
    if MAPS[key] == "number":
        data["color_space"] = "linear"
    made = Map(data, "")
    scale, shift, base, gain = [1.0, 1.0], [0.0, 0.0], 0.0, 1.0
    while words and words[0] in (*_OPTIONS, *_WORDS):
        option, words = words[0], words[1:]
        if option in _WORDS:
            value, words = (words[0] if words else ""), words[1:]
            if option == "-clamp" and value == "on":
                data["wrap"] = "clamp"
            elif option == "-imfchan":
                made.channel = {"m": "a"}.get(value, value)
            elif option != "-clamp" and value not in ("off", ""):
                _say_option(option, key, place, report)
            continue
        values, words = _leading_numbers(words, _OPTIONS[option])
        if not values:
            report.problem(place, option, "needs numbers")
            return None
        if option == "-s":
            scale = [*values, 1.0][:2]
        elif option == "-o":
            shift = [*values, 0.0][:2]
        elif option == "-mm":
            base, gain = values
        elif option == "-bm":
            made.multiplier = values[0]
        else:
            _say_option(option, key, place, report)
    if not words:
        report.drop(f"{quote(key)}: names no picture")
        return None
    try:
        made.file = reach.name_of(find(" ".join(words), place, reach, report))
        data["file"] = made.file
    except OutOfReachError as error:
        is_color = MAPS[key] == "color"
        report.lacks_at(place, key, error, CHECKERED if is_color else WITHOUT)
        if not (is_color and report.can_do_without(error)):
            return None
        data["pixels"] = MISSING
    one = made.channel in ("r", "g", "b", "a")
    if one and MAPS[key] == "number":
        made.data = channel(data, made.channel)
    elif made.channel not in ("", "l"):
        report.drop(f"-imfchan {made.channel} of {key}: not covered")
    if [*scale, *shift] != [1.0, 1.0, 0.0, 0.0]:
        data["to_uv"] = [{"scale": scale}, {"translate": shift}]
    lay_out(data, reach, report)
    if (base, gain) != (0.0, 1.0):
        if base < 0.0 or gain < 0.0:
            report.problem(place, "-mm", f"must be >= 0, got {base:g} {gain:g}")
            return None
        scaled = {"type": "multiply", "a": gain, "b": made.data}
        made.data = {"type": "add", "a": base, "b": scaled}
        if base + gain > 1.0 and key not in ("map_ke", "map_bump", "bump"):
            text = f"-mm of {key} may reach {base + gain:g}: it is cut at 1"
            report.approximate(f"{place}: {text}")
            made.data = {"type": "clamp", "texture": made.data}
    return made


def _say_option(option: str, key: str, place: str, report: Report) -> None:
    if option in _HARMLESS:
        report.drop(f"{option}: plays no part")
    else:
        report.approximate(f"{place}: {option} of {key} is not covered and was left out")


def _leading_numbers(words: list[str], count: tuple[int, int]) -> tuple[list[float], list[str]]:
    values: list[float] = []
    while words and len(values) < count[1]:
        try:
            value = float(words[0])
        except ValueError:
            break
        # The last word is the file's name, even if it looks like a number.
        if len(words) == 1 or not abs(value) <= 1e6:
            break
        values.append(value)
        words = words[1:]
    return (values if len(values) >= count[0] else []), words


def find(name: str, place: str, reach: Reach, report: Report) -> Path:
    """Find a file that a program on another computer may have named.

    Names may stand in quotes and differ in upper and lower case; of a path that leads nowhere its
    last parts are looked for, as many as there are.

    Raises
    ------
    OutOfReachError
        If it lies outside or does not exist.
    """
    plain = name.strip().strip('"')
    if is_tiled(plain):
        return reach.folder / find_tiles(plain, reach)
    try:
        return reach.find(plain)
    except OutOfReachError:
        parts = [part for part in plain.replace("\\", "/").split("/") if part.strip(".")]
        for first in range(len(parts)):
            found = reach.find_alike("/".join(parts[first:]))
            if found is not None:
                shown = quote(reach.name_of(found))
                report.approximate(f"{place}: {quote(name)} was found as {shown}")
                return found
        raise
