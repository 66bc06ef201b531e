"""Optional packages: what alight requires, and the command that installs what is missing."""

from __future__ import annotations

import re
from pathlib import Path

#: Where the package lies.
_ABOVE = Path(__file__).parents[2]


def requirements() -> list[tuple[str, str]]:
    """List the packages that alight's own metadata names, with their extra or an empty text."""
    # Slow to import, and wanted where something is missing only.
    from importlib import metadata

    try:
        lines = metadata.requires("alight") or []
    except metadata.PackageNotFoundError:
        return []
    found = []
    for line in lines:
        name = re.match(r"[\w.-]+", line)
        extra = re.search(r"extra\s*==\s*['\"]([\w-]+)['\"]", line)
        if name:
            found.append((name[0], extra[1] if extra else ""))
    return found


def install_command(extra: str, *packages: str) -> str:
    """The command that installs an extra.

    Parameters
    ----------
    extra : str
    *packages : str
        What is missing, by the names of the index, should alight's metadata not know.

    Returns
    -------
    str
        From the checkout that runs, if it does; else package by package, as no index has alight.
    """
    if (_ABOVE / "pyproject.toml").is_file():
        return f'pip install "{_ABOVE}[{extra}]"'
    known = [name for name, of in requirements() if of == extra]
    return f"pip install {' '.join(known or packages)}"
