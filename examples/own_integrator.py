r"""An integrator of your own: the normal of the first surface as a colour.

.. math:: L = \tfrac12 (n_s + 1)

Writes normals.png. `alight.register` makes it a name like any other: ``--integrator normal_colors``
with ``--plugin own_integrator.py``.
"""

from typing import ClassVar, Literal

import alight
from alight.accel import intersect_closest
from alight.core.constants import INFINITY
from alight.core.spec import Integrator
from alight.integrators.walk import count_lanes
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import any_lane, lanes, lanes_mask, lanes_vec3, where


class NormalColors(Integrator):
    """Normals as colours; needs no light."""

    needs_light: ClassVar[bool] = False
    type: Literal["normal_colors"] = "normal_colors"


EXAMPLES = (NormalColors(),)


def step(program):
    """The kernel for the first and only vertex."""

    @kernel
    def normal_step(scene, settings, path):
        """Colour the first surface, end the path."""
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        found = path.active & (hit.t < INFINITY)
        L = path.L
        if any_lane(found):
            surface = make_surface(scene, hit, path.o, path.d, found)
            L = where(found, surface.ns * 0.5 + lanes_vec3(0.5), L)
        rays = path.rays + count_lanes(path.active)
        return replace(path, L=L, L_direct=L, active=lanes_mask(False), rays=rays)

    return normal_step


alight.register(__name__)

if __name__ == "__main__":
    film = alight.render(
        "cornell-box", integrator="normal_colors", size=96, spp=4, output="normals.png"
    )
    print("normals.png: the back wall is", film.image[40, 48].round(2))
