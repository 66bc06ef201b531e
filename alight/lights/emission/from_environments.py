r"""Light from infinity on its way into the scene: a direction, then one of its parallel lines.

The direction is drawn as for light sampling, from the mixture of all environments,

.. math:: p_\omega = \sum_i P_i \Bigl(\frac{s_i}{4 \pi} + (1 - s_i)\, p_i(\omega)\Bigr)

where :math:`s_i` is the share of its light that environment i leaves to BSDF sampling, which here
nothing else would find. The line meets the disk of the scene's ball; where there are portals, half
of the lines are drawn through these, :math:`p_A` being the density of both ways together. The ray
carries the light of all environments: no line knows which of them it was drawn for.

Source: PBR4 section 16.1.2; Veach and Guibas, Optimally combining sampling techniques for Monte
Carlo rendering, SIGGRAPH 1995 (a mixture as one technique).
"""

from __future__ import annotations

from alight.core.constants import INV_FOUR_PI, ONE_MINUS_EPSILON
from alight.core.distributions import pmf_discrete
from alight.core.warps import square_to_uniform_sphere
from alight.lights.ball import across_the_ball, behind_the_ball, disk_area, radius_of
from alight.lights.halves import sum_of
from alight.lights.misses import environment_radiance, environments_of
from alight.lights.model import LIGHTS
from alight.lights.tables import CHOICE, INFO, Emission
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    minimum,
    minimum_u32,
    to_float,
    to_uint,
    where,
)


def _sources(program) -> list[tuple[int, str]]:
    """Number from the end and name of each environment that sends light."""
    names = enumerate(environments_of(program)[::-1], 1)
    return [(back, name) for back, name in names if LIGHTS[name].radiance]


def _windows(program) -> list[tuple[int, str]]:
    """Number from the end and name of each portal."""
    names = enumerate(environments_of(program)[::-1], 1)
    return [(back, name) for back, name in names if LIGHTS[name].window_point]


@kernel
def probability_of(scene, back):
    """Probability of choosing the light number `back` from the end."""
    row = scene.lights.info.size // INFO - back
    return pmf_discrete(scene.lights.emission, CHOICE, lanes_u32(row))


def _left_out(name: str):
    own = LIGHTS[name].left_out
    if own is not None:
        return own

    @kernel
    def nothing(scene, back):
        return lanes(0.0)

    return nothing


# ---------------------------------------------------------------- directions


def _density_of(back: int, name: str):
    """``(scene, p, d)``: probability of an environment times its density of the direction d."""
    density, left_out = LIGHTS[name].pdf, _left_out(name)
    assert density is not None

    @kernel
    def chosen(scene, p, d):
        rest = left_out(scene, back)
        mixed = rest * INV_FOUR_PI + (1.0 - rest) * density(scene, back, p, d)
        return probability_of(scene, back) * mixed

    return chosen


def _probability(back: int):
    @kernel
    def of_it(scene, p, d):
        return probability_of(scene, back)

    return of_it


@specialised
def environments_probability(program):
    """``(scene, p, d)``: probability of choosing any environment; p and d are of no concern."""
    return sum_of(tuple(_probability(back) for back, _ in _sources(program)))


@specialised
def arriving_pdf(program):
    """``(scene, p, d)``: density per steradian of light from the direction d; p of no concern.

    Of `emit_from_environment`, its light travelling along -d.
    """
    density = sum_of(tuple(_density_of(back, name) for back, name in _sources(program)))

    @kernel
    def of_all(scene, p, d):
        return density(scene, p, d) / environments_probability(scene, p, d)

    return of_all


def _draw(back: int, name: str):
    """``(scene, u, v2)``: a direction to one environment."""
    sample, left_out = LIGHTS[name].sample, _left_out(name)

    @kernel
    def draw(scene, u, v2):
        rest = lanes(0.0) + left_out(scene, back)
        anywhere = u < rest
        u = minimum((u - rest) / where(rest < 1.0, 1.0 - rest, 1.0), ONE_MINUS_EPSILON)
        own = sample(scene, back, lanes_vec3(0.0), where(anywhere, 0.0, u), v2).wi
        return where(anywhere, square_to_uniform_sphere(v2), own)

    return draw


