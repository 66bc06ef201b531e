r"""Absorption inside a clear body: Beer and Lambert's law.

.. math:: T(t) = c^{t / d} = e^{-\sigma t}, \qquad \sigma = -\ln(c) / d

Light keeps the colour c after the distance d inside. A segment of a path is dimmed by the body that
it lies in, wherever it begins and ends: at the body's own boundary, at another's, at an opaque
thing or a lamp inside, or at the camera. Which body that is:
`alight.integrators.interiors.enclosing`.

The body below a mask is that of its material, whatever the opacity: holes are holes in its surface.
The body below a blend absorbs as the mean of those of its parts that have one, each with its share;
parts whose share varies over the surface count alike.

Source: Lambert, Photometria (1760); PBR4 section 11.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from alight.core.field_types import Reflectance
from alight.core.fields import Interval
from alight.core.spec import Bsdf

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
    def bounds_body(self) -> bool:
        """Whether there is a body below the surface, which light can enter."""
        return True

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
    return (ABSORBING,) if spec.bounds_body and any(spec.coefficients) else ()
