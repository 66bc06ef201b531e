"""Light at the end of a ray: what paths gain where their directions happen to lead to it.

In multiple importance sampling this is the technique of the BSDF; the factories take its weight,
``bsdf_weight(path, light_pdf)``, the kernels of `alight.integrators.contributions` that listen, and
``unguided(path)``, the path as its BSDF's density would have it, if there is a guide.
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.switch import has_null
from alight.core.vec import length
from alight.integrators.caustics.chain_types import turns
from alight.integrators.walk import gather_light, gather_unguided
from alight.lights.hits import emitted, light_pdf
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.targets import leads_to_disk
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, where

#: The kernels of `alight.integrators.contributions`, or nothing in the place of each.
Listeners = namedtuple("Listeners", "meet find leave sample")
NO_LISTENERS = Listeners(None, None, None, None)


@kernel
def drawn_by_bsdf(path):
    """A path whose last direction has the density of the BSDF."""
    return replace(path, pdf=path.unguided.pdf)


def write_reach_environment(bsdf_weight, listeners, unguided=None):
    """``(scene, path, missed) -> path``: light of the environment, where rays left the scene."""
    recorded, leave = listeners.leave is not None, listeners.leave
    guided, reach_unguided = unguided is not None, _write_reach_unguided(bsdf_weight, unguided)

    @kernel
    def reach_environment(scene, path, missed):
        depth = path.depth + 1
        if any_lane(missed):
            # Idle lanes all read the same texel, which costs no memory traffic.
            d = where(missed, path.d, 0.0)
            Le = environment_radiance(scene, d)
            pdf = environment_pdf(scene, path.p, d)
            w = bsdf_weight(path, pdf)
            found = path.beta * Le * w
            path = gather_light(path, found, missed, depth <= 2)
            if guided:
                path = reach_unguided(path, Le, pdf, missed)
            if recorded:
                leave(scene, path, depth, missed, found)
        return path

    return reach_environment


@kernel
def is_led_to_disk(scene, path):
    """Mask: paths whose chains end in the disk that is a target, if they leave the scene."""
    chain = path.chain
    return chain.known & turns(chain.type) & leads_to_disk(scene, path.d)


def write_reach_lamp(bsdf_weight, holes, listeners, unguided=None):
    """``(scene, path, hit, surface, active) -> path``: light of surfaces that rays hit."""
    recorded, find = listeners.find is not None, listeners.find
    guided, reach_unguided = unguided is not None, _write_reach_unguided(bsdf_weight, unguided)

    @kernel
    def reach_lamp(scene, path, hit, surface, active):
        depth = path.depth + 1
        shining = active & (surface.light != 0)
        if any_lane(shining):
            distance = hit.t
            if holes:
                # From the last vertex, not from the hole in between.
                distance = length(surface.p - path.p)
            Le = emitted(scene, surface, -path.d)
            pdf = light_pdf(scene, surface.light, path.p, path.d, distance, surface)
            w = bsdf_weight(path, pdf)
            found = path.beta * Le * w
            path = gather_light(path, found, shining, depth <= 2)
            if guided:
                path = reach_unguided(path, Le, pdf, shining)
            if recorded:
                find(scene, path, surface.light, depth, shining, found)
        return path

    return reach_lamp


def _write_reach_unguided(bsdf_weight, unguided):
    """``(path, Le, light_pdf, mask) -> path``: the same light to `unguided`, by its own weight."""

    @kernel
    def reach_unguided(path, Le, light_pdf, mask):
        w = bsdf_weight(unguided(path), light_pdf)
        return gather_unguided(path, path.beta * Le * w, mask)

    return reach_unguided


def write_is_from_camera(program):
    """``path -> mask``: whether nothing but holes lies between the camera and the ray."""
    holes = has_null(program)

    @kernel
    def is_from_camera(path):
        first = path.depth == 0
        if holes:
            # Paths begin like this, and a hole leaves both; a delta lobe has a probability.
            first = path.delta & (path.pdf == 0.0)
        return first

    return is_from_camera
