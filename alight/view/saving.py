"""What can be saved of a session: the film, the picture, the scene as its camera is now."""

from __future__ import annotations

from pathlib import Path

from alight.core.errors import OutputError
from alight.formats import dumps
from alight.outputs.image import write_image
from alight.view.layers import PICTURE
from alight.view.session import Session

#: Names under which they are requested.
SAVED = ("film.alight", "picture.exr", "picture.png", "scene.yaml")


def save(session: Session, path: Path) -> None:
    """Write what the name of a file says.

    Raises
    ------
    OutputError
        If there is no such thing here, or not yet.
    """
    if path.suffix == ".yaml":
        if session.editor is None:
            raise OutputError("only scenes can be saved as scenes")
        path.write_text(dumps(session.editor.scene), encoding="utf-8")
        return
    film, layers, display = session.film, session.layers, session.look.display
    shown = {
        "exposure": display.exposure, "tone_map": display.tone_map,
        "white_balance": display.white_balance,
    }  # fmt: skip
    if film is not None:
        film.save(path, **({} if path.suffix == ".alight" else shown))
    elif layers is None or session.live is not None or path.suffix == ".alight":
        raise OutputError("there is no film yet" if session.live else "this is no film")
    else:
        write_image(path, layers.plane(PICTURE), **shown)
