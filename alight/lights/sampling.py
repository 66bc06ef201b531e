"""Light sampling (next event estimation), and the light that rays hit by chance.

All densities are per solid angle at the lit point and include the probability of choosing the
light, so `sample_light`, `light_pdf` and `environment_pdf` agree with each other.
"""

from __future__ import annotations

from alight.core.distributions import sample_discrete
from alight.core.vec import dot, gather_vec3, row_vec3
from alight.lights.halves import one_after_another, sum_of
from alight.lights.hits import on_shapes, pdf_of_shape, radiance_of_shape
from alight.lights.model import LIGHTS
from alight.lights.moving import moving_sample
from alight.lights.tables import INFO, STRIDE, LightSample, row_of
from alight.lights.tree import choose_by_tree, plain_probability
from alight.shapes.hit import shadow_length, spawn_origin
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    as_int,
    as_uint,
    gather,
    horizontal_max,
    is_finite,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    to_float,
    where,
)


@kernel
def no_sample(scene, index, p, u, u2):
    """A `LightSample` of zeros in every lane."""
    zero, vector = lanes(0.0), lanes_vec3(0.0)
    return LightSample(vector, zero, vector, zero, lanes_mask(False), zero, zero)


def _sample_of(name: str):
    """A light's `sample` by its row; of the one environment it is the last."""
    own = LIGHTS[name].sample
    if not LIGHTS[name].is_around:
        return own

    @kernel
    def of_the_last_light(scene, index, p, u, u2):
        return own(scene, 1, p, u, u2)

    return of_the_last_light


def _by_row(names: tuple[str, ...], others):
    """A kernel that runs `sample` of each of several environments where it was chosen."""
    if not names:
        return others
    chosen = one_after_another(
        [_if_chosen(LIGHTS[name].sample, back) for back, name in enumerate(names[::-1], 1)]
    )

    @kernel
    def choose(scene, index, p, u, u2):
        return chosen(scene, index, p, u, u2, others(scene, index, p, u, u2))

    return choose


def _if_chosen(own, back: int):
    """A kernel that puts the sample of one environment into the lanes that chose it."""

    @kernel
    def choose(scene, index, p, u, u2, result):
        mine = lanes_u32(0) + index == scene.lights.info.size // INFO - back
        if any_lane(mine):
            result = where(mine, own(scene, back, p, u, u2), result)
        return result

    return choose


def _by_kind(names: tuple[str, ...]):
    """A kernel that runs each light's `sample` where it was chosen."""
    if not names:
        return no_sample
    own, number, others = _sample_of(names[0]), LIGHTS[names[0]].number, _by_kind(names[1:])

    @kernel
    def choose(scene, index, p, u, u2):
        result = others(scene, index, p, u, u2)
        mine = gather(scene.lights.info, index * INFO) == number
        if any_lane(mine):
            # Rows of other kinds say other things (where a map begins, not which shape shines), and
            # would lead out of the tables: those lanes ask about a light of this kind too.
            some = as_uint(as_int(horizontal_max(where(mine, to_float(index), 0.0))))
            result = where(mine, own(scene, where(mine, index, some), p, u, u2), result)
        return result

    return choose


@specialised
def sample_chosen(program):
    """``sample_chosen(scene, index, p, u, u2) -> LightSample`` of the lights `index`."""
    several = program.environments
    names = tuple(name for name in LIGHTS if name in program.lights and name not in several)
    # Where all lights are of one kind, nobody has to ask.
    alone = not several and len(names) == 1
    own = _sample_of(names[0]) if alone else _by_row(several, _by_kind(names))
    return moving_sample(own) if "lights" in program.motion else own


def has_delta_lights(program) -> bool:
    """True if the program has lights that only light sampling finds."""
    return any(name in LIGHTS and LIGHTS[name].DELTA for name in program.lights)


@specialised
def choose_light(program):
    """``choose_light(scene, u)``: index of a light, its probability, and what is left of u."""
    if program.single_light:

        @kernel
        def the_only_one(scene, u):
            # A uniform index: its rows are loaded once for all lanes.
            return 0, lanes(1.0), u

        return the_only_one

    @kernel
    def by_probability(scene, u):
        count = scene.lights.info.size // INFO
        return sample_discrete(scene.lights.cdf, 0, count, u)

    return by_probability


@specialised
def light_index(program):
    """``light_index(light)``: row of the light with the number light = index + 1; 0 for none."""
    if program.single_light:

        @kernel
        def the_only_one(light):
            return 0

        return the_only_one

    @kernel
    def one_less(light):
        return where(light > 0, light - 1, 0)

    return one_less


