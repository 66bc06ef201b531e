"""Small pictures of random scenes, sample by sample the same, by the NumPy reading of kernels."""

from functools import partial

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats.native import read
