"""Hair of other renderers: the ranges of what their files say of it, and what is usual."""

from __future__ import annotations

#: Roughness along and around a fibre, and the tilt of its scales, degrees, where a file is silent.
BETA, TILT = 0.3, 2.0

#: Less roughness than this is not rendered: lobes would be too narrow to be found.
LEAST_BETA = 0.05

#: A colour of 0 would absorb without end.
LEAST_COLOR = 1e-4

#: Tilt in degrees, and pigment that leaves no light in any channel.
MOST_TILT, MOST = 20.0, 1e3


def roughness(beta: float) -> float:
    """A roughness in [0, 1] as alight takes it."""
    return max(beta, LEAST_BETA)
