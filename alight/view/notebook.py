"""A render in the background of a notebook: its picture while it goes on, and its film at the end.

::

    live = alight.view("cornell-box", spp=256)
    live                                         shown below the cell, which ends at once
    film = live.wait()                           the film of `alight.render`, bit for bit

Where anywidget is installed and the notebook shows widgets, a picture refines beside its error, the
time that is left and a button to stop; its frames are those of the page of ``alight view``.
Anywhere else, and in a notebook that was saved, the cell shows a static picture, which is replaced
from time to time and at the end.
"""

from __future__ import annotations

import html
import logging
import math
import threading
import time
from collections.abc import Callable
from functools import cache
from importlib import resources
from importlib.util import find_spec
from typing import Any

import numpy as np

from alight.films import Film
from alight.films.notebook import html_of, html_of_warnings
from alight.options.entry import takes
from alight.options.render import RenderOptions
from alight.rendering import Progress
from alight.rendering.render import Prepared, prepare
from alight.rendering.writing import finish
from alight.view.frames import frame

_LOG = logging.getLogger("alight")

#: Largest share of the time for frames and errors, and the least seconds between static pictures.
_SHARE, _STATIC_EVERY = 0.1, 1.0

_IMPORT = 'import { draw, frameOf } from "./frames.js";\n'


@takes(RenderOptions)
def view(scene: Any, options: RenderOptions) -> LiveFilm:
    """Render in the background, and show the picture while it refines, in a notebook.

    Parameters
    ----------
    scene : Scene, path, name of a built-in scene, dict or object
        Everything that `alight.load` takes.
    {options}

    Returns
    -------
    LiveFilm
        To be the last expression of a cell.

    Raises
    ------
    AlightError
        For a scene or an option that is wrong; what goes wrong later is raised by
        `LiveFilm.wait`.
    """
    return LiveFilm(prepare(scene, options))


class LiveFilm:
    """A render in the background; see `view`.

    Attributes
    ----------
    film : Film or None
        As it is now; None until its scene is compiled.
    is_done : bool
        Whether it has ended.
    """

    def __init__(self, prepared: Prepared) -> None:
        self.film: Film | None = None
        self._prepared, self._begin = prepared, time.perf_counter()
        self._display = prepared.options.display
        self._cancel, self._done = prepared.options.cancel or threading.Event(), threading.Event()
        self._problem: BaseException | None = None
        self._text, self._next, self._next_static = "waiting", 0.0, 0.0
        self._handles: list[Any] = []
        self._widget = _widget(self._cancel.set)
        self._thread = threading.Thread(target=self._run, name="alight notebook", daemon=True)
        self._thread.start()

    # ----------------------------------------------------------------------- what others ask for

    @property
    def is_done(self) -> bool:
        """Whether it has ended."""
        return self._done.is_set()

    def stop(self) -> None:
        """End it where it is; `wait` then gives the film that there is."""
        self._cancel.set()

    def wait(self) -> Film:
        """Wait for the end. An interrupt stops the render.

        Raises
        ------
        AlightError
            If the render, or writing its files, has failed.
        """
        try:
            # Not for ever at once: an interrupt would wait as long.
            while not self._done.wait(0.1):
                pass
        except KeyboardInterrupt:
            self.stop()
            self._done.wait()
        if self._problem is not None:
            raise self._problem
        assert self.film is not None
        return self.film

    def __repr__(self) -> str:
        """Say how far it is."""
        return f"<LiveFilm: {self._text}>"

    def _repr_html_(self) -> str:
        """Show the picture as it is now."""
        said = f"<p>{html.escape(self._text)}</p>"
        if not self._has_samples:
            return said + (html_of_warnings(self.film) if self.film else "")
        return html_of(self.film, self._display) + (said if self._problem is not None else "")

    def _ipython_display_(self) -> None:
        """Show it below a cell, and again whenever there is more to see."""
        from IPython.display import display

        bundle = {"text/plain": repr(self), "text/html": self._repr_html_()}
        if self._widget is not None and not self.is_done:
            bundle |= self._widget._repr_mimebundle_()[0]
        self._handles.append(display(bundle, raw=True, display_id=True))
        if self.is_done:
            self._show_still()

    # --------------------------------------------------------------------------------- the thread

    @property
    def _has_samples(self) -> bool:
        return self.film is not None and bool(self.film.sample_count.any())

    def _run(self) -> None:
        prepared = self._prepared
        try:
            self.film = prepared.render(progress=self._take, cancel=self._cancel)
            is_whole = not self._cancel.is_set()
            if is_whole:
                finish(self.film, prepared.targets, self._begin, prepared.warnings())
            # Who stops it while its files are written comes too late.
            self._text = "done" if is_whole else "stopped"
        except BaseException as problem:
            self._problem, self._text = problem, f"{type(problem).__name__}: {problem}"
        finally:
            self._show("done", 1.0)
            self._done.set()
            self._show_still()

    def _take(self, progress: Progress) -> None:
        """A report of the main loop."""
        self.film = progress.film
        own = self._prepared.options.progress
        if own is not None:
            own(progress)
        begin = time.perf_counter()
        if progress.phase != "render":
            self._text = "compiling kernels (first run only)"
            self._show(progress.phase, None)
        elif begin >= self._next:
            share = _share(progress, self._prepared.options)
            self._text = _words(progress, share)
            self._show("render", share)
            if self._widget is None and begin >= self._next_static:
                self._show_still()
                self._next_static = time.perf_counter() + _STATIC_EVERY
            now = time.perf_counter()
            self._next = now + (now - begin) * (1.0 / _SHARE - 1.0)

    def _show(self, phase: str, share: float | None) -> None:
        """Picture and progress for the page; one that is lost does not cost the film."""
        try:
            self._paint()
            self._tell(phase, share)
        except Exception as problem:
            _LOG.warning("the picture in the notebook is not shown any more: %s", problem)
            self._widget = None

    def _paint(self) -> None:
        if self._widget is None or self.film is None or not self._has_samples:
            return
        picture = self.film.picture(layers=False)
        shown = self._display.developed(picture.straight).apply(picture.straight)
        colors, alpha = picture.over_display(shown)
        whole = np.ones(colors.shape[:2]) if alpha is None else alpha
        rgba = np.rint(np.concatenate([colors, whole[..., None]], axis=-1) * 255.0)
        self._widget.frame = frame(0, 0, rgba.astype(np.uint8))

    def _tell(self, phase: str, share: float | None) -> None:
        if self._widget is not None:
            told = {"phase": phase, "share": share, "text": self._text}
            self._widget.told = told | {"warnings": self.film.warnings if self.film else []}

    def _show_still(self) -> None:
        """Put a static picture in the place of what cells show."""
        bundle = {"text/plain": repr(self), "text/html": self._repr_html_()}
        for handle in self._handles:
            handle.update(bundle, raw=True)


