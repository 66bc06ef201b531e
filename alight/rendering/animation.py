r"""`alight.animate`: many pictures of a scene, each made as `alight.render` makes one.

Frame n shows the scene while the camera's shutter is open, which counts in frames: with the shutter
[a, b] of the scene from (n + a) / fps to (n + b) / fps, in the unit of the keyframes. A turntable
keeps the time and turns the camera about the vertical through the middle of what is seen. A file
of glTF or OpenUSD that has an animation is read once for each frame, n / fps seconds after the time
that `at` names, and shown sharp.

A frame that is there already is kept if its file says that it is this very picture: of the same
scene, by its hash, with the same samples, kernels and display. So an animation that was killed
goes on where it was, and one whose end was changed renders the end alone. Only EXR and PNG files
say so, and a film is made from EXR files only. On a cluster the workers share two frames and the
samples of each, and stay from frame to frame.
"""

from __future__ import annotations

import hashlib
import json
import threading
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import OptionError, unknown_name
from alight.core.version import VERSION
from alight.films import Film
from alight.films.denoising import denoise
from alight.films.storage import is_film_file
from alight.formats.readers import choices_of
from alight.options.animation import AnimationOptions
from alight.options.device import GPU
from alight.options.entry import takes
from alight.options.render import RenderOptions
from alight.outputs import exr, moving, png
from alight.outputs.atomic import check_folder
from alight.outputs.image import FORMATS, check_writable, format_of, read_picture, write_image
from alight.outputs.moving import MovingFile
from alight.outputs.picture import Picture
from alight.rendering import main_loop
from alight.rendering.executors.blocks import Crew, Threads
from alight.rendering.executors.cluster_executor import joined
from alight.rendering.frame_files import FRAME, label_in, numbered
from alight.rendering.frame_scenes import (
    at_time,
    is_still,
    middle,
    played,
    shown_from,
    turned,
)
from alight.rendering.job import Progress
from alight.rendering.render import prepare
from alight.rendering.resources import usable_processors
from alight.rendering.schedules.passes import PASS_SECONDS
from alight.rendering.schedules.selection import time_limit_of
from alight.scene import Scene, content_hash, flatten
from alight.scene.flatten import place_camera
from lanewise.machine import fingerprint

#: Two frames share the threads, and none is shown before its end: passes may be longer than of a
#: picture alone, and have less to add to the film.
_PASSES_IN_ONE = 4

#: Options that change no bit of a frame.
_NO_PART = frozenset({
    "output", "threads", "spp_per_pass", "progress", "cancel", "notes", "cluster", "cluster_keys",
})  # fmt: skip

#: Pixels of a frame beyond which there are no two in work: each film takes 250 bytes a pixel.
_LARGE = 2**22

#: What is shown of a frame where nothing shows it.
_NOTHING = np.zeros((1, 1, 3), np.uint8)


class _CancelledError(Exception):
    """A frame was cancelled."""


class _Stop(threading.Event):
    """Ends frames that are in work; the user's event does so too, and is the user's to set."""

    def __init__(self, users: threading.Event | None) -> None:
        super().__init__()
        self._users = users or threading.Event()

    def is_set(self) -> bool:
        return super().is_set() or self._users.is_set()


@takes(AnimationOptions)
def animate(scene: Any, options: AnimationOptions) -> list[Path]:
    """Render an animation.

    Parameters
    ----------
    scene : Scene, path, name of a built-in scene, dict or object
        Everything that `alight.load` takes.
    {options}

    Returns
    -------
    list of Path
        The files: of `output`, names with ``####`` stand for a file per frame, names that end in
        ``.gif``, ``.apng`` or ``.mp4`` for all of them.

    Raises
    ------
    AlightError
        For a scene or an option that is wrong, and for a file that cannot be written.

    Examples
    --------
    >>> alight.animate("cornell-box", frames="0:8", output="box.gif")  # doctest: +SKIP
    """
    return Animation(scene, options).render()


