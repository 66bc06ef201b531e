"""Build kernels: the boxes of primitives, their sorting into bins and to both sides of a split.

A *reference* stands for a primitive while the tree is built: 8 floats, the lower bounds x, y, z, the
primitive's index (bits), the negated upper bounds, nothing. With the upper bounds negated the union
of two boxes is one minimum of 8 lanes. Centroids are stored doubled (lower + upper): only their
order counts.
"""

from __future__ import annotations

from alight.core.constants import INFINITY
from alight.core.jit import kernel
from alight.core.simd import (
    absolute,
    as_float,
    as_int,
    as_uint,
    bits_float,
    maximum,
    minimum,
    to_uint,
    where,
)
from alight.core.wide import high_half, join, lane, load_wide, low_half, shuffled, store_wide, wide

#: Most bins an axis.
BINS = 16

#: Boxes are enlarged by this much of the primitive's size, and by as much of the coordinate: the
#: intersection test itself errs by a few units of 2^-24 of either.
MARGIN = 2.0**-20
ROUNDING = 2.0**-22


@kernel(strict=True)
def refer_to_triangles(vertices, faces, references, boxes, chunk, begin, end):
    """Write references to triangles begin to end, and the union of boxes and centroids at `chunk`."""
    box, centers = wide(8, INFINITY), wide(8, INFINITY)
    for i in range(begin, end):
        a, b, c = 3 * as_int(faces[3 * i]), 3 * as_int(faces[3 * i + 1]), 3 * as_int(faces[3 * i + 2])
        size = as_float(0)
        for k in range(3):
            low = minimum(vertices[a + k], minimum(vertices[b + k], vertices[c + k]))
            high = maximum(vertices[a + k], maximum(vertices[b + k], vertices[c + k]))
            size = maximum(size, high - low)
            references[8 * i + k] = low
            references[8 * i + 4 + k] = -high
        size = size * MARGIN
        reference = load_wide(8, references, 8 * i)
        reference = reference - (size + absolute(reference) * ROUNDING)
        store_wide(references, 8 * i, reference)
        references[8 * i + 3] = bits_float(as_uint(i))
        references[8 * i + 7] = as_float(0)
        box = minimum(box, reference)
        centers = minimum(centers, centroid(reference))
    store_wide(boxes, 16 * chunk, box)
    store_wide(boxes, 16 * chunk + 8, centers)


@kernel(strict=True)
def union_of_references(references, boxes, at, begin, end):
    """The union of boxes and of centroids of references begin to end, written at 16 `at`."""
    box, centers = wide(8, INFINITY), wide(8, INFINITY)
    for i in range(begin, end):
        reference = load_wide(8, references, 8 * i)
        box = minimum(box, reference)
        centers = minimum(centers, centroid(reference))
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
def bin_scale(centers, bins):
    """Number of bins over the extent of the centroids, by axis; 0 where they do not differ."""
    extent = -(low_half(centers) + high_half(centers))
    return where(extent > 1e-36, as_float(bins) * 0.99999 / extent, 0.0)


@kernel(strict=True)
def bin_of(reference, base, scale, last):
    """The bin of a reference on each axis."""
    c = low_half(reference) - high_half(reference)
    return to_uint(minimum(maximum((c - base) * scale, 0.0), last))


@kernel(strict=True)
def fill_bins(references, begin, end, centers, bins, table, counts):
    """Sort references into bins on all three axes.

    Parameters
    ----------
    centers : 8 floats
        Bounds of the centroids.
    bins : int
        Bins an axis.
    table : floats, 3 * BINS * 8
        Box of each bin, written.
    counts : int64, 3 * BINS
        References of each bin, written.
    """
    for b in range(3 * BINS):
        store_wide(table, 8 * b, wide(8, INFINITY))
        counts[b] = 0
    base, scale, last = low_half(centers), bin_scale(centers, bins), as_float(bins - 1)
    for i in range(begin, end):
        reference = load_wide(8, references, 8 * i)
        k = bin_of(reference, base, scale, last)
        x, y, z = as_int(lane(k, 0)), BINS + as_int(lane(k, 1)), 2 * BINS + as_int(lane(k, 2))
        store_wide(table, 8 * x, minimum(load_wide(8, table, 8 * x), reference))
        store_wide(table, 8 * y, minimum(load_wide(8, table, 8 * y), reference))
        store_wide(table, 8 * z, minimum(load_wide(8, table, 8 * z), reference))
        counts[x] += 1
        counts[y] += 1
        counts[z] += 1


@kernel(strict=True)
def partition(source, target, begin, end, left, right, centers, bins, axis, split, boxes, at):
    """Copy references to the left or right part, bounding the centroids of either.

    Left are those in bins 0 to `split` of `axis`. They go to places from `left` on, the others to
    places from `right` on. The bounds are written to boxes[at : at + 8] and [at + 8 : at + 16].
    """
    base, scale, last = low_half(centers), bin_scale(centers, bins), as_float(bins - 1)
    nothing = wide(8, INFINITY)
    left_centers, right_centers = nothing, nothing
    for i in range(begin, end):
        reference = load_wide(8, source, 8 * i)
        goes_left = as_int(lane(bin_of(reference, base, scale, last), axis)) <= split
        store_wide(target, 8 * where(goes_left, left, right), reference)
        step = where(goes_left, 1, 0)
        left += step
        right += 1 - step
        c = centroid(reference)
        left_centers = minimum(left_centers, where(goes_left, c, nothing))
        right_centers = minimum(right_centers, where(goes_left, nothing, c))
    store_wide(boxes, at, left_centers)
    store_wide(boxes, at + 8, right_centers)
