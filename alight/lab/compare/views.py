"""What a comparison looks like: a signed difference, pictures side by side, a page to flip in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.constants import LUMINANCE
from alight.lab.compare.figures import PictureComparison
from alight.lab.report import pictures
from alight.lab.report.numbers import number
from alight.lab.report.page import render_page
from alight.metrics import SHOWN
from alight.metrics.epsilon import default_epsilon
from alight.metrics.model import METRICS, label_of, shown_of
from alight.outputs.atomic import replacing
from alight.outputs.display import Display
from alight.outputs.image import write_image

#: Linear formats that keep values below 0, for the plain difference.
_LINEAR = (".exr", ".npy", ".pfm")

SUFFIXES = (".png", ".html", *_LINEAR)

#: Pixels that one of the pictures side by side is wide, at least and at most.
_NARROWEST, _WIDEST = 360, 900


def write_view(path: Path, found: Sequence[PictureComparison], exposure: float) -> Path:
    """Write pictures side by side (PNG), a page (HTML), or the difference a - b (EXR, NPY, PFM).

    Parameters
    ----------
    path : Path
        Its suffix decides.
    found : sequence of PictureComparison
        Against one reference; the difference is that of the first.
    exposure : float
        Stops.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix in _LINEAR:
        return write_image(path, found[0].a.image - found[0].b.image)
    if suffix == ".html":
        page = render_page("compare.html.j2", page_context(found, exposure))
        with replacing(path) as beside:
            beside.write_text(page, encoding="utf-8")
        return path
    with replacing(path) as beside:
        _draw_side_by_side(beside, found, exposure)
    return path


def signed_difference(comparison: PictureComparison) -> np.ndarray:
    """Luminance of a - b over the brightness of b; shape (h, w)."""
    a, b = comparison.a.image.astype(np.float64), comparison.b.image.astype(np.float64)
    scale = np.sqrt((b @ LUMINANCE) ** 2 + max(default_epsilon(b), 1e-30))
    return ((a - b) @ LUMINANCE) / scale


def _draw_side_by_side(path: Path, found: Sequence[PictureComparison], exposure: float) -> None:
    """The pictures in a row and below each its difference to the last one, with a colour bar."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from alight.lab.report.style import GREY, INK

    shown = [comparison.a for comparison in found] + [found[0].b]
    differences = [signed_difference(comparison) for comparison in found]
    scale = pictures.Scale.of(differences, "signed")
    w, h = found[0].a.size
    width = min(max(w, _NARROWEST), _WIDEST)
    height, gap, head, foot, count = width * h / w, 14.0, 44.0, 34.0, len(shown)
    full_w = count * width + (count + 1) * gap
    full_h = 2.0 * (height + head) + foot
    figure = Figure(figsize=(full_w / 100.0, full_h / 100.0), dpi=100)
    FigureCanvasAgg(figure)

    def place(column: int, row: int) -> Any:
        left, top = gap + column * (width + gap), head + row * (height + head)
        box = (left / full_w, 1.0 - (top + height) / full_h, width / full_w, height / full_h)
        axes = figure.add_axes(box)
        axes.set_axis_off()
        return axes

    def title(axes: Any, text: str, note: str) -> None:
        style = {"transform": axes.transAxes, "va": "baseline", "ha": "left"}
        axes.text(0.0, 1.0 + 21.0 / height, _cut(text, width), color=INK, fontsize=9.5,
                  fontweight="bold", **style)  # fmt: skip
        axes.text(0.0, 1.0 + 7.0 / height, note, color=GREY, fontsize=8, **style)

    with mpl.rc_context({"font.family": ["DejaVu Sans"], "axes.unicode_minus": True}):
        for i, one in enumerate(shown):
            axes = place(i, 0)
            axes.imshow(Display(exposure).apply(one.image), interpolation="nearest", aspect="auto")
            role = "reference" if i == count - 1 else f"picture {'AB'[i]}"
            title(axes, Path(one.name).name, role)
        for i, (comparison, plane) in enumerate(zip(found, differences, strict=True)):
            axes = place(i, 1)
            axes.imshow(plane, cmap="RdBu_r", vmin=scale.low, vmax=scale.high, aspect="auto",
                        interpolation="nearest")  # fmt: skip
            title(axes, "Difference to the reference", _words(comparison))
            _draw_bar(figure, axes, scale, (full_w, full_h))
        figure.savefig(path, format="png", facecolor="white")


def _draw_bar(figure: Any, axes: Any, scale: pictures.Scale, size: tuple[float, float]) -> None:
    """A colour bar below a map, 8 pixels high, with three numbers."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    box = axes.get_position()
    bar = figure.add_axes(
        (box.x0 + 0.2 * box.width, box.y0 - 12.0 / size[1], 0.6 * box.width, 8.0 / size[1])
    )
    values = ScalarMappable(Normalize(scale.low, scale.high), "RdBu_r")
    drawn = figure.colorbar(values, cax=bar, orientation="horizontal")
    drawn.outline.set_visible(False)
    ticks = pictures.color_bar(scale, percent=True)["ticks"]
    drawn.set_ticks([scale.low, 0.0, scale.high], labels=[tick.text for tick in ticks])
    bar.tick_params(labelsize=7.5, length=2, pad=1)