def _draw_chosen(sources: list[tuple[int, str]]):
    """``(scene, index, u, v2)``: a direction to the environments `index`."""
    own, back = _draw(*sources[0]), sources[0][0]
    if len(sources) == 1:

        @kernel
        def the_only_one(scene, index, u, v2):
            return own(scene, u, v2)

        return the_only_one
    others = _draw_chosen(sources[1:])

    @kernel
    def choose(scene, index, u, v2):
        wi = others(scene, index, u, v2)
        mine = lanes_u32(0) + index == scene.lights.info.size // INFO - back
        if any_lane(mine):
            wi = where(mine, own(scene, u, v2), wi)
        return wi

    return choose


@specialised
def draw_direction(program):
    """``draw_direction(scene, index, u, v2)``: to the environments `index`."""
    return _draw_chosen(_sources(program))


# ---------------------------------------------------------------- lines


def _window_pdf(back: int, name: str):
    own = LIGHTS[name].window_pdf
    assert own is not None

    @kernel
    def of_it(scene, p, d):
        return own(scene, back, p, d)

    return of_it


def _point_of(windows: list[tuple[int, str]]):
    """``(scene, number, u2)``: a point of the portal of some number."""
    back, own = windows[0][0], LIGHTS[windows[0][1]].window_point
    assert own is not None
    if len(windows) == 1:

        @kernel
        def the_last_one(scene, number, u2):
            return own(scene, back, u2)

        return the_last_one
    others, left = _point_of(windows[1:]), len(windows) - 1

    @kernel
    def choose(scene, number, u2):
        return where(number == left, own(scene, back, u2), others(scene, number, u2))

    return choose


@specialised
def line_pdf(program):
    """``line_pdf(scene, p, d)``: density per square metre across d of the line through p."""
    windows = _windows(program)
    if not windows:

        @kernel
        def across_the_disk(scene, p, d):
            return 1.0 / disk_area(scene)

        return across_the_disk
    through = sum_of(tuple(_window_pdf(back, name) for back, name in windows))
    share = 0.5 / len(windows)

    @kernel
    def of_both(scene, p, d):
        return 0.5 / disk_area(scene) + share * through(scene, p, d)

    return of_both


@specialised
def draw_line(program):
    """``draw_line(scene, d, u2) -> (p, mask)``: where a ray along d starts; it meets the ball."""
    windows = _windows(program)
    if not windows:

        @kernel
        def through_the_disk(scene, d, u2):
            p, _ = across_the_ball(scene, d, u2)
            return p, lanes_mask(True)

        return through_the_disk
    point, count = _point_of(windows), len(windows)

    @kernel
    def through_either(scene, d, u2):
        by_window = u2[0] < 0.5
        x = minimum(2.0 * where(by_window, u2[0], u2[0] - 0.5), ONE_MINUS_EPSILON)
        p, _ = across_the_ball(scene, d, (x, u2[1]))
        number = minimum_u32(to_uint(x * count), count - 1)
        rest = minimum(x * count - to_float(number), ONE_MINUS_EPSILON)
        seen, squared = behind_the_ball(scene, point(scene, number, (rest, u2[1])), d)
        radius = radius_of(scene)
        return where(by_window, seen, p), ~by_window | (squared <= radius * radius)

    return through_either


@kernel
def emit_from_environment(scene, index, u, u2, v2):
    """A ray from the environments `index`, as `Emission` before their choice.

    Parameters
    ----------
    scene : namedtuple
    index : uint32
    u, v2 : float and pair of floats
        Uniform in [0, 1), choose the direction.
    u2 : pair of floats
        Uniform in [0, 1), choose the line.
    """
    wi = draw_direction(scene, index, u, v2)
    d = -wi
    p, meets = draw_line(scene, d, u2)
    pdf_direction, pdf_position = arriving_pdf(scene, p, wi), line_pdf(scene, p, d)
    density = pdf_direction * pdf_position
    drawn = meets & (density > 0.0)
    share = where(drawn, 1.0 / where(drawn, density, 1.0), 0.0)
    return Emission(
        p=p,
        n=d,
        o=p,
        d=d,
        flux=environment_radiance(scene, wi) * share,
        light=lanes_u32(0),
        prim=lanes_u32(0),
        choice=lanes(1.0),
        pdf_position=lanes(0.0) + pdf_position,
        pdf_direction=lanes(0.0) + pdf_direction,
        delta_position=lanes_mask(False),
        delta_direction=lanes_mask(False),
    )
