"""The options of the laboratory, command by command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from alight.options import scene
from alight.options.cluster import ClusterOptions
from alight.options.kinds import Anything, File, Names, Switch, Text, Texts
from alight.options.quantities import Number, Seconds, Share, Whole
from alight.options.render import MOST_SAMPLES, PromiseOptions, ThreadOptions
from alight.options.scene import SceneOptions, SizedOptions
from alight.options.table import PROMISE, SAMPLING, SCENE, Options, option, table

if TYPE_CHECKING:
    from alight.films import Film

#: What a check looks at, in this order.
PARTS = ("materials", "lights", "numbers", "paths", "pictures", "accelerators")


def _seed() -> Any:
    help = "Seed of the random numbers."
    return option(Whole(0, 2**32 - 1), help, default=0, panel=SAMPLING)


def _told() -> Any:
    return option(Anything(), "Called with a description of what runs next.", flag="", default=None)


@table
class InfoOptions(SceneOptions):
    """The options of `alight.info`."""

    tree: bool = option(Switch(), "Show the scene graph and the cost of the BVH.", default=False)
    camera: str | int | None = scene.camera()


@table
class PlanOptions(PromiseOptions, ThreadOptions, SizedOptions):
    """The options of `alight.plan`."""

    error: float | str = option(
        Share(0.0, 10.0, least_is_open=True), "Error that the picture is to reach.",
        default=0.02, metavar="2%", panel=PROMISE,
    )  # fmt: skip


@table
class CheckOptions(SceneOptions):
    """The options of `alight.check`."""

    output: str | PathLike[str] | None = option(
        File("FOLDER"), "Folder for pictures of failures.", flag="--output -o",
        shown="check-failures, in Python none", default=None
    )  # fmt: skip
    level: float = option(
        Number(0, 1), "Probability that a scene without a bug fails.", default=0.01
    )
    only: Sequence[str] | str = option(
        Names("part", PARTS), f"Comma-separated: {', '.join(PARTS)}.", default=(), shown="all"
    )
    seed: int = _seed()
    progress: Callable[[str], None] | None = _told()


@table
class WhyOptions(SceneOptions):
    """The options of `alight.why`."""

    output: str | PathLike[str] | None = option(
        File(), "PNG of the maps.", flag="--output -o",
        shown="SCENE.why.png, in Python none", default=None
    )  # fmt: skip
    size: int = option(Whole(8, 1024), "Pixels of the longer side.", default=128)
    spp: int = option(
        Whole(32, MOST_SAMPLES),
        "Samples per pixel, 32 or more, rounded down to a multiple of 32.",
        default=64,
    )
    measure: bool = option(
        Switch(), "Try other options, for advice.", default=True, flag="--measure/--no-measure"
    )
    time_limit: float | str = option(
        Seconds(can_be_zero=True), "Start no new trial after this many seconds.",
        default=60.0, flag="--time",
    )  # fmt: skip
    seed: int = _seed()
    integrator: str | None = scene.integrator()
    max_depth: int | None = scene.max_depth()
    progress: Callable[[str], None] | None = _told()


@table
class CompareOptions(Options):
    """The options of `alight.compare`."""

    reference: Film | Any | str | PathLike[str] | None = option(
        Text("FILE"), "Compare both pictures with this one.", default=None
    )
    output: str | PathLike[str] | None = option(
        File(), ".png or .html: side by side; .exr, .npy, .pfm: the difference.",
        flag="--output -o", default=None
    )  # fmt: skip
    layer: str | None = option(Text("NAME"), "Layer of EXR files, such as albedo.", default=None)
    exposure: float = option(
        Number(-100, 100, is_closed=True),
        "Exposure in stops, for what a display shows.",
        default=0.0,
    )
    skip_invalid: bool = option(Switch(), "Ignore NaN and infinite pixels.", default=False)
    flip: bool = option(
        Switch(), "Compute FLIP (slow on large pictures).", default=True, flag="--flip/--no-flip"
    )
    fail_above: Sequence[str] | str = option(
        Texts("FIGURE=NUMBER"), "Limit of a figure, such as relmse=0.01; exit code 1 above it.",
        default=(),
    )  # fmt: skip
    plugins: Sequence[str | PathLike[str]] | str | PathLike[str] = scene.scripts("metrics")


@table
class StudyOptions(ClusterOptions, Options):
    """The options of `alight.study`."""

    plugins: Sequence[str | PathLike[str]] | str | PathLike[str] = scene.scripts(
        "models for the scenes, or metrics"
    )
    output: str | PathLike[str] | None = option(
        File("FOLDER"), "Folder to write.", flag="--output -o", shown="study-NAME", default=None
    )
    quick: bool = option(Switch(), "Small and short, with wider intervals.", default=False)
    root: str | PathLike[str] | None = option(
        File("FOLDER"), "Folder whose files the study and its scenes may read.",
        shown="the study's own folder", panel=SCENE, default=None
    )  # fmt: skip
    threads: int | None = option(
        Whole(1, 1024), "Threads to render with.", shown="all processors", default=None
    )
    progress: Callable[[Any], None] | None = option(
        Anything("callable"),
        "Called with a `StudyProgress` from time to time.",
        flag="",
        default=None,
    )


@table
class TraceOptions(SizedOptions):
    """The options of `alight.trace`."""

    sample: int = option(Whole(0, MOST_SAMPLES), "Which sample of the pixel.", default=0)
    seed: int = _seed()
    camera: str | int | None = scene.camera()
    integrator: str | None = scene.integrator()
    sampler: str | None = scene.sampler()
    filter: str | None = scene.filter()
    max_depth: int | None = scene.max_depth()
    rr_depth: int | None = scene.rr_depth()
    replicates: int | None = option(
        Text("INTEGER"),
        "Independent scrambles for the error bars.",
        key="film.replicates",
        panel=SCENE,
        default=None,
    )


@table
class GuideOptions(SceneOptions):
    """The options of `alight.guide`."""

    output: str | PathLike[str] | None = option(
        File(), "PNG of the disks.", flag="--output -o",
        shown="SCENE.guide.png, in Python none", default=None
    )  # fmt: skip
    spp: int = option(
        Whole(2, MOST_SAMPLES), "Samples of the light from each direction, rounded down to even.",
        default=64,
    )  # fmt: skip
    seed: int = _seed()
    camera: str | int | None = scene.camera()
    progress: Callable[[str], None] | None = _told()


@table
class ReferenceOptions(ThreadOptions, SizedOptions):
    """The options of ``alight reference``."""

    error: float | str = option(
        Share(0.0, 1.0, least_is_open=True, most_is_open=True), "Requested relRMSE, such as 0.5%.",
        default=0.01,
    )  # fmt: skip


@table
class ConvertOptions(SceneOptions):
    """The options of ``alight convert``."""

    camera: str | int | None = scene.camera()
