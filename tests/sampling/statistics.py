"""Tests of hypotheses for samples: those that users get too."""

from alight.laws.statistics import (
    LARGEST_Z,
    SIDES,
    SIGNIFICANCE,
    chi_square,
    length_error,
    sphere_cells,
    unit_vectors,
    z_of_mean,
)

__all__ = [
    "LARGEST_Z",
    "SIDES",
    "SIGNIFICANCE",
    "chi_square",
    "length_error",
    "sphere_cells",
    "unit_vectors",
    "z_of_mean",
]
