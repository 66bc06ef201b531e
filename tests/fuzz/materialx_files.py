"""Mutated documents of MaterialX: shaders, pictures, procedural nodes, graphs."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from tests.formats.materialx.reading import document, link, node, picture, value
from tests.formats.mutate import TEXT_MUTATIONS, Mutation

# fmt: off
WORDS = (
    "0", "-1", "1e30", "1e-30", "nan", "inf", "1, 2", "0.5, 0.5, 0.5", "1,1,1,1", "true", "",
    "a.png", "../a.png", "b.png", "p", "S", "M", "m", "color3", "float", "vector2", "vector3",
    "filename", "surfaceshader", "material", "image", "multiply", "mix", "noise2d", "normalmap",
    "checkerboard", "standard_surface", "open_pbr_surface", "gltf_pbr", "UsdPreviewSurface",
    "base_color", "subsurface", "subsurface_radius", "coat", "transmission", "1.38", "1e999",
)
# fmt: on

_PICTURE = picture("p", "color3")
_MIXED = node(
    "mix", "m", "color3", link("fg", "color3", "p"), value("bg", "color3", "0.2, 0.3, 0.9"),
    value("mix", "float", "0.4"),
)  # fmt: skip
_BODY = "".join([
    value("subsurface", "float", "1"), link("subsurface_color", "color3", "m"),
    value("subsurface_radius", "color3", "0.1, 0.05, 0.02"),
    value("subsurface_scale", "float", "0.5"), value("specular_roughness", "float", "0.4"),
])  # fmt: skip
_LAYERS = "".join([
    link("base_color", "color3", "m"), value("metalness", "float", "0.5"),
    value("coat", "float", "0.5"), value("sheen", "float", "0.3"),
    value("thin_film_thickness", "float", "300"), value("emission", "float", "0.5"),
    link("normal", "vector3", "n"), value("opacity", "color3", "0.5, 0.5, 0.5"),
])  # fmt: skip
_BUMPS = node("normalmap", "n", "vector3", link("in", "vector3", "v"))
_VECTORS = picture("v", "vector3")
_OPEN = "".join([
    value("subsurface_weight", "float", "1"), link("subsurface_color", "color3", "p"),
    value("subsurface_radius", "float", "0.2"), value("transmission_weight", "float", "0"),
    value("coat_weight", "float", "0"), value("fuzz_weight", "float", "0"),
])  # fmt: skip
_GLASS = "".join([
    value("transmission", "float", "1"), value("transmission_color", "color3", "1, 0.5, 1"),
    value("transmission_depth", "float", "0.1"), value("ior", "float", "1.4"),
])  # fmt: skip
_CHECKED = node("checkerboard", "c", "color3", value("color1", "color3", "1, 0, 0"))
_DOCUMENTS = (
    document(_BODY, _PICTURE, _MIXED),
    document(_LAYERS, _PICTURE, _MIXED, _VECTORS, _BUMPS),
    document(_OPEN, _PICTURE, category="open_pbr_surface"),
    document(_GLASS),
    document(_GLASS, category="gltf_pbr"),
    document(link("base_color", "color3", "c"), _CHECKED),
    document(link("diffuseColor", "color3", "p"), _PICTURE, category="UsdPreviewSurface"),
)


def copy_picture(folder: Path) -> None:
    """Put the picture that documents name into a folder."""
    Image.linear_gradient("L").resize((4, 3)).convert("RGB").save(folder / "a.png")


def materialx_files(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` documents, each of one material."""
    rng = random.Random(seed)
    for _ in range(n):
        # Lines for the mutations that move them.
        text = rng.choice(_DOCUMENTS).replace("><", ">\n<")
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            change = rng.choice((*[_swap_value] * 12, *TEXT_MUTATIONS))
            text = change(text, rng)
        # Lone surrogates stand for bytes that are no text.
        yield Mutation("broken.mtlx", "broken.mtlx", text.encode("utf-8", "surrogateescape"))


def _swap_value(text: str, rng: random.Random) -> str:
    """Replace what stands between a pair of quotes."""
    quotes = [i for i, c in enumerate(text) if c == '"']
    if len(quotes) < 2:
        return text
    at = rng.randrange(len(quotes) - 1)
    return text[: quotes[at] + 1] + rng.choice(WORDS) + text[quotes[at + 1] :]
