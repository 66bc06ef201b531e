"""The command line that renders what a view shows: its film has the bits of the settled one."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

from alight.core.errors import AlightError
from alight.options.loading import scene_of
from alight.options.render import RenderOptions
from alight.options.view import ViewOptions
from alight.outputs.display import Display
from alight.rendering.schedules.selection import planned_spp
from alight.rendering.writing import command
from alight.scene import Scene, content_hash
from alight.scene.dump import dump_scene
from alight.view.live import LiveScene

if TYPE_CHECKING:
    from alight.view.editor import Editor
    from alight.view.look import Look

#: Where no words of a command give the scene that is shown.
SAVE_FIRST = "no command says all of these edits: save the scene, and render that file"
#: Where the file is another one by now.
FILE_CHANGED = (
    "the scene's file has changed since it was opened: open it again, or save the scene that is "
    "shown, and render that file"
)


class Origin(NamedTuple):
    """What ``alight view`` was called with, and the scene that it read."""

    subject: str
    options: ViewOptions
    scene: Scene


def command_of(
    origin: Origin | None, editor: Editor, live: LiveScene, look: Look
) -> dict[str, Any]:
    """Write the command, after making sure that its scene is the one that is shown.

    Returns
    -------
    dict
        ``text``, and ``notes`` (list of str): what the command does in another way.

    Raises
    ------
    AlightError
        If there is no such command.
    """
    if origin is None:
        raise AlightError("the scene came from Python, not from a file: save it first")
    shown, asked = editor.scene, origin.options
    try:
        now = _read(origin, asked)
    except AlightError as error:
        raise AlightError(f"{FILE_CHANGED}\n{error}") from None
    if content_hash(now) != content_hash(origin.scene):
        raise AlightError(FILE_CHANGED)
    made, notes = _with_end(asked, live, shown.source.remarks.spp)
    made = made.changed(changes=(*made.changes, *editor.assignments()))
    if (camera := shown.camera) != _read(origin, made).camera:
        if isinstance(camera, str):
            made = made.changed(camera=camera)
        else:
            data = dump_scene(shown, edited="camera")["camera"]
            # Earlier changes of the camera have no effect.
            others = [text for text in made.changes if not text.startswith(("camera=", "camera."))]
            made = made.changed(camera=None, changes=(*others, f"camera={json.dumps(data)}"))
    if content_hash(_read(origin, made)) != content_hash(shown):
        raise AlightError(SAVE_FIRST)
    shared = made.options().keys() & RenderOptions.options().keys()
    words = RenderOptions(**{name: getattr(made, name) for name in shared}, **_shown_as(look))
    seed = () if made.seed else ("--seed", "0")
    return {"text": command("render", origin.subject, *words.words(), *seed), "notes": notes}


def _read(origin: Origin, options: ViewOptions) -> Scene:
    # Scripts have registered their models already.
    return scene_of(origin.subject, options.changed(plugins=()))


def _with_end(
    options: ViewOptions, live: LiveScene, own_spp: int | None
) -> tuple[ViewOptions, list[str]]:
    """The options with the samples that the view takes, and notes on what they cannot express."""
    planned, ends_earlier = planned_spp(live.movable.options, own_spp)
    if not ends_earlier:
        options = options.changed(spp=live.wish.spp or planned)
    notes = []
    if live.wish.stops:
        notes.append("the view was stopped; the command renders all samples")
    elif options.max_time is not None:
        notes.append("a time limit ends after other samples each time")
    elif ends_earlier and live.wish.spp:
        notes.append("the view went on to more samples; the command ends as it was asked to")
    return options, notes


def _shown_as(look: Look) -> dict[str, Any]:
    """The options of the picture files, as the page shows them."""
    display, plain = look.display, Display()
    found = {
        name: getattr(display, name)
        for name in ("exposure", "tone_map", "white_balance")
        if getattr(display, name) != getattr(plain, name)
    }
    return found | ({"denoise": True} if look.denoised else {})
