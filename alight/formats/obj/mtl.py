r"""Materials of OBJ files (.mtl) -> `principled`.

The format knows a lamp and a highlight, not materials; what its numbers mean here:

* `Kd` times `map_Kd` is the base colour, linear; a black `Kd` with a map counts as white, as many
  programs write it.
* `Ns` is the exponent of a highlight: :math:`\alpha = \sqrt{2 / (Ns + 2)}`, the width at which
  Beckmann's and Blinn's lobes agree (Walter et al. 2007), roughness :math:`\sqrt\alpha`.
* `Ks` is the weight and tint of a dielectric's reflection, not its reflectance: files say 0.5 or 1
  for varnish and skin, whose reflectance is 0.04. Without `Ks`, and with `illum` 0 or 1, there is
  no highlight. With `illum` 3, 5 or 8 and a `Ks` brighter than `Kd` it is a metal of that colour.
* `d` and `Tr` are opacity and 1 - opacity, of a surface with holes, except with `illum` 4, 6, 7
  and 9, which are glass of index `Ni`, tinted by `Tf`.
* The keys for physically based rendering (`Pr`, `Pm`, `Ps`, `Pc`, `Pcr`, `aniso`, `anisor`, `norm`)
  come before all of these.

Source: Wavefront Technologies, MTL material format (Advanced Visualizer manual, 1995); the keys P*
after the extension by the makers of Exocortex Clara.io and Blender.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from alight.core.errors import Issue, SceneError, quote
from alight.formats.materials.surfaces import LARGEST_IOR, Surface
from alight.formats.materials.textures import (
    channel,
    complement,
    multiplied,
)
from alight.formats.obj.maps import MAPS, Map, read_map
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report

Data = dict[str, Any]
GLASS, METAL, MATT = (4, 6, 7, 9), (3, 5, 8), (0, 1)
_NUMBERS = {
    "ns": (0.0, 1e5), "ni": (0.0, 10.0), "d": (0.0, 1.0), "tr": (0.0, 1.0), "pr": (0.0, 1.0),
    "pm": (0.0, 1.0), "ps": (0.0, 1.0), "pc": (0.0, 1.0), "pcr": (0.0, 1.0), "aniso": (0.0, 1.0),
    "anisor": (0.0, 1.0), "illum": (0, 10),
}  # fmt: skip
_COLORS = {"kd": 1.0, "ks": 1e6, "ke": 1e15, "tf": 1.0}
_DROPPED = {
    "ka": "ambient light is traced", "map_ka": "ambient light is traced",
    "refl": "reflections are traced", "sharpness": "reflections are traced",
    "map_refl": "reflections are traced", "map_aat": "edges are always smooth",
}  # fmt: skip
#: What changes the picture.
_LEFT_OUT = {
    "decal": "decals are not covered", "disp": "displacement is not covered",
    "map_disp": "displacement is not covered", "map_ns": "highlights have one exponent",
    "map_ni": "glass has one index of refraction", "map_tf": "the tint of glass is even",
}  # fmt: skip


@dataclass
class Entry:
    """The statements of one material."""

    place: str
    numbers: dict[str, float] = field(default_factory=dict)
    colors: dict[str, list[float]] = field(default_factory=dict)
    maps: dict[str, Map] = field(default_factory=dict)


def read(text: str, name: str, reach: Reach, report: Report) -> dict[str, Surface]:
    """Read a material library.

    Parameters
    ----------
    text, name : str
        Content of the file, and its name for messages.
    reach : Reach
        Finds pictures; where the library lies, too.
    report : Report
        Takes problems and remarks.
    """
    entries: dict[str, Entry] = {}
    current: Entry | None = None
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        key, place = words[0].lower(), f"{name}:{number}:1"
        if key == "newmtl":
            current = entries.setdefault(" ".join(words[1:]), Entry(place))
        elif current is None:
            report.problem(place, words[0][:60], "stands before the first newmtl")
        else:
            _statement(current, key, words[1:], place, reach, report)
    return {name: _surface(entry, report) for name, entry in entries.items()}


def _statement(
    entry: Entry, key: str, words: list[str], place: str, reach: Reach, report: Report
) -> None:
    if key in _NUMBERS:
        low, high = _NUMBERS[key]
        if "-halo" in words:
            report.approximate(f"{place}: -halo: opacity does not depend on the angle")
        numbers = _numbers([w for w in words if w != "-halo"][:1], place, key, report)
        if key == "ni" and numbers == [0.0]:
            # So programs write that there is no index.
            report.drop("Ni 0: it is not an index of refraction")
        elif key == "ns" and numbers and numbers[0] < 0.0:
            # Blender wrote -1.96 for the widest highlight that it had.
            report.drop("Ns below 0: the highlight is as wide as at 0")
            entry.numbers[key] = 0.0
        elif numbers and not low <= numbers[0] <= high:
            report.problem(place, key, f"must be in [{low:g}, {high:g}], got {numbers[0]:g}")
        elif numbers:
            entry.numbers[key] = numbers[0]
    elif key in _COLORS:
        if words and words[0] in ("spectral", "xyz"):
            report.problem(place, key, f"must be three numbers; {words[0]} is not covered")
            return
        numbers = _numbers(words[:3], place, key, report)
        if numbers and not all(0.0 <= c <= 1e15 for c in numbers):
            report.problem(place, key, f"must be >= 0, got {numbers}")
        elif numbers:
            cut = [min(c, _COLORS[key]) for c in numbers]
            if cut != numbers:
                report.approximate(f"{place}: {key} was cut to {_COLORS[key]:g}")
            entry.colors[key] = (cut * 3)[:3] if len(cut) == 1 else cut
    elif key in MAPS:
        found = read_map(key, words, place, reach, report)
        if found is not None:
            entry.maps[{"map_bump": "bump"}.get(key, key)] = found
    else:
        known = (*_NUMBERS, *_COLORS, *MAPS)
        report.leave_out(place, key, "key", dropped=_DROPPED, approximated=_LEFT_OUT, known=known)


def _numbers(words: list[str], place: str, key: str, report: Report) -> list[float]:
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = []
    if not found or len(found) == 2 or not all(map(math.isfinite, found)):
        report.problem(place, key, f"must be numbers, got {quote(' '.join(words))}")
        return []
    return found


def _times(color: Any, found: Map | None) -> Any:
    return multiplied(color, None if found is None else found.data)


def _surface(entry: Entry, report: Report) -> Surface:
    numbers, colors, maps = entry.numbers, entry.colors, entry.maps
    kd = colors.get("kd", [0.8, 0.8, 0.8])
    if "map_kd" in maps and max(kd) == 0.0:
        kd = [1.0, 1.0, 1.0]
    bsdf: Data = {"type": "principled", "base_color": _times(kd, maps.get("map_kd"))}
    _reflection(entry, bsdf, kd)
    _physical(entry, bsdf)
    is_glass = int(numbers.get("illum", 2)) in GLASS
    if "ni" in numbers:
        # Many programs write 0 for what is no glass.
        bsdf["ior"] = min(numbers["ni"], LARGEST_IOR) if numbers["ni"] >= 1.0 else 1.5
        if bsdf["ior"] != numbers["ni"] and (is_glass or numbers["ni"] > 1.0):
            report.approximate(f"{entry.place}: Ni {numbers['ni']:g} became {bsdf['ior']:g}")
    if is_glass:
        bsdf["base_color"] = colors.get("tf", [1.0, 1.0, 1.0])
        bsdf["transmission"] = 1.0
        bsdf["metallic"] = 0.0
        if "tf" in colors and max(colors["tf"]) == 0.0:
            report.approximate(f"{entry.place}: Tf 0 would be black glass; clear glass is taken")
            bsdf["base_color"] = 1.0
    _say_unused(entry, is_glass, report)
    key = "norm" if "norm" in maps else "bump"
    bent: Data | None = None
    if key in maps:
        kind = {"norm": "normal_map", "bump": "bump_map"}[key]
        bent = {"type": kind, "texture": maps[key].data, "scale": maps[key].multiplier}
    opacity = 1.0 if is_glass else _opacity(entry)
    ke = colors.get("ke", [1.0, 1.0, 1.0] if "map_ke" in maps else [0.0, 0.0, 0.0])
    if "map_ke" in maps and max(ke) == 0.0:
        ke = [1.0, 1.0, 1.0]
    emission = _times(ke, maps.get("map_ke")) if max(ke) > 0.0 else None
    return Surface(bsdf, bent, opacity, emission, place=entry.place)


def _say_unused(entry: Entry, is_glass: bool, report: Report) -> None:
    """List keys that another one of the material makes idle."""
    if is_glass and ({"d", "tr"} & set(entry.numbers) or {"map_d", "map_tr"} & set(entry.maps)):
        report.drop('"d": glass (illum 4, 6, 7 or 9) is transparent by itself')
    if not is_glass and entry.colors.get("tf", [1.0] * 3) != [1.0] * 3:
        report.drop('"tf": only glass (illum 4, 6, 7 or 9) lets light through')
    if {"norm", "bump"} <= set(entry.maps):
        report.approximate(f"{entry.place}: bump is left out beside norm")


def _reflection(entry: Entry, bsdf: Data, kd: list[float]) -> None:
    """Ks, Ns and illum: highlights and metals."""
    numbers, colors, maps = entry.numbers, entry.colors, entry.maps
    illum = int(numbers.get("illum", 2))
    ks = colors.get("ks", [1.0, 1.0, 1.0] if "map_ks" in maps else [0.0, 0.0, 0.0])
    ks = [min(c, 1.0) for c in ks]
    alpha = math.sqrt(2.0 / (numbers.get("ns", 0.0) + 2.0))
    bsdf["roughness"] = math.sqrt(alpha)
    strength = max(ks)
    if illum in METAL and strength > 0.2 and sum(ks) > sum(kd):
        bsdf["metallic"] = 1.0
        bsdf["base_color"] = _times(ks, maps.get("map_ks"))
    elif illum in MATT or strength == 0.0:
        bsdf["specular"] = 1.0 if illum in GLASS else 0.0
    else:
        bsdf["specular"] = strength
        tint = [c / strength for c in ks]
        if "map_ks" in maps or min(tint) < 1.0:
            bsdf["specular_color"] = _times(tint, maps.get("map_ks"))


def _physical(entry: Entry, bsdf: Data) -> None:
    """The keys P*, which say more than the old ones."""
    numbers, maps = entry.numbers, entry.maps

    def put(key: str, name: str) -> None:
        found = maps.get(f"map_{key}")
        if key in numbers or found is not None:
            factor = numbers.get(key, 1.0)
            # Programs write 0 beside a map.
            bsdf[name] = _times(1.0 if found and factor == 0.0 else factor, found)

    if {"pr", "pm"} & set(numbers) or {"map_pr", "map_pm"} & set(maps):
        bsdf.pop("specular_color", None)
        bsdf["specular"] = 1.0
        bsdf["metallic"] = 0.0
        bsdf["base_color"] = _times(
            entry.colors.get("kd", [0.8] * 3) if "map_kd" not in maps else [1.0] * 3,
            maps.get("map_kd"),
        )
    put("pr", "roughness")
    put("pm", "metallic")
    put("pc", "clearcoat")
    put("pcr", "clearcoat_roughness")
    put("aniso", "anisotropy")
    if "anisor" in numbers:
        bsdf["anisotropy_rotation"] = 2.0 * math.pi * numbers["anisor"]
    put("ps", "sheen_color")


def _opacity(entry: Entry) -> Any:
    numbers, maps = entry.numbers, entry.maps
    opacity = numbers.get("d", 1.0 - numbers["tr"] if "tr" in numbers else 1.0)
    found = maps.get("map_d")
    if found is None:
        if "map_tr" in maps:
            part = complement(maps["map_tr"].data)
            return multiplied(opacity or 1.0, part)
        return opacity
    color = maps.get("map_kd")
    part = found.data
    # The picture of the colours is meant for its alpha; others are grey.
    if not found.channel and color is not None and color.file == found.file:
        part = channel(part, "a")
    # Programs write 0 beside a map.
    return multiplied(opacity or 1.0, part)


def broken(place: str, message: str) -> SceneError:
    """Make the error of a library that cannot be read."""
    return SceneError([Issue("mtllib", message, place)])
