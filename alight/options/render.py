"""The options of a render: `alight.render` and ``alight render`` take the same."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from alight.core.errors import OptionError
from alight.options import scene
from alight.options.cluster import ClusterOptions
from alight.options.device import DeviceOptions
from alight.options.kinds import Anything, Choice, File, Files, Names, PlainData, Switch, Text
from alight.options.quantities import Part, Seconds, Share, Whole
from alight.options.scene import SizedOptions
from alight.options.table import PICTURE, PROMISE, SAMPLING, Options, option, table
from alight.options.target import TargetOptions

if TYPE_CHECKING:
    from alight.outputs.display import Display

#: What an error may be that of, and the rules of adaptive sampling.
PROMISED, CRITERIA = ("relrmse", "pixel"), ("pilot", "cycles")

#: What is seen where there is no surface: the surroundings, nothing, or shadows on the ground.
BACKGROUNDS = ("scene", "transparent", "shadow")
#: The layer of coverage, and the setting that keeps the surroundings out of the picture.
COVERAGE, HIDES = "alpha", "integrator.hide_emitters"

#: Seconds between two checkpoints.
EVERY = 60.0

MOST_SAMPLES = 2**31 - 1


def layer_names() -> Iterable[str]:
    """Layers that can be asked for."""
    from alight.films.mattes import ALL_MATTES, MATTES
    from alight.integrators.aov import LAYERS
    from alight.lights.ground import SHADOW

    return ("direct", "indirect", *LAYERS, SHADOW, ALL_MATTES, *MATTES)


@table
class ThreadOptions(Options):
    """Options of everything that renders."""

    seed: int = option(
        Whole(0, 2**32 - 1), "Seed of the random numbers.", default=0, panel=SAMPLING
    )
    threads: int | None = option(
        Whole(1, 1024),
        "Threads; their number does not change the picture.",
        shown="all processors",
        panel=SAMPLING,
        default=None,
    )


@table
class PromiseOptions(Options):
    """What a picture shall be when its render ends."""

    error: float | str | None = option(
        Share(0.0, 10.0, least_is_open=True), "Render until the error is this small.",
        metavar="2%", panel=PROMISE, default=None
    )  # fmt: skip
    confidence: float | str = option(
        Share(0.5, 1.0, most_is_open=True), "Confidence with which it is that small.",
        default=0.95, metavar="95%", panel=PROMISE,
    )  # fmt: skip
    metric: str = option(
        Choice("metric", PROMISED),
        "Which error: relrmse of the whole picture, or pixel: that of a share of the pixels.",
        default="relrmse", panel=PROMISE,
    )  # fmt: skip
    share: float | str = option(
        Share(0.5, 1.0, most_is_open=True),
        "Share of the pixels that must be within the error, for the metric pixel.",
        default=0.95, metavar="95%", panel=PROMISE,
    )  # fmt: skip

    def useless(self) -> list[tuple[str, tuple[str, ...]]]:
        """Options that others would have to ask for: what is missing, and the names in it."""
        if self.error is None:
            return [(f"{{{name}}} does nothing without {{error}}", (name, "error"))
                    for name in self.given("confidence", "metric", "share")]  # fmt: skip
        found: list[tuple[str, tuple[str, ...]]] = []
        if self.metric == "relrmse" and self.given("share"):
            found.append(("{share} does nothing without {metric} pixel", ("share", "metric")))
        if self.error >= 1.0:  # type: ignore[operator]
            text = f"{{error}}: asks for {100.0 * self.error:g} %; did you mean {self.error:g}%?"  # type: ignore[operator]
            found.append((text, ("error",)))
        return found


@table
class DisplayOptions(Options):
    """How linear values become those of a display."""

    exposure: float | str = option(
        Text("STOPS"),
        "Exposure in stops, or auto, for display formats.",
        default=0.0,
        panel=PICTURE,
    )
    white_balance: str = option(
        Text("LIGHT"),
        "Light to show as white: none, auto, a temperature such as 3200K, or a colour R,G,B.",
        default="none", panel=PICTURE,
    )  # fmt: skip
    tone_map: str = option(
        Text("NAME"),
        "Tone curve: none, reinhard, aces, hable or agx.",
        default="none",
        panel=PICTURE,
    )
    bits: int = option(Whole(8, 16), "Bits per channel: 8, or 16 (PNG).", default=8, panel=PICTURE)
    dpi: int | None = option(
        Whole(1, 10_000), "Pixels per inch, kept in PNG, JPEG and EXR; for sizes in inches.",
        shown="none, 300 for a size in inches", default=None, panel=PICTURE,
    )  # fmt: skip
    denoise: bool = option(
        Switch(), "Denoise the picture; EXR keeps the noisy one too. Needs the extra denoise.",
        default=False, panel=PICTURE,
    )  # fmt: skip

    @property
    def display(self) -> Display:
        """The part that pictures are developed by.

        Raises
        ------
        OptionError
            For a tone map, an exposure, a white balance or bits that do not exist.
        """
        from alight.outputs.display import Display

        return Display(self.exposure, self.tone_map, self.bits, self.white_balance, self.dpi)


@table
class LimitOptions(Options):
    """When a render gives up, and where its samples go."""

    max_time: float | str | None = option(
        Seconds(),
        "Give up after this time, such as 90s, 10m or 2h.",
        metavar="10m",
        panel=PROMISE,
        default=None,
    )
    max_spp: int | None = option(
        Whole(1, MOST_SAMPLES),
        "Give up at this many samples per pixel.",
        panel=PROMISE,
        default=None,
    )
    adaptive: bool = option(
        Switch(), "More samples where there is more noise.", default=False, panel=PROMISE
    )
    criterion: str = option(
        Choice("criterion", CRITERIA),
        "pilot (unbiased), or cycles: Blender's rule (biased), with the error as threshold.",
        default="pilot", flag="--adaptive-criterion", panel=PROMISE,
    )  # fmt: skip


@table
class RenderOptions(
    DisplayOptions, PromiseOptions, LimitOptions, ClusterOptions, DeviceOptions, TargetOptions,
    ThreadOptions, SizedOptions,
):  # fmt: skip
    """The options of `alight.render`.

    Every number is checked when the object is made, and contradictions are refused.
    """

    output: Sequence[str | PathLike[str]] | str | PathLike[str] = option(
        Files(), "File to write; the suffix chooses the format. Repeatable.",
        default=(), flag="--output -o", shown="SCENE.png, in Python none",
        panel=PICTURE,
    )  # fmt: skip
    background: str = option(
        Choice("background", BACKGROUNDS),
        "scene, or transparent: alpha in EXR and PNG, and the lights themselves are hidden; "
        "shadow: the same with the shadows on the ground.",
        default="scene", panel=PICTURE,
    )  # fmt: skip
    aovs: Sequence[str] | str = option(
        Names("layer", layer_names),
        "Extra layers (EXR), comma-separated, such as albedo,normal or direct,indirect.",
        default=(), flag="--aov", panel=PICTURE,
    )  # fmt: skip
    stats: str | PathLike[str] | None = option(
        File(), "JSON file for times and errors.", panel=PICTURE, default=None
    )
    spp: int | None = option(
        Whole(1, MOST_SAMPLES), "Samples per pixel.",
        default=None, shown="as the scene file says or 64, if no time limit is given",
        panel=SAMPLING,
    )  # fmt: skip
    time_limit: float | str | None = option(
        Seconds(),
        "Start no pass after this many seconds.",
        flag="--time",
        panel=SAMPLING,
        default=None,
    )
    first_sample: int = option(
        Whole(0, MOST_SAMPLES), "Index of the first sample, to extend a film.",
        default=0, panel=SAMPLING,
    )  # fmt: skip
    part: tuple[int, int] | str | None = option(
        Part(), "Render only one of N equal ranges of the samples; alight merge adds the films.",
        default=None, shown="all of them", panel=SAMPLING,
    )  # fmt: skip
    replicates: int | None = option(
        Whole(1, 1024), "Independent scrambles for the error bars.",
        shown="as the scene says, 4", panel=SAMPLING, default=None
    )  # fmt: skip
    spp_per_pass: int | None = option(
        Whole(1, MOST_SAMPLES),
        "Samples per pixel between progress reports; does not change the picture.",
        panel=SAMPLING, default=None
    )  # fmt: skip
    checkpoint: str | PathLike[str] | None = option(
        File(), "Save the state there: alight resume FILE continues after a stop or a crash.",
        panel=SAMPLING, default=None
    )  # fmt: skip
    every: float | str = option(
        Seconds(can_be_zero=True), "Time between checkpoints, such as 60s, 5m or 1h.",
        default=EVERY, panel=SAMPLING,
    )  # fmt: skip
    camera: str | int | None = scene.camera()
    integrator: str | None = scene.integrator()
    sampler: str | None = scene.sampler()
    filter: str | None = scene.filter()
    max_depth: int | None = scene.max_depth()
    rr_depth: int | None = scene.rr_depth()
    schedule: Any = option(
        Anything("Schedule", "next"),
        "Decides which samples are rendered, in place of the number of samples.",
        default=None, flag="",
    )  # fmt: skip
    notes: Mapping[str, Any] = option(
        PlainData("mapping of str to plain JSON"),
        "Plain JSON that checkpoints keep, for whoever resumes.",
        default={},
        flag="",
    )
    progress: Callable[[Any], None] | None = option(
        Anything("callable", "__call__"),
        "Called with a `Progress` from time to time, in the calling thread.",
        flag="",
        default=None,
    )
    cancel: threading.Event | None = option(
        Anything(has="is_set"),
        "Ends the render early when set; the film holds what was finished, no file is written.",
        flag="", default=None
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse contradictions, too."""
        super().__post_init__()
        if self.schedule is not None:
            for name in self.given("error", "adaptive", "criterion", "max_spp"):
                refuse_beside_schedule(name)
        if self.part is not None:
            check_part(self)
        further = [name for name in self.layers_of_background if name not in self.aovs]
        if further:
            object.__setattr__(self, "aovs", (*self.aovs, *further))
        if self.criterion == "pilot":
            check_end(self.error, self.spp, self.max_spp)

    @property
    def layers_of_background(self) -> tuple[str, ...]:
        """Layers that alpha is made of."""
        from alight.lights.ground import SHADOW

        return {"scene": (), "transparent": (COVERAGE,)}.get(self.background, (COVERAGE, SHADOW))

    def useless(self) -> list[tuple[str, tuple[str, ...]]]:
        """Options that others would have to ask for: what is missing, and the names in it."""
        found = super().useless()
        if self.checkpoint is None and self.given("every"):
            found.append(("{every} does nothing without {checkpoint}", ("every", "checkpoint")))
        return found

    def assignments(self) -> list[str]:
        """Those of any scene, and what a transparent background takes."""
        found = super().assignments()
        return found if self.background == "scene" else [*found, f"{HIDES}=true"]


def refuse_beside_schedule(name: str) -> None:
    """Refuse an option that a schedule of the user's own would not look at.

    Raises
    ------
    OptionError
    """
    text = "{schedule} decides itself which samples are rendered; leave out {%s}"
    raise OptionError(text % name, names=("schedule", name))


def check_end(error: float | None, spp: int | None, max_spp: int | None) -> None:
    """Refuse a render that two of its options would end differently.

    Raises
    ------
    OptionError
    """
    if error is None and max_spp is not None:
        text = "{max_spp} limits {error}; without it, give {spp}"
        raise OptionError(text, names=("max_spp", "error", "spp"))
    if error is not None and spp is not None:
        text = "{error} and {spp} contradict each other; the limit is {max_spp}"
        raise OptionError(text, names=("error", "spp", "max_spp"))


def check_part(options: RenderOptions) -> None:
    """Refuse a part of a render whose samples only the render itself decides.

    Raises
    ------
    OptionError
    """
    for name in options.given("schedule", "error", "adaptive", "criterion", "time_limit",
                              "max_time"):  # fmt: skip
        text = "{part} is a share of a fixed number of samples; leave out {%s} and give {spp}"
        raise OptionError(text % name, names=("part", name, "spp"))
