"""Hable's curve of "Uncharted 2", per channel: a toe, a straight part and a soft shoulder.

Source: Hable 2010, "Filmic tonemapping operators", filmicworlds.com.
"""

from __future__ import annotations

from typing import Literal

from alight.core.spec import ToneCurve

#: Linear value that becomes white, and what exposure is multiplied by before.
WHITE, BIAS = 11.2, 2.0

SHOULDER, LINEAR, ANGLE, TOE, NUMERATOR, DENOMINATOR = 0.15, 0.50, 0.10, 0.20, 0.02, 0.30


class Hable(ToneCurve):
    """Look of film, with soft highlights."""

    type: Literal["hable"] = "hable"


EXAMPLES = (Hable(),)


def apply(spec, rgb):
    """Hable's curve, scaled so that 11.2 becomes white, after his exposure bias of 2."""
    return _curve(BIAS * rgb) / _curve(WHITE)


def _curve(x):
    top = x * (SHOULDER * x + ANGLE * LINEAR) + TOE * NUMERATOR
    bottom = x * (SHOULDER * x + LINEAR) + TOE * DENOMINATOR
    return top / bottom - NUMERATOR / DENOMINATOR
