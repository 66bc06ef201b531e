"""The size ratchet: a file is one concept, a function is one thought."""

import statistics

from tests.static.sources import all_files, code_lines, functions, package_files, place

LONGEST_FILE = 500
MEDIAN_FILE = 150
LONGEST_FUNCTION = 120
NINE_OF_TEN_FUNCTIONS = 40


def _lines(path):
    return path.read_text(encoding="utf-8").count("\n")


def test_no_file_is_longer_than_500_lines():
    too_long = [
        f"{place(path)}: {_lines(path)}" for path in all_files() if _lines(path) > LONGEST_FILE
    ]
    assert not too_long, f"more than {LONGEST_FILE} lines: {too_long}"


def test_half_of_the_files_have_at_most_150_lines():
    assert statistics.median(_lines(path) for path in package_files()) <= MEDIAN_FILE


def test_no_function_is_longer_than_120_lines():
    too_long = [
        f"{place(path, function.lineno)} {function.name}"
        for path in all_files()
        for function in functions(path)
        if code_lines(function) > LONGEST_FUNCTION
    ]
    assert not too_long, f"more than {LONGEST_FUNCTION} lines: {too_long}"


def test_nine_functions_of_ten_have_at_most_40_lines():
    lengths = [code_lines(f) for path in package_files() for f in functions(path)]
    short = sum(length <= NINE_OF_TEN_FUNCTIONS for length in lengths)
    assert short >= 0.9 * len(lengths)
