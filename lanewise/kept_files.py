"""Files of compiled code: whole, or as if they were not there."""

from __future__ import annotations

import json
import os
import secrets
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any


def read_kept(path: Path) -> tuple[dict[str, Any], bytes] | None:
    """Header and content that `write_kept` wrote; None if there is nothing, or nothing whole."""
    try:
        line, _, content = path.read_bytes().partition(b"\n")
        header = json.loads(line)
        whole = header["crc32"] == zlib.crc32(content)
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return (header, content) if whole else None


#: The last file that could not be kept, and why, until somebody has asked.
_lost: list[OSError] = []


def lost() -> OSError | None:
    """Why code could not be kept since the last call; None if all of it was."""
    found = _lost[-1] if _lost else None
    _lost.clear()
    return found


def write_kept(path: Path, header: dict[str, Any], content: bytes) -> None:
    """A line of JSON, then the content; what cannot be written is compiled again: see `lost`."""
    line = json.dumps({**header, "crc32": zlib.crc32(content)}).encode()
    unfinished = path.with_name(f"{path.name}.{os.getpid()}-{secrets.token_hex(4)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished.write_bytes(line + b"\n" + content)
        unfinished.replace(path)
    except OSError as error:
        _lost.append(error)
        with suppress(OSError):
            unfinished.unlink(missing_ok=True)