@specialised
def sample_light(program):
    """Choose a light, and light from it: ``sample_light(scene, p, ns, u, u2, active)``.

    Parameters
    ----------
    scene : namedtuple
        With the fields `shapes` and `lights`.
    p, ns : Vec3
        The lit point and its normal on the side that is lit (the zero vector where it has none);
        only a light tree looks at the normal.
    u : float
        Uniform in [0, 1), chooses the light.
    u2 : tuple of 2 floats
        Uniform in [0, 1), choose the direction.
    active : mask
        Lanes that need a sample.

    Returns
    -------
    LightSample
        Not yet tested for shadow: see `shadow_ray`. Where pdf is 0, radiance is 0 too.
    """
    if not program.lights:

        @kernel
        def without_lights(scene, p, ns, u, u2, active):
            return no_sample(scene, lanes(0.0), p, u, u2)

        return without_lights

    if program.light_tree:
        return _from_the_tree

    @kernel
    def with_lights(scene, p, ns, u, u2, active):
        index, pmf, rest = choose_light(scene, u)
        s = sample_chosen(scene, index, p, rest, u2)
        pdf = s.pdf * pmf
        # No light from behind, from nowhere, or from farther than float32 can tell.
        valid = (pdf > 0.0) & is_finite(pdf) & (s.cosine > 0.0)
        radiance = s.radiance * gather_vec3(scene.lights.data, index * STRIDE)
        radiance, pdf = together(scene, index, p, s.wi, radiance, pdf)
        return LightSample(
            s.wi,
            s.distance,
            where(valid, radiance, lanes_vec3(0.0)),
            where(valid, pdf, 0.0),
            s.delta,
            s.cosine,
            s.error,
        )

    return with_lights


@kernel
def _from_the_tree(scene, p, ns, u, u2, active):
    """`sample_light` of a program with a light tree."""
    choice = choose_by_tree(scene, p, ns, u, u2, active)
    s = sample_chosen(scene, choice.index, p, choice.rest, u2)
    # The density for MIS, which does not know the normal; the estimate is divided by the true one.
    pdf = s.pdf * choice.plain
    valid = (pdf > 0.0) & is_finite(pdf) & (s.cosine > 0.0) & (choice.pmf > 0.0)
    radiance = s.radiance * gather_vec3(scene.lights.data, choice.index * STRIDE)
    radiance, pdf = together(scene, choice.index, p, s.wi, radiance, pdf)
    factor = choice.plain / where(valid, choice.pmf, 1.0)
    return LightSample(
        s.wi,
        s.distance,
        where(valid, radiance * factor, lanes_vec3(0.0)),
        where(valid, pdf, 0.0),
        s.delta,
        s.cosine,
        s.error,
    )


@specialised
def choose_light_at(program):
    """``choose_light_at(scene, p, n, u, u2, active)``: the light that `sample_light` takes there.

    Returns
    -------
    uint32
        Row of the light.
    """
    if program.light_tree:

        @kernel
        def by_tree(scene, p, n, u, u2, active):
            return choose_by_tree(scene, p, n, u, u2, active).index

        return by_tree

    @kernel
    def by_table(scene, p, n, u, u2, active):
        index, _, _ = choose_light(scene, u)
        return index

    return by_table


@specialised
def lit_normal(program):
    """``lit_normal(ns, wo)``: the normal on the viewer's side, for `sample_light`; wo is local."""
    if not program.light_tree:

        @kernel
        def any_side(ns, wo):
            return ns

        return any_side

    @kernel
    def of_the_viewer(ns, wo):
        return where(wo.z < 0.0, -ns, ns)

    return of_the_viewer


@kernel
def shadow_ray(surface, sample):
    """Origin and length of the ray that decides whether a light sample is visible.

    Parameters
    ----------
    surface : Surface
        The lit surface.
    sample : LightSample
        Of `sample_light` at ``surface.p``.

    Returns
    -------
    o : Vec3
    t_max : float
        For a ray along ``sample.wi``; see `alight.shapes.hit.shadow_length`.
    """
    o = spawn_origin(surface.p, surface.error, surface.ng, sample.wi)
    return o, shadow_length(sample.distance, sample.cosine, sample.error, surface.error)


