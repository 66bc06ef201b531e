"""Glass that disperses light, against Snell's law and quadrature over wavelengths."""

from __future__ import annotations

import numpy as np
import pytest

import alight
from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.dispersion import SUBSTANCES, extremes_of, indices, spread_of
from alight.bsdfs.switch import SPREADS
from alight.compiled.materials import compile_materials
from alight.core.errors import SceneError
from alight.core.registry import specs
from alight.core.wavelengths import (
    DISPERSIVE,
    LINE_C,
    LINE_D,
    LINE_F,
    LONGEST,
    SHORTEST,
    wavelength_at,
    weights_at,
)
from alight.formats import loads
from alight.formats.materials.cie import OBSERVER, WAVELENGTHS
from alight.formats.materials.spectra import TO_SRGB
from alight.laws.statistics import LARGEST_Z
from tests.twin import picture_of

#: Abbe's numbers and indices at the line d, as catalogues and handbooks have them.
KNOWN = {
    "bk7": (1.5168, 64.17), "baf10": (1.67003, 47.11), "fk51a": (1.48656, 84.47),
    "lasf9": (1.85025, 32.17), "sf5": (1.67271, 32.25), "sf10": (1.72828, 28.53),
    "sf11": (1.78472, 25.68), "fused_quartz": (1.4585, 67.8), "sapphire": (1.768, 72.3),
    "diamond": (2.4175, 55.3),
}  # fmt: skip


def test_substances_have_the_indices_of_catalogues():
    assert set(KNOWN) == set(SUBSTANCES)
    for name, (index, abbe) in KNOWN.items():
        d, f, c = indices(name, 1e-3 * np.array([LINE_D, LINE_F, LINE_C]), 1.0)
        assert d == pytest.approx(index, abs=3e-4), name
        assert (d - 1.0) / (f - c) == pytest.approx(abbe, rel=2e-3), name


@pytest.mark.parametrize("dispersion", [*SUBSTANCES, 20.0, (1.5046, 0.0042)])
def test_coefficients_of_kernels_fit(dispersion):
    at = np.linspace(SHORTEST, LONGEST, 97)
    n_d = indices(dispersion, np.array([1e-3 * LINE_D]), 1.6)[0]
    x = (LINE_D / at) ** 2
    a, b, c = spread_of(dispersion, n_d)
    fitted = n_d + a * (x - 1.0) + b * (x**2 - 1.0) + c * (x**3 - 1.0)
    error = np.abs(fitted - indices(dispersion, 1e-3 * at, n_d)).max()
    assert error < (6e-5 if isinstance(dispersion, str) else 1e-12)
    assert extremes_of(dispersion, n_d)[0] < n_d < extremes_of(dispersion, n_d)[1]


def test_wavelengths_add_up_to_white():
    u = ((np.arange(1 << 16) + 0.5) / (1 << 16)).astype(np.float32)
    weights = weights_at(u)
    means = [weight.mean(dtype=float) for weight in (weights.x, weights.y, weights.z)]
    assert means == pytest.approx([1.0] * 3, abs=2e-6)


def test_each_wavelength_has_the_colour_of_the_published_tables():
    u = ((np.arange(1 << 12) + 0.5) / (1 << 12)).astype(np.float32)
    weights, at = weights_at(u), wavelength_at(u).astype(float)
    fine = np.arange(SHORTEST, LONGEST + 1.0)
    xyz = np.array([np.interp(fine, WAVELENGTHS, column) for column in OBSERVER.T])
    matched = TO_SRGB @ xyz
    density = np.gradient(u.astype(float), at)
    for weight, column in zip((weights.x, weights.y, weights.z), matched, strict=True):
        wanted = np.interp(at, fine, column / column.sum())
        # The fit by lobes is that good; red is below 0 in the cyan, which sRGB cannot show.
        assert np.abs(weight * density - wanted).max() < 0.06 * wanted.max()
    assert weights.x.min() < -1.0


#: A wedge whose first face is seen straight on; rays leave it through the second one, bent by the
#: wavelength, to a wall that shines on one side of a line.
PRISM = """
alight: 1
film: {{size: [16, 16], filter: box}}
sampler: independent
camera: {{type: orthographic, height: 0.0001, transform: {{translate: [0, 0, 1]}}}}
integrator: {{type: {kind}, max_depth: 3, russian_roulette: none}}
nodes:
  prism:
    shape:
      type: mesh
      vertices: [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [{x0}, -1, {z0}], [{x1}, -1, {z1}],
                 [{x1}, 1, {z1}], [{x0}, 1, {z0}]]
      faces: [[0, 1, 2], [0, 2, 3], [4, 7, 6], [4, 6, 5]]
    bsdf: {glass}
  wall:
    shape: rectangle
    transform: [{{scale: 50}}, {{translate: [{edge}, 0, -10]}}]
    light: {{type: area, radiance: 1}}
"""
#: Angle of the second face, and its distance behind the first.
APEX, THICK = np.radians(25.0), 0.6


