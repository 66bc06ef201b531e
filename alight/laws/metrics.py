"""Laws of metrics: nothing between equal pictures, more between those that differ more.

Each law is a function of an example and raises `BrokenLawError`. A metric that needs a package
which is not installed obeys all of them.
"""

from __future__ import annotations

import numpy as np

from alight.laws.report import demand, demand_close
from alight.metrics.model import METRICS, Metric, MetricModel, Pair


def _model(spec: Metric) -> MetricModel:
    return METRICS[spec.type_name()]


def _is_missing(spec: Metric) -> bool:
    return bool(_model(spec).missing())


def _value(spec: Metric, image: np.ndarray, reference: np.ndarray, **how) -> float:
    return _model(spec).evaluate(spec, Pair(image, reference, **how))


def picture(seed: int = 1) -> np.ndarray:
    """A smooth scene with an edge, (24, 32, 3) in (0, 1)."""
    y, x = np.mgrid[0:24, 0:32] / 32.0
    hues = np.random.default_rng(seed).uniform(0.2, 1.0, 3)
    plane = 0.15 + 0.5 * x + 0.2 * np.sin(9.0 * y) ** 2 * (x > 0.4)
    return plane[..., None] * hues


def noise(seed: int = 2) -> np.ndarray:
    """Of mean 0 and deviation 1 in each pixel and channel, like `picture` in shape."""
    return np.random.default_rng(seed).standard_normal((24, 32, 3))


def equal_pictures_have_no_error(spec: Metric) -> None:
    """On a display or not, at any exposure."""
    if _is_missing(spec):
        return
    for how in ({}, {"on_display": True}, {"exposure": 2.0}):
        # SSIM of a picture with itself is 1 but for the last bits.
        found = _value(spec, picture(), picture(), **how)
        demand_close(found, 0.0, "of a picture with itself", atol=1e-9)


def more_noise_is_more_error(spec: Metric) -> None:
    """The same noise, 1.5 times as strong, is never less; values are finite and not negative."""
    if _is_missing(spec):
        return
    found = [_value(spec, picture() + s * noise(), picture()) for s in 0.01 * 1.5 ** np.arange(8)]
    demand(np.isfinite(found), f"a value is not finite: {found}")
    demand(np.array(found) > 0.0, f"noise has no error: {found}")
    demand(np.diff(found) > 0.0, f"more noise has less error: {found}")


def pictures_may_be_turned(spec: Metric) -> None:
    """Upside down, mirrored, or on its side, a picture has the same error."""
    if _is_missing(spec):
        return
    image, reference = picture() + 0.1 * noise(), picture()
    straight = _value(spec, image, reference)
    for turn in (np.flipud, np.fliplr, lambda one: np.transpose(one, (1, 0, 2))):
        turned = (np.ascontiguousarray(turn(one)) for one in (image, reference))
        demand_close(_value(spec, *turned), straight, "turned", rtol=1e-4)


def what_is_bounded_is_never_above_one(spec: Metric) -> None:
    """Black against white, white against black, and negative pixels too."""
    if _is_missing(spec) or not _model(spec).BOUNDED:
        return
    for image, reference in ((0.0, 1e6), (1e6, 0.0), (-1.0, 1.0)):
        planes = (np.full((16, 16, 3), one) for one in (image, reference))
        found = _value(spec, *planes)
        demand(0.0 <= found <= 1.0 + 1e-6, f"{image:g} against {reference:g} gives {found:.6g}")


def the_weights_are_those_of_the_squares(spec: Metric) -> None:
    """Where weights are declared, it is the mean of weighted squared errors."""
    weight = _model(spec).weight
    if weight is None:
        return
    image, reference = picture() + 0.1 * noise(), picture()
    found = float(np.mean(weight(spec, reference) * (image - reference) ** 2))
    demand_close(found, _value(spec, image, reference), "by its weights", rtol=1e-5)


def the_map_has_its_mean(spec: Metric) -> None:
    """Where a map is declared, it is as large as the picture, and its mean is the metric."""
    error_map = _model(spec).error_map
    if error_map is None or _is_missing(spec):
        return
    for on_display in (False, True):
        pair = Pair(picture() + 0.1 * noise(), picture(), on_display=on_display)
        found = error_map(spec, pair)
        demand(found.shape == (24, 32), f"the map's shape is {found.shape}")
        expected = _model(spec).evaluate(spec, pair)
        demand_close(np.array(found.mean(dtype=np.float64)), expected, "by its map", rtol=1e-4)


LAWS = (
    equal_pictures_have_no_error,
    more_noise_is_more_error,
    pictures_may_be_turned,
    what_is_bounded_is_never_above_one,
    the_weights_are_those_of_the_squares,
    the_map_has_its_mean,
)
