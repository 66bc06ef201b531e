"""What the shares and trials say, in lines of text and as plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from alight.lab.why.shares import Part, Share, Shares
from alight.lab.why.trials import Trial

#: Parts with less than this share are not worth a line.
LEAST = 0.01
#: Lines of the ranked list.
MOST = 10

_TABLES = (
    ("depth", "by path length"),
    ("technique", "by technique"),
    ("light", "by light"),
    ("material", "by the material that the camera's ray met first"),
)


def ranked(shares: Shares) -> dict[Part, Share]:
    """Parts by light, technique and depth that are worth a line, the largest first."""
    found = shares.by("light", "technique", "depth")
    worth = {part: share for part, share in found.items() if abs(share.value) >= LEAST}
    return dict(list(worth.items())[:MOST])


def share_lines(shares: Shares) -> Iterator[str]:
    """The ranked list, and a table for each property of a path."""
    error = math.sqrt(max(shares.relative_variance, 0.0) / shares.spp)
    yield f"relative error {100 * error:.3g} % at {shares.spp} independent samples a pixel"
    if shares.relative_variance <= 0.0:
        yield "nothing varies: there is no noise to explain"
        return
    for part, share in ranked(shares).items():
        yield f"{_percent(share)} of the variance: {part}"
    for title, rows in share_tables(shares):
        yield f"{title}:"
        for label, share in rows:
            yield f"  {share}  {label}"


def share_tables(shares: Shares) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    """A table for each property of a path: its title, and what each value's share is."""
    for name, title in _TABLES:
        groups = shares.by(name)
        if all(getattr(part, name) is None for part in groups):
            continue
        rows = [
            (_label(name, part), _percent(share))
            for part, share in list(groups.items())[:MOST]
            if abs(share.value) >= LEAST or len(groups) == 1
        ]
        yield title, rows


def _percent(share: Share) -> str:
    return f"{100 * share.value:5.1f} % ± {100 * share.error:.1f}"


def _label(name: str, part: Part) -> str:
    value = getattr(part, name)
    if name == "depth":
        return {1: "1 edge: lights themselves", 2: "2 edges: direct light"}.get(
            value, f"{value} edges"
        )
    if name == "material" and not value:
        return "none: lights and sky themselves"
    return str(value)


def trial_lines(trials: Sequence[Trial], left: Sequence[str]) -> Iterator[str]:
    """What was tried, and what of it is advice."""
    helping = [trial for trial in trials if trial.helps]
    for trial in helping:
        yield f"advice: --set {trial.change}  {_figures(trial)}"
    if not helping:
        yield "no advice: nothing that was tried was measured to be more efficient"
    for trial in trials:
        if not trial.helps:
            yield f"tried:  --set {trial.change}  {_figures(trial)}"
    if left:
        yield f"no time left to try: {', '.join(left)}"


def _figures(trial: Trial) -> str:
    value, low, high = trial.efficiency
    variance, least, most = trial.variance
    n = trial.bright
    few = "a bright sample carries" if n == 1 else f"{n} bright samples carry"
    reason = f"{few} the noise" if n else "hardly a sample has met the light of most noise"
    if trial.told_by_lamps:
        return f"efficiency x {trial.at_least:.2g} or more by paths from the lamps, as {reason}"
    if not trial.helps and (n or not math.isnan(trial.at_least)):
        return f"unknown, as {reason}"
    return (
        f"variance / {variance:.3g} [{least:.3g}, {most:.3g}], "
        f"efficiency x {value:.3g} [{low:.3g}, {high:.3g}], corrected p = {trial.p_value:.2g}"
    )


def plain(shares: Shares, trials: Sequence[Trial], left: Sequence[str]) -> dict[str, Any]:
    """All numbers, for JSON."""

    def rows(*fields: str) -> list[dict[str, Any]]:
        return [
            {name: getattr(part, name) for name in fields}
            | {"share": share.value, "standard_error": share.error}
            for part, share in shares.by(*fields).items()
        ]

    return {
        "spp": shares.spp,
        "size": list(shares.variance.shape[::-1]),
        "relative_variance_of_one_sample": shares.relative_variance,
        "parts": rows("light", "technique", "depth", "material"),
        **{f"by_{name}": rows(name) for name, _ in _TABLES},
        "trials": [trial_data(trial) for trial in trials],
        "not_tried": list(left),
    }


def trial_data(trial: Trial) -> dict[str, Any]:
    """One trial as plain data; ratios as [value, low, high]."""
    return {
        "change": trial.change,
        "variance_ratio": list(trial.variance),
        "time_ratio": list(trial.time),
        "efficiency_ratio": list(trial.efficiency),
        "corrected_p": trial.p_value,
        "helps": trial.helps,
        "bright_samples": trial.bright,
        "at_least": None if math.isnan(trial.at_least) else trial.at_least,
    }
