"""The lobes of a fibre: along it, d'Eon's; around it, a logistic distribution that is cut off.

Sources: those of `alight.bsdfs.fibres.hair`.
"""

from __future__ import annotations

from alight.core.constants import INV_TWO_PI, PI, TWO_PI
from alight.core.maths import exp, log
from lanewise.jit import kernel
from lanewise.simd import absolute, maximum, minimum, rint, sqrt, where


@kernel(strict=True)
def scaled_bessel(x):
    """exp(-x) I_0(x) for x >= 0, within 6e-7."""
    near = minimum(x * (1.0 / 3.75), 1.0)
    t = near * near
    small = 1.0 + t * (3.5156229 + t * (3.0899424 + t * (1.2067492 + t * (
        0.2659732 + t * (0.0360768 + t * 0.0045813)))))  # fmt: skip
    far = maximum(x, 3.75)
    t = 3.75 / far
    large = 0.39894228 + t * (0.01328592 + t * (0.00225319 + t * (-0.00157565 + t * (
        0.00916281 + t * (-0.02057706 + t * (0.02635537 + t * (
            -0.01647633 + t * 0.00392377)))))))  # fmt: skip
    return where(x < 3.75, small * exp(-minimum(x, 3.75)), large / sqrt(far))


@kernel(strict=True)
def longitudinal(sin_o, cos_o, sin_i, cos_i, v):
    """M, a density per unit of sin(theta_i); its formula is in `alight.bsdfs.fibres.hair`."""
    inverse = 1.0 / v
    rise, width = sin_i + sin_o, cos_i - cos_o
    d = rise * rise + width * width
    return (
        scaled_bessel(cos_i * cos_o * inverse)
        * exp(-0.5 * inverse * d)
        * (inverse / (1.0 - exp(-2.0 * inverse)))
    )


@kernel(strict=True)
def logistic(x, s):
    """N: density of an angle x from the middle, in [-pi, pi]."""
    x = x - TWO_PI * rint(x * INV_TWO_PI)
    e = exp(-absolute(x) / s)
    edge = exp(-PI / s)
    # Between -pi and pi lies tanh(pi / 2 s) of it.
    return e * (1.0 + edge) / (s * (1.0 + e) * (1.0 + e) * (1.0 - edge))


@kernel(strict=True)
def sample_logistic(u, s):
    """An angle with that density."""
    edge = exp(-PI / s)
    low = edge / (1.0 + edge)
    y = minimum(maximum(low + u * (1.0 - 2.0 * low), 1e-7), 1.0 - 1e-7)
    return minimum(maximum(s * log(y / (1.0 - y)), -PI), PI)
