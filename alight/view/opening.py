"""From the words of the command line to a session."""

from __future__ import annotations

from pathlib import Path

from alight.core.errors import OptionError
from alight.lab.picture_info import is_film_or_picture
from alight.options.loading import scene_of
from alight.options.view import ViewOptions
from alight.view.command import Origin
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
    against, other = None, {}
    if options.against is not None:
        against, other = read_layers(Path(options.against)), {"rival": Path(options.against).name}
    if not is_film_or_picture(subject):
        scene = scene_of(subject, options)
        session = Session(Path(subject).name, scene, options.of_render, against, **other)
        session.origin = Origin(subject, options, scene)
        return session
    for name in options.given():
        if name not in _OF_THE_PAGE:
            raise OptionError(f"{Path(subject).name} is no scene: nothing is rendered", name)
    return Session(Path(subject).name, read_layers(Path(subject)), against=against, **other)
