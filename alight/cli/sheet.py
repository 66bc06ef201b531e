"""``alight sheet``: many scenes as small pictures on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli.reporting import INTERRUPTED
from alight.cli.words import Plugins, Quiet

#: Exit code when a scene has no picture.
FAILED = 1


def sheet(
    scenes: Annotated[
        list[str],
        typer.Argument(
            metavar="SCENE|FOLDER ...",
            help="Scene files, names of built-in scenes, folders of scene files.",
        ),
    ],
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help=".png or .jpg: one picture; .html: a page. Repeatable.",
            show_default="sheet.png",
        ),
    ] = None,
    tile: Annotated[str, typer.Option(metavar="WxH", help="Pixels of a picture.")] = "256x192",
    columns: Annotated[int, typer.Option(min=1, help="Of the picture.")] = 6,
    spp: Annotated[int, typer.Option(min=1, help="Samples per pixel.")] = 64,
    time_limit: Annotated[
        float | None,
        typer.Option("--time", help="Start no pass after this many seconds, of each scene."),
    ] = None,
    threads: Annotated[int | None, typer.Option(help="Threads; by default all processors.")] = None,
    exposure: Annotated[str, typer.Option(metavar="STOPS", help="Stops, or auto.")] = "0",
    note: Annotated[
        list[str] | None,
        typer.Option(help="Line below the sheet, such as the scenes' origin. Repeatable."),
    ] = None,
    lenient: Annotated[
        bool,
        typer.Option(
            "--lenient", help="Replace unsupported parts and missing files, and list them."
        ),
    ] = False,
    root: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder whose files the scenes may read; must contain them.",
            show_default="each scene's own folder",
        ),
    ] = None,
    plugins: Plugins = None,
    quiet: Quiet = False,
) -> None:
    """Make a contact sheet of scenes; a scene that fails shows its error message."""
    from alight.core.errors import OptionError
    from alight.lab.report.targets import check_target
    from alight.lab.sheet import SUFFIXES, Tile, find_scenes, render_tile, write_sheet
    from alight.options.kinds import Size
    from alight.options.plugins import load_plugins
    from alight.outputs.display import Display

    load_plugins(plugins)
    outputs = output or [Path("sheet.png")]
    try:
        size = Size().check(tile)
    except ValueError as error:
        raise OptionError(str(error), "--tile") from None
    if not all(16 <= length <= 4096 for length in size):
        raise OptionError(f"must be 16 to 4096 pixels wide and high, got {tile}", "--tile")
    display = Display(exposure)
    for path in outputs:
        check_target(path, SUFFIXES)
    found, closed = find_scenes(scenes)
    notes = list(note or [])
    if closed:
        notes.append(f"Not entered, as scenes lie above: {', '.join(map(str, closed))}")
        typer.echo(notes[-1], err=True)
    tiles: list[Tile] = []
    stopped = False
    for number, scene in enumerate(found, 1):
        try:
            made = render_tile(
                scene, size, spp=spp, time_limit=time_limit, threads=threads, lenient=lenient,
                root=root, display=display,
            )  # fmt: skip
        except KeyboardInterrupt:
            stopped = True
            notes.append(f"Stopped after {len(tiles)} of {len(found)} scenes.")
            break
        tiles.append(made)
        if not quiet:
            told = f"[{number}/{len(found)}] {made.name}"
            words = [*made.facts] if made.pixels is not None else ["no picture"]
            typer.echo(f"{told}: {', '.join(words)}")
        if made.pixels is None:
            typer.echo(f"error: {made.message}", err=True)
    if tiles:
        for path in outputs:
            write_sheet(path, tiles, size, columns=columns, notes=notes)
            if not quiet:
                typer.echo(f"sheet: {path}")
    if stopped:
        raise typer.Exit(INTERRUPTED)
    if any(made.pixels is None for made in tiles):
        raise typer.Exit(FAILED)
