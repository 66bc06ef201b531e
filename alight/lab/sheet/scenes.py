"""Which files of a folder are scenes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from alight.core.errors import OptionError
from alight.formats import builtin_names
from alight.formats.native import SUFFIXES
from alight.formats.scene_text import FOREIGN


def find_scenes(wanted: Sequence[str]) -> tuple[list[str], list[Path]]:
    """List the scenes that files, folders and built-in names refer to.

    A folder means the scene files in it; only where it holds none, for those of the folders
    below. So the meshes in the folder of a scene, which are its parts, are no scenes.

    Parameters
    ----------
    wanted : sequence of str

    Returns
    -------
    list of str
        Scenes, in the given order, folders by name, none twice.
    list of Path
        Folders that were not entered, though they hold files that could be scenes.

    Raises
    ------
    OptionError
        If a folder holds no scene.
    """
    found: dict[str, None] = {}
    closed: list[Path] = []
    for name in wanted:
        if name not in builtin_names() and Path(name).is_dir():
            below = _in_folder(Path(name), closed)
            if not below:
                kinds = ", ".join(SUFFIXES + FOREIGN)
                raise OptionError(f"{name}: the folder holds no scene file ({kinds})")
            found |= dict.fromkeys(map(str, below))
        else:
            found[name] = None
    return list(found), closed


def _in_folder(folder: Path, closed: list[Path]) -> list[Path]:
    entries = sorted(folder.iterdir(), key=lambda path: path.name.lower())
    folders = [path for path in entries if path.is_dir() and not path.name.startswith(".")]
    scenes = [path for path in entries if path.is_file() and _is_scene(path)]
    if scenes:
        closed += [path for path in folders if any(map(_is_scene, path.rglob("*")))]
        return scenes
    return [scene for below in folders for scene in _in_folder(below, closed)]


def _is_scene(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES + FOREIGN
