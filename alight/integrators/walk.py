"""What all integrators share: the state of a path, and the random numbers of its vertices.

An integrator is one kernel, ``step(scene, settings, path) -> path``: it extends every lane's path
by one vertex and clears `active` where the path has ended. The main loop starts paths, calls
`step`, and adds finished ones to the film.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.bsdfs.interiors.bodies import absorbs
from alight.core.spec import Integrator
from alight.core.vec import Vec3, dot, luminance, normalize
from alight.core.wavelengths import DISPERSIVE
from alight.guiding.gain import add_unguided, begin_unguided
from alight.guiding.tables import GUIDED, Guide, no_log
from alight.integrators.caustics.chain_types import follows_chains, no_chain
from alight.integrators.interiors.enclosing import no_bodies
from alight.integrators.model import model_of
from alight.integrators.moments import at_times_of
from alight.samplers.state import SamplerState
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    as_int,
    count_bits,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    mask_bits,
    where,
)

#: One path per lane.
#:
#: o, d : Vec3, the ray to follow next;
#: p : Vec3, the surface point that it starts from (o is p moved off the surface);
#: L : Vec3, radiance gathered so far;  L_direct : Vec3, the part from depth <= 2;
#: beta : Vec3, throughput;  pdf : density of d per steradian;
#: delta : mask, d was chosen by a delta lobe, or is a camera ray;
#: depth : u32, edges traced so far;  sampler : SamplerState;  active : mask;
#: rays : uniform whole number, rays traced by all lanes so far;
#: unguided : `alight.guiding.gain.Unguided` where there is a guide, else empty;
#: bodies : `alight.integrators.interiors.enclosing.Bodies` where bodies absorb light, else empty;
#: monochromatic : mask, `beta` is that of one wavelength, where materials disperse light, else ();
#: chain : `alight.integrators.caustics.chain_types.Chain` where caustics are looked for, else
#: empty.
#:
#: Paths from lights keep other things in two of them: pdf, the brightness that they began with;
#: delta, see `alight.integrators.both_ends.light_subpath`.
PathState = namedtuple(
    "PathState",
    "o d p L L_direct beta pdf delta depth sampler active rays unguided bodies monochromatic chain",
)

#: Uniform numbers of a render: max_depth, rr_depth, seed and replicates (whole), distance (float32,
#: metres).
Settings = namedtuple("Settings", "max_depth rr_depth seed replicates distance")

#: The same of a render with a guide: its tables, and the log of training paths
#: (`alight.guiding.tables`).
GuidedSettings = namedtuple("GuidedSettings", (*Settings._fields, "guide", "log"))

#: Depth of paths that only roulette ends.
UNLIMITED = 2**31 - 1

#: Dimensions 0 to 7 are the camera's: 0-1 the pixel filter, 2-3 the lens, 4 the time (`moments`),
#: 6 the wavelength (`dispersed`).
FILTER, LENS = 0, 2
CAMERA_DIMENSIONS = 8

#: Sixteen dimensions a vertex; these are their places.
VERTEX_DIMENSIONS = 16
LIGHT_CHOICE, LIGHT_POINT, BSDF_CHOICE, BSDF_DIRECTION, ROULETTE = 0, 1, 3, 4, 6


class SentIntegrator(Integrator):
    """What `make_settings` reads of an integrator, for processes that do not know its class."""

    max_depth: int | None = None
    rr_depth: int = UNLIMITED
    distance: float | None = None


def sent_integrator(integrator: Integrator) -> SentIntegrator:
    """The same settings in a class of ours: a user's is known where its script has run."""
    known = SentIntegrator.model_fields
    return SentIntegrator(**{name: value for name, value in integrator if name in known})


def make_settings(
    integrator: Integrator, *, seed: int, replicates: int, guide: Guide | None = None
) -> Settings | GuidedSettings:
    """What a render is done with, the numbers of the integrator from its description."""
    fields = dict(integrator)
    depth = fields.get("max_depth")
    settings = Settings(
        max_depth=UNLIMITED if depth is None else depth,
        rr_depth=fields.get("rr_depth", UNLIMITED),
        seed=seed,
        replicates=replicates,
        distance=np.float32(fields.get("distance") or np.inf),
    )
    return settings if guide is None else GuidedSettings(*settings, guide, no_log())


@kernel
def no_paths():
    """Paths, none of them active."""
    zero = lanes_u32(0)
    black = lanes_vec3(0.0)
    return PathState(
        o=black, d=lanes_vec3(1.0), p=black, L=black, L_direct=black, beta=black, pdf=lanes(0.0),
        delta=lanes_mask(False), depth=zero,
        sampler=SamplerState(x=zero, y=zero, index=zero, scramble=zero, seed=zero, a=zero, b=zero),
        active=lanes_mask(False), rays=as_int(0), unguided=(), bodies=(), monochromatic=(),
        chain=(),
    )  # fmt: skip


@kernel
def begin_paths(new, o, d, weight, sampler, path):
    """Start paths in the lanes of `new`.

    Parameters
    ----------
    new : mask
    o, d : Vec3
        Camera rays there; in the other lanes as in `path`.
    weight : float
        Of the pixel filter.
    sampler : SamplerState
    path : Path
        What continues in the other lanes.
    """
    black = lanes_vec3(0.0)
    begun = replace(
        path, p=o, L=black, L_direct=black, beta=lanes_vec3(1.0) * weight, pdf=lanes(0.0),
        delta=new, depth=lanes_u32(0), active=new,
    )  # fmt: skip
    return replace(where(new, begun, path), o=o, d=d, sampler=sampler, rays=path.rays)


