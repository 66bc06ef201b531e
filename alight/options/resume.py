"""The options of going on with a render: `alight.resume` and ``alight resume`` take the same."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from alight.core.errors import OptionError
from alight.options.cluster import ClusterOptions
from alight.options.kinds import Anything, File, Files, Text
from alight.options.quantities import Seconds, Whole
from alight.options.render import (
    EVERY,
    MOST_SAMPLES,
    PromiseOptions,
    check_end,
    refuse_beside_schedule,
)
from alight.options.scene import scripts
from alight.options.table import PROMISE, option, table

if TYPE_CHECKING:
    from alight.scene import Scene


@table
class ResumeOptions(PromiseOptions, ClusterOptions):
    """The options of `alight.resume`."""

    output: Sequence[str | PathLike[str]] | str | PathLike[str] = option(
        Files(), "File to write; repeatable.", default=(), flag="--output -o",
        shown="as for the first part of the render",
    )  # fmt: skip
    spp: int | None = option(
        Whole(1, MOST_SAMPLES),
        "Samples per pixel in all.",
        shown="as asked for first",
        default=None,
    )
    max_spp: int | None = option(
        Whole(1, MOST_SAMPLES),
        "Give up at this many samples per pixel; alone, a new limit of the promise made first.",
        panel=PROMISE,
        default=None,
    )
    time_limit: float | str | None = option(
        Seconds(), "Start no pass after this many seconds.", flag="--time",
        shown="what is left of the first limit", default=None
    )  # fmt: skip
    scene: Scene | str | PathLike[str] | None = option(
        Text(), "The same scene, if its file was moved or it was built in Python.", default=None
    )  # fmt: skip
    root: str | PathLike[str] | None = option(
        File("FOLDER"), "Folder whose files the scene may read.",
        shown="as the render began", default=None
    )  # fmt: skip
    checkpoint: str | PathLike[str] | None = option(
        File(), "Write checkpoints to another file.", shown="the one that was read", default=None
    )
    every: float | str = option(
        Seconds(can_be_zero=True), "Time between checkpoints, such as 60s, 5m or 1h.", default=EVERY
    )
    threads: int | None = option(
        Whole(1, 1024),
        "Threads; their number does not change the picture.",
        shown="all processors",
        default=None,
    )
    plugins: Sequence[str | PathLike[str]] | str | PathLike[str] = scripts("models for the scene")
    stats: str | PathLike[str] | None = option(
        File(), "JSON file for times and errors.", default=None
    )
    spp_per_pass: int | None = option(
        Whole(1, MOST_SAMPLES),
        "Samples per pixel between progress reports.",
        flag="",
        default=None,
    )
    promise: Any = option(
        Anything("Promise", "share"), "Go on until it is kept.", flag="", default=None
    )
    schedule: Any = option(
        Anything("Schedule", "next"),
        "Another rule instead of the one in the checkpoint.",
        flag="",
        default=None,
    )
    progress: Callable[[Any], None] | None = option(
        Anything("callable", "__call__"),
        "Called with a `Progress` from time to time, in the calling thread.",
        flag="",
        default=None,
    )
    cancel: threading.Event | None = option(
        Anything(has="is_set"),
        "Ends the render early when set; no file is written.",
        flag="",
        default=None,
    )

    def __post_init__(self) -> None:
        """Refuse contradictions, too."""
        super().__post_init__()
        if self.schedule is not None:
            for name in self.given("spp", "error", "max_spp", "promise"):
                refuse_beside_schedule(name)
        # Without an error of its own a limit is that of the checkpoint's.
        if self.max_spp is not None and self.spp is not None:
            text = "{max_spp} limits {error}, and {spp} is without one: give one of the two"
            raise OptionError(text, names=("max_spp", "error", "spp"))
        check_end(self.error, None if self.promise else self.spp, None)
