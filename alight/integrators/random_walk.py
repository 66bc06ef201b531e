r"""Random walk: the naive baseline. Follow uniform directions and hope to hit a light.

.. math::
    L_o \approx L_e
        + \frac{f(\omega_o, \omega_i)\, |\cos\theta_i|\, L_i(\omega_i)}{p(\omega_i)}

Source: PBR4 section 1.3.6 (RandomWalkIntegrator).
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.bsdfs.dispatch import evaluate_bsdf, is_mixed, sample_bsdf
from alight.bsdfs.flags import DELTA, REFLECTION, TRANSMISSION
from alight.core.constants import INV_FOUR_PI
from alight.core.field_types import Depth
from alight.core.spec import Integrator
from alight.core.warps import square_to_uniform_sphere
from alight.integrators import path
from lanewise.jit import kernel
from lanewise.simd import where


class RandomWalk(Integrator):
    """Path tracing without light sampling or roulette.

    Parameters
    ----------
    max_depth : int >= 1, default 5
        Longest path, counted in edges after the camera.
    """

    walks_inside: ClassVar[bool] = True
    sees_dispersion: ClassVar[bool] = True
    transports: ClassVar[bool] = True
    type: Literal["random_walk"] = "random_walk"
    max_depth: Depth = 5

    @property
    def longest_path(self) -> int:
        """As `max_depth` says."""
        return self.max_depth

    @property
    def finds_light_by_chance(self) -> bool:
        """Always."""
        return True


EXAMPLES = (RandomWalk(), RandomWalk(max_depth=1), RandomWalk(max_depth=20))


@kernel
def scatter_uniformly(scene, surface, wo, u, u2, active):
    """Any direction of the sphere, equally likely; delta lobes still choose their own.

    Where a material may have both, a coin is tossed: one side is for the delta lobes, the other for
    the rest, and each counts double.
    """
    both = is_mixed(scene, surface)
    heads = both & (u < 0.5)
    share = where(both, 0.5, 1.0)
    v = where(both, where(heads, 2.0 * u, 2.0 * u - 1.0), u)
    wi, weight, pdf, flags = sample_bsdf(scene, surface, wo, v, u2, active)
    delta = (flags & DELTA) != 0
    uniform = square_to_uniform_sphere(u2)
    f_cos, _ = evaluate_bsdf(scene, surface, wo, uniform, active)
    chosen = where(both, heads, delta)
    # Heads and no delta lobe: the path has failed.
    weight = where(chosen & ~delta, 0.0, where(delta & chosen, weight, f_cos * (1.0 / INV_FOUR_PI)))
    return (
        where(chosen, wi, uniform),
        weight * (1.0 / share),
        where(chosen, pdf, INV_FOUR_PI) * share,
        where(chosen, flags, flags & (REFLECTION | TRANSMISSION)),
    )


def step(program, *, record=None):
    """The path tracer's step with uniform directions, without light sampling and roulette."""
    return path.step(
        program, scatter=scatter_uniformly, strategy="bsdf", roulette=False, record=record
    )
