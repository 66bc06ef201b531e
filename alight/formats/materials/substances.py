"""Coefficients of well-known media, per millimetre, red, green and blue.

Source: Jensen et al., A practical model for subsurface light transport, SIGGRAPH 2001, figure 5,
and equation 15 for the diffuse reflectance.
"""

from __future__ import annotations

import math

Triple = tuple[float, float, float]

#: What they scatter, as if to all sides alike, and what they absorb.
SUBSTANCES: dict[str, tuple[Triple, Triple]] = {
    "Apple": ((2.29, 2.39, 1.97), (0.0030, 0.0034, 0.046)),
    "Chicken1": ((0.15, 0.21, 0.38), (0.015, 0.077, 0.19)),
    "Chicken2": ((0.19, 0.25, 0.32), (0.018, 0.088, 0.20)),
    "Cream": ((7.38, 5.47, 3.15), (0.0002, 0.0028, 0.0163)),
    "Ketchup": ((0.18, 0.07, 0.03), (0.061, 0.97, 1.45)),
    "Marble": ((2.19, 2.62, 3.00), (0.0021, 0.0041, 0.0071)),
    "Potato": ((0.68, 0.70, 0.55), (0.0024, 0.0090, 0.12)),
    "Skimmilk": ((0.70, 1.22, 1.90), (0.0014, 0.0025, 0.0142)),
    "Skin1": ((0.74, 0.88, 1.01), (0.032, 0.17, 0.48)),
    "Skin2": ((1.09, 1.59, 1.79), (0.013, 0.070, 0.145)),
    "Spectralon": ((11.6, 20.4, 14.9), (0.0, 0.0, 0.0)),
    "Wholemilk": ((2.55, 3.21, 3.77), (0.0011, 0.0024, 0.014)),
}


def diffuse_reflectance(absorbed: float, scattered: float, eta: float) -> float:
    """Part of the light that a half space of a medium gives back."""
    if scattered <= 0.0:
        return 0.0
    albedo = scattered / (scattered + absorbed)
    inside = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta
    a = (1.0 + inside) / (1.0 - inside)
    s = math.sqrt(3.0 * (1.0 - albedo))
    return 0.5 * albedo * (1.0 + math.exp(-4.0 / 3.0 * a * s)) * math.exp(-s)
