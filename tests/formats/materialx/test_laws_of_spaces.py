"""Colour spaces of MaterialX, from their primaries, white and curve.

Source: ITU-R BT.709, SMPTE EG 432-1 (P3, with white D65), Adobe RGB (1998), ACES S-2014-004 (AP1),
SMPTE ST 2065-1 (AP0), ITU-R BT.2020;
SMPTE RP 177:1993 for the matrices, and Lam (1985) for ACES' white.
"""

import numpy as np
import pytest

from alight.formats.materialx.spaces import SPACES, to_linear

D65 = (0.3127, 0.3290)
#: x and y of red, green, blue and white.
PRIMARIES = {
    "rec709": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, *D65),
    "p3": (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, *D65),
    "adobe": (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, *D65),
    "ap1": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),
    "ap0": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770, 0.32168, 0.33767),
    "rec2020": (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, *D65),
}
CONES = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def srgb(x):
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def power(exponent):
    return lambda x: x**exponent


CURVES = {
    "linear": power(1.0), "srgb": srgb, "1.8": power(1.8), "2.2": power(2.2), "2.4": power(2.4),
    "adobe": power(563.0 / 256.0),
}  # fmt: skip
#: Name -> primaries and curve.
MEANT = {
    "lin_rec709": ("rec709", "linear"), "lin_rec709_scene": ("rec709", "linear"),
    "lin_srgb": ("rec709", "linear"), "linear": ("rec709", "linear"), "": ("rec709", "linear"),
    "data": ("rec709", "linear"), "none": ("rec709", "linear"), "raw": ("rec709", "linear"),
    "Raw": ("rec709", "linear"), "sRGB": ("rec709", "srgb"), "srgb": ("rec709", "srgb"),
    "srgb_rec709_scene": ("rec709", "srgb"), "srgb_texture": ("rec709", "srgb"),
    "sRGB - Texture": ("rec709", "srgb"), "Utility - sRGB - Texture": ("rec709", "srgb"),
    "ACEScg": ("ap1", "linear"), "acescg": ("ap1", "linear"), "lin_ap1": ("ap1", "linear"),
    "lin_ap1_scene": ("ap1", "linear"), "g22_ap1": ("ap1", "2.2"), "adobergb": ("adobe", "adobe"),
    "lin_adobergb": ("adobe", "linear"), "g18_rec709": ("rec709", "1.8"),
    "g22_rec709": ("rec709", "2.2"), "rec709_display": ("rec709", "2.4"),
    "lin_displayp3": ("p3", "linear"), "srgb_displayp3": ("p3", "srgb"),
}  # fmt: skip
#: A picture's own, which no colour has.
OF_PICTURES = {"auto"}


def to_xyz(name):
    x, y = np.array(PRIMARIES[name]).reshape(4, 2).T
    xyz = np.stack([x / y, np.ones(4), (1.0 - x - y) / y])
    return xyz[:, :3] * np.linalg.solve(xyz[:, :3], xyz[:, 3])


def to_srgb(name):
    """The matrix from primaries to linear sRGB, white kept."""
    xyz, ours = to_xyz(name), to_xyz("rec709")
    gains = (CONES @ ours.sum(axis=1)) / (CONES @ xyz.sum(axis=1))
    return np.linalg.solve(ours, np.linalg.solve(CONES, gains[:, None] * (CONES @ xyz)))


@pytest.mark.parametrize("name", sorted({*SPACES} - OF_PICTURES))
def test_colours_are_those_of_their_primaries_and_curve(name):
    primaries, curve = MEANT[name]
    rgb = np.random.default_rng(len(name)).uniform(0.2, 1.0, (50, 3))
    wanted = np.maximum(CURVES[curve](rgb) @ to_srgb(primaries).T, 0.0)
    np.testing.assert_allclose(to_linear(rgb, name), wanted, atol=2e-3)
