"""Nodes of MaterialX with numbers, pictures and places, and what becomes of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from alight.formats.materialx import scene as reader
from tests.formats.materialx.reading import document, link, node, parsed, value
from tests.formats.materialx.reading import picture as picture_node
from tests.recorded.making import briefly, described, in_folder, outcome

LIBRARY = json.loads(
    (Path(__file__).parents[2] / "formats" / "materialx" / "library.json").read_text("utf-8")
)
KINDS = {"color3": "base_color", "float": "specular_roughness"}


def _text(kind: str, number: float) -> str:
    return str(number) if kind == "float" else f"{number}, {number + 0.1:.2f}, {number + 0.25:.2f}"


def _read(kind: str, nodes: list[str], name: str = "n") -> Any:
    text = document(link(KINDS[kind], kind, name), *nodes)
    found = parsed(text, Path(), lenient=True)
    return [briefly(_without_texels(found.data["bsdfs"]["M"])), described(found.warnings[:3])]


def _without_texels(data: Any) -> Any:
    if isinstance(data, dict):
        return {k: _without_texels(v) for k, v in data.items()}
    if isinstance(data, (list, tuple)):
        return [_without_texels(v) for v in data]
    return data if isinstance(data, (int, float, str, bool)) or data is None else described(data)


def of_numbers() -> dict[str, Any]:
    """Every node whose inputs are numbers."""
    return _every(pictured=False)


def of_pictures() -> dict[str, Any]:
    """Every node whose first input is a picture."""
    return _every(pictured=True)


def _every(pictured: bool) -> dict[str, Any]:
    found: dict[str, Any] = {}
    with in_folder():
        for category, inputs in LIBRARY["nodes"].items():
            for kind in ("float",) if pictured else ("color3",):
                words, nodes = [], []
                for number, name in enumerate(inputs):
                    if pictured and number == 0:
                        nodes.append(picture_node("p", kind))
                        words.append(link(name, kind, "p"))
                    else:
                        words.append(value(name, kind, _text(kind, 0.2 + 0.15 * number)))
                nodes.append(node(category, "n", kind, *words))
                found[f"{category} {kind}"] = outcome(_read, kind, nodes)
    return found


def of_places() -> dict[str, Any]:
    """Pictures whose coordinates are computed, and other pictures."""
    uv = node("texcoord", "uv", "vector2")
    places = {
        "multiply": [value("in2", "vector2", "2, 3")],
        "divide": [value("in2", "vector2", "2, 4")],
        "add": [value("in2", "vector2", "0.1, 0.2")],
        "subtract": [value("in2", "vector2", "0.3, 0.1")],
        "rotate2d": [value("amount", "float", "30")],
        "place2d": [
            value("pivot", "vector2", "0.5, 0.4"), value("scale", "vector2", "2, 3"),
            value("rotate", "float", "20"), value("offset", "vector2", "0.1, 0.3"),
        ],
        "combine2": [value("in2", "float", "0.4")],
        "normalize": [],
    }  # fmt: skip
    found: dict[str, Any] = {}
    with in_folder():
        for category, more in places.items():
            first = "texcoord" if category == "place2d" else "in1" if more else "in"
            first = "in" if category == "rotate2d" else first
            made = node(category, "at", "vector2", link(first, "vector2", "uv"), *more)
            shown = picture_node("n", "color3", link("texcoord", "vector2", "at"))
            found[category] = outcome(_read, "color3", [uv, made, shown])
            twice = node(category, "two", "vector2", link(first, "vector2", "at"), *more)
            shown = picture_node("n", "color3", link("texcoord", "vector2", "two"))
            found[f"{category} twice"] = outcome(_read, "color3", [uv, made, twice, shown])
        for words in ("periodic", "clamp", "mirror", "constant", "x"):
            for filtered in ("closest", "linear", "cubic"):
                more = [
                    value("uaddressmode", "string", words),
                    value("vaddressmode", "string", "clamp"),
                    value("filtertype", "string", filtered),
                ]
                shown = picture_node("n", "color3", *more)
                found[f"{words} {filtered}"] = outcome(_read, "color3", [shown])
        tiled = [
            value("file", "filename", "a.png"), value("uvtiling", "vector2", "2, 3"),
            value("uvoffset", "vector2", "0.1, 0.2"),
        ]  # fmt: skip
        found["tiled"] = outcome(_read, "color3", [node("tiledimage", "n", "color3", *tiled)])
        for space in ("srgb_texture", "lin_rec709", "acescg", "lin_ap1", "g22_rec709", "raw", "x"):
            shown = value("file", "filename", "a.png", f' colorspace="{space}"')
            found[space] = outcome(_read, "color3", [node("image", "n", "color3", shown)])
    found["words"] = sorted(name for name in vars(reader) if name.isupper())
    return found


def of_shaders() -> dict[str, Any]:
    """Every input of every shader, alone."""
    found: dict[str, Any] = {}
    with in_folder():
        for shader, inputs in LIBRARY["shaders"].items():
            plain = _of_shader(shader, "")
            found[shader] = {"": plain}
            for name, default in inputs.items():
                kind = "float" if isinstance(default, (int, float)) else "color3"
                if isinstance(default, str) or default is None or isinstance(default, bool):
                    continue
                words = value(name, kind, _text(kind, 0.35))
                made = outcome(_of_shader, shader, words)
                # The rest is as without the input.
                found[shader][name] = _changed(described(plain), made)
    return found


def _changed(before: Any, after: Any) -> Any:
    if isinstance(before, dict) and isinstance(after, dict):
        gone = [key for key in before if key not in after]
        differing = {k: v for k, v in after.items() if k not in before or before[k] != v}
        return {k: _changed(before.get(k), v) for k, v in differing.items()} | (
            {"gone": gone} if gone else {}
        )
    if isinstance(before, list) and isinstance(after, list) and len(before) == len(after) == 2:
        return [_changed(a, b) for a, b in zip(before, after, strict=True)]
    return after


def _of_shader(shader: str, words: str) -> Any:
    made = parsed(document(words, category=shader), Path(), lenient=True)
    return [briefly(_without_texels(made.data["bsdfs"]["M"])), described(made.warnings[:2])]


CASES = {
    "of_numbers": of_numbers, "of_pictures": of_pictures, "of_places": of_places,
    "of_shaders": of_shaders,
}  # fmt: skip
