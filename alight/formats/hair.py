r"""The colour of much hair, by what one hair absorbs.

.. math:: c = \exp\bigl(-\sqrt{\sigma_a}\; q(\beta_n)\bigr)

with a polynomial q of the roughness around the hair; :math:`\sigma_a` in units of its diameter.

Source: Chiang et al., A practical and controllable hair and fur model for production path tracing,
Computer Graphics Forum 35(2), 2016; PBR4 section 9.9.3 for the pigments.
"""

from __future__ import annotations

import math

#: What a unit of the two pigments absorbs.
_EUMELANIN, _PHEOMELANIN = (0.419, 0.697, 1.37), (0.187, 0.4, 1.05)
#: Eumelanin of brown hair, and how rough hair is around itself.
USUAL_EUMELANIN, USUAL_BETA_N = 1.3, 0.3
#: Pigment that leaves no light in any channel.
MOST = 1e3


def absorption(eumelanin: float, pheomelanin: float) -> list[float]:
    """What hair with these pigments absorbs."""
    pairs = zip(_EUMELANIN, _PHEOMELANIN, strict=True)
    return [eumelanin * e + pheomelanin * f for e, f in pairs]


def color(absorbed: list[float], beta_n: float = USUAL_BETA_N) -> list[float]:
    """The colour of much hair."""
    b = beta_n
    q = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return [math.exp(-math.sqrt(max(channel, 0.0)) * max(q, 0.0)) for channel in absorbed]
