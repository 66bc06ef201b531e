"""Build kernels: the boxes of primitives, their sorting into bins and to both sides of a split.

A *reference* stands for a primitive while the tree is built: 8 floats, the lower bounds x, y, z,
the primitive's index (bits), the negated upper bounds, nothing. With the upper bounds negated the
union of two boxes is one minimum of 8 lanes. Centroids are stored doubled (lower + upper): only
their order counts.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    as_float,
    as_int,
    as_uint,
    bits_float,
    local_floats,
    local_longs,
    maximum,
    minimum,
    to_uint,
    where,
)
from lanewise.wide import (
    four,
    high_half,
    join,
    lane,
    load_wide,
    low_half,
    shuffled,
    smaller,
    store_wide,
    wide,
)

#: Most bins an axis.
BINS = 16

#: The bins of all axes. boxes: `TABLE` floats, the box of each bin and then room for the bounds of
#: the centroids of both sides of a split; counts: `COUNTS` whole numbers, the references of each.
Bins = namedtuple("Bins", "boxes counts")
TABLE, COUNTS = 8 * (3 * BINS + 2), 3 * BINS

#: A border of bins that divides references. centers: bounds of their centroids, 8 floats; per_axis:
#: bins; axis; last: the last bin on the left.
Border = namedtuple("Border", "centers per_axis axis last")

#: Boxes are enlarged by `MARGIN` of the primitive's size and `ROUNDING` of the coordinate: the
#: intersection test itself errs by a few units of 2^-24 of either.
MARGIN = 2.0**-20
ROUNDING = 2.0**-22


@kernel(strict=True)
def corner(vertices, faces, k):
    """Vertex number ``faces[k]`` and a zero."""
    at = 3 * as_int(faces[k])
    return four(vertices[at], vertices[at + 1], vertices[at + 2], 0.0)


@kernel(strict=True)
def enlarged(box):
    """A box with the margin that it needs (`MARGIN`, `ROUNDING`)."""
    edges = -(low_half(box) + high_half(box))
    size = maximum(lane(edges, 0), maximum(lane(edges, 1), lane(edges, 2)))
    return box - (size * MARGIN + absolute(box) * ROUNDING)


@kernel(strict=True)
def refer_to_triangles(vertices, faces, references, boxes, chunk, begin, end):
    """Write references to triangles begin to end; at `chunk` the union of boxes and centroids."""
    box, centers = wide(8, INFINITY), wide(8, INFINITY)
    for i in range(begin, end):
        a = corner(vertices, faces, 3 * i)
        b = corner(vertices, faces, 3 * i + 1)
        c = corner(vertices, faces, 3 * i + 2)
        box_of_corners = smaller(smaller(join(a, -a), join(b, -b)), join(c, -c))
        reference = enlarged(box_of_corners)
        store_wide(references, 8 * i, reference)
        references[8 * i + 3] = bits_float(as_uint(i))
        box = smaller(box, reference)
        centers = smaller(centers, centroid(reference))
    store_wide(boxes, 16 * chunk, box)
    store_wide(boxes, 16 * chunk + 8, centers)


@kernel(strict=True)
def union_of_references(references, boxes, at, begin, end):
    """The union of boxes and of centroids of references begin to end, written at 16 `at`."""
    box, centers = wide(8, INFINITY), wide(8, INFINITY)
    for i in range(begin, end):
        reference = load_wide(8, references, 8 * i)
        box = smaller(box, reference)
        centers = smaller(centers, centroid(reference))
    store_wide(boxes, at, box)
    store_wide(boxes, at + 8, centers)


@kernel(strict=True)
def centroid(reference):
    """(c, -c) of a reference, c its doubled centroid."""
    c = low_half(reference) - high_half(reference)
    return join(c, -c)


@kernel(strict=True)
def half_area(box, scale):
    """Half the surface area of a box in units of 1 / scale^2."""
    edges = (low_half(box) + high_half(box)) * -scale
    faces = edges * shuffled(edges, (1, 2, 0, 3))
    return lane(faces, 0) + lane(faces, 1) + lane(faces, 2)


@kernel(strict=True)
def largest_edge(box):
    """The longest edge of a box; at least a tiny number, so that it can be divided by."""
    edges = -(low_half(box) + high_half(box))
    return maximum(maximum(lane(edges, 0), lane(edges, 1)), maximum(lane(edges, 2), 1e-36))


@kernel(strict=True)
def bin_scale(centers, per_axis):
    """Number of bins over the extent of the centroids, by axis; 0 where they do not differ."""
    extent = -(low_half(centers) + high_half(centers))
    return where(extent > 1e-36, as_float(per_axis) * 0.99999 / extent, 0.0)


@kernel(strict=True)
def bin_of(reference, base, scale, last):
    """The bin of a reference on each axis."""
    c = low_half(reference) - high_half(reference)
    return to_uint(minimum(maximum((c - base) * scale, 0.0), last))


@kernel(strict=True)
def put_into_bin(bins, b, reference):
    """Count a reference in bin b and enlarge the bin's box."""
    store_wide(bins.boxes, 8 * b, smaller(load_wide(8, bins.boxes, 8 * b), reference))
    bins.counts[b] += 1


