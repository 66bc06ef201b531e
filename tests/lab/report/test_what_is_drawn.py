"""What a report draws and writes is what the result says: lines, looks and cells, one by one."""

import itertools
import operator
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

from alight.lab.report import charts, data_files, style
from alight.lab.report.page import table_context
from alight.lab.report.tables import error_table
from alight.lab.results import TableResult
from alight.metrics.estimate import Estimate
from tests.lab.report import synthetic


@pytest.mark.parametrize("expected", [None, -0.5])
def test_fitted_lines_have_the_slope_that_is_written_beside_them(expected):
    x, y = [4.0, 16.0, 100.0], [0.9, 0.2, 0.03]
    look = style.Look("#0072b2", "o", False)
    line = charts.Line("net", look, x, y, y, y, Estimate(-1.3, -1.9, -0.2), expected)
    axes = style.new_figure(1.0, 1.0).add_axes((0.0, 0.0, 1.0, 1.0))
    charts._draw_slopes(axes, line)
    drawn = []
    for shown in axes.lines:
        ends, values = np.log(np.asarray(shown.get_data()))
        slope = np.diff(values)[0] / np.diff(ends)[0]
        drawn.append(slope)
        # Through the middle of the points.
        middle = values[0] + slope * (np.log(x).mean() - ends[0])
        assert middle == pytest.approx(np.log(y).mean())
        assert np.exp(ends[0]) < x[0] < x[-1] < np.exp(ends[1])
    assert drawn == pytest.approx([s for s in (expected, -1.3) if s is not None])


@pytest.mark.parametrize("baseline", range(9))
def test_looks_repeat_only_where_all_colours_are_taken(baseline):
    """Wherever the baseline stands: the first eight of the others are solid and all differ."""
    found = style.looks(9, baseline)
    assert found.pop(baseline) == style.Look(style.BASELINE, "o", False)
    assert len({look.color for look in found}) == len({look.mark for look in found}) == 8
    assert not any(look.dashed for look in found)
    again = style.looks(17, baseline)[9:]
    assert all(look.dashed for look in again)


def test_the_digits_of_a_bias_are_those_of_its_noise():
    """However large it is: what is shown differs by less than the noise."""
    for value, half in ((5.0034, 0.005), (3.2e-6, 4e-7), (12345.6, 250.0)):
        arm = synthetic.arm("base", 0, 0.01, np.ones((48, 48, 3), np.float32))
        known = replace(arm.samples[-1], bias2=Estimate(value, value - half, value + half))
        table = error_table([(replace(arm, samples=[known], times=[]), None)])
        (at,) = (i for i, head in enumerate(table.heads) if head.startswith("bias²"))
        shown, unit = table.rows[0].cells[at].text, _power(table.heads[at])
        assert abs(_number(shown) * unit - value) <= 0.05 * half


def test_a_table_of_a_study_shows_each_value_under_its_own_head():
    """Times the power of ten of its head it is that of the result, whole numbers to the end."""
    rows = [
        ["few", 7000, [2e-5, 1e-5, 3e-5], True, 4.5e7],
        ["many", 2_500_000, [8e-5, 6e-5, 9e-5], False, None],
    ]
    columns = ["Lamps", "Rays", "Share", "Kept", "Bytes"]
    shown = table_context(TableResult("t", "T", "About it.", columns, rows))
    table = shown["table"]
    assert shown["first"] == "Lamps"
    assert [head.split(" ×")[0] for head in table.heads] == columns[1:]
    for row, made in zip(rows, table.rows, strict=True):
        assert made.label == row[0]
        for head, value, cell in zip(table.heads, row[1:], made.cells, strict=True):
            assert cell.title == head
            if value is None or isinstance(value, bool):
                assert cell.text == {None: "", True: "yes", False: "no"}[value]
                continue
            middle = value[0] if isinstance(value, list) else value
            assert _number(cell.text) * _power(head) == pytest.approx(middle, rel=1e-9)


def _number(text):
    return float(text.replace("\u2009", "").replace("−", "-"))


def _power(head):
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return 10.0 ** int(head.rpartition("10")[2].translate(digits)) if "×" in head else 1.0


#: Columns of arms.csv, once more: an attribute of the arm, of which intervals have three columns.
COLUMNS = {
    "arm": "name", "label": "label", "baseline": "is_baseline",
    "declares_different": "declares_different", "replicates": "replicates",
    "verdict": "bias.verdict", "efficiency": "efficiency", "speedup": "speedup.ratio",
    "speedup_p": "speedup.p_value", "speedup_p_holm": "speedup.p_adjusted",
    "bootstrap_low": "speedup.bootstrap.low", "bootstrap_high": "speedup.bootstrap.high",
    "slope_spp": "slope_spp", "slope_time": "slope_time", "expected_slope": "expected_slope",
    "z_rms": "bias.z_rms", "z_low": "bias.z_low", "z_high": "bias.z_high",
    "z_largest": "bias.z_largest", "bias_p": "bias.p_value",
    "microseconds_per_sample": "microseconds_per_sample", "compile_seconds": "compile_seconds",
    "load_seconds": "load_seconds", "invalid": "invalid",
}  # fmt: skip
OTHERS = {"scene", "options", "seeds"}


def test_each_column_of_a_file_of_arms_has_its_own_number():
    """No two numbers of the arm are the same."""
    count = itertools.count(1)

    def numbered(value):
        """The same with other numbers."""
        if isinstance(value, Estimate):
            n = next(count)
            return Estimate(n + 0.5, n + 0.25, n + 0.75)
        if is_dataclass(value):
            names = [f.name for f in fields(value) if f.name not in ("images", "samples", "times")]
            return replace(value, **{name: numbered(getattr(value, name)) for name in names})
        return (
            value if isinstance(value, bool) or not isinstance(value, int | float) else next(count)
        )

    picture = np.ones((48, 48, 3), np.float32)
    arm = numbered(synthetic.arm("base", 0, 0.01, picture, ratio=4.0))
    (row,) = data_files._arm_rows(synthetic.study([synthetic.scene([arm])]))
    expected = {}
    for column, path in COLUMNS.items():
        value = operator.attrgetter(path)(arm)
        ends = ("", "_low", "_high") if isinstance(value, Estimate) else ("",)
        values = value if isinstance(value, Estimate) else (value,)
        expected |= {column + end: one for end, one in zip(ends, values, strict=True)}
    assert {name: row[name] for name in row.keys() - OTHERS} == expected
