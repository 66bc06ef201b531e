"""Which files a scene may read: those in one folder and below it, no others.

A scene comes from strangers as often as a mesh does. The folder is that of the scene file; whoever
trusts the file names a larger one, the root. What a path says and where it leads (``..``, links)
must both lie inside of it, so that no scene shows or tells what else lies on a disk. What is said
of a path outside of it follows from the path alone: the disk is not looked at.
"""

from __future__ import annotations

import os
from copy import copy
from pathlib import Path, PureWindowsPath
from typing import Any

from alight.core.errors import join_path, nearest, quote
from alight.outputs.texels import SUFFIXES
from alight.scene.builtin.pictures import is_builtin
from alight.scene.files import Files

#: Files that only their like can be meant for, by their suffixes.
_KINDS = (SUFFIXES, (".mtl",))


class OutOfReachError(ValueError):
    """A path that must not or cannot be read; the message says why."""


class UnreadableError(OutOfReachError):
    """A file that is there, and cannot be read."""


class Reach:
    """Finds the files of a scene.

    Parameters
    ----------
    folder : Path or None
        Of the scene file; the current folder by default.
    root : Path, optional
        What a scene may read lies here or below; `folder` by default.

    Raises
    ------
    OutOfReachError
        If the root is no folder, or `folder` lies outside of it.

    Attributes
    ----------
    files : Files
        What a reader takes from meshes and pictures, the scene need not read again.
    """

    def __init__(self, folder: Path | None = None, root: Path | None = None) -> None:
        self.folder = folder or Path()
        self.files = Files(self.folder)
        self.searched = [self.folder]
        self.named_root = root
        self.root = (self.folder if root is None else root).resolve()
        self._home = self.folder.resolve()
        if root is not None and not root.is_dir():
            raise OutOfReachError(f"must be a folder, got {quote(str(root))}")
        if not self._home.is_relative_to(self.root):
            text = f"must be a folder that holds the scene file, got {quote(str(root))}"
            raise OutOfReachError(f"{text}  (the file lies in {self._home})")

    def add(self, name: str) -> None:
        """Look in a folder (``<path value="..."/>``) before the others.

        Raises
        ------
        OutOfReachError
            If it lies outside, or is no folder.
        """
        path = self.inside(name)
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
        candidates, refused = [], []
        for folder in self.searched:
            try:
                candidates.append(self.inside(name, folder))
            except OutOfReachError as error:
                refused.append(error)
                continue
            if is_file(candidates[-1]):
                return candidates[-1]
        raise refused[0] if refused else OutOfReachError(_missing(candidates[0], name))

    def find_alike(self, name: str) -> Path | None:
        """Find a file by a name that may differ in upper and lower case; None if there is none."""
        for folder in self.searched:
            try:
                path = self.folder
                for part in self.name_of(self.inside(name, folder)).split("/"):
                    path /= part if part == ".." else _alike(path, part)
                path = self.inside(self.name_of(path))
            except (OSError, OutOfReachError):
                continue
            if is_file(path):
                return path
        return None

    def from_folder(self, folder: Path) -> Reach:
        """The same reach for a file that lies in a folder and names files from there."""
        other = copy(self)
        other.searched = [folder, *(path for path in self.searched if path != folder)]
        return other

    def name_of(self, path: Path) -> str:
        """Name a file relative to the scene's folder, as the native format does."""
        return path.relative_to(self.folder).as_posix()

    def inside(self, name: str, folder: Path | None = None, shown: str = "") -> Path:
        """The path of a name, whether there is such a file or not.

        Parameters
        ----------
        name : str
            As the scene file writes it; backslashes stand for slashes.
        folder : Path, optional
            To which it is relative; that of the scene by default.
        shown : str, optional
            How messages call it, if not by `name`.

        Returns
        -------
        Path
            Relative to the folder from which the scene file was named.

        Raises
        ------
        OutOfReachError
            If it lies outside.
        """
        plain, shown = _plain(name), quote(shown or name)
        if not plain or "\0" in plain or not plain.isprintable():
            raise OutOfReachError(f"must be a path, got {shown}")
        if PureWindowsPath(plain).drive and os.name != "nt":
            text = "is a path of another computer, not in the folder of the scene"
            raise OutOfReachError(f"{text}: {shown}")
        said = _said(plain, self._home if folder is None else folder.resolve())
        # The root itself may be named through a link.
        if not any(said.is_relative_to(root) for root in (self.root, self._named())):
            raise OutOfReachError(self._refusal(shown) + self._way_out(said))
        try:
            resolved = said.resolve()
        except (OSError, RuntimeError) as error:
            raise OutOfReachError(f"cannot read {shown}: {error}") from None
        if not resolved.is_relative_to(self.root):
            raise OutOfReachError(self._refusal(f"{shown}, by a link"))
        return self.folder / os.path.relpath(resolved, self._home)

    def keep_inside(self, data: Any) -> dict[str, str]:
        """Refuse files that a description in the native format must not read.

        Parameters
        ----------
        data : dict or list
            Plain data. Names of files stand under keys ``file``; they are put in the
            shortest form, so that what is read is what was looked at here.

        Returns
        -------
        dict of str to str
            Key path of what is refused -> why.
        """
        found: dict[str, str] = {}
        stack: list[tuple[tuple[str | int, ...], Any]] = [((), data)]
        while stack:
            path, value = stack.pop()
            items = value.items() if isinstance(value, dict) else enumerate(value)
            for key, item in items:
                if isinstance(item, dict | list):
                    stack.append(((*path, key), item))
                elif key == "file" and isinstance(item, str) and not is_builtin(item):
                    try:
                        self.inside(item)
                    except OutOfReachError as error:
                        found[join_path(*path, key)] = str(error)
                    else:
                        said = _said(_plain(item), self._home)
                        value[key] = Path(os.path.relpath(said, self._home)).as_posix()
        # What was put on the stack last came first.
        return dict(reversed(found.items()))

    def _named(self) -> Path:
        """The root as it was named, made absolute."""
        return Path.cwd() / (self.folder if self.named_root is None else self.named_root)

    def _refusal(self, name: str) -> str:
        if self.named_root is None:
            where = "the folder of the scene, which holds all that a scene may read"
        else:
            where = f"{quote(str(self.named_root))}, which holds all that the scene may read"
        return f"leads out of {where}: {name}"

    def _way_out(self, said: Path) -> str:
        """Name the smallest root that holds the scene and a path; none that is a whole disk."""
        if said.anchor != self._home.anchor:
            return ""
        root = Path(os.path.commonpath([said, self._home]))
        if root == Path(root.anchor):
            return ""
        levels = len(self._home.parts) - len(root.parts)
        shown = Path(os.path.normpath(self.folder.joinpath(*[".."] * levels)))
        if shown.resolve() != root:
            shown = root
        return f"; for a file that you trust: --root {shown}"


