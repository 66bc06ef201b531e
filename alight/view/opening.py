"""From the words of the command line to a session."""

from __future__ import annotations

from pathlib import Path

from alight.core.errors import OptionError
from alight.films.storage import is_film_file
from alight.options.loading import scene_of
from alight.options.view import ViewOptions
from alight.outputs.image import FORMATS
from alight.view.layers import read_layers
from alight.view.session import Session

#: Options that say where the page is served, and what it is compared with.
_OF_THE_PAGE = {"host", "port", "token", "browser", "against"}


def session_of(subject: str, options: ViewOptions) -> Session:
    """Open a scene, a film or a picture.

    Raises
    ------
    AlightError
        For a file that is missing or broken, and for options of a render where nothing is rendered.
    """
    against = None if options.against is None else read_layers(Path(options.against))
    if not _is_film_or_picture(subject):
        scene = scene_of(subject, options)
        return Session(Path(subject).name, scene, options.of_render, against)
    for name in options.given():
        if name not in _OF_THE_PAGE:
            raise OptionError(f"{Path(subject).name} is no scene: nothing is rendered", name)
    return Session(Path(subject).name, read_layers(Path(subject)), against=against)


def _is_film_or_picture(subject: str) -> bool:
    suffixes = {suffix for module in FORMATS for suffix in module.SUFFIXES}
    return is_film_file(subject) or Path(subject).suffix.lower() in suffixes
