"""``alight models``: what scene files may say."""

from __future__ import annotations

import shutil
import sys
import textwrap
from typing import TYPE_CHECKING, Annotated

import typer

from alight.cli.scenes import entry
from alight.cli.words import Plugins

if TYPE_CHECKING:
    from alight.core.spec import Spec


def models(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]", help="A model, a family, scene, node or film.", show_default="all"
        ),
    ] = None,
    plugins: Plugins = None,
) -> None:
    """List the models of scene files, or the keys of one."""
    from alight.options.plugins import load_plugins
    from alight.scene.keys import find, known_models, summary_of

    load_plugins(plugins)
    known = known_models()
    columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    if name is None or name in known:
        for family in known if name is None else [name]:
            typer.echo(f"{family}:")
            for each, model in known[family].items():
                for line in entry(f"  {each}", summary_of(model), 24, columns):
                    typer.echo(line)
        return
    for family, model in find(name):
        _show(name, family, model, columns or 100)


def _show(name: str, family: str, model: type[Spec], columns: int) -> None:
    """Print what a model is, and its keys."""
    from alight.scene.keys import keys_of, summary_of, tables_of

    typer.echo(f"{name} ({family}): {summary_of(model)}")
    for key in keys_of(model):
        takes = key.takes.replace("`", "")
        default = f", default {key.default}" if key.default else ""
        typer.echo(f"  {key.name}: {takes}{', required' if key.required else default}")
        text = key.text.replace("`", "")
        _wrapped(text, columns, 4)
    for title, names in tables_of(model).items():
        _wrapped(f"{title}: {', '.join(names)}.", columns, 2)


def _wrapped(text: str, columns: int, indent: int) -> None:
    space = " " * indent
    typer.echo(textwrap.fill(text, columns, initial_indent=space, subsequent_indent=space))
