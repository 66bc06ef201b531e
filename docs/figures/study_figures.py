"""The figure of one study: convergence, speed-ups, and crops at equal time."""

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, NullLocator
from PIL import Image

from alight.lab.report.charts import tick_texts
from alight.lab.report.pictures import exposure_for
from alight.lab.report.scenes import crops_of
from alight.lab.report.style import BASELINE, FAINT, GREY, Look, looks, new_figure, paper_style
from alight.lab.results import CurveResult, SceneResult, StudyResult
from alight.outputs.display import Display

#: Inches.
WIDTH, PANEL, CROP = 7.4, 2.3, 1.3

#: Samples per pixel of the zone plates.
LADDER = (1, 4, 16, 64)

#: Crops of more scenes would be too small to see anything.
MOST_STRIPS = 2


def draw(result: StudyResult, path: Path) -> None:
    """Write the figure of a study as SVG, always the same bytes."""
    with paper_style(), mpl.rc_context({"svg.fonttype": "path", "figure.facecolor": "white"}):
        figure = _scenes(result.scenes) if result.scenes else _curves(result.curves)
        path.parent.mkdir(exist_ok=True)
        figure.savefig(path, metadata={"Date": None, "Creator": None}, facecolor="white")


def _looks(scene: SceneResult) -> list[Look]:
    baseline = next(i for i, arm in enumerate(scene.arms) if arm.is_baseline)
    return looks(len(scene.arms), baseline)


def draw_means(scene: SceneResult, path: Path) -> None:
    """Write the mean pictures of all arms, side by side and without noise to speak of."""
    show = Display(exposure_for(scene.reference_image))
    row = np.concatenate([show.apply(arm.images.mean) for arm in scene.arms], axis=1)
    grey = np.round(np.clip(row.mean(axis=2), 0.0, 1.0) * 255.0).astype(np.uint8)
    Image.fromarray(grey).save(path, optimize=True)


def draw_examples(scenes: Sequence[SceneResult], path: Path) -> None:
    """Write what each arm shows in the time of the baseline, and the reference: a scene a row."""
    columns = len(scenes[0].arms) + 1
    side = WIDTH / columns
    shapes = [scene.reference_image.shape for scene in scenes]
    rows = [side * shape[0] / shape[1] for shape in shapes]
    height = sum(rows) + 0.3
    with paper_style(), mpl.rc_context({"figure.facecolor": "white"}):
        figure = new_figure(WIDTH, height)
        top = height - 0.3
        for scene, row in zip(scenes, rows, strict=True):
            top -= row
            show = Display(exposure_for(scene.reference_image))
            shown = [(arm.label, arm.images.example) for arm in scene.arms]
            for i, (label, image) in enumerate([*shown, ("reference", scene.reference_image)]):
                box = (i / columns + 0.002, top / height, 1.0 / columns - 0.004, row / height)
                axes = figure.add_axes(box)
                picture = np.clip(show.apply(image), 0.0, 1.0)
                axes.imshow(np.round(picture * 255.0).astype(np.uint8), interpolation="nearest")
                axes.set_axis_off()
                if scene is scenes[0]:
                    axes.set_title(label, fontsize=7)
        figure.savefig(path, dpi=200, metadata={"Software": None}, facecolor="white")


# ------------------------------------------------------------------------ studies of pictures


def _scenes(scenes: Sequence[SceneResult]) -> Figure:
    strips = len(scenes) <= MOST_STRIPS
    count = len(scenes[0].arms) + 1
    crop = min(CROP, (WIDTH - 0.1) / count)
    row = PANEL + 0.62 + (crop + 0.5 if strips else 0.0)
    figure = new_figure(WIDTH, row * len(scenes))
    height = figure.get_figheight()
    for i, scene in enumerate(scenes):
        top = height - i * row - 0.28
        figure.text(0.01, (top + 0.08) / height, scene.label, fontweight="bold", va="bottom")
        bottom = (top - 0.2 - (PANEL - 0.35)) / height
        size = (PANEL - 0.35) / height
        _convergence(figure.add_axes((0.075, bottom, 0.40, size)), scene)
        _speedups(figure.add_axes((0.73, bottom, 0.24, size)), scene)
        if strips:
            _strip(figure, scene, top - PANEL - 0.42, crop)
    return figure


