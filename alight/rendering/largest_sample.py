r"""The largest value that a sample of a scene can have, where that follows from its description.

Let Le be the largest radiance that any light emits, W the largest weight f cos / pdf of a sampled
direction, and b_d the largest throughput after d scatterings: b_0 is the weight of the pixel
filter, b_d = W b_{d-1}, and from the first roulette on b_d = max(1, W b_{d-1} / 0.95), because a
path survives with the smaller of its throughput and 0.95. Light that the path hits at depth d
has an MIS weight of 1 at most. Light that is sampled at the same place brings

.. math:: b_{d-1} L_e \frac{f \cos}{p_l} w_l \le b_{d-1} L_e\, W\, h, \qquad
    h = \max \frac{p_b}{p_l} w_l = \begin{cases} \tfrac12 & \text{power heuristic} \\
    1 & \text{balance heuristic} \end{cases}

whatever the lights' density p_l is, since :math:`f \cos \le W p_b`. Without MIS it would be
unbounded next to a light, and for a light at a point it is. So for paths of at most D edges

.. math:: c_{\max} = L_e \sum_{d=1}^{D} b_{d-1} + L_e\, W\, h \sum_{d=1}^{D-1} b_{d-1} .

Paths without a cap are cut for the bound where what is left has a mean below `_REST` of Le.

Source: Veach and Guibas, Optimally combining sampling techniques, SIGGRAPH 1995, for the weights.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from alight.bsdfs.nesting import Nested
from alight.core.spec import Bsdf, Filter, Light, Texture
from alight.filters.mitchell import Mitchell
from alight.integrators.path import MAX_SURVIVAL, Path

if TYPE_CHECKING:
    from alight.scene.flatten import FlatScene

#: Mean light, over Le, beyond the depth at which the bound of an unlimited path ends.
_REST = 1e-4


def largest_sample(flat: FlatScene) -> float | None:
    """Bound every channel of every sample; None where it is not known to be bounded."""
    integrator = flat.integrator
    if not isinstance(integrator, Path) or integrator.light_sampling != "mis" or flat.lights:
        return None
    weight = _largest(_weight_of(bsdf) for bsdf in flat.bsdfs)
    lights = [shape.light for shape in flat.shapes if shape.light is not None]
    if len(flat.environments) > 1:
        # They add up.
        return None
    lights += [placed.light for placed in flat.environments]
    radiance = _largest(_radiance_of(light) for light in lights)
    start = _filter_weight(flat.film.filter)
    if weight is None or radiance is None or start is None:
        return None
    depth = integrator.max_depth
    if depth is None:
        if not 0.0 < weight < 1.0:
            return None if weight else start * radiance
        depth = math.ceil(math.log(_REST * (1.0 - weight)) / math.log(weight))
    share = 0.5 if integrator.heuristic == "power" else 1.0
    plays = integrator.russian_roulette == "throughput"
    total, throughput = 0.0, start
    for d in range(1, depth + 1):
        total += throughput * (1.0 + (weight * share if d < depth else 0.0))
        throughput *= weight
        if plays and d >= integrator.rr_depth:
            throughput = max(1.0, throughput / MAX_SURVIVAL)
        if not total * radiance < 1e30:
            return None
    return total * radiance


def _largest(values: Iterable[float | None]) -> float | None:
    """The largest of all; None if one is unknown."""
    largest = 0.0
    for value in values:
        if value is None:
            return None
        largest = max(largest, value)
    return largest


def _weight_of(bsdf: Bsdf) -> float | None:
    """Bound f cos / pdf of a material's sampled directions."""
    if isinstance(bsdf, Nested):
        # Of several models the densities are mixed with the same shares as the values.
        return _largest(_weight_of(part.bsdf) for part in bsdf.parts)
    fields = dict(bsdf)
    match bsdf.type_name():
        case "diffuse":
            albedo = _color(fields["reflectance"])
            return albedo if albedo is None or fields["sampling"] == "cosine" else 2.0 * albedo
        case "mirror":
            return _color(fields["reflectance"])
        case "conductor" | "rough_conductor":
            # Fresnel's factor and the masking of visible facets are 1 at most.
            return _color(fields["specular_reflectance"])
        case "null":
            return 1.0
    return None


def _radiance_of(light: Light) -> float | None:
    """Bound the radiance that a light emits."""
    fields = dict(light)
    match light.type_name():
        case "area" | "constant":
            return _color(fields["radiance"])
        case "environment":
            pixels = fields["pixels"]
            if pixels is None:
                return None
            return max(p * s for p, s in zip(pixels.maximum(), fields["scale"], strict=True))
    return None


def _color(value: Any) -> float | None:
    """Largest channel of a colour or texture."""
    if isinstance(value, Texture):
        maximum = getattr(value, "maximum", None)
        return None if maximum is None else max(maximum())
    return None if isinstance(value, str) else float(np.max(value))


def _filter_weight(spec: Filter) -> float | None:
    """Bound the weight of a camera ray: 1 for filters without negative lobes."""
    return None if isinstance(spec, Mitchell) else 1.0
