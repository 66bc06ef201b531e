"""Numbers as a paper prints them: true minus signs, common powers of ten, aligned decimals."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from alight.metrics.estimate import Estimate

#: Shown for an unknown number.
UNKNOWN = "–"

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

#: Columns whose numbers differ by more than this are written with a power of ten each.
_WIDEST = 1e4

#: Powers of ten of numbers that are written out.
_SMALLEST_PLAIN, _LARGEST_PLAIN = -1, 4


def superscript(exponent: int) -> str:
    """Raise a whole number.

    Examples
    --------
    >>> superscript(-12)
    '⁻¹²'
    """
    return str(exponent).translate(_SUPERSCRIPTS)


def fixed(value: float, decimals: int) -> str:
    """Write a number with the given decimals, thin spaces between thousands.

    Examples
    --------
    >>> fixed(-1.25, 1)
    '−1.2'
    """
    # Adding 0 turns -0.0, which rounding leaves, into 0.0.
    rounded = round(value, decimals) + 0.0 if math.isfinite(value) else value
    return f"{rounded:,.{decimals}f}".replace(",", "\u2009").replace("-", "−")


def number(value: float | None, digits: int = 3) -> str:
    """Write one number with the given significant digits.

    Examples
    --------
    >>> number(0.0123), number(1.5e-7), number(1234.5)
    ('0.0123', '1.50 × 10⁻⁷', '1\u2009234')
    """
    if value is None or math.isnan(value):
        return UNKNOWN
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if -4 <= exponent <= 5:
        return fixed(value, max(digits - 1 - exponent, 0))
    mantissa = f"{value / 10.0**exponent:.{digits - 1}f}".replace("-", "−")
    return f"{mantissa} × 10{superscript(exponent)}"


def interval(estimate: Estimate | None, digits: int = 3) -> str:
    """Write a value and its interval in words of their own: ``3.21 (2.90 to 3.55)``."""
    if estimate is None or math.isnan(estimate.value):
        return "unknown"
    text = number(estimate.value, digits)
    if math.isnan(estimate.low) or math.isnan(estimate.high):
        return text
    return f"{text} ({number(estimate.low, digits)} to {number(estimate.high, digits)})"


def p_value(p: float | None) -> str:
    """Write a probability: two digits, never smaller than it can be trusted."""
    if p is None or math.isnan(p):
        return UNKNOWN
    if p < 0.001:
        return "< 0.001"
    return f"{p:.3f}" if p < 0.0995 else f"{p:.2f}"


@dataclass(frozen=True)
class Column:
    """How all numbers of a column are written, so that their decimals align.

    Attributes
    ----------
    power : int
        All numbers are divided by 10^power; the head of the column says so.
    decimals : int or None
        None: each number has its own power of ten.
    """

    power: int
    decimals: int | None

    @classmethod
    def of(cls, values: Iterable[float | None], digits: int = 3, plain: bool = False) -> Column:
        """Choose the power and the decimals that show the smallest number with enough digits.

        Parameters
        ----------
        values : iterable of float
            NaN and None are passed over.
        digits : int, default 3
            Significant digits of the largest number; the smallest has at least one less.
        plain : bool, default False
            Never divide by a power of ten.
        """
        sizes = [abs(v) for v in values if v is not None and math.isfinite(v) and v != 0.0]
        if not sizes:
            return cls(0, 0)
        low, high = min(sizes), max(sizes)
        if high > _WIDEST * low and not plain:
            return cls(0, None)
        top, bottom = math.floor(math.log10(high)), math.floor(math.log10(low))
        # Powers of a thousand, as engineers are used to.
        power = 0 if plain or _SMALLEST_PLAIN <= top <= _LARGEST_PLAIN else 3 * (top // 3)
        wanted = max(digits - 1 - (top - power), digits - 2 - (bottom - power), 0)
        return cls(power, min(wanted, 6))

    @property
    def unit(self) -> str:
        """What the head of the column adds: ``× 10⁻³``, or nothing."""
        return f"× 10{superscript(self.power)}" if self.power else ""

    def text(self, value: float | None) -> str:
        """One number of the column."""
        if value is None or not math.isfinite(value) or self.decimals is None:
            return number(value)
        return fixed(value / 10.0**self.power, self.decimals)

    def bounds(self, estimate: Estimate | None) -> str:
        """Write the interval of an estimate, in brackets; nothing where it is unknown or exact."""
        if estimate is None or math.isnan(estimate.low) or math.isnan(estimate.high):
            return ""
        if estimate.low == estimate.value == estimate.high:
            return ""
        return f"[{self.text(estimate.low)}, {self.text(estimate.high)}]"
