"""The errors of one picture against a reference that is itself noisy."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.metrics import flip
from alight.metrics.relmse import LITERATURE_EPSILON, default_epsilon
from alight.metrics.smape import EPSILON as SMAPE_EPSILON


class Figures:
    """Works out the errors of pictures against one reference.

    Parameters
    ----------
    image, variance : ndarray of float32, shape (h, w, 3)
        The reference and the variance of its own error, whose mean is subtracted from squared
        errors: the expected figures are those of a perfect reference.
    """

    def __init__(self, image: np.ndarray, variance: np.ndarray) -> None:
        self.image = np.asarray(image, np.float32)
        square = self.image**2
        # A black picture has no relative error; any epsilon gives the same 0.
        epsilon = default_epsilon(self.image) or 1.0
        self._weights = {
            "relmse": (1.0 / (square + np.float32(epsilon))).astype(np.float32),
            "relmse_literature": (1.0 / (square + np.float32(LITERATURE_EPSILON))),
        }
        self._absolute = np.abs(self.image) + np.float32(SMAPE_EPSILON)
        noise = np.asarray(variance, np.float64)
        self._noise = {"mse": float(noise.mean())}
        for name, weight in self._weights.items():
            self._noise[name] = float((noise * weight).mean())

    def of(self, picture: np.ndarray, with_flip: bool = False) -> dict[str, Any]:
        """Errors of a picture.

        Parameters
        ----------
        picture : ndarray of float32, shape (h, w, 3)
        with_flip : bool
            FLIP takes longer than everything else.

        Returns
        -------
        dict of str to float or None
            "mse", "relmse", "relmse_literature", "smape", "flip"; the last is None where it is not
            asked for or the package is not installed.
        """
        difference = picture - self.image
        squared = difference * difference
        result: dict[str, Any] = {"mse": _mean(squared) - self._noise["mse"]}
        for name, weight in self._weights.items():
            result[name] = _mean(squared * weight) - self._noise[name]
        result["smape"] = _mean(np.abs(difference) / (np.abs(picture) + self._absolute))
        result["flip"] = None
        if with_flip and flip.is_available():
            result["flip"] = flip.flip(picture, self.image, "ldr").mean
        return result


def _mean(values: np.ndarray) -> float:
    return float(values.mean(dtype=np.float64))
