"""The render loop of a view: one thread that follows the camera.

::

    while the camera moves:   one sample of a small picture, at once
    when it rests:            the main loop of `alight render`, until its schedule ends it
    when it moves again:      that render is cancelled, tile by tile

What settles is made by the very job that ``alight render`` makes of the same scene and options, so
its film has the same bits.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from alight.core.errors import AlightError
from alight.options.render import RenderOptions
from alight.outputs.picture import as_picture
from alight.rendering.executors.blocks import Threads
from alight.rendering.job import Job
from alight.rendering.main_loop import REPORT_EVERY, render_passes
from alight.rendering.schedules.passes import Pace
from alight.scene import Scene
from alight.view.layers import FileLayers, GrowingLayers, Layers
from alight.view.movable import Movable
from alight.view.pose import Pose

#: Seconds without a move after which the camera is at rest.
REST = 0.15

#: Phases in which a render can go on to more samples, and all in which nothing is rendered.
_COMPLETE = ("done", "stopped")
_ENDED = (*_COMPLETE, "failed")

#: Seconds to wait for a loop to end, and for the kernel that looks where a pixel is.
_PATIENCE, _WAIT_FOR_LOOK = 2.0, 0.25


@dataclass(frozen=True)
class Wish:
    """What shall be rendered.

    Attributes
    ----------
    number : int
        Of the view: another camera, another number.
    pose : Pose or None
        None is the scene's own camera, untouched.
    moves : bool
        Whether the camera is being moved.
    spp : int or None
        Samples per pixel, in place of what the options say.
    stops : bool
        Whether the render shall end where it is.
    """

    number: int = 0
    pose: Pose | None = None
    moves: bool = False
    spp: int | None = None
    stops: bool = False


class LiveScene:
    """A scene, rendered for as long as somebody looks.

    Parameters
    ----------
    scene : Scene
    options : RenderOptions
    changed : callable
        Called from the loop's thread whenever there is more to see.

    Attributes
    ----------
    pose : Pose
        Where the camera is, and what it turns about.
    layers : Layers or None
        What is to be seen now; None before the first samples.
    phase : {"compiling", "moving", "rendering", "done", "stopped", "failed"}
        Of what was asked for last: nothing has ended before the loop has heard of it.
    problem : str
        Why it failed.
    job : Job or None
        The render that settles, or has settled.
    """

    def __init__(
        self,
        scene: Scene,
        options: RenderOptions,
        changed: Callable[[], None],
    ) -> None:
        self._changed = changed
        self.movable = Movable(scene, options)
        self.pose = Pose.of(self.movable.flat.camera)
        self.layers: Layers | None = None
        self._phase, self.problem = "compiling", ""
        self.job: Job | None = None
        # Which view it is of.
        self._number: int | None = None
        self._wish, self._cancel = Wish(), threading.Event()
        self._done: Wish | None = None
        self._news = threading.Condition()
        self._closed = False
        # A changed scene that waits for its kernels, and whether the camera stays with it.
        self._next: Movable | None = None
        self._compiles = threading.Lock()
        self._keeps_camera = True
        # Whether there is machine code for `aim`.
        self._looks = threading.Event()
        self._eye: threading.Thread | None = None
        self._small: tuple[int, np.ndarray] | None = None
        self._thread = threading.Thread(target=self._run, name="alight view", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------------------ what is asked for

    @property
    def wish(self) -> Wish:
        """The latest request."""
        return self._wish

    @property
    def scene(self) -> Scene:
        """The scene with its camera as it is now."""
        return self.movable.scene_from(self._wish.pose)

    @property
    def phase(self) -> str:
        """How far what was asked for is."""
        phase, wish = self._phase, self._wish
        if phase not in _ENDED or wish is self._done:
            return phase
        return "moving" if wish.moves else "rendering"

    def move(self, change: Callable[[Pose], Pose]) -> None:
        """Move the camera; a pose of which no picture can be taken is left alone."""
        with self._news:
            pose = change(self.pose)
            if pose.is_usable:
                self.pose, last = pose, self._wish
                self._ask(Wish(last.number + 1, pose, moves=True, spp=last.spp))

    def change(self, scene: Scene, keeps_camera: bool = True) -> None:
        """Render another scene in place of this one.

        At once if there are kernels for it: else they are compiled in a thread of their own, while
        the scene before goes on.

        Parameters
        ----------
        scene : Scene
        keeps_camera : bool, default True
            Whether a camera that was moved stays where it is; False takes that of the scene.

        Raises
        ------
        SceneError
            If it cannot be rendered; the scene before goes on.
        """
        movable = Movable(scene, self.movable.options)
        with self._news:
            # A camera that is still waiting for its kernels is in this scene, too.
            self._keeps_camera = keeps_camera and (self._next is None or self._keeps_camera)
            self._next = movable
            same = movable.compiled.program == self.movable.compiled.program
            if same:
                self._take_next()
        if not same:
            threading.Thread(target=self._prepare, args=(movable,), daemon=True).start()
        self._changed()

    @property
    def prepares(self) -> bool:
        """Whether kernels are compiled for a changed scene."""
        return self._next is not None

    def _prepare(self, movable: Movable) -> None:
        """Compile the kernels of a changed scene, and take it if none has come after it."""
        problem = ""
        # One at a time: of those that wait, only the newest is of use.
        with self._compiles:
            if self._next is not movable:
                return
            try:
                movable.prepare()
            except Exception as error:
                problem = _words(error)
        with self._news:
            if self._next is not movable:
                return
            if problem:
                self._next, self.problem = None, problem
            else:
                # A kernel that looks at pixels is compiled anew, too.
                self._looks, self._eye = threading.Event(), None
                self._take_next()
        self._changed()

    def _take_next(self) -> None:
        assert self._next is not None
        self.movable, self._next, self.problem = self._next, None, ""
        last, keeps_camera = self._wish, self._keeps_camera
        pose = last.pose if keeps_camera else None
        if pose is None:
            mine, old = Pose.of(self.movable.flat.camera), self.pose
            self.pose = replace(mine, pivot=old.pivot, up=old.up) if keeps_camera else mine
        self._ask(Wish(last.number + 1, pose, spp=last.spp))

    def rest(self) -> None:
        """The camera has come to rest: do not wait for it."""
        with self._news:
            if self._wish.moves:
                self._wish = replace(self._wish, moves=False)
                self._news.notify_all()

    def aim(self, x: int, y: int) -> None:
        """Put the pivot on what a pixel of the window shows.

        It stays where it is if that is nothing, and while the kernel that looks is compiled.
        """
        point = self.seen_at(x, y, _WAIT_FOR_LOOK)
        if point is not None:
            self.turn_about(point)

    def turn_about(self, point: np.ndarray) -> None:
        """Put the pivot there."""
        with self._news:
            self.pose = replace(self.pose, pivot=point)

    def seen_at(self, x: int, y: int, patience: float | None = None) -> np.ndarray | None:
        """Find the point that a pixel of the window shows.

        None if that is nothing, or if the kernel that looks is compiled for longer than `patience`,
        in seconds.
        """
        if not self._looks.is_set():
            if self._eye is None:
                self._eye = threading.Thread(target=self._prepare_to_look, daemon=True)
                self._eye.start()
            if not self._looks.wait(patience):
                return None
        left, top, width, height = self.movable.window
        at = left + min(x, width - 1), top + min(y, height - 1)
        return self.movable.hit(self.pose, *at)

    def _prepare_to_look(self) -> None:
        self.movable.hit(self.pose, *self.movable.window[:2])
        self._looks.set()

    def more(self) -> None:
        """Go on to twice the samples."""
        with self._news:
            job = self.job
            if self.phase in _COMPLETE and job is not None:
                target = max(2 * round(job.film.spp), 1)
                self._ask(replace(self._wish, spp=target, stops=False))

    def stop(self) -> None:
        """End the render where it is."""
        with self._news:
            # What is rendered may be a view from which the camera has moved on, and more samples
            # may have been asked for that the loop has not begun.
            if self.phase not in _ENDED and self._number == self._wish.number:
                self._ask(replace(self._wish, stops=True))

    def close(self) -> None:
        """End the loop, and wait for it, but not for a compiler."""
        with self._news:
            self._closed = True
            self._ask(self._wish)
        self._thread.join(_PATIENCE)

    def _ask(self, wish: Wish) -> None:
        self._wish = wish
        self._cancel.set()
        self._news.notify_all()

    # ------------------------------------------------------------------------ the loop

    def _run(self) -> None:
        while not self._closed:
            with self._news:
                self._news.wait_for(lambda: self._wish is not self._done or self._closed)
                wish, self._cancel = self._wish, threading.Event()
                cancel = self._cancel
                if self._closed:
                    return
            try:
                if wish.moves:
                    self._show_small(wish, cancel)
                    self._wait_for_rest(wish)
                elif wish.stops:
                    self._end(wish)
                else:
                    self._settle(wish, cancel)
                    self._done = wish
            except Exception as error:
                # The page outlives a view that cannot be rendered, and a bug of ours.
                self.problem = _words(error)
                self._tell("failed", wish)

    def _wait_for_rest(self, wish: Wish) -> None:
        with self._news:
            if not self._news.wait_for(lambda: self._wish is not wish, REST):
                self._wish = replace(wish, moves=False)

    def _show_small(self, wish: Wish, cancel: threading.Event) -> None:
        """Render one sample of a small picture, and show it if it is still wanted."""
        job = self.movable.coarse_job(wish.pose or self.pose, 1)
        job.start(None)
        with Threads() as threads:
            threads.begin(job)
            render_passes(job, threads, Pace(1), cancel, lambda: None)
        if not cancel.is_set():
            image = job.film.image
            self._small = wish.number, image
            layers = FileLayers(as_picture(image))
            layers.number = wish.number
            # Whoever paints them now must know which view they are of.
            self.layers = layers
            self._tell("moving" if wish.moves else "rendering")

    def _settle(self, wish: Wish, cancel: threading.Event) -> None:
        """Render the picture until it is finished or no longer wanted."""
        job = self._continued(wish)
        if job is None:
            self.job = None
            if self._small is None or self._small[0] != wish.number:
                self._show_small(wish, cancel)
            job = self.movable.job(wish.pose, wish.spp)
        if self._small is None or cancel.is_set():
            return
        job.start(None)
        self.job, layers = job, GrowingLayers(job.film, self._small[1])
        self._number = layers.number = wish.number
        self._phase, told = "rendering", 0.0

        def report() -> None:
            nonlocal told
            if job.seconds - told > REPORT_EVERY:
                told = job.seconds
                layers.film = job.film
                self.layers = layers
                self._changed()

        job.start_clock()
        try:
            with Threads() as threads:
                threads.begin(job)
                render_passes(job, threads, Pace(self.movable.options.spp_per_pass), cancel, report)
        finally:
            job.stop_clock()
        if not cancel.is_set():
            layers.film = job.film
            self.layers = layers
            self._end(wish)

    def _continued(self, wish: Wish) -> Job | None:
        """The job of the same view, if it only has to go on."""
        job = self.job
        if job is None or wish.spp is None or self._number != wish.number:
            return None
        job.schedule, job.goal = job.schedule.extended(wish.spp), None
        return job

    def _end(self, wish: Wish) -> None:
        """Complete a film as ``alight render`` does."""
        job = self.job
        assert job is not None
        job.record_biases()
        job.film.stats = job.statistics({})
        self._tell("stopped" if wish.stops else "done", wish)

    def _tell(self, phase: str, ended: Wish | None = None) -> None:
        self._phase = phase
        if ended is not None:
            # Last: the phase before is not that of this view.
            self._done = ended
        self._changed()


def _words(error: Exception) -> str:
    """What the page shows of an error; bugs are printed on the terminal, too."""
    if not isinstance(error, AlightError):
        traceback.print_exception(error)
    return str(error) or type(error).__name__
