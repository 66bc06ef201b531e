"""Where pages and pictures of the laboratory are written to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from alight.core.errors import OutputError, unknown_name
from alight.lab.report.style import require_packages
from alight.outputs.atomic import check_folder


def check_target(path: Path, suffixes: Sequence[str], drawn: Sequence[str] = (".html",)) -> None:
    """Refuse a target before any time is spent on it.

    Parameters
    ----------
    path : Path
    suffixes : sequence of str
        That can be written.
    drawn : sequence of str
        Those that matplotlib draws; pages also need Jinja2.

    Raises
    ------
    OutputError
        For an unknown suffix or a folder that cannot be written to.
    OptionError
        If the packages that make it are not installed.
    """
    suffix = path.suffix.lower()
    if suffix not in suffixes:
        raise OutputError(f"cannot write {path}: {unknown_name('suffix', suffix, suffixes)}")
    if suffix in drawn:
        require_packages("matplotlib", *(("jinja2",) if suffix == ".html" else ()))
    check_folder(path)
