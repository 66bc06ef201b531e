"""Bugs of what machine code adds up of large pictures, and of pictures at the edges."""

from tests.mutants.mutant import Mutant

LARGE = "tests/metrics/test_large_pictures.py::test_machine_code_adds_up_what_numpy_does"
EDGES = "tests/metrics/test_edges_of_intervals.py"

LARGE_PICTURES = (
    Mutant(
        "brightness that is always taken too low in products of errors",
        "metrics/own_error.py",
        (("np.copysign(np.sqrt(variance), brightness - other)", "np.sqrt(variance)"),),
        f"{EDGES}::test_any_number_of_replicates_holds_the_error_and_none_is_wide_for_nothing",
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
        "products of large pictures by brightness that is taken too low",
        "metrics/large_pictures.py",
        (("where(b.brightness >= a.brightness, deviation, -deviation)", "deviation"),),
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
)
