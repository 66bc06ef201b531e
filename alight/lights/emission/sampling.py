r"""Rays of light that leave the lights, where light paths begin.

.. math::
    \Phi = \frac{L_e(x, \omega)\, |\cos\theta|}{P_i\, p_A(x)\, p_\omega(\omega)}

A light is chosen by its power, even where light sampling chooses by a light tree: a light path
starts for nobody in particular. The mean of the flux is the power of all lights together.

Source: Veach 1997, Robust Monte Carlo methods for light transport simulation, section 8.3; PBR4
section 16.1.
"""

from __future__ import annotations

from alight.core.distributions import pmf_discrete, sample_discrete
from alight.core.motion import direction_at_rest, inverse_rows, matrix_at, placed, turned
from alight.core.switch import is_one_of
from alight.core.vec import dot, gather_vec3, normalize
from alight.lights.ball import middle_of
from alight.lights.choice import of_one_kind
from alight.lights.emission.from_environments import (
    arriving_pdf,
    emit_from_environment,
    environments_probability,
)
from alight.lights.emission.from_shapes import emit_from_shape, place_on_shape, shape_direction_pdf
from alight.lights.hits import on_shapes, radiance_of_shape
from alight.lights.misses import environments_of
from alight.lights.model import LIGHTS, LightModel
from alight.lights.tables import CHOICE, INFO, STRIDE, Emission
from alight.shapes.hit import spawn_origin
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    gather,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    where,
)


def _at_points(program) -> tuple[LightModel, ...]:
    """The lights of the program at a point, or infinitely far away in one direction."""
    models = (LIGHTS[name] for name in LIGHTS if name in program.lights)
    return tuple(model for model in models if model.spec.placement == "node")


def _around(program) -> bool:
    """Whether light comes from environments."""
    return bool(environments_of(program))


@kernel
def is_around(scene, index, count):
    """Where a light is one of the `count` environments, which are the last."""
    return lanes_u32(0) + index >= scene.lights.info.size // INFO - count


# ---------------------------------------------------------------- sampling


@kernel
def no_emission(scene, index, u, u2, v2):
    """An `Emission` of zeros in every lane."""
    zero, vector = lanes(0.0), lanes_vec3(0.0)
    return Emission(
        p=vector,
        n=vector,
        o=vector,
        d=vector,
        flux=vector,
        light=lanes_u32(0),
        prim=lanes_u32(0),
        choice=zero,
        pdf_position=zero,
        pdf_direction=zero,
        delta_position=lanes_mask(False),
        delta_direction=lanes_mask(False),
    )


@specialised
def in_motion(program):
    """``in_motion(scene, index, emission)``: lights at points where they are at the time."""
    if "lights" not in program.motion:

        @kernel
        def at_rest(scene, index, e):
            return e

        return at_rest

    @kernel
    def moved(scene, index, e):
        number = lanes_u32(0) + gather(scene.motions.of_light, index)
        moving = number != 0
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            # What comes from infinity only turns, and must still meet the ball.
            middle = middle_of(scene)
            turning = middle + turned(m, e.p - middle)
            p = where(moving, where(e.delta_direction, turning, placed(m, e.p)), e.p)
            d = where(moving, normalize(turned(m, e.d)), e.d)
            e = replace(e, p=p, o=p, n=d, d=d)
        return e

    return moved


def _from_point(model: LightModel):
    """A light's `emit` with its colour, at the times of the paths."""
    own = model.emit
    assert own is not None

    @kernel
    def colored(scene, index, u, u2, v2):
        e = in_motion(scene, index, own(scene, index, u2, v2))
        return replace(e, flux=e.flux * gather_vec3(scene.lights.data, index * STRIDE))

    return colored


def _if_mine(own, number: int, others):
    """A kernel that runs `own` for the lights of the kind `number`."""

    @kernel
    def choose(scene, index, u, u2, v2):
        result = others(scene, index, u, u2, v2)
        mine = gather(scene.lights.info, index * INFO) == number
        if any_lane(mine):
            result = where(mine, own(scene, of_one_kind(mine, index), u, u2, v2), result)
        return result

    return choose


@specialised
def emit_chosen(program):
    """``emit_chosen(scene, index, u, u2, v2) -> Emission`` of the lights `index`."""
    result = no_emission
    for model in on_shapes(program):
        result = _if_mine(emit_from_shape, model.number, result)
    for model in _at_points(program):
        result = _if_mine(_from_point(model), model.number, result)
    if not _around(program):
        return result
    others, count = result, max(len(program.environments), 1)

    @kernel
    def choose(scene, index, u, u2, v2):
        e = others(scene, index, u, u2, v2)
        around = is_around(scene, index, count)
        if any_lane(around):
            last = scene.lights.info.size // INFO - 1
            inside = where(around, index, last)
            e = where(around, emit_from_environment(scene, inside, u, u2, v2), e)
        return e

    return choose


@specialised
def choice_of(program):
    """``choice_of(scene, index)``: `Emission.choice` of the lights `index`."""
    if not _around(program):

        @kernel
        def of_its_power(scene, index):
            return pmf_discrete(scene.lights.emission, CHOICE, index)

        return of_its_power
    count = max(len(program.environments), 1)

    @kernel
    def of_all_around(scene, index):
        own = pmf_discrete(scene.lights.emission, CHOICE, index)
        nowhere = lanes_vec3(0.0)
        together = environments_probability(scene, nowhere, nowhere)
        return where(is_around(scene, index, count), together, own)

    return of_all_around