def _share(progress: Progress, options: RenderOptions) -> float | None:
    """How much of the render is done, by its samples, its time or its error; None if unknown."""
    shares = []
    if progress.total_samples:
        shares.append(progress.done_samples / progress.total_samples)
    limits = (options.time_limit, options.max_time)
    shares += [progress.seconds / limit for limit in limits if isinstance(limit, float)]
    if isinstance(options.error, float):
        error = progress.film.relmse_estimate(literature=False).relrmse.value
        # The square of the error falls as the samples grow.
        shares.append(0.0 if math.isnan(error) else (options.error / max(error, 1e-9)) ** 2)
    return min(max(shares), 1.0) if shares else None


def _words(progress: Progress, share: float | None) -> str:
    """Samples, error and the time that is left."""
    facts = [f"{progress.film.spp:.3g} spp"]
    error = progress.film.relmse_estimate(literature=False).relrmse.value
    if not math.isnan(error):
        facts.append(f"error {error:.2%}")
    if share:
        facts.append(f"{progress.seconds * (1.0 / share - 1.0):.0f} s left")
    return ", ".join(facts)


def module_text() -> str:
    """The module of the widget, one text as anywidget wants it."""
    page = resources.files("alight.view") / "page"
    frames, own = ((page / f"{n}.js").read_text("utf-8") for n in ("frames", "notebook"))
    return frames.replace("export function", "function") + own.replace(_IMPORT, "")


def _widget(stop: Callable[[], None]) -> Any:
    """A widget, or None where nothing shows one."""
    if find_spec("anywidget") is None or find_spec("IPython") is None:
        return None
    made = _widget_class()()
    made.observe(lambda change: stop() if change["new"] else None, "stops")
    return made


@cache
def _widget_class() -> Any:
    import anywidget
    import traitlets

    class Widget(anywidget.AnyWidget):
        """State for the browser, and whether it wants to stop."""

        _esm = module_text()
        frame = traitlets.Bytes(b"").tag(sync=True)
        told = traitlets.Dict({"phase": "load", "share": None, "text": ""}).tag(sync=True)
        stops = traitlets.Bool(False).tag(sync=True)

    return Widget
