"""Acceleration structures find the first surface that a ray hits, or whether it hits any.

`query` is what integrators ask, `build` makes the bounding volume hierarchy
and `accelerator` puts it together with flat lists and instances for a whole scene.
"""

from alight.accel.accelerator import build_accelerator as build_accelerator
from alight.accel.primitives import Analytic as Analytic
from alight.accel.primitives import Instance as Instance
from alight.accel.primitives import TriangleSet as TriangleSet
from alight.accel.query import intersect_closest as intersect_closest
from alight.accel.query import is_occluded as is_occluded
