"""Light sampling (next event estimation).

All densities are per solid angle at the lit point and include the probability of choosing the
light, so `sample_light` agrees with `alight.lights.hits.light_pdf` and
`alight.lights.misses.environment_pdf`.
"""

from __future__ import annotations

from alight.core.vec import gather_vec3
from alight.lights.choice import choose_light, of_one_kind
from alight.lights.halves import one_after_another
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.model import LIGHTS
from alight.lights.moving import moving_sample
from alight.lights.tables import INFO, STRIDE, LightSample
from alight.shapes.hit import shadow_length, spawn_origin
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    gather,
    is_finite,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    where,
)


@kernel
def no_sample(scene, index, p, u, u2):
    """A `LightSample` of zeros in every lane."""
    zero, vector = lanes(0.0), lanes_vec3(0.0)
    return LightSample(
        wi=vector,
        distance=zero,
        radiance=vector,
        pdf=zero,
        delta=lanes_mask(False),
        cosine=zero,
        error=zero,
    )


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


def sample_by_kind(names: tuple[str, ...]):
    """A kernel that runs each light's `sample` where it was chosen."""
    if not names:
        return no_sample
    own, number, others = _sample_of(names[0]), LIGHTS[names[0]].number, sample_by_kind(names[1:])

    @kernel
    def choose(scene, index, p, u, u2):
        result = others(scene, index, p, u, u2)
        mine = gather(scene.lights.info, index * INFO) == number
        if any_lane(mine):
            result = where(mine, own(scene, of_one_kind(mine, index), p, u, u2), result)
        return result

    return choose


@specialised
def sample_chosen(program):
    """``sample_chosen(scene, index, p, u, u2) -> LightSample`` of the lights `index`."""
    several = program.environments
    names = tuple(name for name in LIGHTS if name in program.lights and name not in several)
    # Where all lights are of one kind, nobody has to ask.
    alone = not several and len(names) == 1
    own = _sample_of(names[0]) if alone else _by_row(several, sample_by_kind(names))
    return moving_sample(own) if "lights" in program.motion else own


def has_delta_lights(program) -> bool:
    """True if the program has lights that only light sampling finds."""
    return any(name in LIGHTS and LIGHTS[name].DELTA for name in program.lights)


@kernel
def sample_light(scene, p, ns, u, u2, active):
    """Choose a light, and light from it.

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
    sample, _ = sample_known_light(scene, p, ns, u, u2, active)
    return sample


@specialised
def sample_known_light(program):
    """`sample_light` with the row of the light: ``(LightSample, index)``."""
    if not program.lights:

        @kernel
        def without_lights(scene, p, ns, u, u2, active):
            return no_sample(scene, lanes(0.0), p, u, u2), lanes_u32(0)

        return without_lights

    by_tree = program.light_tree

    @kernel
    def with_lights(scene, p, ns, u, u2, active):
        choice = choose_light(scene, p, ns, u, u2, active)
        s = sample_chosen(scene, choice.index, p, choice.rest, u2)
        # The density for MIS, which does not know the normal.
        pdf = s.pdf * choice.mis_pmf
        # No light from behind, from nowhere, or from farther than float32 can tell.
        valid = (pdf > 0.0) & is_finite(pdf) & (s.cosine > 0.0)
        radiance = s.radiance * gather_vec3(scene.lights.data, choice.index * STRIDE)
        if by_tree:
            valid = valid & (choice.pmf > 0.0)
        radiance, pdf = together(scene, choice.index, p, s.wi, radiance, pdf)
        if by_tree:
            # The estimate is divided by the true density, which knows the normal.
            radiance = radiance * (choice.mis_pmf / where(valid, choice.pmf, 1.0))
        radiance, pdf = where(valid, radiance, lanes_vec3(0.0)), where(valid, pdf, 0.0)
        return replace(s, radiance=radiance, pdf=pdf), choice.index

    return with_lights


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
