"""The scene of a command, loaded by the options that all commands share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from alight.scene import Scene


def load_scene(
    scene: str,
    changes: Sequence[str] = (),
    *,
    plugin: list[Path] | None = None,
    define: list[str] | None = None,
    lenient: bool = False,
    root: Path | None = None,
) -> Scene:
    """Load a scene after the models that scripts register.

    Parameters
    ----------
    scene : str
        File, or name of a built-in scene.
    changes : sequence of str, optional
        ``path=value``, see `alight.cli.options.changes_of`.
    plugin, define, lenient, root
        As the options of the same names in `alight.cli.arguments` give them.
    """
    from alight.cli.options import parse_definitions
    from alight.cli.plugins import load_plugins
    from alight.formats import load

    load_plugins(plugin)
    definitions = parse_definitions(define)
    return load(scene, list(changes), definitions=definitions, lenient=lenient, root=root)
