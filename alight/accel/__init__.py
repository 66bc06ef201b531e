"""Acceleration structures find the first surface that a ray hits, or whether it hits any.

`build` makes a bounding volume hierarchy of wide nodes, `single_ray` follows one ray
through it, `accelerator` puts it together with flat lists, planes and instances for a whole scene,
and `query` is what integrators call.
"""

from alight.accel.accelerator import build_accelerator as build_accelerator
from alight.accel.primitives import Analytic as Analytic
from alight.accel.primitives import Instance as Instance
from alight.accel.primitives import TriangleSet as TriangleSet
from alight.accel.query import intersect_closest as intersect_closest
from alight.accel.query import is_occluded as is_occluded
