"""The errors of one picture against a reference that is itself noisy."""

from __future__ import annotations

import numpy as np

from alight.metrics.model import METRICS, MetricModel, Pair


class Figures:
    """Works out the errors of pictures against one reference, by all metrics that studies report.

    Parameters
    ----------
    image, variance : ndarray of float32, shape (h, w, 3)
        The reference and the variance of its own error, whose mean is subtracted from squared
        errors: the expected figures are those of a perfect reference.
    """

    def __init__(self, image: np.ndarray, variance: np.ndarray) -> None:
        self.image = np.asarray(image, np.float32)
        self._metrics = {name: one for name, one in METRICS.items() if one.IN_STUDIES}
        self._weights = {
            name: np.asarray(one.weight(one.example, self.image), np.float32)
            for name, one in self._metrics.items()
            if one.weight is not None
        }
        noise = np.asarray(variance, np.float64)
        self._noise = {name: float((noise * w).mean()) for name, w in self._weights.items()}

    def of(self, picture: np.ndarray, slow: bool = False) -> dict[str, float | None]:
        """Errors of a picture, as a display shows it where a metric asks for that.

        Parameters
        ----------
        picture : ndarray of float32, shape (h, w, 3)
        slow : bool
            Slow metrics take longer than everything else.

        Returns
        -------
        dict of str to float or None
            By the metric's name; None where it is slow and not asked for, or not installed.
        """
        squared = np.square(picture - self.image)
        pair = Pair(picture, self.image, on_display=True)
        return {
            name: _mean(squared * self._weights[name]) - self._noise[name]
            if name in self._weights
            else _value(one, pair, slow)
            for name, one in self._metrics.items()
        }


def _value(metric: MetricModel, pair: Pair, slow: bool) -> float | None:
    if metric.missing() or (metric.SLOW and not slow):
        return None
    return float(metric.evaluate(metric.example, pair))


def _mean(values: np.ndarray) -> float:
    return float(values.mean(dtype=np.float64))
