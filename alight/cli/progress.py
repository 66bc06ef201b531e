"""The progress bar of every command, and what it shows of a render: rate, time left, error."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from rich.progress import TaskID

    from alight.films import Film
    from alight.rendering import Progress

#: The error is worked out for at most this share of the time.
_ERROR_SHARE = 0.02

#: Characters of the bar itself, however narrow the terminal.
_SHORTEST_BAR = 10

#: The message while machine code is compiled, and the seconds after which a file or a pipe, which
#: shows no bar, gets it too: loading cached code takes less.
COMPILING, _LONG = "compiling kernels (first run only)", 2.0


class Bar:
    """One line on stderr: what is done, how far it is, some figures, the time that is left.

    Parameters
    ----------
    quiet : bool, default False
        Show nothing.
    """

    def __init__(self, quiet: bool = False) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
        from rich.table import Column

        console = Console(stderr=True)
        # In files and pipes a bar would leave nothing but empty lines.
        self._hidden = quiet or not console.is_terminal
        self._bar = Progress(
            TextColumn("{task.description}", table_column=Column(no_wrap=True)),
            # On a narrow terminal the texts are cut before the bar is.
            BarColumn(table_column=Column(min_width=_SHORTEST_BAR)),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[error]}"),
            console=console,
            transient=True,
            disable=self._hidden,
        )
        self._task = self._begin("loading", None)

    def _begin(self, text: str, total: float | None) -> TaskID:
        """Add a line; its speed is its own."""
        return self._bar.add_task(text, total=total, rate="", error="")

    def __enter__(self) -> Self:
        """Start showing."""
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Remove the bar."""
        self._bar.stop()


class ProgressBar(Bar):
    """Shows `Progress` objects on stderr; a callback for `alight.render`.

    Parameters
    ----------
    quiet : bool
        Show nothing.
    time_limit : float, seconds, optional
        Full length of the bar where no number of samples is given.
    warns : callable, optional
        Given the warnings of the scene before its first sample.

    Attributes
    ----------
    film : Film or None
        The film of the last report, for whoever must write what is there.
    phase : str
        Of the last report; "load" before the first.
    title : str
        Precedes the render's progress.
    """

    def __init__(
        self,
        quiet: bool = False,
        time_limit: float | None = None,
        warns: Callable[[Iterable[str]], None] = lambda messages: None,
    ) -> None:
        super().__init__(quiet)
        self._warns = warns
        self.film: Film | None = None
        self.phase, self.title = "load", ""
        self._time_limit = time_limit
        self._error, self._next_error = "", 1.0
        self._speaks, self._timer = self._hidden and not quiet, threading.Timer(0.0, lambda: None)

    def __exit__(self, *raised: Any) -> None:
        """Remove the bar."""
        self._timer.cancel()
        super().__exit__(*raised)

    def __call__(self, progress: Progress) -> None:
        """Show how far the render is."""
        self.phase = progress.phase
        self._timer.cancel()
        if progress.phase != "render":
            self._warns(progress.film.warnings)
            text = COMPILING if progress.phase == "compile" else progress.phase
            self._bar.update(self._task, description=f"{self.title}{text}", total=None)
            if self._speaks:
                self._timer = threading.Timer(_LONG, self._say, [text])
                self._timer.daemon = True
                self._timer.start()
            return
        self.film = progress.film
        seconds = max(progress.seconds, 1e-9)
        done, total = float(progress.done_samples), float(progress.total_samples)
        speed = f"{done / seconds / 1e6:.2f} Msamples/s"
        share = done / total if total else 0.0
        if self._time_limit and seconds / self._time_limit > share:
            # The time will run out first.
            done, total = min(seconds, self._time_limit), self._time_limit
        self._bar.update(
            self._task,
            description=f"{self.title}rendering",
            completed=done,
            total=total or None,
            rate=", ".join(filter(None, (speed, progress.note))),
            error=self._current_error(progress),
        )

    def _say(self, text: str) -> None:
        """Say once, in one line, what takes long."""
        self._speaks = False
        sys.stderr.write(f"{text}\n")

    def _current_error(self, progress: Progress) -> str:
        if self._hidden or progress.seconds < self._next_error:
            return self._error
        begin = time.perf_counter()
        error = progress.film.relmse_estimate(literature=False).relrmse.value
        cost = time.perf_counter() - begin
        self._next_error = progress.seconds + max(1.0, cost / _ERROR_SHARE)
        self._error = "" if math.isnan(error) else f"error {error:.1%}"
        return self._error
