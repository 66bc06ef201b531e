"""Tests of hypotheses for samples: those that users get too."""

from alight.laws.statistics import (
    LARGEST_Z,
    SIGNIFICANCE,
    SphereCells,
    chi_square,
    length_error,
    unit_vectors,
    z_of_mean,
)

__all__ = [
    "LARGEST_Z",
    "SIGNIFICANCE",
    "SphereCells",
    "chi_square",
    "length_error",
    "unit_vectors",
    "z_of_mean",
]