@specialised
def light_pdf(program):
    """Density of `sample_light` for a direction that has hit an area light, for MIS.

    ``light_pdf(scene, light, p, wi, distance, surface)``: `light` is ``surface.light``, 0 where the
    surface does not shine (the density is 0 then); p, wi, distance: from where, unit direction,
    metres to the hit.
    """
    if not on_shapes(program):

        @kernel
        def without_area_lights(scene, light, p, wi, distance, surface):
            return lanes(0.0)

        return without_area_lights

    if program.light_tree:
        return _pdf_in_the_tree

    @kernel
    def with_area_lights(scene, light, p, wi, distance, surface):
        shines = light > 0
        index = light_index(light)
        cosine = -dot(wi, surface.ng)
        density = pdf_of_shape(scene, index, surface.prim, p, wi, distance, cosine)
        return where(shines, density * gather(scene.lights.data, index * STRIDE + 3), 0.0)

    return with_area_lights


@kernel
def _pdf_in_the_tree(scene, light, p, wi, distance, surface):
    """`light_pdf` of a program with a light tree."""
    shines = light > 0
    index, prim = light_index(light), where(shines, surface.prim, 0)
    cosine = -dot(wi, surface.ng)
    density = pdf_of_shape(scene, index, prim, p, wi, distance, cosine)
    return where(shines, density * plain_probability(scene, index, prim, p, shines), 0.0)


@specialised
def emitted(program):
    """``emitted(scene, surface, wo)``: radiance that a surface itself sends along the unit wo."""
    if not on_shapes(program):

        @kernel
        def dark(scene, surface, wo):
            return lanes_vec3(0.0)

        return dark

    @kernel
    def on_outer_side(scene, surface, wo):
        shines = (surface.light > 0) & (dot(wo, surface.ng) > 0.0)
        radiance = radiance_of_shape(scene, light_index(surface.light), surface, wo)
        return where(shines, radiance, lanes_vec3(0.0))

    return on_outer_side


def environments_of(program) -> tuple[str, ...]:
    """Names of the models of the program's lights from infinity, in the order of their rows."""
    if program.environments:
        return program.environments
    return tuple(name for name in program.lights if name in LIGHTS and LIGHTS[name].is_around)


def _radiance_of(name: str, back: int):
    radiance = LIGHTS[name].radiance
    assert radiance is not None

    @kernel
    def colored(scene, p, d):
        return row_vec3(scene.lights.data, row_of(scene, back)) * radiance(scene, back, d)

    return colored


def _density_of(name: str, back: int):
    density = LIGHTS[name].pdf
    assert density is not None

    @kernel
    def chosen(scene, p, d):
        return density(scene, back, p, d) * scene.lights.data[row_of(scene, back) + 3]

    return chosen


@specialised
def environment_radiance(program):
    """``environment_radiance(scene, d)``: radiance of a ray that leaves the scene along unit d."""
    names = tuple(enumerate(environments_of(program)[::-1], 1))
    # Portals send nothing.
    parts = tuple(_radiance_of(name, back) for back, name in names if LIGHTS[name].radiance)
    if not parts:

        @kernel
        def black(scene, d):
            return lanes_vec3(0.0)

        return black
    total = sum_of(parts)

    @kernel
    def from_anywhere(scene, d):
        return total(scene, d, d)

    return from_anywhere


@specialised
def environment_pdf(program):
    """Density of `sample_light` for a ray that leaves the scene.

    ``environment_pdf(scene, p, d)``: p, d: the vertex that it comes from, and its unit direction.
    """
    names = tuple(enumerate(environments_of(program)[::-1], 1))
    if not names:

        @kernel
        def impossible(scene, p, d):
            return lanes(0.0)

        return impossible
    return sum_of(tuple(_density_of(name, back) for back, name in names))


@specialised
def together(program):
    """``together(scene, index, p, wi, radiance, pdf)``: those of several environments as of one.

    A ray cannot tell from which of them its light comes; nor does a sample, whichever of them drew
    its direction: it brings the light of all, with the density of their mixture.
    """
    count = len(program.environments)
    if not count:

        @kernel
        def each_by_itself(scene, index, p, wi, radiance, pdf):
            return radiance, pdf

        return each_by_itself

    @kernel
    def of_all(scene, index, p, wi, radiance, pdf):
        around = lanes_u32(0) + index >= scene.lights.info.size // INFO - count
        if any_lane(around):
            radiance = where(around, environment_radiance(scene, wi), radiance)
            pdf = where(around, environment_pdf(scene, p, wi), pdf)
        return radiance, pdf

    return of_all