def draw_samples(path: Path) -> None:
    """Write the zone plate with 1, 4, 16 and 64 samples per pixel, side by side."""
    import alight

    changes = ["film.size=[256,256]", "film.filter.type=box"]
    scene = alight.load("zone-plate", changes)
    pictures = [np.asarray(Display(0.0).apply(alight.render(scene, spp=n).image[:128, :128]))
                for n in LADDER]  # fmt: skip
    with paper_style(), mpl.rc_context({"svg.fonttype": "path", "figure.facecolor": "white"}):
        figure = new_figure(WIDTH, WIDTH / len(LADDER) + 0.22)
        for i, (spp, picture) in enumerate(zip(LADDER, pictures, strict=True)):
            share = 1.0 / len(LADDER)
            axes = figure.add_axes((i * share + 0.004, 0.01, share - 0.008, 0.88))
            axes.imshow(np.round(np.clip(picture, 0.0, 1.0) * 255.0).astype(np.uint8),
                        interpolation="nearest")  # fmt: skip
            axes.set_axis_off()
            axes.set_title(f"{spp} samples a pixel" if spp > 1 else "1 sample a pixel", fontsize=8)
        figure.savefig(path, metadata={"Date": None, "Creator": None}, facecolor="white")


def _convergence(axes: Axes, scene: SceneResult) -> None:
    """RelMSE over samples per pixel, with bands."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    for arm, look in zip(scene.arms, _looks(scene), strict=True):
        points = [point for point in arm.samples if point.relmse.value > 0.0]
        x = [point.spp for point in points]
        low, high = ([max(point.relmse[i], 1e-30) for point in points] for i in (1, 2))
        axes.plot(x, [point.relmse.value for point in points], marker=look.mark, color=look.color,
                  linestyle="--" if arm.declares_different else "-",
                  markeredgecolor="white", markeredgewidth=0.6)  # fmt: skip
        axes.vlines(x, low, high, color=look.color, linewidth=0.9, alpha=0.7)
    values = [point.relmse.value for arm in scene.arms for point in arm.samples]
    _limit(axes, [v for v in values if v > 0.0])
    axes.xaxis.set_major_locator(FixedLocator([point.spp for point in scene.arms[0].samples]))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("samples per pixel")
    axes.set_title("relMSE", loc="left", fontsize=8.5)


def _limit(axes: Axes, values: Sequence[float]) -> None:
    """Some room, ticks at powers of ten or 1, 2, 5, and faint lines."""
    low, high = min(values), max(values)
    room = max((high / low) ** 0.07, 1.15)
    axes.set_ylim(low / room, high * room)
    decades = math.log10(high / low)
    subs = (1.0,) if decades > 2.0 else (1.0, 2.0, 5.0)
    inside = [s * 10.0**e for e in range(-40, 40) for s in subs
              if low / room <= s * 10.0**e <= high * room]  # fmt: skip
    inside = inside[:: max(1, math.ceil(len(inside) / 7))]
    axes.yaxis.set_major_locator(FixedLocator(inside))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_yticklabels(tick_texts(inside))
    axes.grid(axis="y")
    axes.spines["left"].set_visible(False)


def _speedups(axes: Axes, scene: SceneResult) -> None:
    """Dots and intervals of the efficiency over the baseline's, and the key of the colours."""
    arms = sorted(zip(scene.arms, _looks(scene), strict=True), key=lambda a: a[0].efficiency.value)
    axes.set_xscale("log")
    axes.axvline(1.0, color=BASELINE, linewidth=0.8, linestyle=(0, (2, 2)), zorder=1)
    values = [1.0]
    for y, (arm, look) in enumerate(arms):
        ratio = arm.speedup.ratio if arm.speedup else None
        x = ratio.value if ratio else 1.0
        if ratio:
            axes.hlines(y, ratio.low, ratio.high, color=look.color, linewidth=1.8)
        fill = "white" if arm.declares_different else look.color
        axes.plot(x, y, marker=look.mark, markersize=6, color=fill, markeredgecolor=look.color)
        values += [x, *((ratio.low, ratio.high) if ratio else ())]
    low, high = min(values), max(values)
    room = max((high / low) ** 0.1, 1.06)
    axes.set_xlim(low / room, high * room)
    axes.set_ylim(-0.6, len(arms) - 0.4)
    axes.set_yticks(range(len(arms)), [_short(arm.label) for arm, _ in arms])
    for label, (_, look) in zip(axes.get_yticklabels(), arms, strict=True):
        label.set_color(look.color)
        label.set_fontweight("bold")
    subs = ((1.0,) if high / low > 30.0 else (1.0, 2.0, 5.0) if high / low > 3.0 else
            (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0))  # fmt: skip
    inside = [s * 10.0**e for e in range(-8, 8) for s in subs
              if low / room <= s * 10.0**e <= high * room]  # fmt: skip
    axes.xaxis.set_major_locator(FixedLocator(inside[:: max(1, math.ceil(len(inside) / 4))]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(lambda x, _: tick_texts([x])[0])
    axes.set_title("speed-up over the baseline" if low < high else "", loc="left", fontsize=8.5)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)


def _short(label: str) -> str:
    """A label in lines of about 20 letters."""
    words, lines = label.split(), [""]
    for word in words:
        if lines[-1] and len(lines[-1]) + len(word) > 19:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def _strip(figure: Figure, scene: SceneResult, top: float, size: float) -> None:
    """The reference and one picture of each arm, cut where the arms differ most."""
    height = figure.get_figheight()
    x, y, w, h = crops_of(scene)[0]
    show = Display(exposure_for(scene.reference_image))
    arms = list(zip(scene.arms, _looks(scene), strict=True))
    tiles = [("reference", GREY, scene.reference_image)]
    tiles += [(arm.label, look.color, arm.images.example) for arm, look in arms]
    left = 0.005 * WIDTH
    for i, (label, color, image) in enumerate(tiles):
        side = min(size, CROP) - 0.06
        box = ((left + i * size) / WIDTH, (top - side) / height, side / WIDTH, side / height)
        axes = figure.add_axes(box)
        part = np.asarray(show.apply(image[y : y + h, x : x + w]), np.float64)
        axes.imshow(np.round(part * 255.0).clip(0, 255).astype(np.uint8), interpolation="nearest")
        axes.set_axis_off()
        axes.text(0.0, 1.03, _short(label), transform=axes.transAxes, color=color,
                  fontsize=6.8, fontweight="bold", va="bottom", linespacing=0.95)  # fmt: skip


# ------------------------------------------------------------------------- studies of their own


def _curves(diagrams: Sequence[CurveResult]) -> Figure:
    """Small diagrams in a row, with one key."""
    columns = 2 if len(diagrams) <= 4 else 5
    rows = -(-len(diagrams) // columns)
    panel = 2.6 if columns == 2 else 1.75
    figure = new_figure(WIDTH, rows * (panel + 0.35) + 0.45)
    height = figure.get_figheight()
    names = list(dict.fromkeys(c.label for d in diagrams for c in d.curves))
    styles = dict(zip(names, looks(len(names)), strict=True))
    gap = 0.075 if columns == 2 else 0.05
    for i, diagram in enumerate(diagrams):
        row, column = divmod(i, columns)
        width = (1.0 - 0.01) / columns
        bottom = (height - 0.3 - row * (panel + 0.35) - panel + 0.15) / height
        axes = figure.add_axes((column * width + gap, bottom, width - gap - 0.006,
                                (panel - 0.45) / height))  # fmt: skip
        _diagram(axes, diagram, styles, small=columns > 2)
    handles = [mpl.lines.Line2D([], [], color=s.color, marker=s.mark, label=n)
               for n, s in styles.items()]  # fmt: skip
    figure.legend(handles=handles, loc="lower center", ncol=len(names), frameon=False,
                  fontsize=8, handlelength=1.6, columnspacing=1.2)  # fmt: skip
    return figure


def _diagram(axes: Axes, diagram: CurveResult, styles: dict[str, Look], small: bool) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for curve in diagram.curves:
        look = styles[curve.label]
        axes.plot(curve.x, curve.y, color=look.color, marker=look.mark,
                  markersize=2.6 if small else 4.5, linewidth=1.0 if small else 1.4)  # fmt: skip
        axes.fill_between(curve.x, curve.low, curve.high, color=look.color, alpha=0.18, linewidth=0)
    if small:
        low = min(y for c in diagram.curves for y in c.y if y > 0.0)
        axes.set_ylim(max(low / 3.0, 1e-8), 3.0)
        axes.tick_params(labelsize=6.5)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(10.0, numticks=6))
        axis.set_minor_locator(NullLocator())
        axis.set_minor_formatter(NullFormatter())
    ticks = [t for t in axes.get_yticks() if axes.get_ylim()[0] <= t <= axes.get_ylim()[1]]
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.set_yticklabels(tick_texts(ticks))
    axes.grid(axis="y", color=FAINT)
    axes.spines["left"].set_visible(False)
    title = diagram.title.replace("-dimensional", "D")
    title = title.replace("A product of sines", "smooth").replace("A ball's indicator", "edge")
    axes.set_title(title if small else f"{title}: {diagram.y_label}", loc="left", fontsize=8)
    axes.set_xlabel(diagram.x_label, fontsize=7 if small else 8.5)
