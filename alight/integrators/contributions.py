"""Where the light of a path comes from: a log of every contribution to the picture.

A pass of its own over the same samples as the picture's, as for AOVs (`alight.integrators.aov`):
the path tracer's own text, which also calls the kernels below wherever it adds to the radiance of a
path. Programs without this pass have not an instruction of it.

A contribution is one product of throughput, radiance and weight. It is known by the length of its
path in edges (`depth`), by how its light was found, by the light, and by the material that the
camera's ray met first.
"""

from __future__ import annotations

import inspect
from collections import namedtuple

from alight.integrators.model import INTEGRATORS
from alight.integrators.walk import LIGHT_CHOICE, LIGHT_POINT, vertex_dimension
from alight.lights.choice import choose_light
from alight.lights.tables import INFO as LIGHT_INFO
from alight.samplers.sampling import get_1d, get_2d
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    LANES,
    as_int,
    gather,
    lanes_u32,
    local_floats,
    local_uints,
    mask_bits,
    minimum_u32,
    store_lanes,
    trailing_zeros,
    where,
)

#: Name of this pass instead of an integrator's, and of the option that names the integrator.
PASS, RECORDED = "contributions", "recorded"

#: words: four u32 a contribution (see `FIELDS`); values: red, green, blue; count: [contributions so
#: far, including those that did not fit]; first: a u32 a sample, number of the first material;
#: window: u32, first column and row of the tile, its columns, samples a pixel, replicates.
Log = namedtuple("Log", "words values count first window")

#: How one lane's light was found, u32 each: light + 1, length of the path, way (below), number of
#: the first material + 1.
Found = namedtuple("Found", "light depth how first")

#: What the words hold: y and x; replicate and depth (16 bits each); light + 1; how the light was
#: found and number of the first material + 1.
FIELDS = 4
HALF = 16

#: How light is found: at the end of the camera's ray, by a direction that the BSDF chose, by one
#: that a delta lobe chose (lights cannot be sampled for it), by sampling the lights.
SEEN, BY_BSDF, BY_DELTA, BY_LIGHT = range(4)


def can_record(integrator: str) -> bool:
    """Whether an integrator reports its contributions: the path tracer and what is made of it."""
    step = INTEGRATORS[integrator].step
    return step is not None and "record" in inspect.signature(step).parameters


def step(program):
    """The step of the integrator that the option `RECORDED` names, with a log of what it adds."""
    own = INTEGRATORS[program.option(RECORDED)].step
    assert own is not None
    return own(program, record=(meet, find, leave, sample))


@kernel
def sample_number(log, sampler, mask):
    """The number of each lane's sample among those of the tile, in lanes of the mask; else 0."""
    x0, y0, columns, samples, replicates = (
        log.window[0], log.window[1], log.window[2], log.window[3], log.window[4],
    )  # fmt: skip
    pixel = (sampler.y - y0) * columns + (sampler.x - x0)
    number = pixel * samples + sampler.index * replicates + sampler.scramble
    return where(mask, number, 0)


@kernel
def meet(scene, path, surface, depth, mask):
    """Record the material that the camera rays hit; 0 means none.

    A path changes its lane while it waits, so the record is indexed by its sample.
    """
    log, numbers, materials = scene.log, local_uints(16), local_uints(16)
    new = mask & (depth == 1)
    store_lanes(numbers, 0, sample_number(log, path.sampler, new))
    store_lanes(materials, 0, surface.bsdf + 1)
    bits = mask_bits(new)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        log.first[as_int(numbers[lane])] = materials[lane]


@kernel
def find(scene, path, light, depth, mask, value):
    """Log light that the rays hit; `light` is its number + 1."""
    how = where(path.delta, lanes_u32(BY_DELTA), lanes_u32(BY_BSDF))
    how = where(depth == 1, lanes_u32(SEEN), how)
    number = sample_number(scene.log, path.sampler, mask)
    first = where(depth == 1, lanes_u32(0), gather(scene.log.first, number))
    write(scene.log, path, Found(light, depth, how, first), mask, value)


@kernel
def leave(scene, path, depth, mask, value):
    """Log light of the environments, all as of the last light, where rays left the scene."""
    last = lanes_u32(scene.lights.info.size // LIGHT_INFO)
    find(scene, path, last, depth, mask, value)


@specialised
def as_found(program):
    """``as_found(scene, index)``: the light that a ray would take the light `index` for."""
    count = len(program.environments)

    @kernel
    def last_of_the_environments(scene, index):
        last = scene.lights.info.size // LIGHT_INFO - 1
        return where(lanes_u32(0) + index + count > last, lanes_u32(last), index)

    @kernel
    def itself(scene, index):
        return index

    return last_of_the_environments if count else itself


@kernel
def sample(scene, path, p, n, passed, mask, value):
    """Log light that light sampling found from the vertex that the path has just reached.

    p, n: place of the vertex, and its normal as `sample_light` was given it; passed (u32): surfaces
    that the shadow ray went through.
    """
    depth = path.depth + 1
    dimension = vertex_dimension(depth)
    u, u2 = (
        get_1d(path.sampler, dimension + LIGHT_CHOICE),
        get_2d(path.sampler, dimension + LIGHT_POINT),
    )
    index = as_found(scene, choose_light(scene, p, n, u, u2, mask).index)
    light = lanes_u32(0) + index + 1
    first = gather(scene.log.first, sample_number(scene.log, path.sampler, mask))
    found = Found(light, depth + passed + 1, lanes_u32(BY_LIGHT), first)
    write(scene.log, path, found, mask, value)


@kernel
def write(log, path, found, mask, value):
    """Append what is not black, lane by lane."""
    words, values = local_uints(64), local_floats(48)
    store_lanes(words, 0, (path.sampler.y << HALF) | path.sampler.x)
    short = minimum_u32(found.depth, lanes_u32((1 << HALF) - 1))
    store_lanes(words, LANES, (path.sampler.scramble << HALF) | short)
    store_lanes(words, 2 * LANES, found.light)
    store_lanes(words, 3 * LANES, (found.how << HALF) | found.first)
    store_lanes(values, 0, value.x)
    store_lanes(values, LANES, value.y)
    store_lanes(values, 2 * LANES, value.z)
    # Not "> 0": filters with negative lobes weigh paths negatively.
    bright = (value.x != 0.0) | (value.y != 0.0) | (value.z != 0.0)
    bits = mask_bits(mask & bright)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = log.count[0]
        log.count[0] = at + 1
        if 3 * at < log.values.size:
            for i in range(FIELDS):
                log.words[FIELDS * at + i] = words[i * LANES + lane]
            for i in range(3):
                log.values[3 * at + i] = values[i * LANES + lane]
