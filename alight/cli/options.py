"""Options of ``alight render`` that set keys of the scene file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from alight.core.errors import OptionError, quote

#: Option -> key path of the scene file.
_PATHS = {
    "camera": "camera",
    "integrator": "integrator.type",
    "sampler": "sampler.type",
    "filter": "film.filter",
    "max_depth": "integrator.max_depth",
    "rr_depth": "integrator.rr_depth",
    "replicates": "film.replicates",
}


def changes_of(options: Mapping[str, Any], assignments: list[str]) -> list[str]:
    """Translate options to the assignments that ``--set`` takes, those of ``--set`` last.

    Parameters
    ----------
    options : mapping of str to value
        `size`, `crop` and the keys of `_PATHS`; None where an option is not given.
    assignments : list of str
        ``path=value``.

    Raises
    ------
    OptionError
        For a size or crop that is none.
    """
    changes = []
    # Both at once: a crop of the scene file need not fit a new size.
    size, crop = options.get("size"), options.get("crop")
    if size is not None:
        if crop is None:
            changes.append("film.crop=null")
        changes.append(f"film.size={list(parse_size(size))}")
    if crop is not None:
        changes.append(f"film.crop={list(parse_crop(crop))}")
    for name, path in _PATHS.items():
        if options.get(name) is not None:
            changes.append(f"{path}={options[name]}")
    return changes + assignments


def parse_size(text: str) -> tuple[int, int]:
    """Read ``512x512`` (or one number for a square).

    Examples
    --------
    >>> parse_size("640x480")
    (640, 480)
    """
    found = re.fullmatch(r"(\d{1,9})(?:[x,*](\d{1,9}))?", text.strip().lower())
    if found is None:
        raise OptionError(f"--size: must be WIDTHxHEIGHT in pixels, as 512x512, got {quote(text)}")
    return int(found[1]), int(found[2] or found[1])


def parse_crop(text: str) -> tuple[int, int, int, int]:
    """Read ``x,y,width,height``.

    Examples
    --------
    >>> parse_crop("0,16,64,32")
    (0, 16, 64, 32)
    """
    found = re.fullmatch(r"(\d{1,9}),(\d{1,9}),(\d{1,9}),(\d{1,9})", text.replace(" ", ""))
    if found is None:
        raise OptionError(f"--crop: must be X,Y,WIDTH,HEIGHT in pixels, got {quote(text)}")
    x, y, width, height = (int(n) for n in found.groups())
    return x, y, width, height


def parse_names(text: str | None) -> tuple[str, ...]:
    """Read names separated by commas.

    Examples
    --------
    >>> parse_names("direct, indirect")
    ('direct', 'indirect')
    """
    return tuple(name.strip() for name in (text or "").split(",") if name.strip())


def parse_definitions(texts: list[str] | None) -> dict[str, str]:
    """Read the values of ``-D NAME=VALUE``.

    Raises
    ------
    OptionError
        For a text that is none.

    Examples
    --------
    >>> parse_definitions(["spp=64", "scene=a=b"])
    {'spp': '64', 'scene': 'a=b'}
    """
    found = {}
    for text in texts or []:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise OptionError(f"-D: must be NAME=VALUE, got {quote(text)}")
        found[name.strip()] = value
    return found


def parse_seconds(option: str, text: str) -> float:
    """Read a time such as ``60s``, ``5m``, ``1.5h`` or ``90`` (seconds).

    Raises
    ------
    OptionError
        Naming the option, for a text that is none.

    Examples
    --------
    >>> parse_seconds("--every", "5m")
    300.0
    """
    found = re.fullmatch(r"(\d{1,9}(?:\.\d{0,9})?)\s*([smh]?)", text.strip().lower())
    if found is None:
        raise OptionError(f"{option}: must be a time such as 60s, 5m or 1h, got {quote(text)}")
    return float(found[1]) * {"": 1, "s": 1, "m": 60, "h": 3600}[found[2]]
