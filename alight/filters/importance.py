r"""Filter importance sampling: a sample belongs to one pixel, at an offset drawn from its filter.

.. math:: \hat I = \frac1N \sum_i w_i L(x + d_i), \qquad d \sim |f| / \textstyle\int |f|,
    \qquad w = \operatorname{sign} f(d) \int |f| \Big/ \int f

The mean of w is 1, so sums are divided by the number of samples, never by the sum of weights,
which would be biased. No sample touches two pixels, so tiles are independent.

Source: Ernst, Stamminger and Greiner, Filter importance sampling, IEEE Symposium on Interactive
Ray Tracing (2006).
"""

from __future__ import annotations

import numpy as np

from alight.core.spec import Filter
from alight.filters.model import FILTERS
from lanewise.jit import kernel, specialised
from lanewise.view import View


def compile_filter(spec: Filter) -> View:
    """Table of a filter (float32), as `sample_filter` reads it from ``scene.filter``."""
    return View(np.ascontiguousarray(FILTERS[spec.type_name()].pack(spec), np.float32))


@specialised
def sample_filter(program):
    """``sample_filter(scene, u2)``: offsets dx, dy from the pixel's centre in pixels, weight."""
    sample = FILTERS[program.filter].sample

    @kernel
    def sample_filter(scene, u2):
        return sample(scene.filter, u2)

    return sample_filter
