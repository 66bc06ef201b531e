"""Where a scene came from: its file, the places of its values there, and how to load it again."""

from __future__ import annotations

import re
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from alight.core.errors import Issue
from alight.scene.files import Files, Held


@dataclass(frozen=True)
class Remarks:
    """What was noticed in a file of another program.

    Parameters
    ----------
    notes : tuple of str
        What plays no part in the picture.
    warnings : tuple of str
        What was replaced or is suspicious.
    spp : int, optional
        Samples per pixel that the file asks for.
    read : tuple of (str, int)
        Kinds of things that were read, and how many.
    assumed : tuple of (str, str)
        Key path, and the warning that holds for as long as its value stays what it was.
    """

    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    spp: int | None = None
    read: tuple[tuple[str, int], ...] = ()
    assumed: tuple[tuple[str, str], ...] = ()

    @property
    def plays(self) -> bool:
        """Whether the file has an animation, of which one time is shown."""
        return "animations" in dict(self.read)


@dataclass(frozen=True)
class Recipe:
    """How a scene was loaded, to load it again.

    Parameters
    ----------
    path : str
        Absolute path of the file, or name of a built-in scene.
    changes : tuple of str
        Assignments, as for ``--set``.
    definitions : mapping of str to str
        As for ``-D``.
    lenient : bool
    root : str, optional
        Absolute path of the folder in which and below which files may lie.
    variant : str, optional
        Of the materials of a glTF file.
    scene_name, animation : str, optional
        Which of those of a glTF file.
    at : float, seconds, optional
        Time of its animation, or of a stage of OpenUSD.
    """

    path: str
    changes: tuple[str, ...] = ()
    definitions: Mapping[str, str] = field(default_factory=dict)
    lenient: bool = False
    root: str | None = None
    variant: str | None = None
    scene_name: str | None = None
    animation: str | None = None
    at: float | None = None


class Memory:
    """What scenes that are made from one another share: the last one as it was compiled.

    Copies and other processes begin with nothing.

    Attributes
    ----------
    held : object
        See `alight.compiled.recompile`.
    lock : threading.Lock
        Of whoever reads and replaces it.
    """

    def __init__(self) -> None:
        self.held: Any = None
        self.lock = threading.Lock()

    def __reduce__(self) -> tuple[type[Memory], tuple[()]]:
        """Leave what is held behind."""
        return Memory, ()


@dataclass(frozen=True)
class Source:
    """Where a scene came from.

    Parameters
    ----------
    name : str
        File name or name of a built-in scene; empty for scenes made in Python.
    folder : Path, optional
        Where relative mesh files are looked up; the current folder by default.
    places : mapping of str to str
        Key path -> ``line:column`` of the value; key path + ``~`` -> of the key. Values in other
        files than `name` have their name in front.
    remarks : Remarks, optional
        Of the reader of a foreign format.
    recipe : Recipe, optional
        Of scenes that `load` has read. Changes in Python afterwards are not in it.
    held : dict
        What has been read of the files that the scene names (`alight.scene.files.Files`).
    """

    name: str = ""
    folder: Path | None = None
    places: Mapping[str, str] = field(default_factory=dict)
    remarks: Remarks = Remarks()
    recipe: Recipe | None = None
    held: Held = field(default_factory=dict, repr=False, compare=False)

    def files(self) -> Files:
        """Reads the files that the scene names, but for those that have been read before."""
        return Files(self.folder, self.held)

    def located(self, issue: Issue) -> Issue:
        """Fill in the place of an issue: of its path, or of the nearest one above."""
        if not self.name:
            return issue
        path = issue.path
        if issue.about_key and path + "~" in self.places:
            return Issue(path, issue.message, self._in_file(self.places[path + "~"]))
        while path and path not in self.places:
            cut = max(path.rfind("."), path.rfind("["))
            path = path[:cut] if cut > 0 else ""
        line = self.places.get(path, "1:1")
        return Issue(issue.path, issue.message, self._in_file(line))

    def _in_file(self, place: str) -> str:
        return f"{self.name}:{place}" if re.fullmatch(r"\d+:\d+", place) else place
