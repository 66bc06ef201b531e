"""``alight scenes``: the built-in scenes, a line each."""

from __future__ import annotations

import shutil
import sys
import textwrap
from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

#: Columns that a description needs beside the names; a terminal with fewer has it below.
_NARROW = 30


def scenes(
    sheet: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Render them all as a contact sheet: .png, .jpg, .html."),
    ] = None,
) -> None:
    """List the built-in scenes."""
    from alight.formats import builtin_names

    names = builtin_names()
    if sheet is not None:
        from alight.cli.sheet import sheet as make_sheet

        make_sheet(list(names), output=[sheet], spp=16)
        return
    width = max(len(name) for name in names)
    # In files and pipes a scene is a line.
    columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    for name in names:
        for line in entry(name, describe(name), width, columns):
            typer.echo(line)


def entry(name: str, text: str, width: int, columns: int | None) -> list[str]:
    """Lay out a scene: its name in `width` columns, the text beside it, or below it if narrow.

    Examples
    --------
    >>> entry("fog", "A lamp in fog.", 5, None)
    ['fog    A lamp in fog.']
    >>> entry("fog", "A lamp in fog.", 5, 16)
    ['fog', '  A lamp in fog.']
    """
    if columns is None:
        return [f"{name:<{width}}  {text}"]
    if columns - width - 2 < _NARROW:
        return [name, *textwrap.wrap(text, columns, initial_indent="  ", subsequent_indent="  ")]
    beside = " " * (width + 2)
    return textwrap.wrap(
        text, columns, initial_indent=f"{name:<{width}}  ", subsequent_indent=beside
    )


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
