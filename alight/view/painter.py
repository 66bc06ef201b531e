"""The painter: a thread that develops what is shown, and hands it to every browser.

It works at once when something changes after a pause, and for at most a part of the time while a
render goes on, which needs the processor more.
"""

from __future__ import annotations

import json
import threading
import time
from typing import Any, Protocol

import numpy as np

from alight.films.denoising import denoise
from alight.metrics import ErrorEstimate
from alight.view.contrast import DIVIDER, contrast, waits
from alight.view.frames import frame
from alight.view.layers import PICTURE, Layers
from alight.view.look import Look
from alight.view.mailbox import STATE
from alight.view.session import Session
from alight.view.shades import shaded

#: Largest share of the time for frames, and for the error, while a film grows.
_FRAME_SHARE, _ERROR_SHARE = 0.2, 0.05


class Viewer(Protocol):
    """A browser that looks."""

    def post(self, kind: str, message: str | bytes) -> None:
        """Send a message, in place of an older one of its kind that has not been sent yet."""


class Painter:
    """Paints a session for its viewers.

    Parameters
    ----------
    session : Session
        It calls `wake` when something changes.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._viewers: set[Viewer] = set()
        self._news = threading.Condition()
        self._woken = self._closed = False
        self._newest: dict[str, str | bytes] = {}
        self._kept_for: tuple[Any, ...] | None = None
        self._denoised: tuple[int, int, np.ndarray, str] | None = None
        self._contrast: dict[str, float | None] = {}
        self._error: tuple[int, ErrorEstimate] | None = None
        self._next_error = 0.0
        session.changed = self.wake
        self._thread = threading.Thread(target=self._run, name="alight painter", daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """There is something new to see."""
        with self._news:
            self._woken = True
            self._news.notify()

    def join(self, viewer: Viewer) -> None:
        """A browser looks from now on."""
        with self._news:
            self._viewers.add(viewer)
            for kind, message in self._newest.items():
                viewer.post(kind, message)
        self.wake()

    def leave(self, viewer: Viewer) -> None:
        """It looks no more."""
        with self._news:
            self._viewers.discard(viewer)

    def close(self) -> None:
        """End the thread, and wait for it."""
        with self._news:
            self._closed = True
            self._news.notify()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._news:
                self._news.wait_for(lambda: self._closed or (self._woken and self._viewers))
                if self._closed:
                    return
                self._woken = False
            begin = time.perf_counter()
            self._paint()
            if self._grows():
                pause = (time.perf_counter() - begin) * (1.0 / _FRAME_SHARE - 1.0)
                # A camera that moves, or a render that ends, is shown without delay.
                with self._news:
                    self._news.wait_for(lambda: self._closed or not self._grows(), pause)

    def _grows(self) -> bool:
        """Whether the film that is shown gets more samples."""
        live = self.session.live
        return live is not None and live.phase == "rendering"

    def _paint(self) -> None:
        session = self.session
        # Before the picture: what is said to be done is then the picture of which it is said.
        told: dict[str, Any] = session.progress()
        layers, look = session.layers, session.look
        scale = None
        if layers is not None:
            plane, label = self._plane(layers, look)
            done = shaded(_name(layers, look), plane, look.display)
            scale = None if done.low is None or done.high is None else (done.low, done.high)
            told["denoised"] = label
            self._send("frame", frame(0, layers.number, done.rgba))
        # Before the error, which takes longer than a frame.
        self._tell(scale, told)
        if session.against is None:
            self._kept_for = None
        elif layers is not None and self._compare(layers, session.against, look, told):
            self._tell(scale, told)
        if self._estimate():
            self._tell(scale, told)

    def _plane(self, layers: Layers, look: Look) -> tuple[np.ndarray, str]:
        """The layer that is shown, and what was denoised of it, in words."""
        name, film = _name(layers, look), self.session.film
        if not (look.denoised and name == PICTURE and film is not None and self.session.rests):
            return layers.plane(name), ""
        samples = int(film.sample_count.sum())
        if self._denoised is None or self._denoised[:2] != (id(film), samples):
            picture, bias = denoise(film)
            self._denoised = id(film), samples, picture.image, bias.line
        return self._denoised[2], self._denoised[3]

    def _compare(self, layers: Layers, against: Layers, look: Look, told: dict[str, Any]) -> bool:
        """Send what is compared with, or how both differ; whether there is more to tell."""
        if look.way == DIVIDER:
            if self._kept_for != (against, look):
                self._kept_for = against, look
                plane = against.plane(_name(against, look))
                done = shaded(_name(against, look), plane, look.display)
                self._send("kept", frame(1, 0, done.rgba))
            return False
        if against.size != layers.size:
            told["differs"] = "the pictures differ in size"
            return True
        if not self.session.rests and (why := waits(look.way)):
            told["differs"] = why
            return True
        film = self.session.film
        samples = 0 if film is None else int(film.sample_count.sum())
        if self._kept_for != (against, look, layers, samples):
            self._kept_for = against, look, layers, samples
            plane, mean = contrast(look.way, layers.plane(PICTURE), against.plane(PICTURE))
            done = shaded(look.way, plane, look.display)
            self._send("kept", frame(1, 0, done.rgba))
            self._contrast = {"mean": mean, "low": done.low, "high": done.high}
        told["contrast"] = self._contrast
        return True

    def _tell(self, scale: tuple[float, float] | None, told: dict[str, Any]) -> None:
        state = self.session.state(self._error and self._error[1], scale, **told)
        self._send(STATE, json.dumps(state, allow_nan=False))

    def _estimate(self) -> bool:
        """Work the error of the film out anew, now and then while it grows; say if it was."""
        film = self.session.film
        if film is None:
            self._error, self._next_error = None, 0.0
            return False
        samples, now = int(film.sample_count.sum()), time.perf_counter()
        stale = self._error is None or self._error[0] != samples
        due = stale and samples > 0 and (not self._grows() or now >= self._next_error)
        if due:
            self._error = samples, film.relmse_estimate(literature=False)
            cost = time.perf_counter() - now
            self._next_error = now + max(0.5, cost / _ERROR_SHARE)
        return due

    def _send(self, kind: str, message: str | bytes) -> None:
        with self._news:
            self._newest[kind] = message
            for viewer in self._viewers:
                viewer.post(kind, message)


def _name(layers: Layers, look: Look) -> str:
    """The layer that is wished for, or the picture."""
    return look.layer if look.layer in layers.names else PICTURE
