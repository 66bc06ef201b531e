"""Files of an animation's frames: how they are named, and what they say of how they were made."""

from __future__ import annotations

import re
from pathlib import Path

from alight.core.errors import OutputError
from alight.outputs import exr, png

#: What a frame's file says of how it was made.
FRAME = "frame"


def numbered(pattern: Path, number: int) -> Path:
    """The name of a frame's file: its number in the place of the last run of ``#``."""
    found = re.search(r"#+(?!.*#)", pattern.name)
    assert found is not None
    text = str(number).zfill(len(found[0]))
    return pattern.with_name(pattern.name[: found.start()] + text + pattern.name[found.end() :])


def label_in(path: Path) -> str | None:
    """What the file of a frame says of how it was made; None if it is none, or broken."""
    try:
        if path.suffix.lower() in exr.SUFFIXES:
            return exr.read_layers(path)[1].get(FRAME)
        if path.suffix.lower() in png.SUFFIXES:
            from PIL import Image

            with Image.open(path) as image:
                # Half a file is none: the pixels must be there.
                image.load()
                return str(image.info.get(f"alight.{FRAME}"))
    except (OSError, ValueError, SyntaxError, OutputError):
        return None
    return None
