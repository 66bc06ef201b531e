"""Pictures of what failed, as files."""

from __future__ import annotations

import re
from pathlib import Path

from alight.laws.scene.findings import Verdict
from alight.outputs.image import write_image


def write_failures(verdict: Verdict, folder: Path) -> list[Path]:
    """Write the pictures of all findings that do not hold, as PNG.

    Parameters
    ----------
    verdict : Verdict
    folder : Path
        Made if there is something to write. Files that were there before are replaced.

    Returns
    -------
    list of Path
        A picture for each finding that has some: see `Verdict.pictures`.

    Raises
    ------
    OutputError
        If one cannot be written.
    """
    written = []
    for finding, picture in verdict.pictures():
        folder.mkdir(parents=True, exist_ok=True)
        name = re.sub(r"[^a-z0-9]+", "-", f"{finding.part} {finding.law}".lower()).strip("-")
        written.append(write_image(folder / f"{name}.png", picture))
    return written
