r"""Absorption inside a clear body: Beer and Lambert's law.

.. math:: T(t) = c^{t / d} = e^{-\sigma t}, \qquad \sigma = -\ln(c) / d

Light keeps the colour c after the distance d inside. The surface at the end of a path segment
determines the body that contains it: if the segment arrives at the inner side of a surface, that
surface's material absorbs along the whole segment. No list of media is kept, so this is right for
closed bodies, nested ones included if each boundary is one surface that names the media on both
sides (`int_ior`, `ext_ior`); light from opaque things inside a body is dimmed on its way out, but
not the light that comes to them. Shadow rays do not pass boundaries that refract. Segments arrive
as seen from the camera: light paths are dimmed by the surface that they leave.

Source: Lambert, Photometria (1760); PBR4 section 11.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from alight.core.spec import Bsdf, Interval, Reflectance

#: What programs call a material that absorbs inside.
ABSORBING = "absorbing"
#: Colours count as at least this: nothing real is blacker after a finite way.
DARKEST = 1e-6


@dataclass(frozen=True)
class Distance(Interval):
    """Metadata of a field that holds a length in metres > 0, infinity allowed."""

    low: float = 0.0
    open_ends: bool = True

    def check(self, value: object) -> float:
        """Return `value` as a Python number, or raise an error that states the allowed range."""
        # As text, because the YAML of scene files knows no number without digits.
        return math.inf if value in (math.inf, ".inf", "inf") else super().check(value)

    def describe(self) -> str:
        """Put the range in words."""
        return "> 0, or .inf"


class Absorbing(Bsdf):
    """Base class of boundaries of clear bodies.

    Parameters
    ----------
    attenuation_color : (r, g, b), default 1
        What is left of white light after `attenuation_distance` inside, each channel in [0, 1].
    attenuation_distance : float > 0, metres, default infinity
        See there; infinity: nothing is absorbed.
    """

    attenuation_color: Reflectance = (1.0, 1.0, 1.0)
    attenuation_distance: Annotated[float, Distance()] = math.inf

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """Absorption coefficients, per metre."""
        r, g, b = (
            min(-math.log(max(c, DARKEST)) / self.attenuation_distance, 1e15) + 0.0
            for c in self.attenuation_color
        )
        return r, g, b


def absorption_features(spec: Absorbing) -> tuple[str, ...]:
    """What must be compiled for the inside of a body."""
    return (ABSORBING,) if any(spec.coefficients) else ()


def pack_absorption(spec: Absorbing, packer) -> None:
    """Fill the slots of the coefficients, per metre."""
    packer.numbers("absorption", *spec.coefficients)