def _cut(text: str, width: float) -> str:
    most = int(width / 7.5)
    return text if len(text) <= most else f"…{text[-most + 1 :]}"


def _words(comparison: PictureComparison) -> str:
    """One figure of the error, those of what an eye sees, and the verdict."""
    parts = [
        f"{metric.LABEL} {_number(name, comparison)}"
        for name, metric in METRICS.items()
        if (name == SHOWN or metric.shown or metric.error_map) and name not in comparison.missing
    ]
    return " · ".join([*parts, comparison.verdict])


def _number(name: str, comparison: PictureComparison) -> str:
    """A figure as tables tell it; a similarity is near 1 and needs another digit."""
    if name in comparison.missing:
        return "–"
    value = shown_of(name, comparison.errors[name])
    return number(value, 3 if METRICS[name].shown is None else 4)


# --------------------------------------------------------------------------------------- page


def page_context(found: Sequence[PictureComparison], exposure: float) -> dict[str, Any]:
    """What the page shows: pictures to flip between, maps over common scales, all figures."""
    inputs = [comparison.a for comparison in found] + [found[0].b]
    roles = [*("AB"[: len(found)]), "reference"]
    h, w = inputs[0].image.shape[:2]
    return {
        "pictures": [
            {"name": Path(one.name).name, "role": role,
             "image": pictures.picture_uri(one.image, exposure)}
            for one, role in zip(inputs, roles, strict=True)
        ],
        "width": w,
        "height": h,
        "exposure": exposure,
        "maps": _maps(found),
        "heads": [Path(c.a.name).name for c in found],
        "reference": Path(inputs[-1].name).name,
        "rows": figure_rows(found),
        "verdicts": [(Path(c.a.name).name, c.verdict, c.notes) for c in found],
    }  # fmt: skip


def _maps(found: Sequence[PictureComparison]) -> list[dict[str, Any]]:
    kinds: list[tuple[str, str, str, bool, list[np.ndarray | None]]] = [
        ("signed", "Difference", "Luminance, as a share of the reference’s.", True,
         [signed_difference(c) for c in found]),
        *(("linear", METRICS[name].LABEL, _first_line(METRICS[name].spec.__doc__), False,
           [c.maps.get(name) for c in found]) for name in found[0].maps),
        ("signed", "z", "Of the largest channel of each block: beyond ±5 is no chance.", False,
         [_largest_z(c) for c in found]),
    ]  # fmt: skip
    shown = []
    for kind, title, text, percent, planes in kinds:
        known = [p for p in planes if p is not None]
        if not known:
            continue
        scale = pictures.Scale.of(known, kind)
        if title == "z":
            scale = pictures.Scale("signed", -5.0, 5.0)
        shown.append({
            "title": title, "text": text, "bar": pictures.color_bar(scale, percent=percent),
            "pictures": [
                {"label": Path(c.a.name).name, "image": pictures.map_uri(plane, scale)}
                for c, plane in zip(found, planes, strict=True) if plane is not None
            ],
        })  # fmt: skip
    return shown


def _first_line(text: str | None) -> str:
    return (text or "").partition("\n")[0]


def _largest_z(comparison: PictureComparison) -> np.ndarray | None:
    if comparison.agreement is None:
        return None
    z = comparison.agreement.z
    order = np.argmax(np.nan_to_num(np.abs(z), nan=-1.0), axis=2)
    return np.take_along_axis(z, order[..., None], axis=2)[..., 0]


def figure_rows(found: Sequence[PictureComparison]) -> list[tuple[str, list[str]]]:
    """Name of each figure and its value for each picture, as text."""
    first = found[0]
    rows = [
        *((label_of(name, first.pair), [_number(name, c) for c in found]) for name in METRICS),
        ("MSE by noise of the picture", [number(c.noise_a) for c in found]),
        ("MSE by noise of the reference", [number(c.noise_b) for c in found]),
    ]
    if any(c.agreement for c in found):
        rows.append(("rms z (R, G, B)", [_rms_words(c) for c in found]))
        rows.append(("Largest |z|", [number(c.agreement.largest) if c.agreement else "–"
                                     for c in found]))  # fmt: skip
    for i, channel in enumerate(("red", "green", "blue")):
        rows.append((f"Mean {channel}, to the reference’s", [_mean_words(c, i) for c in found]))
    rows.append(("Verdict", [c.verdict for c in found]))
    return rows


def _rms_words(comparison: PictureComparison) -> str:
    test = comparison.agreement
    return " ".join(number(v) for v in test.rms) if test else "–"


def _mean_words(comparison: PictureComparison, channel: int) -> str:
    a, b = (float(one.image[..., channel].mean(dtype=np.float64))
            for one in (comparison.a, comparison.b))  # fmt: skip
    share = f" ({100.0 * (a / b - 1.0):+.3f} %)".replace("-", "−") if b else ""
    return f"{number(a, 4)}{share}"
