"""The page of scene keys, made from the descriptions of all models.

Usage: python docs/site/key_page.py rewrites docs/scene-keys.md.
"""

from __future__ import annotations

import sys
from pathlib import Path

from material_pages import parameters, to_markdown

from alight.core.spec import Spec
from alight.scene.keys import keys_of, known_models, summary_of

DOCS = Path(__file__).resolve().parents[1]
PAGE, IMAGES = DOCS / "scene-keys.md", DOCS / "images" / "keys"

sys.path.insert(0, str(DOCS / "figures"))

from key_scenes import STRIPS  # noqa: E402 (not a package)

HEAD = """\
# Scene keys

Every key of a scene file, made from the code that checks it; in Python these are the fields of
`alight.Scene` and of the models. [Transforms](theory/transforms.md) have a page of their own.
`alight models` lists the models in a terminal, `alight models NAME` the keys of one, those of
[your own](extending.md) included with `--plugin`.

`type` chooses the model. A colour is one number or three, linear sRGB; a texture may be described
in place or named. An unknown key or a value out of range is an error that says where it is, what is
allowed, and what was probably meant.

The small pictures show what a key does, for the values next to its name; all else is the same in a
strip. `docs/figures/key_scenes.py` has their scenes. Exposure, tone curves and white balance are
not keys but options of a render: [display](display.md).

"""

#: Where the models of a family are explained.
MORE = {
    "bsdfs": "With pictures, formulas and laws: [materials](materials/index.md).",
    "lights": "How they are sampled: [lights](lights.md).",
    "media": "[Media](media.md) explains them.",
    "cameras": "What moves while the shutter is open: [motion](motion.md).",
    "samplers": "Which one is best where: [the lesson on samplers](learn/samplers.md).",
    "integrators": "What they estimate: [light transport](theory/light-transport.md).",
}


def text() -> str:
    """Write the page."""
    parts = []
    for family, known in known_models().items():
        if family == "parts":
            parts += [_section(f"## {name.capitalize()}", model) for name, model in known.items()]
            continue
        head = "BSDFs" if family == "bsdfs" else family.capitalize()
        parts.append(f"## {head}\n\n{MORE.get(family, '')}".rstrip())
        own = {name: model for name, model in known.items() if _is_ours(model)}
        parts += [_section(f"### {name}", model) for name, model in own.items()]
    return HEAD + "\n\n".join(parts) + "\n"


def _is_ours(model: type[Spec]) -> bool:
    return model.__module__.startswith("alight.")


def _section(title: str, model: type[Spec]) -> str:
    name = title.lstrip("# ").lower()
    parts = [title, to_markdown(summary_of(model)), parameters(model), pictures(name, model)]
    return "\n\n".join(part for part in parts if part)


def pictures(name: str, model: type[Spec]) -> str:
    """The strips of a model's keys, in the order of its table."""
    return "\n\n".join(
        f"`{key}`: {', '.join(f'`{value}`' for value in STRIPS[of].values)}<br>\n"
        f"![{name} by its key {key}](images/keys/{of}.png)"
        for key in (one.name for one in keys_of(model))
        if (of := f"{name}.{key}") in STRIPS
    )


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
