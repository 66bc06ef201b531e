"""Two pictures of any renderer: how far apart, and whether that is more than noise."""

from alight.lab.compare.figures import PictureComparison, compare_inputs
from alight.lab.compare.inputs import Input, make_comparable, read_input

__all__ = ["Input", "PictureComparison", "compare_inputs", "make_comparable", "read_input"]
