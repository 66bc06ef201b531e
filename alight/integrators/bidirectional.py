r"""Bidirectional path tracing: a light path and a camera path, and all ways to join them.

Each sample traces a light path with the vertices :math:`y_0, y_1, \dots` and a camera path with
:math:`z_0` on the lens, :math:`z_1, \dots`. A path with s vertices of the one and t of the other is
found by technique (s, t):

* s = 0: the camera path comes upon light;
* s = 1: light sampling at a vertex of the camera path, exactly as in `alight.integrators.path`;
* t = 1: a vertex of the light path is seen by the camera, which adds to any pixel;
* else the two vertices are joined by a shadow ray.

Light that the camera sees directly is found by s = 0 alone. All techniques that find the same path
share it by weights (`alight.integrators.both_ends.connection_weights`), in which there is one light
path for each pixel of the picture, whatever numbers have been traced: so films are resumed and
merged as any others. Each technique is divided by its own number of paths.

Only paths of at most `LONGEST` edges are joined. Longer ones are found by s = 0 and s = 1 alone,
with the weights of a path tracer: whatever its length, the weights of a path sum to one.

Source: Lafortune and Willems, Bi-directional path tracing, Compugraphics 1993; Veach and Guibas,
Bidirectional estimators for light transport, 1994; Veach 1997, Robust Monte Carlo methods for light
transport simulation, chapter 10.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from alight.core.noise_only import NoiseOnly
from alight.integrators.both_ends.camera_subpath import (
    begin_camera,
    write_extend_camera,
    write_join,
)
from alight.integrators.both_ends.light_subpath import write_begin_light, write_extend_light
from alight.integrators.model import BothEnds
from alight.integrators.options import PathLengths


class Bidirectional(PathLengths):
    """Bidirectional path tracer.

    Parameters
    ----------
    heuristic : {"power", "balance"}, default "power"
        How the techniques that find the same path are weighted.
    light_choice : {"auto", "power", "uniform", "tree"}, default "auto"
        How vertices of camera paths choose a light, see `alight.integrators.options.LightSampling`;
        light paths choose theirs by power.
    """

    splats: ClassVar[bool] = True
    transports: ClassVar[bool] = True
    type: Literal["bidirectional"] = "bidirectional"
    heuristic: Annotated[Literal["power", "balance"], NoiseOnly()] = "power"
    light_choice: Annotated[Literal["auto", "power", "uniform", "tree"], NoiseOnly()] = "auto"

    @property
    def choice_of_lights(self) -> str:
        """As `light_choice` says."""
        return self.light_choice

    @property
    def combines(self) -> bool:
        """Light sampling shares the work with all other techniques."""
        return True


EXAMPLES = (
    Bidirectional(),
    Bidirectional(max_depth=6, rr_depth=3, heuristic="balance"),
    Bidirectional(max_depth=3, russian_roulette="none", light_choice="uniform"),
)


def both_ends(program, tell: Any = None):
    """The kernels of both halves, for the options of a program.

    `tell`, of `alight.integrators.strategies`, is called wherever they add light.
    """
    return BothEnds(
        begin_light=write_begin_light(program),
        extend_light=write_extend_light(program, tell),
        begin_camera=begin_camera,
        extend_camera=write_extend_camera(program, tell),
        join=write_join(program, tell),
    )
