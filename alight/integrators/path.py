r"""Path tracing: unidirectional, with light sampling combined by multiple importance sampling.

Each vertex estimates the rendering equation (Kajiya 1986)

.. math:: L_o = L_e + \int f(\omega_o, \omega_i)\, L_i(\omega_i)\, |\cos\theta_i|\, d\omega_i .

Following :math:`L_i` to the next surface and repeating gives a sum over path lengths. The term of
length k is the light that reaches the camera over k edges; a path with throughput
:math:`\beta = \prod f |\cos\theta| / p` estimates it without bias by :math:`\beta L_e`.

Two techniques find the light at the end of the same edge, seen from the vertex x before it:

* the *BSDF* draws a direction with density :math:`p_b` and the ray happens to hit a light
  (`alight.integrators.reach`): :math:`w_b\, \beta\, f |\cos\theta|\, L_e / p_b`,
  the factor :math:`f |\cos\theta| / p_b` being in `beta` already;
* *light sampling* draws a point on a light with density :math:`p_l` and tests whether it is visible
  (`alight.integrators.direct_light`): :math:`w_l\, \beta\, f |\cos\theta|\, L_e / p_l`.

Both densities are per solid angle at x, and :math:`p_l` includes the probability of choosing that
light. For a direction that both techniques can draw, the weights are (`mis_weights`)

.. math:: w_b = \frac{p_b^\alpha}{p_b^\alpha + p_l^\alpha}, \qquad
    w_l = \frac{p_l^\alpha}{p_b^\alpha + p_l^\alpha}, \qquad w_b + w_l = 1

with :math:`\alpha = 2` ("power") or 1 ("balance"). The sum of both techniques has the mean

.. math:: \int w_b \frac{f L_e |\cos\theta|}{p_b} p_b + w_l \frac{f L_e |\cos\theta|}{p_l} p_l
    \; d\omega = \int (w_b + w_l)\, f L_e |\cos\theta| \; d\omega,

which is the wanted integral because the weights sum to one, wherever light can arrive. A direction
that only one technique can draw must get the whole weight: a mirror (`path.delta`) and camera rays
leave all to the BSDF, a delta light (`light.delta`) leaves all to light sampling. With
``light_sampling`` "bsdf" or "emitter" one technique gets weight 1 and the other 0: the sum is still
one. `path.pdf` carries :math:`p_b` along the edge to the vertex where the light is found.

Weights may use any function of the direction in place of :math:`p_l`, as long as both techniques
use the same one. A light tree chooses with the normal at x, which `reach_lamp` no longer knows: so
both weights use the probability that the tree has without the normal, and only the estimate is
divided by the true :math:`p_l` (the factor that `alight.lights.sampling` puts into the radiance).

Source: Kajiya, The rendering equation, SIGGRAPH 1986; Veach and Guibas, Optimally combining
sampling techniques, SIGGRAPH 1995; PBR4 sections 13.4 and 14.1.4.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import has_null
from alight.core.constants import INFINITY
from alight.core.mis import balance_heuristic, power_heuristic
from alight.core.noise_only import NoiseOnly
from alight.core.vec import absolute_vec3, max_component
from alight.integrators.caustics.chain_types import follows_chains
from alight.integrators.caustics.manifold_sampling import write_add_caustics
from alight.integrators.caustics.specular_chain import extended
from alight.integrators.direct_light import write_add_direct_light
from alight.integrators.guided import (
    NOWHERE,
    guide_at,
    is_guided,
    write_surface_scatter,
)
from alight.integrators.interiors.body_walk import begin_walks, walk_through
from alight.integrators.interiors.dispersed import at_wavelength_of, meet_dispersion
from alight.integrators.interiors.enclosing import (
    begin_inside,
    bodies_beyond,
    come_to,
)
from alight.integrators.largest_sample import largest_of_paths
from alight.integrators.mis_weights import STRATEGIES, weights_of
from alight.integrators.options import PathTracing
from alight.integrators.reach import (
    NO_LISTENERS,
    Listeners,
    drawn_by_bsdf,
    is_led_to_disk,
    write_is_from_camera,
    write_reach_environment,
    write_reach_lamp,
)
from alight.integrators.roulette import write_end_dim_paths
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    count_lanes,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.hits import on_shapes
from alight.lights.misses import environments_of
from alight.lights.sampling import has_delta_lights
from alight.lights.targets import has_far_target
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import lanes, lanes_mask, where


class Path(PathTracing):
    """Path tracer.

    Parameters
    ----------
    heuristic : {"power", "balance"}, default "power"
        How "mis" weights the two techniques that find light.
    caustics : {"paths", "manifold"}, default "paths"
        How lamps and the sun are found behind mirrors and clear glass: by paths that happen to hit
        them, or also by manifold sampling (`alight.integrators.caustics.manifold_sampling`), for
        small ones. Point, spot and directional lights are hit by no path: their caustics are in
        the picture with "manifold" alone.
    """

    walks_inside: ClassVar[bool] = True
    sees_dispersion: ClassVar[bool] = True
    transports: ClassVar[bool] = True
    type: Literal["path"] = "path"
    heuristic: Annotated[Literal["power", "balance"], NoiseOnly()] = "power"
    caustics: Annotated[Literal["paths", "manifold"], NoiseOnly()] = "paths"

    @property
    def aims_at_lamps(self) -> bool:
        """Manifold sampling does."""
        return self.caustics == "manifold"

    def largest_sample(self, radiance: float, weight: float, start: float) -> float | None:
        """Bound of a sample where both ways to find light are combined, or BSDFs alone find it."""
        if self.light_sampling == "emitter" or self.wants_guide or self.caustics != "paths":
            return None
        share = {"power": 0.5, "balance": 1.0}[self.heuristic] if self.combines else 0.0
        return largest_of_paths(self, share, radiance, weight, start)


EXAMPLES = (
    Path(),
    Path(max_depth=8, rr_depth=5),
    Path(light_sampling="bsdf", russian_roulette="none", max_depth=4),
    Path(light_sampling="emitter", light_choice="uniform"),
    Path(heuristic="balance", rr_depth=1),
    Path(hide_emitters=True, guiding="on"),
)


def step(program, *, scatter=sample_bsdf, strategy=None, roulette=None, record=None):
    """The kernel that extends paths by one vertex; parameters as for `stages`."""
    trace, shade = stages(
        program, scatter=scatter, strategy=strategy, roulette=roulette, record=record
    )

    @kernel
    def path_step(scene, settings, path):
        """One more vertex of each path."""
        path, hit = trace(scene, settings, path)
        path, walk = shade(scene, settings, path, hit)
        return walk_through(scene, path, walk)

    return path_step


def stages(program, *, scatter=sample_bsdf, strategy=None, roulette=None, record=None):
    """The two halves of a step, for the options of a program.

    Between them, paths whose rays left the scene end, so that the others can be repacked.

    Parameters
    ----------
    program : Program
    scatter : kernel, default `sample_bsdf`
        How the next direction is chosen.
    strategy : {"mis", "bsdf", "emitter"}, optional
        Overrides the program's ``light_sampling``.
    roulette : bool, optional
        Overrides the program's ``russian_roulette``.
    record : tuple of kernels, optional
        (meet, find, leave, sample) of `alight.integrators.contributions`, which receive every
        contribution.

    Returns
    -------
    trace : kernel (scene, settings, path) -> (path, hit)
        Traces rays to the next surface; adds the environment for those that hit none and ends
        their paths.
    shade : kernel (scene, settings, path, hit) -> (path, walk)
        Adds the light found at the surface, and samples where the path continues; `walk` says which
        have entered bodies (`alight.integrators.interiors.body_walk`).
    """
    strategy = strategy or program.option("light_sampling")
    if roulette is None:
        roulette = program.option("russian_roulette") == "throughput"
    heuristic = {"power": power_heuristic, "balance": balance_heuristic}[
        program.option("heuristic", "power")
    ]
    weights = weights_of(STRATEGIES[strategy], heuristic)
    listeners = Listeners(*record) if record else NO_LISTENERS
    return (
        _write_trace(program, weights[0], listeners),
        _write_shade(program, scatter, strategy, roulette, weights, listeners),
    )


def _write_trace(program, bsdf_weight, listeners):
    environment = bool(environments_of(program))
    far = follows_chains(program) and has_far_target(program)
    hides = program.option("hide_emitters", False)
    unguided = drawn_by_bsdf if is_guided(program) else None
    reach_environment = write_reach_environment(bsdf_weight, listeners, unguided)
    is_from_camera = write_is_from_camera(program)

    @kernel
    def trace(scene, settings, path):
        """Follow the rays to the next surface."""
        path = begin_inside(scene, path, path.active & (path.depth == 0))
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        path = replace(path, rays=path.rays + count_lanes(path.active))
        missed = path.active & (hit.t == INFINITY)
        active = path.active & (hit.t < INFINITY)
        if hides:
            missed = missed & ~is_from_camera(path)
        # The ray left the scene: light of the environment.
        if far:
            # They wait, until it is known whether it counts.
            led = missed & is_led_to_disk(scene, path)
            missed, active = missed & ~led, active | led
        if environment:
            path = reach_environment(scene, path, missed)
        return replace(path, active=active), hit

    return trace


def _write_shade(program, scatter, strategy, roulette, weights, listeners):
    """The second half; parameters as for `stages`."""
    bsdf_weight, light_weight = weights
    by_light = strategy in ("emitter", "mis") and bool(program.lights)
    samples_lights = by_light or has_delta_lights(program)
    area_lights, holes = bool(on_shapes(program)), has_null(program)
    guided, chains = is_guided(program), follows_chains(program)
    far = chains and has_far_target(program)
    reach_environment = write_reach_environment(bsdf_weight, listeners)
    reach_lamp = write_reach_lamp(bsdf_weight, holes, listeners, drawn_by_bsdf if guided else None)
    add_direct_light = write_add_direct_light(program, light_weight, by_light, listeners)
    recorded, meet = listeners.meet is not None, listeners.meet
    hides, is_from_camera = program.option("hide_emitters", False), write_is_from_camera(program)
    next_direction = write_surface_scatter(roulette) if guided else _write_scatter(scatter)
    end_dim_paths = write_end_dim_paths(program, guided)
    add_caustics = write_add_caustics(listeners, guided)

    @kernel
    def shade(scene, settings, path, hit):
        """One more vertex, where the rays of active paths met a surface."""
        left = path.active & (hit.t == INFINITY) if far else lanes_mask(False)
        active, depth = path.active & ~left, path.depth + 1
        surface = at_wavelength_of(make_surface(scene, hit, path.o, path.d, active), path.sampler)
        wo = to_local(surface, -path.d)
        if recorded:
            meet(scene, path, surface, depth, active)

        # The camera looks through lights: the path continues as if it had hit nothing.
        hidden = lanes_mask(False)
        if hides:
            hidden = active & is_from_camera(path) & (surface.light != 0)
            active = active & ~hidden
        # Dimmed by the body that the ray crossed.
        path = come_to(scene, path, surface, hit.t, active, active | hidden)

        covered = lanes_mask(False)  # Lamps that count already, as caustics.
        if chains:
            path, covered = add_caustics(scene, settings, path, surface, wo, active, left)
        if far:
            path = reach_environment(scene, path, left & ~covered)

        # The ray hit a light: the BSDF's technique, weighted by w_b.
        if area_lights:
            path = reach_lamp(scene, path, hit, surface, active & ~covered)

        # The longest path ends here: one more edge would exceed max_depth.
        active = active & (depth < settings.max_depth)
        path = meet_dispersion(scene, surface, path, active)
        here = guide_at(settings, surface.p) if guided else NOWHERE

        # Direct light by light sampling, weighted by w_l.
        if samples_lights:
            path = add_direct_light(scene, settings, path, surface, wo, active, here)

        # Where the path continues: beta gains f cos / p_b.
        arrived = replace(path, active=active)
        drawn, unguided = next_direction(scene, settings, arrived, here, surface, wo)
        wi, weight, pdf, flags = drawn
        beta = path.beta * weight
        # Filters with negative lobes weigh some paths negatively.
        brightness = max_component(absolute_vec3(beta))
        # Not "brightness > 0": a NaN must live on and be counted by the film.
        active = active & ~(brightness <= 0.0)
        d = to_world(surface, wi)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        on = replace(path, o=o, d=d, beta=beta, depth=depth, active=active, unguided=unguided)
        on = replace(on, bodies=bodies_beyond(scene, path.bodies, surface, path.d, d))
        if chains:
            on = replace(on, chain=extended(scene, path.chain, surface, o, d, flags))
        if roulette:
            on = end_dim_paths(scene, settings, on, surface, wi, brightness, here)
        vertex = replace(on, p=surface.p, pdf=pdf, delta=(flags & DELTA) != 0)
        if holes:
            # Straight on, as if nothing were there: the vertex before still looks for light.
            vertex = where((flags & NULL) != 0, on, vertex)
        if hides:
            beyond = spawn_origin(surface.p, surface.error, surface.ng, path.d)
            vertex = where(hidden, replace(path, o=beyond), vertex)
        vertex = replace(vertex, sampler=path.sampler, rays=path.rays)
        return vertex, begin_walks(scene, vertex, surface, active)

    return shade


def _write_scatter(scatter):
    """As `write_surface_scatter`, without a guide."""

    @kernel
    def next_direction(scene, settings, path, here, surface, wo):
        active, dimension = path.active, vertex_dimension(path.depth + 1)
        u = get_1d(path.sampler, dimension + BSDF_CHOICE)
        u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
        return scatter(scene, surface, wo, u, u2, active), NOWHERE

    return next_direction
