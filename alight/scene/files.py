"""The files that a scene names: each is read and checked once, from loading to rendering."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from alight.core.errors import SceneError

Content = TypeVar("Content")

#: Reader and path -> what the file holds: checked, and never changed.
Held = dict[tuple[Callable[..., Any], Path], Any]


class Files:
    """Reads files, each once.

    Parameters
    ----------
    folder : Path, optional
        Where relative names are looked up; the current folder by default.
    held : dict, optional
        What has been read before; whatever is read now is added. It is handed on with a scene
        (`alight.scene.source.Source`).

    Attributes
    ----------
    notes : list of str
        What had to be changed in pictures, each once.
    """

    def __init__(self, folder: Path | None = None, held: Held | None = None) -> None:
        self.folder = folder or Path()
        self.held: Held = {} if held is None else held
        self.notes: list[str] = []
        # Not handed on: a file that was missing may be there when the scene is used again.
        self._errors: dict[tuple[Callable[..., Any], Path], SceneError] = {}

    def read(
        self, reader: Callable[[Path, str], Content], name: str, path: Path | None = None
    ) -> Content:
        """What a reader makes of a file.

        Parameters
        ----------
        reader : callable
            Called with the path, and the name for messages.
        name : str
            How messages call it; relative to `folder` if there is no path.
        path : Path, optional

        Raises
        ------
        SceneError
            As the reader raises it, each time.
        """
        key = (reader, self.folder / name if path is None else path)
        if key in self._errors:
            raise self._errors[key]
        if key not in self.held:
            try:
                self.held[key] = reader(key[1], name)
            except SceneError as error:
                self._errors[key] = error
                raise
        return self.held[key]

    def note(self, text: str) -> None:
        """Note what had to be changed in a picture."""
        if text not in self.notes:
            self.notes.append(text)
