"""What is shown of a file that holds more than one picture: which scene, when, in which clothes."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, fields

from alight.core.errors import Issue, SceneError

#: Option -> who knows it, as a message puts it.
_WHO = {
    "variant": "only glTF files have variants of materials",
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
    """

    variant: str | None = None
    scene_name: str | None = None
    animation: str | None = None
    at: float | None = None

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