@specialised
def empty_paths(program):
    """``empty_paths()``: inactive paths, with all that the integrator keeps."""
    own = model_of(program).empty_paths or no_paths
    if absorbs(program):
        own = _empty_paths_in_bodies(own)
    if DISPERSIVE in program.bsdfs:
        own = _with_empty_mask(own)
    if follows_chains(program):
        own = _empty_with_chains(own)
    if not program.option(GUIDED, False):
        return own

    @kernel
    def empty_guided_paths():
        return replace(own(), unguided=begin_unguided())

    return empty_guided_paths


def _empty_with_chains(own):
    @kernel
    def empty_paths_with_chains():
        return replace(own(), chain=no_chain())

    return empty_paths_with_chains


@specialised
def start_paths(program):
    """``start_paths(new, o, d, weight, sampler, path)``: as `begin_paths`, for the integrator.

    An integrator that keeps more than a `PathState` has kernels of the names `empty_paths` and
    `start_paths`.
    """
    own = model_of(program).start_paths or begin_paths
    if absorbs(program):
        own = _start_paths_outside(own)
    if DISPERSIVE in program.bsdfs:
        own = _with_mask(own)
    if follows_chains(program):
        own = _start_with_chains(own)
    if not program.option(GUIDED, False):
        return own

    @kernel
    def start_guided_paths(new, o, d, weight, sampler, path):
        path = own(new, o, d, weight, sampler, path)
        return replace(path, unguided=where(new, begin_unguided(), path.unguided))

    return start_guided_paths


def _empty_paths_in_bodies(own):
    """``empty_paths()`` where bodies absorb light."""

    @kernel
    def empty_paths_in_bodies():
        return replace(own(), bodies=no_bodies())

    return empty_paths_in_bodies


def _start_paths_outside(own):
    """``start_paths(new, o, d, weight, sampler, path)`` of the same; see `begin_inside`."""

    @kernel
    def start_paths_outside(new, o, d, weight, sampler, path):
        path = own(new, o, d, weight, sampler, path)
        return replace(path, bodies=where(new, no_bodies(), path.bodies))

    return start_paths_outside


def _with_empty_mask(own):
    """``empty_paths()`` of a program in which materials disperse light."""

    @kernel
    def empty_paths_of_all_wavelengths():
        return replace(own(), monochromatic=lanes_mask(False))

    return empty_paths_of_all_wavelengths


def _with_mask(own):
    """``start_paths(new, o, d, weight, sampler, path)`` of the same."""

    @kernel
    def start_paths_of_all_wavelengths(new, o, d, weight, sampler, path):
        path = own(new, o, d, weight, sampler, path)
        return replace(path, monochromatic=path.monochromatic & ~new)

    return start_paths_of_all_wavelengths


def _start_with_chains(own):
    @kernel
    def start_paths_with_chains(new, o, d, weight, sampler, path):
        path = own(new, o, d, weight, sampler, path)
        return replace(path, chain=where(new, no_chain(), path.chain))

    return start_paths_with_chains


@kernel(strict=True)
def gather_light(path, found, mask, direct):
    """Add what paths have found in the lanes of the mask; `direct`: their paths have two edges.

    Strict, so that the sum is not fused with the last product of `found`: the compiler would decide
    that by how often it is used, and a picture would have other bits with the layer "direct".
    """
    return replace(
        path,
        L=where(mask, path.L + found, path.L),
        L_direct=where(mask & direct, path.L_direct + found, path.L_direct),
    )


@kernel
def gather_unguided(path, found, mask):
    """As `gather_light`, with the weights of a path without its guide."""
    return replace(path, unguided=add_unguided(path.unguided, luminance(found), mask))


@kernel
def count_lanes(mask):
    """In how many lanes the mask holds."""
    return count_bits(mask_bits(mask))


@kernel
def vertex_dimension(depth):
    """First dimension of the vertex at the end of edge number `depth` (1 = the first hit)."""
    return CAMERA_DIMENSIONS + (depth - 1) * VERTEX_DIMENSIONS


@kernel
def to_local(surface, w):
    """World -> shading frame, in which z is the shading normal."""
    return Vec3(dot(w, surface.s), dot(w, surface.t), dot(w, surface.ns))


@kernel
def to_world(surface, w):
    """Shading frame -> world; of unit length again after the rounding."""
    return normalize(w.x * surface.s + w.y * surface.t + w.z * surface.ns)


@specialised
def step(program):
    """The step of the program's integrator, or of a pass that replaces it.

    Where things move, it sees the scene at the times of its paths.
    """
    own = model_of(program).step
    assert own is not None
    return _in_time(program, own(program))


@specialised
def trace(program):
    """The first half of a step, ``trace(scene, settings, path) -> (path, hit)``; `is_staged`."""
    return _in_time(program, _stages(program)[0])


def _in_time(program, own):
    """A step, or the first half of one, that sees the scene at the times of its paths."""
    if not program.motion:
        return own

    @kernel
    def step_in_time(scene, settings, path):
        return own(at_times_of(scene, path.sampler), settings, path)

    return step_in_time


@specialised
def shade(program):
    """The second half, ``shade(scene, settings, path, hit) -> (path, walk)``."""
    own = _stages(program)[1]
    if not program.motion:
        return own

    @kernel
    def shade_in_time(scene, settings, path, hit):
        return own(at_times_of(scene, path.sampler), settings, path, hit)

    return shade_in_time


def _stages(program):
    stages = model_of(program).stages
    assert stages is not None
    return stages(program)


def is_staged(program):
    """Whether the step of a program's integrator has two halves, between which paths may wait."""
    return model_of(program).stages is not None