@specialised
def sample_emission(program):
    """A ray of light: ``sample_emission(scene, u, u2, v2) -> Emission``.

    Only scenes compiled with `emits` have the tables (`alight.compiled.scene.compile_scene`).

    Parameters
    ----------
    scene : namedtuple
        With the fields `shapes` and `lights`; at the times of the paths where things move.
    u : float
        Uniform in [0, 1), chooses the light and what there is to choose on it.
    u2, v2 : pairs of floats
        Uniform in [0, 1), choose position and direction.

    Returns
    -------
    Emission
        Flux 0 where there is no light.
    """
    if not program.lights:

        @kernel
        def without_lights(scene, u, u2, v2):
            return no_emission(scene, lanes_u32(0), u, u2, v2)

        return without_lights

    @kernel
    def with_lights(scene, u, u2, v2):
        count = scene.lights.info.size // INFO
        index, _, rest = sample_discrete(scene.lights.emission, CHOICE, count, u)
        e = emit_chosen(scene, index, rest, u2, v2)
        choice = choice_of(scene, index)
        return replace(e, flux=e.flux * (1.0 / choice), light=index, choice=choice)

    return with_lights


# ---------------------------------------------------------------- lights that are seen


@specialised
def emission_towards(program):
    """What a point of a shape that shines sends elsewhere: ``(scene, index, u, u2, q)``.

    Parameters
    ----------
    scene : namedtuple
    index : uint32
        The lights that `sample_emission` has chosen.
    u, u2 : float and pair of floats
        Uniform in [0, 1): as there, u being the number that chose the light.
    q : Vec3
        What the point is seen from.

    Returns
    -------
    intensity : Vec3
        W/sr, over all probabilities: radiance times cosine; 0 for lights without a surface.
    o : Vec3
        Where a ray to q starts.
    """
    models = on_shapes(program)
    if not models:

        @kernel
        def nothing(scene, index, u, u2, q):
            return lanes_vec3(0.0), q

        return nothing
    is_on_shape = is_one_of(model.number for model in models)

    @kernel
    def from_the_surface(scene, index, u, u2, q):
        mine = is_on_shape(lanes_u32(0) + gather(scene.lights.info, index * INFO))
        count = scene.lights.info.size // INFO
        _, choice, rest = sample_discrete(scene.lights.emission, CHOICE, count, u)
        inside = of_one_kind(mine, index)
        surface, pdf = place_on_shape(scene, inside, rest, u2)
        w = normalize(q - surface.p)
        cosine = maximum(dot(surface.ng, w), 0.0)
        drawn = mine & (pdf > 0.0) & (cosine > 0.0)
        share = where(drawn, cosine / where(drawn, pdf * choice, 1.0), 0.0)
        o = spawn_origin(surface.p, surface.error, surface.ng, w)
        radiance = radiance_of_shape(scene, inside, surface, w)
        return where(drawn, radiance * share, lanes_vec3(0.0)), o

    return from_the_surface


# ---------------------------------------------------------------- density


def _pdf_of(model: LightModel):
    """A light's `emit_pdf` at the times of the paths."""
    own = model.emit_pdf
    assert own is not None

    @kernel
    def of_it(scene, index, n, d):
        return own(scene, index, d)

    return of_it


def _pdf_if_mine(own, number: int, others):
    @kernel
    def choose(scene, index, n, d):
        result = others(scene, index, n, d)
        mine = gather(scene.lights.info, index * INFO) == number
        if any_lane(mine):
            result = where(mine, own(scene, of_one_kind(mine, index), n, d), result)
        return result

    return choose


@kernel
def _from_a_shape(scene, index, n, d):
    return shape_direction_pdf(n, d)


@kernel
def _from_nowhere(scene, index, n, d):
    return lanes(0.0)


@specialised
def emission_direction_pdf(program):
    """`Emission.pdf_direction` of any direction: ``(scene, index, n, d)``.

    Parameters
    ----------
    scene : namedtuple
    index : uint32
        Rows of the lights, lanes.
    n : Vec3
        Their normals where the light starts, on shapes.
    d : Vec3
        Unit directions in which it travels.
    """
    result = _from_nowhere
    for model in on_shapes(program):
        result = _pdf_if_mine(_from_a_shape, model.number, result)
    for model in _at_points(program):
        result = _pdf_if_mine(_pdf_of(model), model.number, result)
    if "lights" in program.motion:
        result = _at_rest(result)
    if not _around(program):
        return result
    others, count = result, max(len(program.environments), 1)

    @kernel
    def choose(scene, index, n, d):
        around = is_around(scene, index, count)
        return where(around, arriving_pdf(scene, -d, -d), others(scene, index, n, d))

    return choose


def _at_rest(pdf):
    """A density of lights of which some move: they only shift and turn."""

    @kernel
    def of_the_direction_at_rest(scene, index, n, d):
        number = lanes_u32(0) + gather(scene.motions.of_light, index)
        moving = number != 0
        if any_lane(moving):
            w = inverse_rows(matrix_at(scene.motions, where(moving, number - 1, 0), scene.time))
            d = where(moving, direction_at_rest(w, d), d)
            n = where(moving, direction_at_rest(w, n), n)
        return pdf(scene, index, n, d)

    return of_the_direction_at_rest
