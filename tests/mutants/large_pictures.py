"""Bugs of what machine code adds up of large pictures, and of pictures and looks at the edges."""

from tests.mutants.mutant import Mutant

LARGE = "tests/metrics/test_large_pictures.py::test_machine_code_adds_up_what_numpy_does"
EDGES = "tests/metrics/test_edges_of_intervals.py"

LARGE_PICTURES = (
    Mutant(
        "brightness that holds most of its own error in products",
        "metrics/own_error.py",
        (
            (
                "np.maximum(brightness - np.sqrt(variance), 0.0)",
                "np.maximum(brightness - 0.25 * np.sqrt(variance), 0.0)",
            ),
        ),
        f"{EDGES}::test_light_of_few_events_in_half_a_picture_does_not_excuse_itself",
    ),
    Mutant(
        "rows of a large picture that stand for four, wherever they lie",
        "metrics/unmet_light.py",
        (("EVENTS * float(size) * share", "EVENTS * float(size) / step"),),
        "tests/metrics/test_unmet_light.py"
        "::test_a_large_picture_of_any_height_is_looked_at_in_proportion[size0]",
    ),
    Mutant(
        "a weight that is infinite where there is hardly any light",
        "metrics/own_error.py",
        (
            (
                "np.sqrt(as_is) / np.sqrt(quiet * quiet + epsilon)",
                "np.sqrt(as_is / (quiet * quiet + epsilon))",
            ),
        ),
        f"{EDGES}::test_an_interval_is_in_order_or_unknown",
    ),
    Mutant(
        "the last pixels of a row added twice",
        "metrics/large_pictures.py",
        (
            (
                "known_of(picture, place) & (lane_index() + x >= start)\n            group",
                "known_of(picture, place)\n            group",
            ),
        ),
        LARGE,
    ),
    Mutant(
        "products of large pictures by brightness that excuses itself",
        "metrics/large_pictures.py",
        (("quiet = maximum(b.brightness - sqrt(noise), 0.0)", "quiet = b.brightness"),),
        LARGE,
    ),
    Mutant(
        "cells of large pictures that go on where the next begin",
        "metrics/large_pictures.py",
        (("            cells[(_PAIRS + i) * width + x] = 0.0\n", ""),),
        LARGE,
    ),
    Mutant(
        "pairs of channels that count once",
        "metrics/large_pictures.py",
        (("(1.0 if i == 0 or i == 2 or i == 5 else 2.0)", "1.0"),),
        LARGE,
    ),
    Mutant(
        "one row of counts for all where pixels have their own",
        "metrics/packets.py",
        (("0 if uniform else w", "0"),),
        LARGE,
    ),
    Mutant(
        "a look at one pixel is as sure as it need be at 95 %, and not beyond",
        "rendering/schedules/stopping.py",
        ((") ** 1.25", ")"),),
        "tests/known_error/test_laws_of_promises.py"
        "::test_looks_without_end_are_wrong_no_more_often_than_one_promises",
    ),
)
