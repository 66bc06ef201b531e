"""pbrt's roughness -> alpha of Trowbridge and Reitz' facets (GGX).

``roughness`` is remapped to alpha unless the file asks for alpha itself.
"""

from __future__ import annotations

import math

from alight.formats.pbrt.context import Data
from alight.formats.pbrt.making import Making

#: pbrt treats what is smoother as a mirror.
SMOOTH = 1e-3


def alpha_of(roughness: float, old: bool) -> float:
    """Remap a roughness in [0, 1] to alpha, as pbrt 4 (a root) or pbrt 3 (a polynomial) does."""
    if not old:
        return math.sqrt(max(roughness, 0.0))
    x = math.log(max(roughness, 1e-3))
    return 1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))


def alphas(m: Making, default: float, prefix: str = "") -> tuple[float | str, float | str]:
    """Ask for the roughness along u and v; alpha, below `SMOOTH` for a mirror."""
    old = m.context.old
    both = m.number(f"{prefix}roughness", default)
    remapped = m.p.flag("remaproughness", True)
    found: list[float | str] = []
    ends: dict[str, str] = {}
    for axis in "uv":
        value = m.number(f"{prefix}{axis}roughness", None)
        value = both if value is None else value
        value = default if value is None else value
        if isinstance(value, str):
            if remapped:
                m.warn("has a texture of roughness, which is taken as alpha without remapping")
            # One texture for both stays one.
            if value not in ends:
                ends[value] = m.capped(value)
            value = ends[value]
        elif old and value == 0.0:
            # A mirror in pbrt 3, whatever the polynomial says.
            value = 0.0
        elif remapped:
            value = alpha_of(value, old)
        if isinstance(value, float) and value > 1.0:
            m.warn(f"is rougher than can be: alpha {value:.3g} became 1")
        found.append(min(max(value, 0.0), 1.0) if isinstance(value, float) else value)
    names = [f"{prefix}{axis}roughness" for axis in ("", "u", "v")]
    for parameter in (m.p.named[name] for name in names if m.p.has(name)):
        if parameter.kind == "float" and float(parameter.values[0]) < 0.0:
            m.p.report.error(parameter, f"must be >= 0, got {float(parameter.values[0]):g}")
    return found[0], found[1]


def is_smooth(*found: float | str) -> bool:
    """Whether pbrt shows a mirror."""
    return all(isinstance(alpha, float) and alpha < SMOOTH for alpha in found)


def facets(u: float | str, v: float | str) -> Data:
    """The keys of a rough surface."""
    keys: Data = {"distribution": "ggx"}
    u, v = (max(a, 1e-4) if isinstance(a, float) else a for a in (u, v))
    return keys | ({"alpha": u} if u == v else {"alpha_u": u, "alpha_v": v})


def one_alpha(m: Making, u: float | str, v: float | str) -> float | str:
    """One roughness for both directions."""
    if u == v or isinstance(u, str) or isinstance(v, str):
        return u
    m.warn("is rougher in one direction: the geometric mean is taken")
    return math.sqrt(u * v)
