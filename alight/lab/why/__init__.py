"""Why is this picture noisy? The parts of the variance, and what was measured to lower it."""

from alight.lab.why.explanation import Explanation, why
from alight.lab.why.shares import Part, Shares, shares_of
from alight.lab.why.trials import Trial, try_alternatives

__all__ = ["Explanation", "Part", "Shares", "Trial", "shares_of", "try_alternatives", "why"]
