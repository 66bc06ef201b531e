"""The options of everything that loads a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Self

from alight.core.errors import OptionError
from alight.options.kinds import Crop, Definitions, File, Files, Paper, Size, Switch, Text, Texts
from alight.options.quantities import Number
from alight.options.table import FOREIGN, SCENE, Options, option, table

#: Pixels per inch of a size on paper, if nothing else is said.
DPI = 300

#: Names of the options that only say how a file is read.
READING = ("definitions", "lenient", "root", "variant", "scene_name", "animation", "at")


def scripts(what: str, panel: str = "") -> Any:
    """Declare the scripts that bring users' models."""
    help = f"Script that registers {what} (alight.register). Repeatable."
    return option(Files("FILE.py"), help, default=(), flag="--plugin", panel=panel)


@table
class SceneOptions(Options):
    """How a scene is loaded, and what of it is changed."""

    changes: Sequence[str] | str = option(
        Texts("PATH=VALUE"),
        "Set any key of the scene file, such as film.size=[64,64]. Repeatable.",
        default=(), flag="--set", panel=SCENE,
    )  # fmt: skip
    plugins: Sequence[str | PathLike[str]] | str | PathLike[str] = scripts(
        "models for the scene", SCENE
    )
    definitions: Mapping[str, str] = option(
        Definitions(), "Set $NAME in an .xml file. Repeatable.",
        default={}, flag="-D", panel=FOREIGN,
    )  # fmt: skip
    lenient: bool = option(
        Switch(), "Replace unsupported parts (.xml, .pbrt) and missing files, and list them.",
        default=False, panel=FOREIGN,
    )  # fmt: skip
    root: str | PathLike[str] | None = option(
        File("FOLDER"),
        "Folder whose files the scene may read; must contain the scene file.",
        shown="the scene's own folder", panel=SCENE, default=None
    )  # fmt: skip

    variant: str | None = option(
        Text("NAME"), "Variant of the materials (.gltf, .glb), or one material (.mtlx).",
        shown="the materials that the file shows", panel=FOREIGN, default=None,
    )  # fmt: skip
    scene_name: str | None = option(
        Text("NAME|NUMBER"), "Scene of the file (.gltf, .glb), from 0.",
        shown="the scene that the file shows", panel=FOREIGN, default=None,
    )  # fmt: skip
    animation: str | None = option(
        Text("NAME|NUMBER"), "Animation that --at refers to (.gltf, .glb); numbers count from 0.",
        shown="the first one", panel=FOREIGN, default=None,
    )  # fmt: skip
    at: float | None = option(
        Number(-1e9, 1e9, is_closed=True),
        "Time of the animation in seconds, from its beginning (.gltf, .glb, .usd).",
        shown="glTF at rest, OpenUSD at its first time", panel=FOREIGN, default=None,
    )  # fmt: skip

    def assignments(self) -> list[str]:
        """All changes of the scene as ``path=value``, those of `changes` last."""
        keyed = {one.key: getattr(self, one.name) for one in self.options().values() if one.key}
        found = [f"{key}={value}" for key, value in keyed.items() if value is not None]
        return [*self._sizes(), *found, *self.changes]

    def _sizes(self) -> list[str]:
        return []

    def with_loaded_scene(self, **words: Any) -> Self:
        """Copy the options for a scene in which they are already, with other values besides."""
        options = self.options()
        done = [*SceneOptions.options(), *(n for n, one in options.items() if one.key)]
        done += ["size", "crop"] if isinstance(self, SizedOptions) else []
        return self.changed(**{**{name: options[name].default for name in done}, **words})

    def check_reads(self) -> None:
        """Refuse what only says how a file is read, where there is none.

        Raises
        ------
        OptionError
        """
        for name in self.given(*READING):
            raise OptionError("the scene is loaded already: give it to alight.load", name)


@table
class SizedOptions(SceneOptions):
    """Options of what renders pictures of another size than the scene's."""

    size: tuple[int, int] | int | str | None = option(
        Size(),
        "Pixels, such as 640x360, or paper, such as 3.5x2.5in or 9x6cm; a single number is the "
        "side of a square.",
        panel=SCENE,
        default=None,
    )
    crop: tuple[int, int, int, int] | str | None = option(
        Crop(), "Region to render, in pixels.", panel=SCENE, default=None
    )

    def __post_init__(self) -> None:
        """Make pixels of a size on paper."""
        super().__post_init__()
        if isinstance(self.size, Paper):
            dpi = getattr(self, "dpi", None) or DPI
            object.__setattr__(self, "size", self.size.pixels(dpi))

    def _sizes(self) -> list[str]:
        # One after the other: a crop of the scene file need not fit a new size.
        size, crop = self.size, self.crop
        found = [] if size is None else ["film.crop=null", f"film.size={list(size)}"]
        return found if crop is None else [*found, f"film.crop={list(crop)}"]


def camera() -> Any:
    """Declare which camera looks."""
    return option(
        Text("NAME|NUMBER"),
        "Camera node of the scene: its path, its name, or its number, from 0.",
        key="camera", panel=SCENE, default=None
    )  # fmt: skip


def integrator() -> Any:
    """Declare the algorithm."""
    help = (
        "Integrator: path, volpath, direct, ambient_occlusion, random_walk, light, bidirectional "
        "or one of a plug-in."
    )
    return option(Text(), help, key="integrator.type", panel=SCENE, default=None)


def max_depth() -> Any:
    """Declare the end of all paths."""
    help = "Longest path, in edges."
    return option(Text("INTEGER"), help, key="integrator.max_depth", panel=SCENE, default=None)


def sampler() -> Any:
    """Declare the source of random numbers."""
    help = "Sampler: independent, stratified, multijittered, halton, sobol or one of a plug-in."
    return option(Text(), help, key="sampler.type", panel=SCENE, default=None)


def filter() -> Any:
    """Declare the pixel filter."""
    help = "Pixel filter: box, tent, gaussian, mitchell or one of a plug-in."
    return option(Text(), help, key="film.filter", panel=SCENE, default=None)


def rr_depth() -> Any:
    """Declare where paths may end by chance."""
    help = "Depth at which Russian roulette starts."
    return option(Text("INTEGER"), help, key="integrator.rr_depth", panel=SCENE, default=None)
