"""Scene files of other programs, by the ending of their names.

What reads a format is imported with the first file of that format: most renders need none of it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

from alight.core.errors import Issue, SceneError
from alight.core.extras import install_command
from alight.formats.reading.reach import Reach
from alight.formats.reading.shown import Shown
from alight.formats.scenes.parsed import Parsed
from alight.outputs.texels import reusing_memory

AS_IT_IS = Shown()
MOST_BYTES = 2**30


class Reader(NamedTuple):
    """How files of one format are read.

    Attributes
    ----------
    parse : callable
        ``parse(data, name, reach) -> Parsed``, with ``shown`` if there are choices, and with
        ``lenient`` if the files name others.
    choices : tuple of str
        Fields of `Shown` that a user may choose by.
    names_files : bool
    opens_them : bool
        The parser opens the file itself, and gets no data.
    """

    parse: Callable[..., Parsed]
    choices: tuple[str, ...] = ()
    names_files: bool = True
    opens_them: bool = False


def _parse_gltf(*given: Any, **chosen: Any) -> Parsed:
    from alight.formats import gltf

    return gltf.parse(*given, **chosen)


def _parse_obj(*given: Any, **chosen: Any) -> Parsed:
    from alight.formats.obj import scene

    return scene.parse(*given, **chosen)


def _parse_ply(*given: Any) -> Parsed:
    from alight.formats import mesh_scene

    return mesh_scene.parse_ply(*given)


def _parse_stl(*given: Any) -> Parsed:
    from alight.formats import mesh_scene

    return mesh_scene.parse_stl(*given)


def _parse_materialx(*given: Any, **chosen: Any) -> Parsed:
    from alight.formats.materialx import scene

    return scene.parse(*given, **chosen)


def _parse_usd(data: bytes, name: str, reach: Reach, shown: Shown, lenient: bool) -> Parsed:
    """Read a file of OpenUSD, if the package for it is there."""
    import importlib.util

    if importlib.util.find_spec("pxr") is None:
        command = install_command("usd", "usd-core")
        text = f"OpenUSD needs the package usd-core: {command}"
        raise SceneError([Issue("", text, name)])
    from alight.formats.usd.scene import parse

    return parse(data, name, reach, shown.at, lenient)


_USD = Reader(_parse_usd, choices=("at",), opens_them=True)
_GLTF = Reader(_parse_gltf, choices=tuple(field.name for field in fields(Shown)))

READERS = {
    ".gltf": _GLTF,
    ".glb": _GLTF,
    ".obj": Reader(_parse_obj),
    ".ply": Reader(_parse_ply, names_files=False),
    ".stl": Reader(_parse_stl, names_files=False),
    ".mtlx": Reader(_parse_materialx, choices=("variant",)),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _USD),
}


def choices_of(scene: object) -> tuple[str, ...]:
    """What can be chosen of a scene's file: fields of `Shown`; nothing of what is no such file."""
    if not isinstance(scene, str | os.PathLike):
        return ()
    reader = READERS.get(Path(scene).suffix.lower())
    return reader.choices if reader else ()


def read_model(
    path: Path, name: str, reach: Reach, shown: Shown = AS_IT_IS, lenient: bool = False
) -> Parsed:
    """Read a file whose ending is one of `READERS`.

    Parameters
    ----------
    path : Path
    name : str
        How messages call it.
    reach : Reach
        Where the files that it names may lie.
    shown : Shown, optional
        Which of what the file holds.
    lenient : bool, default False
        See `alight.load`.

    Raises
    ------
    SceneError
        If it cannot be read, or is no scene at all.
    """
    reader = READERS[path.suffix.lower()]
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            text = f"must be at most {MOST_BYTES >> 20} MB, got {size >> 20} MB"
            raise SceneError([Issue("", text, name)])
        with path.open("rb") as file:
            data = b"" if reader.opens_them else file.read()
    except OSError as error:
        raise SceneError([Issue("", f"cannot be read: {error.strerror}", name)]) from None
    shown.refuse(name, reader.choices)
    options = {"shown": shown} if reader.choices else {}
    more = {"lenient": lenient} if reader.names_files else {}
    with reusing_memory():
        return reader.parse(data, name, reach, **options, **more)
