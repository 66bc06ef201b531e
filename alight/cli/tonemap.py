"""``alight tonemap``: a film or a linear picture once more, with another exposure or tone curve."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import Plugins, Quiet, takes_words
from alight.options.render import DisplayOptions


@takes_words(DisplayOptions)
def tonemap(
    options: DisplayOptions,
    picture: Annotated[
        Path,
        typer.Argument(
            help="Film (.alight), checkpoint, or linear picture: .exr, .hdr, .pfm, .npy."
        ),
    ],
    output: Annotated[
        list[Path] | None,
        typer.Option("-o", "--output", help="PNG or JPEG. Repeatable.", show_default="PICTURE.png"),
    ] = None,
    plugins: Plugins = None,
    quiet: Quiet = False,
) -> None:
    """Write a film or a linear picture again for a display: exposure, white balance, tone curve."""
    from alight.core.errors import OptionError, OutputError
    from alight.films import Film
    from alight.films.storage import is_film_file
    from alight.options.plugins import load_plugins
    from alight.outputs.image import check_writable, format_of, read_picture, write_image
    from alight.rendering.writing import Targets, write_outputs

    load_plugins(plugins)
    if not picture.name:
        raise OutputError(f"cannot read {picture}: it is a folder")
    outputs = output or [picture.with_suffix(".png")]
    for path in outputs:
        if not format_of(path).IS_DISPLAY:
            raise OutputError(f"cannot write {path}: must end in .png, .jpg or .jpeg")
        check_writable(path)
    display = options.display
    if is_film_file(picture):
        targets = Targets(outputs, display, options.denoise)
        targets.check()
        write_outputs(Film.load(picture), targets)
    else:
        if options.denoise:
            raise OptionError("needs a film (.alight), which knows its noise", "--denoise")
        if format_of(picture).IS_DISPLAY:
            raise OutputError(
                f"{picture} is a picture for a display already: give its .exr or film"
            )
        shown = read_picture(picture)
        for path in outputs:
            write_image(path, shown, **vars(display))
    if not quiet:
        for path in outputs:
            typer.echo(f"written: {path}")
