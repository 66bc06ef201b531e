"""Elementary functions for kernels: polynomials, so that they run on lanes without a C library.

============================  ===========================  =======================================
function                      range                        largest error
============================  ===========================  =======================================
`sincos`                      abs(x) <= 1e4                1e-7 absolute
`sincos_2pi`                  0 <= u <= 1                  1.2e-7 absolute
`exp`                         any (0 below -86.6)          1.1 ulp
`expm1`                       -86 <= x <= 88               3.5 ulp
`log`                         x >= 2^-126 (-inf below)     1 ulp
`log1p`                       x > -1                       2.5 ulp
`pow`                         x >= 0                       (2 + 1.25 abs(y log x)) 2^-23 rel.
`arccos`                      -1 <= x <= 1                 1.5 ulp
`arcsin`                      -1 <= x <= 1                 2.5 ulp
`arctan2`                     finite                       2 ulp
============================  ===========================  =======================================

Arguments are first reduced to a short interval around zero; there a polynomial with the least
largest error is evaluated by Horner's rule. The coefficients come from a weighted least-squares fit
whose weights were raised where the error was large until it was level (Lawson's method), then
rounded to float32 one after the other, lowest power first, the others fitted again each time.

The kernels are strict and use `fma`: range reduction fails if operations are reordered.

Sources: Muller, Elementary Functions, 3rd edition (2016), chapters 3 and 11 (range reduction);
Higham, Accuracy and Stability of Numerical Algorithms (2002), section 1.14.1 (`log1p`).
"""

from __future__ import annotations

from alight.core.constants import HALF_PI, INFINITY, PI, TWO_PI
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    bits_float,
    copysign,
    float_bits,
    fma,
    maximum,
    minimum,
    rint,
    sqrt,
    to_float,
    to_uint,
    where,
)

# pi / 2 = high + low, high being the nearest float32.
_HALF_PI_HIGH, _HALF_PI_LOW = 1.57079637050628662109375, -4.37113900018624283e-8
_TWO_OVER_PI = 0.636619772367581343
# ln 2 = high + low, high with 9 bits: its product with an exponent is exact.
_LN2_HIGH, _LN2_LOW = 0.693359375, -2.12194440054690583e-4
_LOG2_E = 1.44269504088896341
_SMALLEST_NORMAL = 2.0**-126
# exp(x) stays a normal number above the first and overflows beyond the second.
_EXP_LOWEST, _EXP_HIGHEST = -86.6, 88.8


@kernel(strict=True)
def sincos_octant(x):
    """(sin x, cos x) for |x| <= pi / 4."""
    t = x * x
    s = fma(t, fma(t, -0.00019518788, 0.008332192), -0.16666655)
    c = fma(t, fma(t, 2.4430668e-05, -0.0013887301), 0.041666646)
    return fma(x * t, s, x), fma(t * t, c, fma(t, -0.5, 1.0))


@kernel(strict=True)
def _turn(s, c, quarter):
    """(sin, cos) of an angle that is `quarter` (u32) right angles larger."""
    odd = (quarter & 1) != 0
    sin_negative, cos_negative = (quarter & 2) != 0, ((quarter + 1) & 2) != 0
    sine, cosine = where(odd, c, s), where(odd, s, c)
    return where(sin_negative, -sine, sine), where(cos_negative, -cosine, cosine)


@kernel(strict=True)
def sincos(x):
    """(sin x, cos x), x in radians."""
    a = absolute(x)
    k = rint(a * _TWO_OVER_PI)
    r = fma(k, -_HALF_PI_LOW, fma(k, -_HALF_PI_HIGH, a))
    s, c = sincos_octant(r)
    s, c = _turn(s, c, to_uint(k))
    return where(x < 0.0, -s, s), c


@kernel(strict=True)
def sincos_2pi(u):
    """(sin 2 pi u, cos 2 pi u): a point of the unit circle from u in [0, 1]."""
    k = rint(4.0 * u)
    # u - k / 4 is exact.
    s, c = sincos_octant(TWO_PI * fma(k, -0.25, u))
    return _turn(s, c, to_uint(k))


@kernel(strict=True)
def _exp_reduced(x):
    """(r, k, q): x = r + k ln 2 with |r| <= ln(2) / 2, and e^r = 1 + r + r^2 q."""
    k = rint(x * _LOG2_E)
    r = fma(k, -_LN2_LOW, fma(k, -_LN2_HIGH, x))
    q = fma(r, fma(r, 0.0013820734, 0.008368677), 0.041668266)
    return r, k, fma(r, fma(r, q, 0.16666521), 0.49999994)


