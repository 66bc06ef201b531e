"""Random scenes that can be rendered, as many as there are numbers.

Each kind of scene (`alight.lab.random_scenes.kinds`) has its noise in other places. What stands in
them is drawn from all registered models.

Examples
--------
>>> from alight.lab.random_scenes import random_scene
>>> random_scene(7, "studio") == random_scene(7, "studio")
True
"""

from __future__ import annotations

from alight.core.errors import OptionError, unknown_name
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.draft import Draft
from alight.lab.random_scenes.kinds import KINDS
from alight.scene.description import Scene

__all__ = ["KINDS", "random_scene"]


def random_scene(seed: int, kind: str | None = None, size: tuple[int, int] | None = None) -> Scene:
    """Make up a scene.

    Parameters
    ----------
    seed : int
        Any whole number.
    kind : str, optional
        One of `KINDS`; drawn by default.
    size : (2,) int, pixels, optional
        Width and height; drawn by default, from 32 to 256 a side.

    Returns
    -------
    Scene
        A function of the arguments and of the models that are registered. It names no files;
        `alight.formats.dumps` writes it as text.

    Raises
    ------
    OptionError
        If there is no such kind.
    """
    if kind is None:
        kind = Chance("kind", seed).choose(tuple(KINDS))
    if kind not in KINDS:
        raise OptionError(unknown_name("kind of scene", kind, KINDS, listed_as="kinds"))
    draft = Draft(Chance(kind, seed), size)
    KINDS[kind].build(draft)
    return draft.finish()
