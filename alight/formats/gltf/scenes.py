"""Which of a file's scenes is shown.

Source: Khronos Group, glTF 2.0 specification, section 3.5.1.
"""

from __future__ import annotations

from alight.core.errors import Issue, SceneError, quote, unknown_name
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item
from alight.formats.reading.shown import flag


def numbered(items: list[Item], wanted: str, option: str, kind: str, file: str) -> int:
    """The index of one of some items by its name, or by its number where no name is alike.

    Raises
    ------
    SceneError
        If there is no such item.
    """
    wanted, names = str(wanted), [item.text("name") for item in items]
    if wanted in names:
        return names.index(wanted)
    if wanted.isdecimal() and int(wanted[:9]) < len(items):
        return int(wanted[:9])
    known = [name or str(index) for index, name in enumerate(names)]
    if not items:
        text = f"the file has no {kind}s"
    elif wanted.isdecimal():
        listed = ", ".join(map(quote, known[:20]))
        text = (
            f"must be below the number of {kind}s, {len(items)}, got {wanted}  ({kind}s: {listed})"
        )
    else:
        text = unknown_name(kind, wanted, known)
    raise SceneError([Issue(flag(option), text, file)])


def choose_scene(document: Document, wanted: str | None) -> None:
    """Make a scene of the file the one that it shows.

    Parameters
    ----------
    document : Document
    wanted : str or None
        Its name or number; None for the file's own choice.

    Raises
    ------
    SceneError
        If the file has no such scene.
    """
    scenes, root = document.list("scenes"), document.root
    if wanted is not None:
        root.value["scene"] = numbered(scenes, wanted, "scene_name", "scene", root.name)
        return
    if len(scenes) > 1:
        shown = root.index("scene", len(scenes), "scenes") or 0
        others = ", ".join(
            quote(item.text("name") or str(index))
            for index, item in list(enumerate(scenes))[:21]
            if index != shown
        )
        document.report.drop(
            f"other scenes ({others}): the file shows scene {shown}; --scene-name shows one of them"
        )
