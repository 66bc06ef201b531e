"""The ledger of a picture: everything in it that is biased, and by how much.

A picture without entries has the right mean in every pixel: only noise is in it, and the error says
how much. An entry is made as soon as something biased is switched on; its effect is added where it
has been measured.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Self


class Bias(NamedTuple):
    """One cause of a bias.

    Attributes
    ----------
    cause : str
        For programs: "depth cap", "adaptive criterion", "stopped at an error", "denoiser",
        "invalid samples", "saturated values", "light paths" or "caustics".
    text : str
        What it is, for people.
    effect : float or None
        Change of the picture's mean, as a share of what it would be; negative: light is missing.
        None where it has not been measured.
    error : float or None
        Standard error of `effect`.
    """

    cause: str
    text: str
    effect: float | None = None
    error: float | None = None

    @property
    def line(self) -> str:
        """The text with its effect."""
        if self.effect is None:
            return self.text
        if not self.effect and not self.error:
            return f"{self.text}: no effect seen"
        return f"{self.text}: {_measured(100.0 * self.effect, self.error)} % of the light"

    def relative(self, mean: float) -> Self:
        """From a change of radiance to a share of what `mean` would be without it."""
        if self.effect is None:
            return self
        whole = mean - self.effect
        if not whole > 0.0:
            return self._replace(effect=None, error=None)
        error = None if self.error is None else self.error / whole
        return self._replace(effect=self.effect / whole, error=error)

    def state(self) -> dict[str, Any]:
        """Plain JSON."""
        return {name: _finite(value) for name, value in self._asdict().items()}

    @classmethod
    def restored(cls, state: Mapping[str, Any]) -> Self:
        """From plain JSON."""
        return cls(state["cause"], state["text"], state["effect"], state["error"])


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _measured(percent: float, error: float | None) -> str:
    """A change in percent with its standard error, a share, to the same decimals."""
    if not error:
        shown = f"{percent:+.2g}" + ("" if error is None else " ± 0")
    else:
        # Two digits of the error: more of the value would say nothing.
        decimals = max(0, 1 - math.floor(math.log10(100.0 * error)))
        value, sign = round(percent, decimals), "+"
        if not value:
            value, sign = 0.0, ""
        shown = f"{value:{sign}.{decimals}f} ± {100.0 * error:.{decimals}f}"
    return shown.replace("-", "−")


def counted(invalid: int, saturated: int, samples: int) -> tuple[Bias, ...]:
    """The entries of samples that were NaN or infinite, and of values that were too large."""
    found = []
    if invalid:
        share = 100.0 * invalid / max(int(samples), 1)
        text = f"NaN or infinite samples were added as black ({share:.2g} % of them)"
        found.append(Bias("invalid samples", text))
    if saturated:
        text = f"{saturated} sample values were cut to 2^36, so that light is missing"
        found.append(Bias("saturated values", text))
    return tuple(found)


def joined(ledgers: Iterable[Iterable[Bias]]) -> tuple[Bias, ...]:
    """The entries of several films of one picture, each once, with the surest of its effects."""
    best: dict[tuple[str, str], Bias] = {}
    for bias in (entry for ledger in ledgers for entry in ledger):
        key = bias.cause, bias.text
        if key not in best or _doubt(bias) < _doubt(best[key]):
            best[key] = bias
    return tuple(best.values())


def _doubt(bias: Bias) -> float:
    if bias.effect is None:
        return math.inf
    return 1e300 if bias.error is None else bias.error
