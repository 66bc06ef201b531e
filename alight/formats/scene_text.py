"""The text of a scene file, or why there is none."""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.formats.native import SUFFIXES
from alight.formats.readers import READERS
from alight.formats.reading.reach import is_file
from alight.scene import plain_yaml

#: Ending of pbrt's files; those of Mitsuba are known by what they hold, see `is_xml`.
PBRT = ".pbrt"

# Files of other programs.
FOREIGN = (".xml", PBRT, *READERS)


def builtin_names() -> tuple[str, ...]:
    """List the names of the built-in scenes."""
    folder = resources.files("alight.scene.builtin")
    return tuple(sorted(f.name[:-5] for f in folder.iterdir() if f.name.endswith(".yaml")))


def read_text(path: Path) -> str:
    """Read a scene file.

    Raises
    ------
    SceneError
        If it is missing, with the nearest name, of another kind, too large or no text.
    """
    name = str(path)
    if not is_file(path):
        raise SceneError([Issue("", _missing(path), name)])
    if path.suffix.lower() not in SUFFIXES + FOREIGN:
        kinds = ", ".join(SUFFIXES + FOREIGN)
        raise SceneError([Issue("", f"must be a scene file ({kinds}), got {quote(name)}", name)])
    try:
        size = path.stat().st_size
        if size > plain_yaml.MOST_BYTES:
            limit = plain_yaml.MOST_BYTES // 2**20
            text = (
                f"must be at most {limit} MB, got {size / 2**20:.0f} MB: put meshes into PLY files"
            )
            raise SceneError([Issue("", text, name)])
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text = f"must be UTF-8 text, got byte 0x{error.object[error.start]:02x} at {error.start}"
        raise SceneError([Issue("", text, name)]) from None
    except OSError as error:
        raise SceneError([Issue("", f"cannot be read: {error.strerror}", name)]) from None


def is_xml(text: str) -> bool:
    """Whether a text is a file of Mitsuba rather than a native one."""
    return text.lstrip("\ufeff \t\r\n").startswith("<")


def _missing(path: Path) -> str:
    built_in = builtin_names()
    # Of names that no file can have the module says False, the path raises an error.
    if os.path.isdir(path):  # noqa: PTH112
        return "is a folder, not a scene file"
    candidates = {str(path.with_name(f.name)): f for f in _files_beside(path)}
    near = nearest(str(path), [*built_in, *candidates])
    hint = f'; did you mean "{near}"?' if near else ""
    return f"no such scene file{hint}  (built in: {', '.join(built_in)})"


def _files_beside(path: Path) -> list[Path]:
    try:
        return [
            entry for entry in path.parent.iterdir() if entry.suffix.lower() in SUFFIXES + FOREIGN
        ]
    except OSError:
        return []
