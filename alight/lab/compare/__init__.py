"""Two pictures of any renderer: how far apart, and whether that is more than noise."""

from alight.lab.compare.comparison import Comparison, compare
from alight.lab.compare.figures import PictureComparison, compare_inputs
from alight.lab.compare.inputs import Input, make_comparable, read_input

__all__ = [
    "Comparison", "Input", "PictureComparison", "compare", "compare_inputs", "make_comparable",
    "read_input",
]  # fmt: skip
