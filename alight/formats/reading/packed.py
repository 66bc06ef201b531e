"""The bytes or the text of a file, unpacked if its name ends in ``.gz``."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path

from alight.core.errors import quote
from alight.formats.reading.reach import UnreadableError


def content_of(path: Path, most: int) -> bytes:
    """Read a file.

    Parameters
    ----------
    path : Path
    most : int
        Bytes that it may have, unpacked.

    Raises
    ------
    UnreadableError
        If it cannot be read or unpacked, or is larger.
    """
    try:
        with path.open("rb") as file:
            packed = path.suffix.lower() == ".gz"
            data = (gzip.GzipFile(fileobj=file) if packed else file).read(most + 1)
    except (OSError, EOFError, zlib.error) as error:
        reason = " ".join(str(getattr(error, "strerror", None) or error).split())
        raise UnreadableError(f"cannot read {quote(path.name)}: {reason}") from None
    if len(data) > most:
        text = f"{quote(path.name)} must be at most {most / 2**20:.0f} MB"
        raise UnreadableError(text)
    return data


def text_of(path: Path, most: int) -> str:
    """Read a file of text in UTF-8; see `content_of`.

    Raises
    ------
    UnreadableError
        If it holds anything else, too.
    """
    data = content_of(path, most)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        byte = f"byte 0x{data[error.start]:02x} at {error.start}"
        raise UnreadableError(f"{quote(path.name)} must be UTF-8 text, got {byte}") from None
