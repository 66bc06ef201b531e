"""What pictures say of themselves beyond their edges.

Source: OpenEXR's standard attribute ``wrapmodes``; the strings ``wrapS`` and ``wrapT`` that the
specification of UsdPreviewSurface asks for, as attributes of EXR and texts of PNG files.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from alight.outputs import exr

_NAMES = {"periodic": "repeat"}


def read_wraps(path: Path) -> tuple[str, str]:
    """Wraps along u and v, such as repeat, clamp, mirror or black; empty if the file has none.

    A file that is missing or broken has none: reading its pixels reports that.
    """
    try:
        with path.open("rb") as file:
            start = file.read(4)
        if start == b"\x76\x2f\x31\x01":
            return _wraps_in(exr.read_header(path))
        if start == b"\x89PNG":
            from PIL import Image

            with Image.open(path, formats=("PNG",)) as image:
                return _wraps_in(image.info)
    except Exception:
        # Decoders meet broken files in many ways.
        return "", ""
    return "", ""


def _wraps_in(header: Mapping[str, Any]) -> tuple[str, str]:
    both = str(header.get("wrapmodes", "")).split(",")
    found = [
        str(header.get(f"wrap{axis}", "")) or both[i % len(both)] for i, axis in enumerate("ST")
    ]
    u, v = (_NAMES.get(wrap.strip(), wrap.strip()) for wrap in found)
    return u, v
