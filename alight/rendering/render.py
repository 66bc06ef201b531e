"""`alight.render`: a scene becomes a film, and the requested files.

::

    prepare    check every option, load and change the scene           loading.py
    render     samples, until it is enough                             main_loop.py
    finish     write pictures and statistics, lose nothing             writing.py
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from alight.cluster.fork_server import RENDERS, start_fork_server
from alight.core.errors import OptionError, SceneError
from alight.films import Film
from alight.films.denoising import FEATURES
from alight.films.storage import is_film_file
from alight.options.entry import takes
from alight.options.loading import scene_of
from alight.options.plugins import load_plugins
from alight.options.render import HIDES, RenderOptions
from alight.rendering import main_loop
from alight.rendering.checkpoints.checkpoint import check_nothing_is_lost
from alight.rendering.writing import Targets, finish
from alight.scene import Scene


@dataclass(frozen=True)
class Prepared:
    """A render before its first second: everything that can be wrong with its options is found.

    Attributes
    ----------
    scene : Scene
        With the options' changes.
    options : RenderOptions
    targets : Targets
    useless : list of (str, tuple of str)
        Options without effect: the message, and their names in it.
    """

    scene: Scene
    options: RenderOptions
    targets: Targets
    useless: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)

    def warnings(self, spell: Callable[[str], str] = str) -> list[str]:
        """What is legal but suspicious, with options spelled as the user has written them."""
        useless = [OptionError(text, names=names).spelled(spell) for text, names in self.useless]
        return [*self.scene.warnings, *useless]

    def render(self, **seen: object) -> Film:
        """Render; `seen` may replace `progress` and `cancel`."""
        return main_loop.render_film(self.scene, self.options.changed(**seen))


def prepare(scene: Any, options: RenderOptions) -> Prepared:
    """Check options and targets, and load the scene.

    Raises
    ------
    AlightError
        For a scene or an option that is wrong.
    """
    start_fork_server(options.cluster, RENDERS)
    options.take_target()
    # Before the options, which may name a tone curve of theirs.
    load_plugins(options.plugins)
    targets = Targets(
        options.output, options.display, options.denoise, options.stats, options.checkpoint,
        options.plugins,
    )  # fmt: skip
    targets.check()
    if targets.checkpoint is not None:
        check_nothing_is_lost(targets.checkpoint)
    for path in targets.outputs:
        if "##" in path.name:
            text = f"#### stands for the number of a frame, and this is one picture: {path}"
            raise OptionError(text, "output")
    if options.part and options.output and not any(map(is_film_file, options.output)):
        text = "{part} makes a film to be merged: give {output} FILE.alight"
        raise OptionError(text, names=("part", "output"))
    description = _described(scene, options.changed(plugins=()))
    asked = [name for name in options.aovs if name not in options.layers_of_background]
    useless = options.useless()
    if options.output:
        useless += targets.useless(asked, options.background != "scene")
    layers = options.aovs
    if options.denoise:
        layers = tuple(dict.fromkeys([*layers, *FEATURES.values()]))
    notes = options.notes or targets.notes()
    return Prepared(description, options.changed(aovs=layers, notes=notes), targets, useless)


def _described(scene: Any, options: RenderOptions) -> Scene:
    """The scene, which must have a background if that shall be transparent."""
    try:
        description = scene_of(scene, options)
    except SceneError as error:
        if options.background != "scene" and any(i.path == HIDES for i in error.issues):
            text = f"{options.background} needs an integrator that can hide lights: path or direct"
            raise OptionError(text, "background") from None
        raise
    if options.background != "scene" and next(description.used_media(), None):
        text = f"{options.background} is for surfaces; of a medium no coverage is known"
        raise OptionError(text, "background")
    return description


@takes(RenderOptions)
def render(scene: Any, options: RenderOptions) -> Film:
    """Render a scene, or an object of another package.

    Parameters
    ----------
    scene : Scene, path, name of a built-in scene, dict or object
        Everything that `alight.load` takes.
    {options}

    Returns
    -------
    Film
        With the times in ``film.stats``. It holds the samples, not what the denoiser makes of
        them: that is in the files of `output`, and in `alight.denoise(film)`.

    Raises
    ------
    AlightError
        For a scene or an option that is wrong, and for a file that cannot be written; the message
        then says where the samples are.
    KeyboardInterrupt
        After the running tiles are in the film, which `progress` has been given.

    Examples
    --------
    >>> film = alight.render("cornell-box", error="5%", size=64)  # doctest: +SKIP
    >>> alight.render("cornell-box", sppp=4)
    Traceback (most recent call last):
        ...
    alight.core.errors.OptionError: unknown option "sppp"; did you mean "spp"? ...
    """
    begin = time.perf_counter()
    prepared = prepare(scene, options)
    film = prepared.render()
    if options.cancel is None or not options.cancel.is_set():
        finish(film, prepared.targets, begin, prepared.warnings())
    return film