class Animation:
    """An animation before its first frame: everything that can be wrong with it is found.

    Parameters
    ----------
    scene, options
        See `animate`.

    Attributes
    ----------
    prepared : Prepared
        The render of a frame: its scene, and what is suspicious of it.
    scene : Scene
    numbers : range
        Of the frames.
    current : int
        Number of the frame that is rendered now, or that is next.
    warnings : dict of str to None
        Those of all frames so far, each once.
    """

    def __init__(self, scene: Any, options: AnimationOptions) -> None:
        self.options, self.numbers = options, options.numbers
        outputs: Any = options.output
        paths = [Path(path) for path in outputs]
        self.films = [path for path in paths if moving.is_moving(path)]
        self.patterns = [path for path in paths if not moving.is_moving(path)]
        self._check()
        single = options.of_frame(())
        chosen = single.animation is not None and not options.turntable
        if chosen and single.at is None and "animation" in choices_of(scene):
            # At rest a file is of none of its animations.
            single = single.changed(at=0.0)
        self.prepared = prepare(scene, single)
        asked = [name for name in single.aovs if name not in single.layers_of_background]
        # A film shows what a JPEG file does.
        targets = replace(self.prepared.targets, outputs=self.patterns or [Path("film.jpg")])
        self.prepared.useless.extend(targets.useless(asked, single.background != "scene"))
        self.current, self._origin = self.numbers.start, None
        plays = self.prepared.scene.source.remarks.plays
        if plays and not options.turntable and not isinstance(scene, Scene):
            # All frames are seen as the first one of them all, whichever of them are rendered.
            self._origin = shown_from(self.prepared.scene)
            self.prepared = replace(self.prepared, scene=self.scene_of(self.current))
        self.scene = self.prepared.scene
        if options.turntable and place_camera(self.scene).motion is not None:
            text = "{turntable} takes the camera as it is at first, without its motion"
            self.prepared.useless.append((text, ("turntable",)))
        moves = options.turntable or self._origin is not None or not is_still(self.scene)
        if len(self.numbers) > 1 and not moves:
            remedy = "{turntable} turns the camera"
            if plays:
                remedy = "the animation of its file is played if the file's path is given"
            text = f"nothing in the scene has keyframes, so all frames are alike; {remedy}"
            self.prepared.useless.append((text, ("frames", "turntable")))
        # What the scene sets already is not set again for every frame; denoising has added layers.
        self.single = self.prepared.options.with_loaded_scene()
        #: By frame: threads are done in any order.
        self._kept: dict[int, list[Path]] = {}
        self.warnings: dict[str, None] = {}
        self.threads = single.threads or usable_processors()
        self._stop = _Stop(options.cancel)
        self._pace: dict[str, int] = {}
        self._pivot = middle(flatten(self.scene)) if options.turntable else np.zeros(3)

    def _check(self) -> None:
        if not self.films and not self.patterns:
            text = "give {output} frame_####.png, or a name that ends in .gif, .apng or .mp4"
            raise OptionError(text, "", ("output",))
        for path in self.films:
            moving.check_encoder(path)
            check_folder(path)
        for path in self.patterns:
            if is_film_file(path):
                raise OptionError(f"films are of single pictures; got {path}", "output")
            suffixes = [suffix for module in FORMATS for suffix in module.SUFFIXES]
            if path.suffix.lower() not in suffixes:
                valid = [*suffixes, *moving.SUFFIXES]
                raise OptionError(unknown_name("suffix", path.suffix, valid), "output")
            check_writable(path)
            if "#" not in path.name:
                text = f"must hold #### for the number of the frame, got {path}"
                raise OptionError(text, "output")

    @property
    def kept(self) -> list[Path]:
        """Files of frames that were there already, in the order of the frames."""
        return [path for number in sorted(self._kept) for path in self._kept[number]]

    @property
    def goes_on(self) -> bool:
        """Whether the same command keeps the frames that exist and goes on."""
        suffixes = {path.suffix.lower() for path in self.patterns}
        # 8 bits and a display are too little to make a film from.
        return bool(suffixes) and suffixes <= {*exr.SUFFIXES, *png.SUFFIXES} and (
            not self.films or not suffixes.isdisjoint(exr.SUFFIXES)
        )  # fmt: skip

    def render(self) -> list[Path]:
        """Render what is not there, and write everything."""
        with joined(self.single) as self.single:
            written = [numbered(path, n) for n in self.numbers for path in self.patterns]
            try:
                with ExitStack() as stack:
                    films = [
                        stack.enter_context(MovingFile(path, self.options.fps, len(self.numbers)))
                        for path in self.films
                    ]
                    for shown in self._frames():
                        for film in films:
                            film.add(shown)
            except _CancelledError:
                return written[: (self.current - self.numbers.start) * len(self.patterns)]
            return [*written, *self.films]

    def _frames(self) -> Iterator[np.ndarray]:
        """What films show of each frame, in order; while one is finished the next is begun."""
        many, self._stop = self._at_once(), _Stop(self.options.cancel)
        with Crew(self.threads) as crew, ThreadPoolExecutor(many) as pool:
            begun: deque[Future[np.ndarray]] = deque()
            waiting = iter(self.numbers)
            try:
                for current in self.numbers:
                    self.current = current
                    # A frame that failed ends the animation when its turn comes: none is begun.
                    failed = any(frame.done() and frame.exception() for frame in begun)
                    for number in islice(waiting, 0 if failed else many - len(begun)):
                        begun.append(pool.submit(self._frame, number, crew))
                    yield begun.popleft().result()
            except BaseException:
                # Frames that have been begun are not finished.
                self._stop.set()
                raise

    def _at_once(self) -> int:
        """How many frames are in work: two, to leave no thread or worker idle while one is written.

        But one on a single thread, where frames have a time for themselves, and where they are so
        large that their samples alone keep all threads busy.
        """
        width, height = self.prepared.scene.film.size
        alone = (
            (self.threads == 1 and self.single.cluster is None)
            or time_limit_of(self.single) is not None
            or width * height > _LARGE
        )
        return 1 if alone else 2

    def _frame(self, number: int, crew: Crew) -> np.ndarray:
        """Make the files of a frame that are not there; what films show of it, if there are any."""
        paths = [numbered(path, number) for path in self.patterns]
        scene = self.scene_of(number)
        label = self.label_of(scene)
        missing = [path for path in paths if label_in(path) != label]
        self._kept[number] = [path for path in paths if path not in missing]
        linear = [path for path in paths if path.suffix.lower() in exr.SUFFIXES]
        if paths and not missing and (linear or not self.films):
            return self._shown(read_picture(linear[0])) if self.films else _NOTHING
        elsewhere = self.single.cluster is not None or self.single.device == GPU
        executor = None if elsewhere else Threads(crew)
        film = main_loop.render_film(scene, self._options_of(number), executor)
        if self._stop.is_set():
            raise _CancelledError
        self._note_pace(film)
        of_scene = film.scene_warnings
        for text in film.warnings:
            self.warnings[text if text in of_scene else f"frame {number}: {text}"] = None
        picture = self._picture_of(film, any(format_of(path).KEEPS_LAYERS for path in missing))
        picture = replace(picture, attributes={**picture.attributes, FRAME: label})
        for path in missing:
            write_image(path, picture, **asdict(self.options.display))
        return self._shown(picture) if self.films else _NOTHING

    def _options_of(self, number: int) -> RenderOptions:
        """The options of a frame's render: its progress is shown while it is the current one."""
        show = self.single.progress

        def shown(progress: Progress) -> None:
            if show is not None and number == self.current:
                show(progress)

        changed = {} if show is None else {"progress": shown}
        return self.single.changed(cancel=self._stop, **self._pace, **changed)

    def _note_pace(self, film: Film) -> None:
        """Frames after the first need no short pass to find out how long passes are."""
        alone = time_limit_of(self.single) is not None or self.single.cluster is not None
        if self.single.spp_per_pass is None and not alone:
            _, _, width, height = film.crop
            seconds = _PASSES_IN_ONE * PASS_SECONDS
            spp = 1e6 * film.stats["msamples_per_s"] * seconds / (width * height)
            self._pace = {"spp_per_pass": max(1, round(spp))}

    def _picture_of(self, film: Film, layers: bool) -> Picture:
        """What the files of a frame hold."""
        return denoise(film)[0] if self.single.denoise else film.picture(layers)

    def _shown(self, picture: Picture) -> np.ndarray:
        """What a film shows of a picture, uint8: without alpha, it is seen over black."""
        display = self.options.display.developed(picture.straight)
        return np.rint(255.0 * display.apply(picture.image)).astype(np.uint8)

    def scene_of(self, number: int) -> Scene:
        """The scene of a frame."""
        if self._origin is not None:
            return played(self._origin, number / self.options.fps)
        if not self.options.turntable:
            return at_time(self.scene, number, self.options.fps)
        turn = -360.0 * (number - self.numbers.start) / len(self.numbers)
        return turned(self.scene, self._pivot, turn)

    def label_of(self, scene: Scene) -> str:
        """Everything that decides the file of a frame, in short."""
        single: RenderOptions = self.single
        kept = {name: value for name, value in single.given().items() if name not in _NO_PART}
        said = json.dumps({name: repr(value) for name, value in sorted(kept.items())})
        parts = (VERSION, fingerprint(), content_hash(scene), str(scene.source.remarks.spp), said)
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()
