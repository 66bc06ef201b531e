"""Laws of tone curves: black stays black, more light is never darker, grey stays grey.

Each law is a function of an example and raises `BrokenLawError`. They hold for what a display
shows: the curve's values, cut to [0, 1].
"""

from __future__ import annotations

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.spec import ToneCurve
from alight.core.srgb import encode_srgb
from alight.laws.report import demand, demand_close
from alight.tone_curves.model import TONE_CURVES

#: Linear values from the last bit of a display to the largest that a curve is given.
LEVELS = np.concatenate([np.logspace(-5, 6, 400), np.logspace(6, 30, 25)])

#: Half a step of a display with 8 bits, encoded: less is not shown.
UNSEEN = 0.5 / 255.0

#: Colours at the corners of the cube, and some inside.
COLORS = np.concatenate(
    [np.indices((2, 2, 2)).reshape(3, -1).T[1:], np.random.default_rng(1).random((24, 3))]
).astype(np.float64)


def shown(spec: ToneCurve, rgb: np.ndarray) -> np.ndarray:
    """What a display shows of linear values, linear too."""
    return np.clip(TONE_CURVES[spec.type_name()].apply(spec, rgb), 0.0, 1.0)


def greys(levels: np.ndarray) -> np.ndarray:
    """The same in all channels, (..., 3)."""
    return levels[..., None] * np.ones(3)


def black_is_shown_black(spec: ToneCurve) -> None:
    """f(0) = 0."""
    demand_close(shown(spec, np.zeros((1, 3))), 0.0, "black", atol=1e-9)


def values_are_finite(spec: ToneCurve) -> None:
    """Values up to 1e30 have finite ones, of the same shape."""
    for rgb in (greys(LEVELS), LEVELS[:, None, None] * COLORS):
        found = TONE_CURVES[spec.type_name()].apply(spec, rgb)
        demand(np.shape(found) == rgb.shape, f"the shape {rgb.shape} becomes {np.shape(found)}")
        demand(np.isfinite(found), "a value is not finite")


def brighter_grey_is_shown_brighter(spec: ToneCurve) -> None:
    """Greys grow without a step back, from black to within a hundredth of white."""
    found = shown(spec, greys(LEVELS))[:, 1]
    demand(np.diff(found) >= -1e-12, "a brighter grey is shown darker")
    demand(found[-1] > 0.99, f"the brightest grey is shown as {found[-1]:.4g}")


def brighter_colours_are_shown_brighter(spec: ToneCurve) -> None:
    """With the exposure, the luminance of what is shown of a colour does not fall visibly.

    A curve that mixes channels may give back a trace of it: AgX's way back gives its blue a
    luminance of -0.009, so that yellow falls by up to 0.0003 where only blue is not full yet.
    """
    seen = encode_srgb(np.minimum(shown(spec, LEVELS[:, None, None] * COLORS) @ LUMINANCE, 1.0))
    fall = np.maximum.accumulate(seen, axis=0) - seen
    demand(fall < UNSEEN, "with more light a colour is shown darker")


def greys_stay_grey(spec: ToneCurve) -> None:
    """Channels that are alike stay alike, to half a step of 8 bits."""
    found = encode_srgb(shown(spec, greys(LEVELS)))
    demand_close(found, greys(found.mean(axis=-1)), "a channel of a grey", atol=UNSEEN)


def pixels_do_not_see_each_other(spec: ToneCurve) -> None:
    """A picture in parts is the picture."""
    picture = LEVELS[::8, None, None] * COLORS
    parts = np.stack([shown(spec, row) for row in picture])
    demand_close(parts, shown(spec, picture), "a picture in parts", rtol=1e-12)


def the_inverse_undoes_the_curve(spec: ToneCurve) -> None:
    """Where an inverse is declared and nothing is cut, it leads back to the light of the scene."""
    invert = TONE_CURVES[spec.type_name()].invert
    if invert is None:
        return
    rgb = np.logspace(-4, 0, 40)[:, None, None] * COLORS
    found = TONE_CURVES[spec.type_name()].apply(spec, rgb)
    inside = (found < 1.0).all(axis=-1)
    demand(inside.any(), "everything is cut")
    demand_close(invert(spec, found)[inside], rgb[inside], "the light", rtol=1e-9, atol=1e-12)


LAWS = (
    black_is_shown_black,
    values_are_finite,
    brighter_grey_is_shown_brighter,
    brighter_colours_are_shown_brighter,
    greys_stay_grey,
    pixels_do_not_see_each_other,
    the_inverse_undoes_the_curve,
)
