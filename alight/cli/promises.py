"""The options that stop and steer a render: an error to reach, and where samples go."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

import typer

from alight.core.errors import OptionError, quote, unknown_name

if TYPE_CHECKING:
    from alight.rendering.schedule import Schedule
    from alight.rendering.stopping import Promise

_PANEL = "Until an error is reached, and adaptive sampling"

Error = Annotated[
    str | None,
    typer.Option(
        metavar="2%", help="Render until the error is this small.", rich_help_panel=_PANEL
    ),
]
Confidence = Annotated[
    str, typer.Option(metavar="95%", help="Confidence in that.", rich_help_panel=_PANEL)
]
Metric = Annotated[
    str,
    typer.Option(
        help="relrmse of the whole picture, or pixel: a share of the pixels.",
        rich_help_panel=_PANEL,
    ),
]
Share = Annotated[
    str,
    typer.Option(
        metavar="95%", help="Share of the pixels, for --metric pixel.", rich_help_panel=_PANEL
    ),
]
MaxTime = Annotated[
    str | None,
    typer.Option(
        metavar="10m",
        help="Give up after this time, such as 90s, 10m or 2h.",
        rich_help_panel=_PANEL,
    ),
]
MaxSpp = Annotated[
    int | None,
    typer.Option(help="Give up at this many samples per pixel.", min=1, rich_help_panel=_PANEL),
]
Adaptive = Annotated[
    bool,
    typer.Option(
        "--adaptive", help="More samples where there is more noise.", rich_help_panel=_PANEL
    ),
]
Criterion = Annotated[
    str,
    typer.Option(
        "--adaptive-criterion",
        help="pilot (unbiased), or cycles: Blender's rule (biased), with --error its threshold.",
        rich_help_panel=_PANEL,
    ),
]


def parse_share(option: str, text: str) -> float:
    """Read ``2%`` or ``0.02``.

    Raises
    ------
    OptionError
        For a text that is neither.

    Examples
    --------
    >>> parse_share("--error", "2.5%")
    0.025
    """
    found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,12})?|\.\d{1,12})\s*(%?)", text.strip())
    if found is None:
        raise OptionError(f"{option}: must be a share such as 2% or 0.02, got {quote(text)}")
    return float(found[1]) / (100.0 if found[2] else 1.0)


def parse_promise(error: str, confidence: str, metric: str, share: str) -> Promise:
    """Make the promise that the options ask for.

    Raises
    ------
    OptionError
        For an option that is wrong.
    """
    from alight.rendering.stopping import Promise

    known = ("relrmse", "pixel")
    if metric not in known:
        raise OptionError("--metric: " + unknown_name("metric", metric, known))
    return Promise(
        parse_share("--error", error),
        parse_share("--confidence", confidence),
        metric,  # type: ignore[arg-type]
        parse_share("--share", share),
    )


def promise_to_resume(
    error: str | None,
    confidence: str,
    metric: str,
    share: str,
    spp: int | None,
    max_spp: int | None,
) -> Promise | None:
    """Make the promise that a resumed render shall keep; None where no error is given.

    Raises
    ------
    OptionError
        For options that are wrong or contradict each other.
    """
    if error is None:
        if max_spp is not None:
            raise OptionError("--max-spp limits --error; without it, give --spp")
        return None
    if spp is not None:
        raise OptionError("--error and --spp contradict each other; the limit is --max-spp")
    return parse_promise(error, confidence, metric, share)


def schedule_of(
    options: dict[str, Any], spp: int | None, first_sample: int, default_spp: int
) -> Schedule | None:
    """Make the schedule that the options ask for; None for the plain one.

    Parameters
    ----------
    options : dict
        `error`, `confidence`, `metric`, `share`, `max_spp`, `adaptive` and `criterion`.
    spp, first_sample : int
        Of the render.
    default_spp : int
        Where nothing else ends an adaptive render.

    Raises
    ------
    OptionError
        For options that contradict each other.
    """
    from alight.rendering.cycles import MOST, THRESHOLD, Cycles
    from alight.rendering.steering import Steered

    error, max_spp, criterion = options["error"], options["max_spp"], options["criterion"]
    if criterion not in ("pilot", "cycles"):
        raise OptionError(
            "--adaptive-criterion: " + unknown_name("criterion", criterion, ("pilot", "cycles"))
        )
    if criterion == "cycles":
        threshold = THRESHOLD if error is None else parse_share("--error", error)
        return Cycles(first_sample, max_spp or spp or MOST, threshold)
    promise = promise_to_resume(
        error, options["confidence"], options["metric"], options["share"], spp, max_spp
    )
    if promise is None:
        return (
            Steered(first_sample, spp or default_spp, None, True) if options["adaptive"] else None
        )
    return Steered(first_sample, max_spp, promise, options["adaptive"])
