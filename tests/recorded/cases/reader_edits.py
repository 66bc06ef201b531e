"""What edits of scene files change: each parameter left out, another, nothing, negative, or wrong.

Of each file every n-th parameter is edited at once, so that a few readings are enough. Kept is only
what is not as it was: a key that is read into another place, under another name, in another unit,
with another default or without its check is another line of the difference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import alight
from alight.core.errors import AlightError
from alight.scene.dump import dump_scene
from tests.recorded.cases import reader_features, readers
from tests.recorded.making import briefly, described, in_folder

#: A parameter in a text: all of it, with its value as the group "value".
XML = re.compile(
    r'<(?:float|integer|boolean|string|rgb|srgb|spectrum|point|vector|scale|rotate|translate|input)'
    r'\b(?:(?! value=| x=| angle=)[^<>])*(?P<value>(?: (?:value|x|y|z|angle)="[^"]*")+)[^<>]*/>'
)  # fmt: skip
PBRT = re.compile(r'"[a-z0-9]+ \w+"\s+(?P<value>\[[^\]]*\]|"[^"]*"|[^\s"\[\]]+)')
USD = re.compile(
    r"^(?!.*faceVertex) *(?:uniform |prepend )*[a-z]\w*(?:\[\])? [\w:.]+ = "
    r"(?P<value>[^<>{\n]+?)(?: \(\n[^)]*\))?$",
    re.MULTILINE,
)  # fmt: skip
LINE = re.compile(r"^(?!newmtl|mtllib|usemtl|[vf] )[A-Za-z_]\w* (?P<value>.+)$", re.MULTILINE)
#: Of glTF: no indices of other things.
JSON = re.compile(
    r'"\w*(?:Factor|Cutoff|scale|strength|Strength|Angle|offset|rotation|'
    r"translation|matrix|intensity|color|range|fov|ratio|mag|znear|zfar|ior|Texture|alphaMode|"
    r'interpolation|type|path|texCoord|doubleSided|wrap[ST]|dispersion)": '
    r'(?P<value>-?[\d.]+(?:e-?\d+)?|"[^"]*"|true|false|\[[-\d., e]*\])'
)

#: What cannot be left out: without it nothing is read of the rest.
NEEDED = re.compile(
    r'name="(?:filename|value|values|wavelengths|name)"|"string (?:filename|name)"|P"|indices"|'
    r"points|faceVertex|vertexCounts|asset|file"
)

NUMBER = re.compile(r"(?<![\w.$#%])-?\d+\.?\d*(?:e-?\d+)?(?![\w.])")
WORD = re.compile(r"(?<=[\"' ])[A-Za-z]\w*(?=[\"' ,])|\b(?:true|false)\b")


def _other(value: str) -> str:
    """Numbers that are others, and flags that are the other way."""

    def of(found: re.Match[str]) -> str:
        text = found[0]
        return str(int(text) + 1) if text.isdigit() else f"{0.7 * float(text) + 0.2:.6g}"

    flags = {"true": "false", "false": "true"}
    return WORD.sub(lambda found: flags.get(found[0], found[0]), NUMBER.sub(of, value))


def _wrong(value: str) -> str:
    """Words where numbers belong, and words that nobody knows."""
    return NUMBER.sub("al", WORD.sub(lambda found: f"{found[0]}s", value))


#: What becomes of a value.
EDITS: dict[str, Callable[[str], str]] = {
    "other": _other,
    "nothing": partial(NUMBER.sub, "0"),
    "negative": partial(NUMBER.sub, lambda found: f"{-1.5 * float(found[0]) - 0.5:.6g}"),
    "wrong": _wrong,
}
#: Types that stand in the place of others.
TYPES = {
    "float": "string", "integer": "float", "boolean": "integer", "string": "integer",
    "rgb": "float", "bool": "integer", "spectrum": "bool", "point": "rgb", "point3": "float",
    "texture": "rgb", "vector": "string", "color3": "float",
}  # fmt: skip


class File(NamedTuple):
    """A file, how its parameters are spelled, how many readings there are of each edit."""

    name: str
    parameter: re.Pattern[str]
    readings: int
    #: That is read, if it is not the file itself.
    scene: str = ""
    #: In the place of what is left out.
    instead: str = ""
    #: Readings of one edit, at most.
    tries: int = 3


def _in_place(name: str, found: re.Match[str], instead: str) -> str:
    """What stands in the place of a parameter."""
    if name == "left out":
        return found[0] if NEEDED.search(found[0]) else instead
    if name == "typed":
        return re.sub(r"\w+", lambda kind: TYPES.get(kind[0], kind[0]), found[0], count=1)
    start, end = (place - found.start() for place in found.span("value"))
    return found[0][:start] + EDITS[name](found["value"]) + found[0][end:]


def edited(text: str, places: list[re.Match[str]], name: str, instead: str) -> str:
    """The text with some of its parameters edited, or with others in their place."""
    parts, end = [], 0
    for found in places:
        parts += [text[end : found.start()], _in_place(name, found, instead)]
        end = found.end()
    return "".join([*parts, text[end:]])


def leaves(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """(place, value) of all that plain data hold; rows of numbers are one."""
    if isinstance(value, dict) and value:
        for key, one in value.items():
            yield from leaves(one, f"{place}.{key}" if place else str(key))
    elif isinstance(value, list) and any(isinstance(one, (dict, list)) for one in value):
        for index, one in enumerate(value):
            yield from leaves(one, f"{place}[{index}]")
    else:
        yield place, value


def _read(name: str) -> tuple[dict[str, Any], list[str]]:
    """The scene of a file by its places, and what is said of it; an error is all that is said."""
    try:
        scene = alight.load(name, lenient=True)
    except AlightError as error:
        return {}, described(str(error)).splitlines()
    return dict(leaves(briefly(dump_scene(scene)))), described(
        [*scene.warnings, *scene.source.remarks.notes]
    )


def _changes(file: File) -> dict[str, Any]:
    """What each edit of a file changes."""
    path, found = Path(file.name), {}
    text, scene = path.read_text("utf-8"), file.scene or file.name
    right, said = _read(scene)
    assert right
    for name in ("left out", "typed", *EDITS):
        for first in range(file.readings):
            places = list(file.parameter.finditer(text))[first :: file.readings]
            now, says, refused = {}, [], []
            # What is refused is as it was at the next try, so that the rest is read.
            for _ in range(file.tries):
                path.write_text(edited(text, places, name, file.instead), "utf-8")
                now, says = _read(scene)
                lines = {int(n) for line in says for n in re.findall(rf"^{file.name}:(\d+)", line)}
                kept = [one for one in places if text.count("\n", 0, one.start()) + 1 not in lines]
                if now:
                    break
                # Where no line is named every other parameter is tried.
                places = kept if len(kept) < len(places) else places[::2]
                refused += says
            change = {key: one for key, one in now.items() if key not in right or right[key] != one}
            gone = [key for key in right if key not in now] if now else []
            told = [line for line in says if line not in said]
            untold = [line for line in said if line not in says] if now else []
            lists = {"refused": refused, "says": told, "does not say": untold, "gone": gone}
            found[f"{name} {first}"] = {**{key: one for key, one in lists.items() if one}, **change}
    path.write_text(text, "utf-8")
    return found


def _features(file: File) -> dict[str, Any]:
    with in_folder(reader_features._files()):
        reader_features._pictures()
        return _changes(file)


def _gltf_features(file: File) -> dict[str, Any]:
    with in_folder({file.name: reader_features._everything().gltf()}):
        return _changes(file)


def _scenes(file: File) -> dict[str, Any]:
    with in_folder(readers.files()):
        readers._pictures()
        return _changes(file)


CASES = {
    "mitsuba": partial(_features, File("interiors.xml", XML, 3)),
    "mitsuba_06": partial(_features, File("old.xml", XML, 3)),
    "mitsuba_3": partial(_scenes, File("m3.xml", XML, 3)),
    "pbrt": partial(_features, File("objects.pbrt", PBRT, 1, tries=2)),
    "usd": partial(_scenes, File("a.usda", USD, 3)),
    "materialx": partial(_scenes, File("a.mtlx", XML, 3)),
    "mtl": partial(_scenes, File("a.mtl", LINE, 3, "a.obj")),
    "gltf_features": partial(_gltf_features, File("a.gltf", JSON, 2, instead='"extras": 0')),
    "gltf": partial(_scenes, File("a.gltf", JSON, 3, instead='"extras": 0')),
}
