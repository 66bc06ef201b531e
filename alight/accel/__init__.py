"""Acceleration structures find the first surface that a ray hits, or whether it hits any.

`build` makes a bounding volume hierarchy of wide nodes, `traversal` follows one ray
through it, `accelerator` puts it together with flat lists, planes and instances for a whole scene,
and `packets` is what integrators call.
"""

from alight.accel.accelerator import build_accelerator as build_accelerator
from alight.accel.packets import intersect_closest as intersect_closest
from alight.accel.packets import is_occluded as is_occluded
from alight.accel.primitives import Analytic as Analytic
from alight.accel.primitives import Instance as Instance
from alight.accel.primitives import TriangleSet as TriangleSet
