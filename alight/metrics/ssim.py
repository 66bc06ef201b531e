"""SSIM, structural similarity: alike in brightness, contrast and structure.

    SSIM = (2 m_a m_b + C1) (2 s_ab + C2) / ((m_a^2 + m_b^2 + C1) (s_a^2 + s_b^2 + C2))

with means, variances and covariance in a Gaussian window of 11x11 pixels and sigma 1.5,
C1 = 0.01^2, C2 = 0.03^2; 1 for equal pictures. Wang, Bovik, Sheikh and Simoncelli 2004, "Image
quality assessment: from error visibility to structural similarity", section III.
"""

from __future__ import annotations

import numpy as np

#: Pixels on either side of the centre of the window, and its standard deviation.
_RADIUS, _SIGMA = 5, 1.5

#: Pixels on the side of the window: no picture has an SSIM below that.
SMALLEST = 2 * _RADIUS + 1

#: Keep flat and black windows from dividing by nothing.
_C1, _C2 = 0.01**2, 0.03**2


def ssim_map(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Structural similarity around every pixel whose window lies within the picture.

    Parameters
    ----------
    a, b : ndarray, shape (h, w)
        Display-encoded grey values in [0, 1], h and w >= 11.

    Returns
    -------
    ndarray of float64, shape (h - 10, w - 10)
        In [-1, 1].

    Raises
    ------
    ValueError
        If the shapes differ, or are no planes of at least 11x11.
    """
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if a.shape != b.shape:
        raise ValueError(f"pictures must have one shape, got {a.shape} and {b.shape}")
    if a.ndim != 2 or min(a.shape) < SMALLEST:
        raise ValueError(f"need planes of at least 11x11 pixels, got {a.shape}")
    mean_a, mean_b = _window(a), _window(b)
    variances = _window(a * a) + _window(b * b) - mean_a**2 - mean_b**2
    covariance = _window(a * b) - mean_a * mean_b
    brightness = (2.0 * mean_a * mean_b + _C1) / (mean_a**2 + mean_b**2 + _C1)
    return brightness * (2.0 * covariance + _C2) / (variances + _C2)


def ssim(a: np.ndarray, b: np.ndarray) -> float:
    """Mean of `ssim_map`: 1 for equal pictures."""
    return float(ssim_map(a, b).mean())


def _window(plane: np.ndarray) -> np.ndarray:
    """Average in the Gaussian window, rows then columns."""
    weights = np.exp(-0.5 * (np.arange(-_RADIUS, _RADIUS + 1) / _SIGMA) ** 2)
    weights /= weights.sum()
    h, w = plane.shape[0] - 2 * _RADIUS, plane.shape[1] - 2 * _RADIUS
    rows = sum((weights[i] * plane[i : i + h] for i in range(len(weights))), np.zeros(1))
    return sum((weights[i] * rows[:, i : i + w] for i in range(len(weights))), np.zeros(1))
