"""The size ratchet: a file is one concept, a function is one thought."""

import ast
import statistics

from tests.static.sources import ROOT, all_files, code_lines, functions, package_files, place

LONGEST_FILE = 400
MEDIAN_FILE = 130
LONGEST_FUNCTION = 120
LONGEST_FUNCTION_WITHOUT_DOCSTRING = 80
NINE_OF_TEN_FUNCTIONS = 40


def _lines(path):
    return path.read_text(encoding="utf-8").count("\n")


def test_no_file_is_longer_than_400_lines():
    lengths = {path.relative_to(ROOT).as_posix(): _lines(path) for path in all_files()}
    too_long = {name: length for name, length in lengths.items() if length > LONGEST_FILE}
    assert not too_long, f"more than {LONGEST_FILE} lines: {too_long}"


def test_half_of_the_files_have_at_most_130_lines():
    assert statistics.median(_lines(path) for path in package_files()) <= MEDIAN_FILE


def test_no_function_is_longer_than_120_lines_or_80_without_a_docstring():
    too_long = [
        f"{place(path, function.lineno)} {function.name}"
        for path in all_files()
        for function in functions(path)
        if code_lines(function) > _longest(function)
    ]
    assert not too_long, f"too long: {too_long}"


def _longest(function):
    """How many lines of code a function may have."""
    told = ast.get_docstring(function) is not None
    return LONGEST_FUNCTION if told else LONGEST_FUNCTION_WITHOUT_DOCSTRING


def test_nine_functions_of_ten_have_at_most_40_lines():
    lengths = [code_lines(f) for path in package_files() for f in functions(path)]
    short = sum(length <= NINE_OF_TEN_FUNCTIONS for length in lengths)
    assert short >= 0.9 * len(lengths)
