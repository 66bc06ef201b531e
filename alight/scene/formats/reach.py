"""Which files a scene may read: those in the folder of the scene file and below it, no others.

A scene comes from strangers as often as a mesh does. Absolute paths and paths that leave the folder
(``..``, links) are refused, so that no scene shows or tells what else lies on a disk.
"""

from __future__ import annotations

from pathlib import Path, PurePosixPath, PureWindowsPath

from alight.core.errors import nearest, quote


class OutOfReachError(ValueError):
    """A path that must not or cannot be read; the message says why."""


class Reach:
    """Finds the files of a scene.

    Parameters
    ----------
    folder : Path or None
        Of the scene file; the current folder by default.
    """

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder or Path()
        self.root = self.folder.resolve()
        self.searched = [self.folder]

    def add(self, name: str) -> None:
        """Look in a folder (``<path value="..."/>``) before the others.

        Raises
        ------
        OutOfReachError
            If it lies outside, or is no folder.
        """
        path = self._inside(self.folder, name)
        if not path.is_dir():
            raise OutOfReachError(f"no such folder: {quote(name)}")
        self.searched.insert(0, path)

    def find(self, name: str) -> Path:
        """Find a file.

        Returns
        -------
        Path
            Relative to the folder from which the scene file was named.

        Raises
        ------
        OutOfReachError
            If it lies outside or does not exist.
        """
        candidates = [self._inside(folder, name) for folder in self.searched]
        for path in candidates:
            if path.is_file():
                return path
        raise OutOfReachError(_missing(candidates[0], name))

    def name_of(self, path: Path) -> str:
        """Name a file relative to the scene's folder, as the native format does."""
        return path.relative_to(self.folder).as_posix()

    def _inside(self, folder: Path, name: str) -> Path:
        plain = name.strip().replace("\\", "/")
        if not plain or "\0" in plain or not plain.isprintable():
            raise OutOfReachError(f"must be a path, got {quote(name)}")
        if PurePosixPath(plain).is_absolute() or PureWindowsPath(plain).drive:
            raise OutOfReachError(f"must be relative to the folder of the scene, got {quote(name)}")
        path = folder / plain
        try:
            resolved = path.resolve()
        except (OSError, RuntimeError) as error:
            raise OutOfReachError(f"cannot read {quote(name)}: {error}") from None
        if not resolved.is_relative_to(self.root):
            text = "leads out of the folder of the scene, which holds all that a scene may read"
            raise OutOfReachError(f"{text}: {quote(name)}")
        return self.folder / resolved.relative_to(self.root)


def _missing(path: Path, name: str) -> str:
    try:
        beside = [entry.name for entry in path.parent.iterdir()]
    except OSError:
        return f"no such file: {quote(name)} (there is no folder {quote(path.parent.name)})"
    near = nearest(path.name, beside)
    return f"no such file: {quote(name)}" + (f'; did you mean "{near}"?' if near else "")