def _plain(name: str) -> str:
    return name.strip().replace("\\", "/")


def _said(plain: str, folder: Path) -> Path:
    """What a path says by itself: ``..`` takes a name away, whatever lies there."""
    return Path(os.path.normpath(folder / plain))


def _alike(folder: Path, name: str) -> str:
    """The name of an entry of a folder that is a name but for upper and lower case."""
    entries = [entry.name for entry in folder.iterdir() if entry.name.lower() == name.lower()]
    return entries[0] if len(entries) == 1 and name not in entries else name


def is_file(path: Path) -> bool:
    """Whether there is a file; names that no file can have are none."""
    try:
        return path.is_file()
    except OSError:
        return False


def _may_stand_for(entry: Path, path: Path) -> bool:
    """Whether a file may be what a name meant: a picture for a picture, say."""
    wanted = next((kind for kind in _KINDS if path.suffix.lower() in kind), ())
    return not wanted or entry.suffix.lower() in wanted


def _missing(path: Path, name: str) -> str:
    try:
        beside = [entry.name for entry in path.parent.iterdir() if _may_stand_for(entry, path)]
    except OSError:
        return f"no such file: {quote(name)} (there is no folder {quote(path.parent.name)})"
    near = nearest(path.name, beside)
    return f"no such file: {quote(name)}" + (f'; did you mean "{near}"?' if near else "")
