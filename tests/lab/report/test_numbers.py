"""Numbers of a report: their digits, and decimals that align."""

import itertools
import math

import numpy as np
import pytest

from alight.lab.report.charts import legible, spread, tick_texts
from alight.lab.report.numbers import Column, interval, number, p_value
from alight.metrics.estimate import Estimate

NAN = math.nan


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (1.0, "1.00"), (-0.01234, "−0.0123"), (99999.0, "99\u2009999"),
        (1.5e-7, "1.50 × 10⁻⁷"), (-2e9, "−2.00 × 10⁹"), (NAN, "–"), (None, "–"), (math.inf, "∞"),
    ],
)  # fmt: skip
def test_single_numbers(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("p", "text"),
    [(0.5, "0.50"), (0.04, "0.040"), (0.0995, "0.10"), (0.001, "0.001"), (0.0009, "< 0.001"),
     (0.0, "< 0.001"), (NAN, "–"), (None, "–")],
)  # fmt: skip
def test_probabilities(p, text):
    assert p_value(p) == text


@pytest.mark.parametrize(
    ("values", "texts", "unit"),
    [
        ([1.0, 2.5, 12.34], ["1.0", "2.5", "12.3"], ""),
        ([0.0123, 0.00456], ["12.3", "4.6"], "× 10⁻³"),
        ([0.5, 0.03], ["0.500", "0.030"], ""),
        ([123456.0, 7000.0], ["123.5", "7.0"], "× 10³"),
        ([1e-9, 1.0], ["1.00 × 10⁻⁹", "1.00"], ""),
        ([NAN, None, 2.0], ["–", "–", "2.00"], ""),
        ([], [], ""),
    ],
)
def test_columns_share_their_decimals(values, texts, unit):
    column = Column.of(values)
    assert [column.text(v) for v in values] == texts
    assert column.unit == unit


def test_intervals_are_left_out_where_unknown_or_exact():
    column = Column.of([2.0])
    assert column.bounds(Estimate(2.0, 1.5, -2.5)) == "[1.50, −2.50]"
    assert column.bounds(Estimate(2.0, NAN, 2.5)) == ""
    assert column.bounds(Estimate(2.0, 2.0, 2.0)) == ""
    assert interval(Estimate(2.0, 1.5, 2.5)) == "2.00 (1.50 to 2.50)"
    assert interval(Estimate(NAN, NAN, NAN)) == "unknown"


def test_ticks_of_an_axis_are_written_alike():
    assert tick_texts([1000.0, 0.5]) == ["1\u2009000", "0.5"]
    assert tick_texts([1e-4, 2e-3, 1.0]) == ["10⁻⁴", "2 × 10⁻³", "1"]


@pytest.mark.parametrize(
    "wanted",
    [[0, 0, 0, 0], [0, 50, 99, 100], [10, 12, 60, 61], [-40, -40, 140, 140], [5, 50, 70, 95]],
)
def test_labels_keep_apart_in_order_and_inside(wanted):
    places = spread(wanted, [20.0] * 4, 0.0, 100.0)
    assert all(b - a >= 20 - 1e-9 for a, b in itertools.pairwise(places))
    assert places[0] >= 10 - 1e-9
    assert places[-1] <= 90 + 1e-9


def test_labels_with_room_stay_where_they_belong():
    assert spread([10.0, 40.0, 80.0], [20.0] * 3, 0.0, 100.0) == [10.0, 40.0, 80.0]
    assert spread([40.0, 42.0], [20.0] * 2, 0.0, 100.0) == [31.0, 51.0]


def test_numbers_of_an_axis_do_not_overprint():
    fine = [0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009]
    kept = legible(fine, 0.0029, 0.0095, 0.16)
    apart = np.diff(np.log(kept)) / np.log(0.0095 / 0.0029)
    assert len(kept) >= 3
    assert apart.min() >= 0.16
    # Seven doublings across an axis stay.
    doubled = [2.0**k for k in range(7)]
    assert legible(doubled, 1.0, 64.0, 0.16) == doubled
