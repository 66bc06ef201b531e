"""Sobotka's AgX: bright colours turn paler, as on film, instead of clipping to pure red or yellow.

Source: Sobotka 2022, github.com/sobotka/AgX; the curve by the polynomial of Wrensch 2023, "Minimal
AgX implementation", iolite-engine.com.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.spec import ToneCurve

#: Mixes the channels so that none stays alone, and back (rows act on column vectors).
INSET = np.array(
    [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]
)
OUTSET = np.linalg.inv(INSET)

#: Stops, log2 of the linear value, that become 0 and 1.
DARKEST, BRIGHTEST = -12.47393, 4.026069

#: The sigmoid over these stops, highest power first.
CURVE = np.array([15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232])


class AgX(ToneCurve):
    """Bright colours turn pale, as on film."""

    type: Literal["agx"] = "agx"


EXAMPLES = (AgX(),)


def apply(spec, rgb):
    """Sobotka's AgX without a look; its curve ends in display values of gamma 2.2."""
    stops = np.log2(np.maximum(rgb @ INSET.T, 2.0**DARKEST))
    position = np.clip((stops - DARKEST) / (BRIGHTEST - DARKEST), 0.0, 1.0)
    display = np.polyval(CURVE, position) @ OUTSET.T
    return np.maximum(display, 0.0) ** 2.2
