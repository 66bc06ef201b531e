"""Conservation of energy: what a surface reflects in all ways is at most what arrives."""

from __future__ import annotations

from alight.core.field_types import Triple
from alight.core.spec import Texture


def energy_problem(**parts: Triple | Texture | str) -> str | None:
    """Say so if reflectances, each at its largest, add up to more than 1 in a channel.

    Names of textures count as 0 here; they are checked again once the scene resolves them.
    """
    colors = [part.maximum() if isinstance(part, Texture) else part for part in parts.values()]
    known = [color for color in colors if not isinstance(color, str)]
    sums = [sum(channel) for channel in zip(*known, strict=True)]
    # A few rounding errors of sums such as 0.7 + 0.2 + 0.1 are no offence.
    if max(sums, default=0.0) <= 1.0 + 1e-9:
        return None
    shown = ", ".join(f"{channel:g}" for channel in sums)
    return f"{' + '.join(parts)} must be at most 1 in each channel, got ({shown})"
