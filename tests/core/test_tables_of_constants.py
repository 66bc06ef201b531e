"""Tables of constants against what defines them, and against each other where they say the same."""

import numpy as np
import pytest

from alight.bsdfs.conductors import conductor
from alight.bsdfs.disney import thin_film
from alight.core import rng, vec
from alight.formats.materials import cie, metals, spectra
from alight.formats.pbrt import colors
from alight.lights import atmosphere
from alight.metrics import comparison
from alight.outputs import white_balance
from alight.samplers.halton import PRIMES
from alight.samplers.sobol import _second_dimension
from alight.textures import mix
from alight.tone_curves import agx
from lanewise.vec3 import Vec3

# ---------------------------------------------------------------- random numbers


def test_the_bases_of_halton_are_the_first_primes():
    limit = 200
    sieve = np.ones(limit, bool)
    sieve[:2] = False
    for n in range(2, limit):
        sieve[2 * n :: n] = False
    assert tuple(np.flatnonzero(sieve)[: len(PRIMES)].tolist()) == PRIMES


def test_the_second_dimension_of_sobol_is_pascals_triangle():
    """Column k of the generator matrix holds the binomials of k modulo 2 (Lucas: j within k)."""
    words = np.uint32(1) << np.arange(32, dtype=np.uint32)
    columns = np.asarray(_second_dimension(words), np.uint32)
    j = np.arange(32)
    expected = [sum(1 << int(i) for i in j[(j & ~k) == 0]) for k in range(32)]
    assert columns.tolist() == expected


def test_multipliers_of_hashes_are_odd():
    """Products by them can be undone."""
    assert all(m % 2 == 1 and 0 < m < 2**32 for m in (rng.M1, rng.M2, rng.M3, rng.M4))
    assert len({rng.M1, rng.M2, rng.M3, rng.M4}) == 4


# ---------------------------------------------------------------- colours


def white(x, y):
    """XYZ of a chromaticity, Y = 1."""
    return np.array([x / y, 1.0, (1.0 - x - y) / y])


def to_xyz(primaries, of_white):
    """The matrix from a space's linear RGB: its primaries, so bright that they add up to white."""
    columns = np.stack([white(*p) for p in primaries], axis=1)
    return columns * np.linalg.solve(columns, of_white)


D65 = white(0.3127, 0.3290)
REC709 = to_xyz([(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)], D65)
FROM_XYZ = np.linalg.inv(REC709)


@pytest.mark.parametrize("module", [spectra, atmosphere])
def test_xyz_becomes_srgb_by_its_primaries(module):
    matrix = module.TO_SRGB if module is spectra else module._TO_RGB
    # Published with a white of four or of five digits.
    np.testing.assert_allclose(matrix, FROM_XYZ, atol=1.5e-3)
    np.testing.assert_allclose(matrix @ D65, 1.0, atol=6e-4)


def test_linear_srgb_becomes_xyz_by_its_primaries():
    np.testing.assert_allclose(white_balance.XYZ_FROM_RGB, REC709, atol=1e-4)


def test_luminance_is_the_second_row():
    ones = np.eye(3, dtype=np.float32)
    found = [
        [float(vec.luminance(Vec3(*c))) for c in ones],
        [mix._grey(tuple(c)) for c in ones.tolist()],
        comparison.STORED_LUMINANCE,
    ]  # fmt: skip
    for weights in found:
        np.testing.assert_allclose(weights, REC709[1], atol=1e-4)
        assert sum(weights) == pytest.approx(1.0, abs=1e-6)


def test_a_film_without_phase_is_as_bright_as_equal_energy():
    """The response of the eye at no path difference: X = Y = Z = 1, in sRGB."""
    zero = np.float32(0.0)
    found = thin_film._response(zero, Vec3(zero, zero, zero))
    expected = FROM_XYZ @ [1.0, 1.0, 1.0]
    np.testing.assert_allclose([found.x, found.y, found.z], expected, atol=3e-3)


#: Primaries of the spaces that pbrt names, and their whites.
SPACES = {
    "rec2020": ([(0.708, 0.292), (0.170, 0.797), (0.131, 0.046)], (0.3127, 0.3290)),
    "dci-p3": ([(0.680, 0.320), (0.265, 0.690), (0.150, 0.060)], (0.3127, 0.3290)),
    "aces2065-1": ([(0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.0770)], (0.32168, 0.33767)),
}


