"""Pages and pictures of docs/materials: a ball of every material.

Usage: python docs/figures/materials.py [--pages] [NAME ...]

With ``--pages`` only the texts are written; with names only those pictures are rendered.
"""

import sys
from pathlib import Path

import alight
from alight.core.registry import type_name_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "site"))

from material_pages import IMAGES, PAGES, index, materials, page, samples, shown


def write_pages() -> None:
    """Rewrite all texts, and remove pages of models that are gone."""
    PAGES.mkdir(exist_ok=True)
    texts = {f"{type_name_of(module)}.md": page(module) for module in materials()}
    texts["index.md"] = index()
    for old in PAGES.glob("*.md"):
        if old.name not in texts:
            old.unlink()
    for name, text in texts.items():
        (PAGES / name).write_text(text, encoding="utf-8")


def render_balls(names: list[str]) -> None:
    """Render the pictures of `names`, or of all materials."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for module in materials():
        name = type_name_of(module)
        if names and name not in names:
            continue
        scene = alight.load("material-ball", [f"bsdfs.ball={shown(module)}"])
        film = alight.render(scene, spp=samples(module))
        film.save(IMAGES / f"{name}.png")
        print(name, f"relative error {film.relmse_estimate().relmse.value ** 0.5:.1%}")


if __name__ == "__main__":
    words = sys.argv[1:]
    write_pages()
    if "--pages" not in words:
        render_balls(words)
