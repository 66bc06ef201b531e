r"""How densely light paths start along an edge, beside how densely light sampling finds its light.

Bidirectional path tracing weighs its techniques by quotients of densities. At the light they need

.. math::
    K = P_i \cdot \begin{cases}
        1 / (\pi A) & \text{on a shape of area } A \\
        p_\omega(\omega) / d^2 & \text{at a point, the distance } d \text{ away} \\
        1 / (\pi R^2) & \text{in one direction, through the disk of the scene's ball} \\
        p_\omega(\omega)\, p_A & \text{from an environment}
    \end{cases}

which is the density of `alight.lights.emission.sampling.sample_emission`, per square metre of the
first surface and per steradian towards the light, over both cosines; and c, that of light sampling
per steradian. Weights may take any function of the path for them: on a shape, K has points uniform
by area, also where a texture has a map; for a light that cannot be hit, c is the probability that a
light path starts there, which asks no light tree for the way to a lamp.

Source: Georgiev, Implementing vertex connection and merging, 2012 (directional, positional and
direct densities of lights).
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.switch import is_one_of
from alight.core.vec import dot
from alight.lights.ball import BEHIND, behind_the_ball, disk_area, middle_of, radius_of
from alight.lights.emission.from_environments import line_pdf
from alight.lights.emission.sampling import choice_of, emission_direction_pdf, is_around
from alight.lights.hits import light_pdf
from alight.lights.misses import environment_pdf, environments_of
from alight.lights.model import LIGHTS
from alight.lights.tables import INFO
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, lanes, lanes_mask, lanes_u32, where

#: The part of a `Surface` that `light_pdf` knows a light by.
LightStart = namedtuple("LightStart", "prim ng")


def _numbers(program, kinds) -> list[int]:
    """Of the program's lights of these kinds."""
    return [
        LIGHTS[name].number for name in program.lights if name in LIGHTS and kinds(LIGHTS[name])
    ]


@specialised
def is_kind(program):
    """``is_kind(scene, index) -> (on a shape, near, around)``, masks; none of them: one direction.

    near: at a point.
    """
    on_shape = is_one_of(_numbers(program, lambda model: model.is_on_shape))
    near = is_one_of(_numbers(program, lambda m: m.spec.placement == "node" and m.cone is not None))
    count = max(len(program.environments), 1) if environments_of(program) else 0

    @kernel
    def is_kind(scene, index):
        kind = lanes_u32(0) + gather(scene.lights.info, index * INFO)
        around = is_around(scene, index, count) if count else lanes_mask(False)
        return on_shape(kind), near(kind), around

    return is_kind


@kernel
def meets_the_ball(scene, p, d):
    """Where the line through p along d meets the scene's ball, and p is not before its start."""
    _, squared = behind_the_ball(scene, p, d)
    radius = radius_of(scene)
    return (squared <= radius * radius) & (dot(p - middle_of(scene), d) >= -BEHIND * radius)


@specialised
def emission_density(program):
    """``emission_density(scene, index, p, d, distance) -> K``; see above.

    Parameters
    ----------
    scene : namedtuple
    index : uint32
        Rows of the lights.
    p : Vec3
        The end of the light's ray in the scene, metres.
    d : Vec3
        Unit direction in which it travels.
    distance : float
        From the light, metres.
    """
    if not program.lights:

        @kernel
        def nothing(scene, index, p, d, distance):
            return lanes(0.0)

        return nothing
    surrounded = bool(environments_of(program))

    @kernel
    def emission_density(scene, index, p, d, distance):
        index = lanes_u32(0) + index
        on_shape, near, around = is_kind(scene, index)
        density = choice_of(scene, index) * emission_direction_pdf(scene, index, d, d)
        squared = distance * distance
        density = where(near, density / where(near & (squared > 0.0), squared, 1.0), density)
        far = ~on_shape & ~near
        if any_lane(far):
            across = 1.0 / disk_area(scene)
            if surrounded:
                across = where(around, line_pdf(scene, p, d), across)
            density = where(far, density * where(meets_the_ball(scene, p, d), across, 0.0), density)
        # The density of the direction straight ahead is that of all, over their cosine.
        shape = density * gather(scene.lights.per_area, index)
        return where(on_shape, shape, density)

    return emission_density


@kernel
def direct_density_of_sample(scene, light, index):
    """c of a `LightSample` and the row of its light."""
    return where(light.delta, choice_of(scene, lanes_u32(0) + index), light.pdf)


@specialised
def direct_density(program):
    """``direct_density(scene, e, p, d, distance) -> c``; see above.

    Parameters
    ----------
    scene : namedtuple
    e : Emission
        Where the light starts.
    p, d, distance
        As for `emission_density`.
    """
    if not program.lights:

        @kernel
        def nothing(scene, e, p, d, distance):
            return lanes(0.0)

        return nothing
    surrounded = bool(environments_of(program))

    @kernel
    def direct_density(scene, e, p, d, distance):
        on_shape, _, around = is_kind(scene, e.light)
        density = choice_of(scene, e.light)
        if any_lane(on_shape):
            number, start = where(on_shape, e.light + 1, 0), LightStart(e.prim, e.n)
            density = where(on_shape, light_pdf(scene, number, p, -d, distance, start), density)
        if surrounded:
            density = where(around, environment_pdf(scene, p, -d), density)
        return density

    return direct_density
