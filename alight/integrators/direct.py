r"""Direct light only: light that reaches the camera after at most one scattering.

Source: PBR4 section 13.2 (direct lighting); Veach and Guibas 1995 for the combination.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from alight.core.noise_only import NoiseOnly
from alight.integrators import path
from alight.integrators.options import LightSampling
from lanewise.jit import kernel
from lanewise.records import replace

#: The camera sees a light (1), or a surface that a light shines on (2).
MAX_DEPTH = 2


class Direct(LightSampling):
    """Direct lighting.

    Parameters
    ----------
    heuristic : {"power", "balance"}, default "power"
        As for `path`.
    """

    sees_dispersion: ClassVar[bool] = True
    transports: ClassVar[bool] = True
    type: Literal["direct"] = "direct"
    heuristic: Annotated[Literal["power", "balance"], NoiseOnly()] = "power"

    @property
    def longest_path(self) -> int:
        """From a light to a surface and into the camera."""
        return MAX_DEPTH


EXAMPLES = (
    Direct(),
    Direct(light_sampling="bsdf"),
    Direct(light_sampling="emitter", heuristic="balance", light_choice="uniform"),
)


def step(program, *, record=None):
    """The path tracer's step, for paths of at most two edges; `record` as there."""
    path_step = path.step(program, roulette=False, record=record)

    @kernel
    def direct_step(scene, settings, walk):
        """One more vertex of each path."""
        two_edges = replace(settings, max_depth=MAX_DEPTH)
        return path_step(scene, two_edges, walk)

    return direct_step