@kernel(strict=True)
def exp(x):
    """e^x; results below 2^-125 become 0."""
    # Clamped this way round, NaN stays NaN.
    r, k, q = _exp_reduced(maximum(_EXP_LOWEST, minimum(_EXP_HIGHEST, x)))
    # 2^k in two factors, because 2^128 is no float32.
    power = bits_float(to_uint(k + 126.0) << 23)
    y = (fma(r * r, q, r) + 1.0) * power * 2.0
    return where(x < _EXP_LOWEST, 0.0, y)


@kernel(strict=True)
def expm1(x):
    """e^x - 1 without cancellation near zero."""
    t = x * x
    p = fma(x, fma(x, 0.00019944267, 0.0013932674), 0.008333208)
    p = fma(x, fma(x, p, 0.04166649), 0.16666667)
    near_zero = fma(t * x, p, fma(t, 0.5, x))
    return where(absolute(x) < 0.34, near_zero, exp(x) - 1.0)


@kernel(strict=True)
def log(x):
    """Natural logarithm; minus infinity below 2^-126 (numbers that small count as zero)."""
    # x = m 2^e with m in [sqrt(1/2), sqrt(2)): on the bits, so that the exponent splits there.
    bits = float_bits(x) + (0x3F800000 - 0x3F3504F3)
    e = to_float(bits >> 23) - 127.0
    f = bits_float((bits & 0x7FFFFF) + 0x3F3504F3) - 1.0
    p = fma(f, fma(f, -0.0786252, 0.1288341), -0.13128395)
    p = fma(f, fma(f, p, 0.14180873), -0.16624561)
    p = fma(f, fma(f, p, 0.20002304), -0.2500081)
    p = fma(f, p, 0.33333316)
    t = f * f
    y = fma(t, -0.5, fma(e, _LN2_LOW, f * t * p))
    y = fma(e, _LN2_HIGH, f + y)
    y = where(x < INFINITY, y, x)  # infinity and NaN as they are
    return where(x < _SMALLEST_NORMAL, -INFINITY, y)


@kernel(strict=True)
def log1p(x):
    """log(1 + x) without cancellation near zero, for x > -1."""
    y = 1.0 + x
    # y is rounded, and log y / (y - 1) hardly changes over that distance.
    d = y - 1.0
    return where(d == 0.0, x, log(y) * x / where(d == 0.0, 1.0, d))


@kernel(strict=True)
def pow(x, y):
    """x^y for x >= 0; x^0 = 1."""
    return where(y == 0.0, 1.0, exp(y * log(x)))


@kernel(strict=True)
def _arcsin_parts(x):
    """(big, arcsin s) with s = sqrt((1 - |x|) / 2) where big, that is |x| > 1/2, and |x| elsewhere.

    Near 1 the half angle, arccos a = 2 arcsin sqrt((1 - a) / 2), does not cancel.
    """
    a = minimum(absolute(x), 1.0)
    big = a > 0.5
    t = where(big, 0.5 * (1.0 - a), a * a)
    s = where(big, sqrt(t), a)
    p = fma(t, fma(t, 0.042158306, 0.024184778), 0.04546915)
    p = fma(t, fma(t, p, 0.074953094), 0.16666752)
    return big, fma(s * t, p, s)


@kernel(strict=True)
def arccos(x):
    """The angle in [0, pi] with cosine x; |x| <= 1 (beyond it, the end of the range)."""
    big, y = _arcsin_parts(x)
    near_end = where(x < 0.0, fma(-2.0, y, PI), 2.0 * y)
    return where(big, near_end, HALF_PI - copysign(y, x))


@kernel(strict=True)
def arcsin(x):
    """The angle in [-pi/2, pi/2] with sine x; |x| <= 1 (beyond it, the end of the range)."""
    big, y = _arcsin_parts(x)
    return copysign(where(big, fma(-2.0, y, HALF_PI), y), x)


@kernel(strict=True)
def arctan2(y, x):
    """The angle of the point (x, y) against the x axis, in [-pi, pi]; 0 at the origin."""
    a, b = absolute(x), absolute(y)
    low, high = minimum(a, b), maximum(a, b)
    q = where(high > 0.0, low / where(high > 0.0, high, 1.0), 0.0)
    t = q * q
    p = fma(t, fma(t, -0.001782832, 0.01086871), -0.031097002)
    p = fma(t, fma(t, p, 0.057881393), -0.08399306)
    p = fma(t, fma(t, p, 0.109508805), -0.14264016)
    p = fma(t, fma(t, p, 0.1999853), -0.333333)
    angle = fma(q * t, p, q)
    angle = where(b > a, HALF_PI - angle, angle)
    angle = where(x < 0.0, PI - angle, angle)
    return copysign(angle, y)
