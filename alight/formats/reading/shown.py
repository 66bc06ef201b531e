"""What is shown of a file that holds more than one picture: which scene, when, in which clothes."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, fields

import numpy as np

from alight.core.errors import Issue, OptionError, SceneError, show_value

#: Option -> who knows it, as a message puts it.
_WHO = {
    "variant": "only glTF and MaterialX files have materials to choose from",
    "scene_name": "only glTF files hold several scenes",
    "animation": "only glTF files name their animations",
    "at": "only glTF and OpenUSD files have animations that are read at a time",
}


@dataclass(frozen=True)
class Shown:
    """What of a file is shown; None is what the file shows by itself.

    Parameters
    ----------
    variant : str, optional
        Of the materials.
    scene_name : str, optional
        Name or number of a scene.
    animation : str, optional
        Name or number of an animation.
    at : float, seconds, optional
        Time of the animation.

    Raises
    ------
    OptionError
        If the time is no number.
    """

    variant: str | None = None
    scene_name: str | None = None
    animation: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        """Check the time."""
        if self.at is None:
            return
        if not isinstance(self.at, int | float | np.number) or isinstance(self.at, bool):
            raise OptionError(f"must be a number of seconds, got {show_value(self.at)}", "at")
        try:
            seconds = float(self.at)
        except OverflowError:
            seconds = math.inf
        if not math.isfinite(seconds):
            raise OptionError(f"must be a finite number of seconds, got {seconds}", "at")
        object.__setattr__(self, "at", seconds)

    def refuse(self, name: str, known: Collection[str] = ()) -> None:
        """Refuse what a format has no choice of.

        Parameters
        ----------
        name : str
            Of the file.
        known : collection of str
            What it has a choice of.

        Raises
        ------
        SceneError
        """
        issues = [
            Issue(flag(field.name), _WHO[field.name], name)
            for field in fields(self)
            if getattr(self, field.name) is not None and field.name not in known
        ]
        if issues:
            raise SceneError(issues)


def flag(option: str) -> str:
    """Name an option as the command line does."""
    return f"--{option.replace('_', '-')}"
