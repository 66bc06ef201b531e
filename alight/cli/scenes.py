"""``alight scenes``: the built-in scenes, a line each."""

from __future__ import annotations

from importlib import resources

import typer


def scenes() -> None:
    """List the built-in scenes."""
    from alight.formats import builtin_names

    names = builtin_names()
    width = max(len(name) for name in names)
    for name in names:
        typer.echo(f"{name:<{width}}  {describe(name)}")


def describe(name: str) -> str:
    """Give the first sentence of the comment that a scene file begins with."""
    file = resources.files("alight.scene.builtin").joinpath(f"{name}.yaml")
    words: list[str] = []
    for line in file.read_text("utf-8").splitlines():
        if not line.startswith("#"):
            break
        words.append(line.lstrip("# "))
    sentence, full_stop, _ = (" ".join(words) + " ").partition(". ")
    return (sentence + full_stop).strip()
