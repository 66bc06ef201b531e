"""Of a sharp peak of a phase function no digit is lost; the laws are in `alight.laws.phases`."""

import numpy as np

from alight.phases.henyey_greenstein import HenyeyGreenstein, sample


def test_of_a_sharp_peak_no_digit_is_lost():
    """At g = 0.99 half of the light turns by less than 2 degrees."""
    u = np.linspace(0.0, 1.0, 1001)[1:-1]
    g = HenyeyGreenstein(g=0.99).g
    # The textbook's inverse, in float64.
    mu = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
    found = sample(np.float32(g), u.astype(np.float32))
    np.testing.assert_allclose(found, 1.0 - mu, rtol=2e-5, atol=1e-8)