def _expected(dispersion, edge):
    """RGB that the camera sees of light right of the edge, by Snell's and Fresnel's laws."""
    u = ((np.arange(20000) + 0.5) / 20000).astype(np.float32)
    weights, at = weights_at(u), wavelength_at(u).astype(float)
    n = indices(dispersion, 1e-3 * at, 1.0)
    first = 1.0 - ((n - 1.0) / (n + 1.0)) ** 2
    sine = n * np.sin(APEX)
    out, cos_i, cos_t = np.arcsin(sine), np.cos(APEX), np.sqrt(1.0 - sine**2)
    s = ((n * cos_i - cos_t) / (n * cos_i + cos_t)) ** 2
    p = ((cos_i - n * cos_t) / (cos_i + n * cos_t)) ** 2
    # The second face is crossed at (0, -THICK), the wall at z = -10.
    x = np.tan(out - APEX) * (10.0 - THICK)
    passed = first * (1.0 - 0.5 * (s + p)) * (x > edge)
    return np.array([np.mean(w * passed) for w in (weights.x, weights.y, weights.z)])


def _scene(dispersion, edge, kind="path"):
    # The second face through (0, -THICK), its normal turned by the apex towards -x or +x.
    slope = np.tan(APEX)
    corners = {"x0": -1.0, "z0": -THICK + slope, "x1": 1.0, "z1": -THICK - slope}
    glass = f"{{type: dielectric, ext_ior: 1, dispersion: {dispersion}}}"
    return loads(PRISM.format(kind=kind, glass=glass, edge=edge + 50.0, **corners))


def _agrees(pixels, expected):
    """Whether pixels, which all see the same, have the mean that is expected in each channel."""
    pixels = pixels.reshape(-1, 3).astype(float)
    error = pixels.std(0, ddof=1) / np.sqrt(len(pixels))
    assert np.abs((pixels.mean(0) - expected) / error).max() < LARGEST_Z
    return error.max()


@pytest.mark.parametrize("edge", [-20.0, 4.15, 4.2])
def test_a_prism_against_quadrature(edge):
    film = alight.render(_scene("sf11", edge), spp=256, seed=3)
    assert _agrees(film.image, _expected("sf11", edge)) < 0.01


def test_a_prism_beside_media():
    pixels = picture_of(_scene("sf11", 4.2, "volpath"), 4)
    assert _agrees(pixels, _expected("sf11", 4.2)) < 0.1


def test_white_glass_is_white():
    # All light comes through a ball in a white furnace, whatever the wavelength.
    scene = loads("""
alight: 1
film: {size: [8, 8], filter: box}
camera: {fov: 5, transform: {translate: [0, 0, 4]}}
sampler: independent
environment: {type: constant, radiance: 1}
integrator: {type: path, light_sampling: bsdf, russian_roulette: none, max_depth: 8}
nodes:
  ball: {shape: sphere, bsdf: {type: rough_dielectric, dispersion: 20, alpha: 0.001}}
""")
    assert _agrees(picture_of(scene, 16), 1.0) < 0.1


@pytest.mark.parametrize("model", ["dielectric", "rough_dielectric", "principled"])
def test_only_what_disperses_light_is_followed_by_wavelengths(model):
    """Scenes without it have the kernels, and so the bits, that they had."""
    spec = specs("bsdfs")[model]
    glass = {"transmission": 1.0} if model == "principled" else {}
    for given, disperses in ((0.0, False), (30.0, True)):
        _, names, _ = compile_materials([spec(dispersion=given, **glass)])
        assert (DISPERSIVE in names) == disperses
    if glass:
        for plain in ({}, {"transmission": 1.0, "thin": True}):
            assert DISPERSIVE not in compile_materials([spec(dispersion=30.0, **plain)])[1]


def test_parts_of_a_blend_disperse_light_too():
    blend = specs("bsdfs")["blend"](
        bsdfs=(Dielectric(dispersion="bk7"), specs("bsdfs")["diffuse"]())
    )
    for material, spreads in ((blend, True), (Dielectric(), False)):
        tables, _, _ = compile_materials([material])
        assert bool(tables.info.array[1] & SPREADS) == spreads


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"dispersion": "sf12"}, 'did you mean "sf11"?'),
        ({"dispersion": 0.5}, "must be in [1, 1000], or 0 (Abbe)"),
        ({"dispersion": [1, 2, 3]}, "got [1, 2, 3]"),
        ({"dispersion": [1.5, 0.9]}, "dispersion makes them 3.23611 to 7.73269"),
        ({"dispersion": [1, 1, 1, 0.3, 0.3, 0.3]}, "no index at some wavelengths"),
        ({"dispersion": "bk7", "int_ior": 1.6}, "leave out one of them"),
    ],
)
def test_what_is_wrong_is_said(given, words):
    with pytest.raises(SceneError) as error:
        Dielectric(**given)
    assert words in str(error.value)


def test_indices_follow_from_coefficients():
    assert Dielectric(dispersion="sf11").int_ior == pytest.approx(1.78472, abs=1e-5)
    assert Dielectric(dispersion="sf11").replaced(ext_ior=1.3).int_ior > 1.78
    assert Dielectric(dispersion=(1.5, 0.01)).int_ior == pytest.approx(1.5 + 0.01 / 0.5875618**2)
    assert Dielectric(dispersion=30.0, int_ior=1.7).int_ior == 1.7


def test_integrators_that_see_no_wavelengths_say_so():
    text = PRISM.format(
        kind="bidirectional", glass="{type: dielectric, dispersion: 30}", edge=0, x0=-1, z0=-1,
        x1=1, z1=-1,
    ).replace("russian_roulette: none", "heuristic: power")  # fmt: skip
    with pytest.raises(SceneError, match=r"does not see that materials disperse light.*use path"):
        loads(text)