@kernel(strict=True)
def new_bins():
    """Room for bins; `fill_bins` fills it (see `lanewise.simd.local_floats`)."""
    return Bins(local_floats(TABLE), local_longs(COUNTS))


@kernel(strict=True)
def fill_bins(references, begin, end, centers, per_axis, bins):
    """Sort references into bins on all three axes.

    Parameters
    ----------
    centers : 8 floats
        Bounds of the centroids.
    per_axis : int
        Bins an axis.
    bins : Bins
        Written.
    """
    for axis in range(3):
        for b in range(axis * BINS, axis * BINS + per_axis):
            store_wide(bins.boxes, 8 * b, wide(8, INFINITY))
            bins.counts[b] = 0
    base, scale, last = low_half(centers), bin_scale(centers, per_axis), as_float(per_axis - 1)
    # Two at a time: the next reference is on its way while a bin waits for the one before.
    for i in range(begin, end - 1, 2):
        first, second = load_wide(8, references, 8 * i), load_wide(8, references, 8 * i + 8)
        k, m = bin_of(first, base, scale, last), bin_of(second, base, scale, last)
        for axis in range(3):
            put_into_bin(bins, axis * BINS + as_int(lane(k, axis)), first)
            put_into_bin(bins, axis * BINS + as_int(lane(m, axis)), second)
    if (end - begin) & 1 != 0:
        single = load_wide(8, references, 8 * end - 8)
        k = bin_of(single, base, scale, last)
        for axis in range(3):
            put_into_bin(bins, axis * BINS + as_int(lane(k, axis)), single)


@kernel(strict=True)
def partition(source, target, begin, end, left, right, border):
    """Copy references begin to end from `source` to the left or right part in `target`.

    Those on the left of the `Border` go to places from `left` on, the others to places from `right`
    on. Returns the bounds of the centroids of either part.
    """
    base, scale = low_half(border.centers), bin_scale(border.centers, border.per_axis)
    last = as_float(border.per_axis - 1)
    nothing = wide(8, INFINITY)
    left_centers, right_centers = nothing, nothing
    for i in range(begin, end):
        reference = load_wide(8, source, 8 * i)
        goes_left = as_int(lane(bin_of(reference, base, scale, last), border.axis)) <= border.last
        store_wide(target, 8 * where(goes_left, left, right), reference)
        step = where(goes_left, 1, 0)
        left += step
        right += 1 - step
        c = centroid(reference)
        left_centers = smaller(left_centers, where(goes_left, c, nothing))
        right_centers = smaller(right_centers, where(goes_left, nothing, c))
    return left_centers, right_centers
