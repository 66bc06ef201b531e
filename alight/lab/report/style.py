"""The look of the figures: colours that colour-blind readers tell apart, few lines, no boxes.

Colours: Okabe and Ito 2008, "Color universal design", darkened where they are too pale for text on
white; the baseline is grey. Marks differ as well as colours, for prints without colour.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

from alight.core.errors import OptionError
from alight.core.extras import install_command

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Ink, lesser ink, and the lines that one should hardly see.
INK, GREY, FAINT = "#1c1f23", "#5d6570", "#dfe3e8"

#: Of the arm that others are compared with.
BASELINE = "#6b7480"

#: Of statements that something is wrong.
WARNING = "#b3401a"

_COLORS = ("#0072b2", "#c8500a", "#008a64", "#b0578d", "#9a6a00", "#2f8fc4", "#3d3d8f", "#7a7a18")
_MARKS = ("o", "s", "^", "D", "v", "P", "X", "p")


class Look(NamedTuple):
    """Colour and mark of an arm, the same in all figures of a report."""

    color: str
    mark: str
    dashed: bool


def looks(count: int, baseline: int | None = None) -> list[Look]:
    """Choose the styles of this many arms; the ninth and later ones repeat colours, dashed."""
    found, n = [], 0
    for i in range(count):
        if i == baseline:
            found.append(Look(BASELINE, "o", False))
            continue
        mark = _MARKS[(n + 1) % len(_MARKS)]
        found.append(Look(_COLORS[n % len(_COLORS)], mark, n >= len(_COLORS)))
        n += 1
    return found


def require_packages(*names: str) -> None:
    """Refuse to start without the packages of the extra `lab`.

    Raises
    ------
    OptionError
    """
    import importlib.util

    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing:
        listed = " and ".join(missing)
        raise OptionError(f"this needs {listed}: {install_command('lab', *missing)}")


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw as in a paper, whatever the user's own settings of matplotlib are."""
    import matplotlib as mpl

    settings: dict[str, Any] = {
        "font.family": ["DejaVu Sans"], "font.size": 8.5, "axes.labelsize": 8.5,
        "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.7,
        "axes.edgecolor": GREY, "axes.labelcolor": INK, "text.color": INK,
        "xtick.color": GREY, "ytick.color": GREY, "xtick.labelcolor": INK,
        "ytick.labelcolor": INK, "xtick.labelsize": 8, "ytick.labelsize": 8,
        "xtick.major.width": 0.7, "ytick.major.width": 0.7, "xtick.minor.size": 0,
        "ytick.minor.size": 0, "xtick.major.size": 3, "ytick.major.size": 0,
        "lines.linewidth": 1.5, "lines.markersize": 5, "lines.solid_capstyle": "round",
        "axes.axisbelow": True, "grid.color": FAINT, "grid.linewidth": 0.7,
        "figure.facecolor": "none", "axes.facecolor": "none", "savefig.facecolor": "none",
        # Text stays text: smaller, searchable, and in the font of the page.
        "svg.fonttype": "none", "svg.hashsalt": "alight", "path.simplify": True,
    }  # fmt: skip
    with mpl.rc_context(), mpl.rc_context(settings):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Make a figure of the given inches without a display or `pyplot`."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasSVG(figure)
    return figure


def svg_of(figure: Figure, name: str, description: str) -> str:
    """Write a figure as an SVG element that scales with the page.

    Parameters
    ----------
    figure : Figure
    name : str
        Prefix of the ids inside: several figures share one page.
    description : str
        For readers who cannot see it.
    """
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # Ids of clip paths and marks would clash between the figures of a page.
    svg = re.sub(r'(id="|url\(#|href="#)', lambda m: m[1] + name + "-", svg)
    svg = re.sub(r'^<svg ([^>]*?)width="[^"]*"', r"<svg \1", svg, count=1)
    svg = re.sub(r'^<svg ([^>]*?)height="[^"]*"', r"<svg \1", svg, count=1)
    label = description.replace("&", "and").replace("<", "").replace('"', "'")
    return svg.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1).strip()
