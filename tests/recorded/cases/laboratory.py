"""The laboratory: reports of made-up studies, comparisons, statistics, reasons, references."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

import alight
from alight.lab import figures, panels
from alight.lab.compare import compare
from alight.lab.report import charts, numbers, pictures, scenes, style, tables
from alight.lab.report import outcome as outcomes
from alight.lab.report.data_files import write_data
from alight.lab.report.page import curve_context, study_context, table_context
from alight.lab.report.targets import check_target
from alight.lab.result_files import load, save
from alight.lab.results import BIASED, UNBIASED
from alight.lab.sheet.tiles import fitted
from alight.lab.statistics import agreement, block_means, decomposition, equal_time, intervals
from alight.metrics.estimate import Estimate
from alight.samplers.independent import Independent
from alight.samplers.sobol import Sobol
from tests.lab.report import synthetic
from tests.recorded.making import described, film_of, in_folder, masked, outcome, rows


def _plain(value: Any) -> Any:
    """Contexts of pages: pictures and drawings are left to a reader of theirs."""
    if isinstance(value, str) and ("<svg" in value or "base64," in value):
        texts = re.findall(r">([^<>\n]+)<", value)
        return ["drawing", sorted(set(texts))[:40], value.count("<path") + value.count("<use")]
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return _plain(value._asdict())
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return described(value)


def reports() -> dict[str, Any]:
    """Everything that pages, tables and files of a study say."""
    result = synthetic.study()
    scene = result.scenes[0]
    found: dict[str, Any] = {
        "summary": outcomes.summary(result, 2.5),
        "table": outcomes.scene_table(scene),
        "sentences": scenes.sentences(scene),
        "crops": scenes.crops_of(scene),
        "columns": [scenes.columns(n) for n in range(1, 9)],
        "overview": described(tables.overview(result.scenes)),
        "badges": [tables.badges_of(arm) for arm in scene.arms],
        "comparable": [tables.comparable(arm) for arm in scene.arms],
        "points": [described(tables.equal_time_point(arm)) for arm in scene.arms],
    }
    looks = style.looks(len(scene.arms), 0)
    ranked = tables.ranked(scene, looks)
    for name in ("efficiency_table", "error_table", "cost_table", "truth_table"):
        found[name] = described(getattr(tables, name)(ranked))
    context = study_context(result)
    found["page"] = {k: _plain(v) for k, v in context.items() if k not in ("scenes", "curves")}
    found["scene"] = _plain(context["scenes"][0])
    found["curve"] = _plain(curve_context(result.curves[0], 0))
    found["tables"] = [_plain(table_context(one)) for one in result.tables]
    with in_folder() as folder:
        for path in write_data(result, folder):
            found[path.name] = path.read_text("utf-8") if path.suffix == ".csv" else ""
        save(result, folder)
        again = load(folder / "results.json")
        found["kept"] = [again.name, again.scenes[0].arms[1].speedup == scene.arms[1].speedup]
        found["report"] = str(outcomes.StudyReport(result, Path("page.html"), 1.5))
        html = outcomes.StudyReport(result, Path("page.html"), 1.5)._repr_html_()
        found["html"] = re.sub(r'base64,[^"]*', "PNG", html)
        found["targets"] = rows(
            lambda name: check_target(Path(name), (".html", ".png")),
            ["a.html", "a.pdf", "none/a.png", "a"],
        )
    return found


def numbers_in_words() -> dict[str, Any]:
    """How reports write numbers."""
    values = (
        0.0,
        1.0,
        -1.5,
        0.00123456,
        123456.0,
        9.995,
        0.0999,
        1e-12,
        -3e9,
        float("nan"),
        float("inf"),
        None,
    )
    found: dict[str, Any] = {
        "numbers": [[numbers.number(v, d) for d in (2, 3, 5)] for v in values],
        "fixed": [[numbers.fixed(v, d) for d in (0, 2, 4)] for v in values[:9]],
        "powers": [numbers.superscript(n) for n in (-12, 0, 3, 10)],
        "intervals": [
            numbers.interval(e)
            for e in (None, Estimate(1.234, 1.1, 1.4), Estimate(2e-5, -1e-6, 3e-5))
        ],
        "p": [numbers.p_value(p) for p in (None, 0.5, 0.04999, 1e-3, 1e-9, 0.0)],
        "ticks": charts.tick_texts([0.001, 0.01, 0.1, 1.0]),
        "more": charts.tick_texts([1, 2, 5, 10, 20]),
        "legible": charts.legible([1, 2, 3, 4, 5, 10, 20, 50, 100], 1, 100, 0.1),
        "spread": charts.spread([1.0, 1.1, 1.2, 5.0], [1.0, 1.0, 1.0, 1.0], 0.0, 9.0),
        "looks": [described(look) for look in style.looks(12, 3)],
    }
    column = [1.5e-5, 3.25e-4, None, 2e-6]
    found["column"] = outcome(lambda: described(numbers.Column(column, [1e-6, 1e-5, 1e-6])))
    return found


def views() -> dict[str, Any]:
    """Maps, scales and crops of reports."""
    draw = np.random.default_rng(3)
    reference = draw.random((20, 30, 3))
    planes = [draw.random((20, 30)) - 0.4 * n for n in range(3)]
    found: dict[str, Any] = {
        "exposure": [pictures.exposure_for(reference * k) for k in (0.01, 1.0, 30.0)],
        "reduced": described(pictures.reduced(planes[1], 7)),
        "differences": described(pictures.error_differences(planes, 8)),
        "crops": pictures.choose_crops(planes),
        "fitted": [
            fitted(a, b) for a in ((640, 480), (10, 900), (5, 5)) for b in ((64, 48), (48, 64))
        ],
        "heat": described(panels.heat(planes[0] ** 2, 0.5)),
        "encoded": described(panels.encoded(reference)),
        "sheets": rows(
            lambda n: panels.check_sheet(Path(n)), ["a.png", "a.jpg", "none/a.png", "a"]
        ),
    }
    for name in ("Scale",):
        made = [m for m in vars(getattr(pictures, name)) if not m.startswith("_")]
        found[name] = sorted(made)
    found["figures"] = described(
        figures.Figures(reference.astype(np.float32), np.float32(0.01 * reference)).of(
            np.float32(reference * 1.1)
        )
    )
    return found


def compared() -> dict[str, Any]:
    """Pictures of films and arrays, compared."""
    a, b = (film_of((24, 19), spp=8, seed=s, aovs={"albedo": ("R", "G", "B")}) for s in (1, 2))
    array = b.image * 1.05
    broken = array.copy()
    broken[3, 4, 1] = np.nan
    display = np.clip(array, 0, 1)
    found: dict[str, Any] = {}
    pairs: dict[str, tuple[Any, Any, dict[str, Any]]] = {
        "films": (a, b, {}),
        "itself": (a, a, {}),
        "arrays": (array, b.image, {"exposure": 1.0}),
        "film and array": (a, array, {}),
        "with": (a, array, {"reference": b}),
        "limits": (a, array, {"fail_above": ["rmse=1e-4", "smape=9"]}),
        "broken": (broken, b, {}),
        "without broken": (broken, b, {"skip_invalid": True}),
        "sizes": (a, array[1:], {}),
        "wrong limit": (a, b, {"fail_above": "rmsee=1"}),
        "no limit": (a, b, {"fail_above": "rmse"}),
        "dark": (a.image * 0, b, {}),
        "bright": (display * 5, display, {}),
        "nothing": ("none.exr", b, {}),
    }
    for name, (one, other, words) in pairs.items():
        made = outcome(lambda o=one, p=other, w=words: _comparison(o, p, w))
        found[name] = made
    with in_folder():
        comparison = compare(a, b, flip=False)
        for path in ("a.npy", "a.exr", "a.pfm", "a.html", "a.png", "a.txt"):
            found[f"written {path}"] = outcome(
                lambda p=path: comparison.save(p).stat().st_size > 100
            )
        found["difference"] = described(np.load("a.npy"))
        texts = re.findall(r">([^<>\n]+)<", Path("a.html").read_text("utf-8"))
        found["page"] = [t for t in texts if not t.startswith(".") and len(t) < 200][:90]
        found["html"] = re.sub(r'base64,[^"]*', "PNG", comparison._repr_html_())
    return found


def _comparison(one: Any, other: Any, words: dict[str, Any]) -> dict[str, Any]:
    made = compare(one, other, flip=False, **words)
    return {"says": str(made), "exceeded": made.exceeded, "numbers": described(made.to_dict())}


def statistics() -> dict[str, Any]:
    """Intervals, blocks, votes, equal times."""
    draw = np.random.default_rng(8)
    a, b = draw.random(9) + 0.5, 2.0 * draw.random(9) + 1.0
    logs = intervals.log_mean(a), intervals.log_mean(b)
    seen = draw.random((7, 18, 24, 3)).astype(np.float32) + 0.2
    moments = decomposition.Moments()
    for one in seen:
        moments.add(one)
    row = [block_means.block_row(one) for one in seen]
    arm = block_means.BlockMoments.of(row, (24, 18)).statistics
    calm = block_means.BlockMoments.calm(row, (24, 18)).statistics
    other = block_means.BlockMoments.of([r * 1.02 for r in row[1:]], (24, 18)).statistics
    exact = block_means.exact_statistics(seen[0], None)
    raw = [block_means.compare_with_reference(arm, one) for one in (other, exact)]
    reference = seen.mean(axis=0)
    pairs = {("a", "b"): 0.4, ("a", "c"): 1e-9, ("b", "c"): 1e-7}
    disputed = {("a", "b"): 1e-9, ("a", "c"): 1e-9, ("b", "c"): 1e-7}
    samplers = {"independent": Independent(), "sobol": Sobol()}
    return {
        "mean": described(logs[0]),
        "interval": described(logs[0].interval),
        "variance": logs[1].variance,
        "ratio": described(intervals.log_ratio(*logs)),
        "more doubt": described(intervals.log_ratio(*logs, extra_variance=0.2)),
        "bootstrap": described(intervals.bootstrap_ratio([a, b], [b, a], 3)),
        "left out": intervals.leave_one_out(a),
        "mean interval": intervals.mean_interval(a),
        "positive": [intervals.positive_interval(v) for v in (a, a - 1.0)],
        "exponential": intervals.exponential(Estimate(0.1, -0.2, 0.5)),
        "holm": intervals.holm_adjusted([0.01, 0.04, 0.03, 0.9]),
        "slope": described(
            intervals.log_slope(
                np.array([[4.0, 16, 64]] * 6).T, (draw.random((6, 3)) * [9, 3, 1]).T
            )
        ),
        "quantile": [intervals.quantile(d) for d in (1, 2.5, 40)],
        "parts": described(
            decomposition.decompose(moments, reference, np.float32(0.001 * reference))
        ),
        "moments": [described(moments.variance), described(moments.mean)],
        "spread": decomposition.reference_spread(np.float32(0.01 * reference), 5),
        "block": [block_means.block_size(s) for s in ((8, 8), (64, 48), (512, 512), (1, 9))],
        "arm": described(arm, 9),
        "calm": described(calm, 9),
        "exact": described(exact, 9),
        "tests": described(raw, 9),
        "judged": [described(j) for j in block_means.judge(raw, [False, True])],
        "joined": described(block_means.joined_statistics(arm, 4), 9),
        "votes": [described(agreement.counted("abc", p, 0.01)) for p in (pairs, disputed)],
        "vote": described(agreement.vote({"a": arm, "b": other, "c": calm}, {"a": other})),
        "natural": {
            n: [equal_time.is_natural(k, s, 4) for k in (3, 4, 6, 8, 12, 16, 20)]
            for n, s in samplers.items()
        },
        "brackets": {
            n: [described(equal_time.bracket(w, s, 4)) for w in (0.3, 5.0, 23.0, 1000.0)]
            for n, s in samplers.items()
        },
        "powers": sorted(equal_time.powers_of_two(3, 70)),
        "words": [BIASED, UNBIASED],
    }


def asked() -> dict[str, Any]:
    """Files and scenes of which `info`, `models`, `scenes` and others tell."""
    found: dict[str, Any] = {}
    for name in ("cornell-box", "milk", "instances", "motion-blur", "fog", "environment-map"):
        info = alight.info(name)
        found[name] = [str(info), info.remarks()]
    found["html"] = masked(alight.info("cornell-box", tree=True)._repr_html_())
    found["changed"] = str(
        alight.info(
            "cornell-box",
            changes=["film.size=[40, 30]", "film.crop=[1, 2, 30, 20]", "integrator.type=direct"],
        )
    )
    found["wrong"] = [
        outcome(lambda w=w: str(alight.info("cornell-box", **w)))
        for w in ({"size": "x"}, {"sise": 3}, {"integrator": "pat"})
    ]
    return found


CASES = {
    "reports": reports,
    "numbers_in_words": numbers_in_words,
    "views": views,
    "compared": compared,
    "statistics": statistics,
    "asked": asked,
}