@pytest.mark.parametrize("name", SPACES)
def test_spaces_of_pbrt_become_srgb_by_their_primaries(name):
    primaries, its_white = SPACES[name]
    cones = white_balance._CONES_FROM_XYZ
    adapted = np.linalg.solve(cones, np.diag((cones @ D65) / (cones @ white(*its_white))) @ cones)
    expected = FROM_XYZ @ adapted @ to_xyz(primaries, white(*its_white))
    np.testing.assert_allclose(colors._SPACES[name], expected, atol=1e-3)
    np.testing.assert_allclose(colors._SPACES[name].sum(axis=1), 1.0, atol=6e-4)
    assert set(SPACES) | {"srgb"} == set(colors.SPACES)


def test_agx_keeps_grey():
    for matrix in (agx.INSET, agx.OUTSET):
        np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=2e-3)
        assert np.linalg.cond(matrix) < 3.0


# ---------------------------------------------------------------- spectra


def test_the_observer_sees_equal_energy_as_grey():
    """By definition the three areas are alike; the table of 5 nm has them to 4e-4."""
    areas = np.trapezoid(cie.OBSERVER, cie.WAVELENGTHS, axis=0)
    np.testing.assert_allclose(areas, spectra.LUMINOUS, rtol=4e-4)
    assert cie.OBSERVER[:, 1].max() == 1.0
    assert cie.WAVELENGTHS[cie.OBSERVER[:, 1].argmax()] == 555.0


def test_the_observers_curves_are_smooth():
    """Each number against the cubic through its four neighbours."""
    y = cie.OBSERVER
    between = (-y[:-4] + 4.0 * y[1:-3] + 4.0 * y[3:-1] - y[4:]) / 6.0
    size = np.maximum(np.maximum(y[1:-3], y[3:-1]), 1e-3)
    assert np.abs((between - y[2:-2]) / size).max() < 0.08


def test_daylight_is_white_and_published_each_ten_nanometres():
    """In between it is linear by definition (CIE 15); its chromaticity is that of D65."""
    middle = 0.5 * (cie.D65[:-2:2] + cie.D65[2::2])
    np.testing.assert_allclose(cie.D65[1::2], middle, rtol=1.2e-5)
    assert cie.D65[cie.WAVELENGTHS == 560.0] == 100.0
    xyz = np.trapezoid(cie.D65[:, None] * cie.OBSERVER, cie.WAVELENGTHS, axis=0)
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), colors._LAMPS["stdillum-D65"], atol=3e-5)
    assert xyz[1] / spectra.LUMINOUS == pytest.approx(spectra.DAYLIGHT, rel=1.2e-3)


def test_plancks_constants_are_those_of_codata():
    h, c, k = 6.62607015e-34, 299792458.0, 1.380649e-23
    assert pytest.approx(2.0 * h * c * c, rel=1e-12) == spectra._FIRST
    assert pytest.approx(h * c / k, rel=1e-12) == spectra._SECOND
    # Wien's and Stefan and Boltzmann's laws.
    wavelengths, radiance = spectra.blackbody(5000.0)
    assert wavelengths[radiance.argmax()] == pytest.approx(2.897771955e-3 / 5000.0 * 1e9, abs=0.5)


METALS = {
    "silver": "Ag", "aluminium": "Al", "gold": "Au", "beryllium": "Be", "chromium": "Cr",
    "copper": "Cu", "mercury": "Hg", "iridium": "Ir", "potassium": "K", "lithium": "Li",
    "molybdenum": "Mo", "sodium": "Na_palik", "niobium": "Nb", "nickel": "Ni_palik",
    "rhodium": "Rh", "tantalum": "Ta", "vanadium": "V_palik", "tungsten": "W",
}  # fmt: skip


@pytest.mark.parametrize("name", METALS)
def test_both_tables_of_metals_agree(name):
    """To the last digit of the shorter one."""
    ours, theirs = conductor.METALS[name], metals.METALS[METALS[name]]
    np.testing.assert_allclose(ours, theirs, atol=1.1e-4)
