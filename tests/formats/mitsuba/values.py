"""What both programs are asked for: materials as Mitsuba writes them, and directions.

`make_values.py` stores what Mitsuba says, `test_values.py` compares.
"""

from __future__ import annotations

import numpy as np

ROUGHNESSES = (0.3, 0.6, 1.0)
#: A picture of heights, and where it is looked up; v grows downwards, as in Mitsuba.
HEIGHTS = np.array([[0.5 * x + 0.25 * y + 0.3 * (x == 2) for x in range(4)] for y in range(4)])
PLACES = ((0.4, 0.45), (0.55, 0.3), (0.7, 0.7))


def floats(**numbers: float) -> str:
    """Parameters that are one number."""
    return "".join(f'<float name="{name}" value="{x}"/>' for name, x in numbers.items())


def colour(r: float, g: float, b: float) -> str:
    """The base colour."""
    return f'<rgb name="base_color" value="{r}, {g}, {b}"/>'


ORANGE, GREEN = colour(0.9, 0.5, 0.1), colour(0.64, 0.81, 0.49)
METAL = '<rgb name="eta" value="1.66, 0.88, 0.52"/><rgb name="k" value="9.22, 6.27, 4.84"/>'
# Of Beckmann's facets Mitsuba's masking is a fit that is off by 0.4 %.
METAL += '<string name="distribution" value="ggx"/>'
BRUSHED = f'<bsdf type="roughconductor">{METAL}{floats(alpha_u=0.3, alpha_v=0.6)}</bsdf>'
MATTE = '<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.4, 0.2"/></bsdf>'


def bent(x: float, y: float, z: float, inside: str) -> tuple[str, str]:
    """A normal map of one normal."""
    texture = f'<vector name="value" value="{x}, {y}, {z}"/>'
    texture = f'<texture name="normalmap" type="rawconstant">{texture}</texture>'
    return "normalmap", texture + inside


#: Name: (type, content) of a BSDF.
MATERIALS: dict[str, tuple[str, str]] = {
    "plain": ("principled", ORANGE),
    "brushed metal": ("principled", ORANGE + floats(metallic=1, roughness=0.6, anisotropic=0.7)),
    "cloth": (
        "principled",
        GREEN
        + floats(roughness=0.8, sheen=0.6, sheen_tint=0.5, flatness=0.5, spec_tint=0.4, eta=1.4),
    ),
    "lacquer": (
        "principled",
        ORANGE + floats(metallic=0.3, roughness=0.5, clearcoat=1, clearcoat_gloss=0.1),
    ),
    "glass": (
        "principled",
        GREEN + floats(spec_trans=0.8, metallic=0.2, roughness=0.6, clearcoat=0.5, sheen=0.3),
    ),
    "thin glass": (
        "principledthin",
        GREEN + floats(spec_trans=0.7, roughness=0.6, anisotropic=0.5, eta=1.33, spec_tint=0.5),
    ),
    "leaf": (
        "principledthin",
        GREEN + floats(diff_trans=0.8, roughness=0.7, sheen=0.4, sheen_tint=0.5, flatness=0.5),
    ),
    "bent matte": bent(0.7, 0.4, 0.9, MATTE),
    "bent metal": bent(0.35, 0.6, 0.95, BRUSHED),
    "very bent": bent(0.9, 0.3, 0.75, MATTE),
    "brushed": ("roughconductor", METAL + floats(alpha_u=0.25, alpha_v=0.05)),
}
#: Likewise, for those that alight's own `principled` must agree with.
SHARED: dict[str, tuple[str, str]] = {
    f"{name} {roughness}": ("principled", content + floats(roughness=roughness))
    for name, content in (
        ("metal", ORANGE + floats(metallic=1)),
        ("plastic", colour(0, 0, 0) + floats(eta=1.5)),
        ("glass", GREEN + floats(spec_trans=1, eta=1.5)),
    )
    for roughness in ROUGHNESSES
}


def directions() -> tuple[np.ndarray, np.ndarray]:
    """(wo, wi), each (3, 240) float32: all sides, a third of them near mirrored ones."""
    w = np.random.default_rng(7).standard_normal((2, 3, 240))
    w[1, :, ::3] = w[0, :, ::3] * [[-1], [-1], [1]] + 0.2 * w[1, :, ::3]
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    w = w.astype(np.float32)
    return w[0], w[1]
