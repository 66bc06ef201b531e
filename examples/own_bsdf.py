r"""A BSDF of your own: Lommel and Seeliger's law, by which the full moon looks like a disk.

.. math:: f = \frac{w}{4 \pi (\cos\theta_i + \cos\theta_o)}

Light enters a dust of albedo w, is scattered once, and leaves. Writes moon.png: left Lambert's law,
right this one, both lit from behind the camera.

Source: Hapke, Theory of Reflectance and Emittance Spectroscopy (2012), section 8.
"""

from typing import Annotated, Literal, NamedTuple

import alight
from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_TWO_PI
from alight.core.fields import Interval
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3
from alight.core.warps import direction_around_z
from alight.textures.fetch import Scalar
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, lanes_vec3, maximum, where


class LommelSeeliger(Bsdf):
    """Dust that scatters light once.

    Parameters
    ----------
    dust : float in [0, 1], default 0.9
        Albedo w of a grain.
    """

    type: Literal["lommel_seeliger"] = "lommel_seeliger"
    dust: Annotated[float, Interval(0.0, 1.0)] = 0.9


EXAMPLES = (LommelSeeliger(), LommelSeeliger(dust=1.0), LommelSeeliger(dust=0.0))


def is_lossless(spec: LommelSeeliger) -> bool:
    """Never: light that is scattered twice is left out."""
    return False


def is_reciprocal(spec: LommelSeeliger) -> bool:
    """The formula is symmetric."""
    return True


class Params(NamedTuple):
    """A row of the table."""

    dust: Scalar


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: LommelSeeliger, packer) -> None:
    """Fill the row of one material."""
    packer.numbers("dust", spec.dust)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    f_cos = params.dust * INV_TWO_PI * 0.5 * wi.z / maximum(wi.z + wo.z, 1e-9)
    value = where(above, f_cos, lanes(0.0))
    return Vec3(value, value, value), where(above, lanes(INV_TWO_PI), lanes(0.0))


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): uniform, so no weight exceeds w/2."""
    wi = direction_around_z(1.0 - u2[0], u2[1])
    f_cos, pdf = evaluate(params, wo, wi)
    return wi, f_cos * (1.0 / INV_TWO_PI), pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Colour for the AOV of that name."""
    return lanes_vec3(1.0) * params.dust


alight.register(__name__)


SCENE = {
    "camera": {
        "type": "orthographic",
        "height": 2.3,
        "transform": {"look_at": {"origin": [0, 0, 10], "target": [0, 0, 0]}},
    },
    "film": {"size": [128, 64]},
    "integrator": {"type": "path", "max_depth": 2},
    "nodes": {
        # It shines along +z of its node, here away from the camera.
        "sun": {
            "light": {"type": "directional", "irradiance": 6},
            "transform": {"rotate": {"axis": "y", "angle": 180}},
        },
        "lambert": {
            "shape": {"type": "sphere", "center": [-1.1, 0, 0]},
            "bsdf": {"type": "diffuse"},
        },
        "moon": {
            "shape": {"type": "sphere", "center": [1.1, 0, 0]},
            "bsdf": {"type": "lommel_seeliger"},
        },
    },
}

if __name__ == "__main__":
    # Sample against pdf, energy, reciprocity, machine code against NumPy: as for built-in models.
    print(alight.check_laws(__name__))
    film = alight.render(SCENE, spp=16, output="moon.png")
    middle, rim = film.image[32, 95, 0], film.image[32, 119, 0]
    print(f"moon.png: the rim has {rim / middle:.0%} of the middle's radiance")
