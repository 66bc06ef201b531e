"""The hair model where its laws do not look: met beside its axis, and its parts one by one."""

import numpy as np
import pytest
from scipy import special

from alight.bsdfs.fibres import hair
from alight.bsdfs.fibres.lobes import scaled_bessel
from alight.laws.materials import Material
from alight.laws.statistics import SIDES, sphere_cells

CELLS = sphere_cells(SIDES[1])


def from_above(h: float, height: float) -> np.ndarray:
    """A direction that meets the fibre at h, at that sine of theta_o."""
    cosine = np.sqrt(1.0 - height**2)
    return np.array([height, -h * cosine, np.sqrt(1.0 - h**2) * cosine], np.float32)[:, None]


@pytest.mark.parametrize("h", [-0.95, 0.5])
@pytest.mark.parametrize("height", [-0.7, 0.9])
def test_a_fibre_that_absorbs_nothing_sends_out_all_light_wherever_it_is_met(h, height):
    material = Material(hair.Hair(sigma_a=0.0, beta_m=0.4, beta_n=0.4))
    f_cos, pdf = material.evaluate(from_above(h, height), CELLS.points)
    assert CELLS.integrals(f_cos[0]).sum() == pytest.approx(1.0, abs=1e-3)
    assert CELLS.integrals(pdf).sum() == pytest.approx(1.0, abs=1e-3)


def test_light_is_mirrored_at_the_surface_where_it_is_met():
    """Without scales, p = 0 lies around the mirror image of wo about the normal."""
    smooth = hair.Hair(sigma_a=1e3, beta_m=0.05, beta_n=0.05, alpha=0.0)
    for h in (-0.6, 0.2, 0.7):
        wo = from_above(h, 0.3)
        f_cos, _ = Material(smooth).evaluate(wo, CELLS.points)
        brightest = CELLS.points[:, f_cos[0].argmax()]
        mirrored = np.array([-wo[0, 0], -wo[1, 0], wo[2, 0]])
        assert brightest @ mirrored > 0.99


def test_the_scaled_bessel_function_is_that_of_scipy():
    x = np.concatenate([np.linspace(0.0, 8.0, 400), np.geomspace(8.0, 1e4, 100)]).astype(np.float32)
    np.testing.assert_allclose(scaled_bessel(x), special.ive(0, x.astype(float)), rtol=6e-7)


def test_colors_come_back_from_their_absorption():
    """The fit of Chiang et al. 2016 has one absorption for a colour; more pigment absorbs more."""
    assert hair.Hair(color=(1.0, 1.0, 1.0)).absorption == (0.0, 0.0, 0.0)
    red, green, blue = hair.Hair(color=(0.8, 0.5, 0.2)).absorption
    assert red < green < blue
    assert hair.Hair().absorption == pytest.approx(hair.Hair(eumelanin=1.3).absorption)
    assert hair.Hair(pheomelanin=1.0).absorption == pytest.approx(hair.PHEOMELANIN)


#: (wo, wi, f cos) by Mitsuba 3.9 for sigma_a 0.1, 0.5, 1, roughness 0.3 along and 0.4 around the
#: fibre, scales tilted by 3 degrees and an index of 1.55.
MITSUBA = (
    ((-0.510972, -0.844954, 0.157991), (0.34597, 0.93392, 0.089992),
     (0.543256, 0.536907, 0.536223)),
    ((-0.453917, -0.644882, 0.614887), (0.791192, 0.132032, -0.597145),
     (0.0114373, 0.00527065, 0.00204757)),
    ((-0.510899, 0.852832, 0.107979), (-0.829689, -0.039985, -0.556792),
     (0.0007522, 6.65452e-05, 4.29389e-06)),
    ((-0.589075, -0.456058, 0.667085), (0.68209, -0.07801, -0.727096),
     (1.41181, 0.62172, 0.223071)),
    ((0.217073, 0.440147, 0.871292), (-0.249895, -0.9536, -0.167929),
     (0.0119822, 0.00565539, 0.0023549)),
)  # fmt: skip


@pytest.mark.parametrize(("wo", "wi", "expected"), MITSUBA)
def test_values_are_mitsubas(wo, wi, expected):
    """But for the ten terms that its series for I_0 ends after."""
    spec = hair.Hair(sigma_a=(0.1, 0.5, 1.0), beta_m=0.3, beta_n=0.4, alpha=3.0)
    columns = (np.array(w, np.float32)[:, None] for w in (wo, wi))
    f_cos, _ = Material(spec).evaluate(*columns)
    np.testing.assert_allclose(f_cos[:, 0], expected, rtol=4e-3)


def test_what_a_fibre_absorbs_follows_its_pigments_or_its_colour():
    """Chiang et al. 2016: pigments of section 6.1 as pbrt has them, colours by equation 9."""
    brown = np.array([0.419, 0.697, 1.37])
    red = np.array([0.187, 0.4, 1.05])
    np.testing.assert_allclose(hair.Hair().absorption, 1.3 * brown)
    np.testing.assert_allclose(hair.Hair(eumelanin=0.3).absorption, 0.3 * brown)
    np.testing.assert_allclose(hair.Hair(pheomelanin=0.5).absorption, 0.5 * red)
    both = hair.Hair(eumelanin=0.3, pheomelanin=0.5)
    np.testing.assert_allclose(both.absorption, 0.3 * brown + 0.5 * red)
    color = np.array([0.8, 0.5, 0.2])
    for around in (0.1, 0.3, 0.9):
        powers = around ** np.arange(6)
        fit = powers @ [5.969, -0.215, 2.532, -10.73, 5.574, 0.245]
        for along in (0.2, 0.7):
            fibre = hair.Hair(color=tuple(color), beta_m=along, beta_n=around)
            np.testing.assert_allclose(fibre.absorption, (np.log(color) / fit) ** 2, rtol=1e-6)


def test_lobes_are_as_wide_as_their_roughness_says():
    """Chiang et al. 2016, equations 7 and 8, at rough fibres, where only their last terms count."""
    for m, n in ((0.05, 0.3), (0.5, 0.95), (0.9, 0.05), (1.0, 1.0)):
        packed: dict = {}

        class Packer:
            def numbers(self, name, *values, packed=packed):
                packed[name] = values

        hair.pack(hair.Hair(beta_m=m, beta_n=n), Packer())
        along = 0.726 * m + 0.812 * m * m + 3.7 * np.exp(20.0 * np.log(m))
        around = 0.265 * n + 1.194 * n * n + 5.372 * np.exp(22.0 * np.log(n))
        assert packed["variance"] == pytest.approx((along * along,))
        assert packed["scale"] == pytest.approx((0.6266570686577501 * around,))
