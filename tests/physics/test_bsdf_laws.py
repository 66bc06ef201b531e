"""Energy, white furnace and reciprocity of every registered BSDF example."""

import numpy as np
import pytest

from alight.bsdfs.flags import DELTA, TRANSMISSION
from alight.bsdfs.uniform_scatter import UniformScatter
from tests.sampling.materials import (
    COSINES,
    EXAMPLES,
    NAMES,
    Material,
    direction,
    each_delta_example,
    each_example,
    has_back,
    is_lossless,
    is_reciprocal,
    unit_interval,
)
from tests.sampling.statistics import SphereCells, unit_vectors

CELLS = SphereCells()


def reflected_power(material, spec, wo):
    """Part of the light that arrives along wo and leaves again, (3,).

    By reciprocity it is also what wo receives under a constant sky. Refracted radiance is
    scaled back by eta^2: power, not radiance, is what is conserved.
    """
    if not material.is_delta(wo):
        return np.array([CELLS.integrals(f).sum() for f in material.evaluate(wo, CELLS.points)[0]])
    _, weight, pdf, flags = material.sample(wo, unit_interval(4096))
    eta = 1.0
    if hasattr(spec, "int_ior"):
        eta = spec.int_ior / spec.ext_ior if wo[2] > 0.0 else spec.ext_ior / spec.int_ior
    scale = np.where(flags & TRANSMISSION, eta * eta, 1.0)
    return (weight * scale * (pdf > 0.0)).mean(1)


@each_example
def test_no_more_light_leaves_than_arrives(spec, cosine):
    material = Material(spec)
    assert np.all(reflected_power(material, spec, direction(cosine)) <= 1.0 + 6e-4)


@pytest.mark.parametrize("cosine", [1.0, 0.9, 0.5, 0.1, 0.01, 1e-3])
@pytest.mark.parametrize(
    "spec", [pytest.param(s, id=n) for s, n in zip(EXAMPLES, NAMES, strict=True) if is_lossless(s)]
)
def test_white_furnace_of_lossless_models(spec, cosine):
    material = Material(spec)
    np.testing.assert_allclose(reflected_power(material, spec, direction(cosine)), 1.0, atol=2e-4)
    if has_back(spec):
        back = reflected_power(material, spec, direction(-cosine))
        np.testing.assert_allclose(back, 1.0, atol=2e-4)


@each_example
def test_values_are_neither_negative_nor_infinite(spec, cosine):
    f_cos, pdf = Material(spec).evaluate(direction(cosine), CELLS.points)
    for values in (f_cos, pdf):
        assert np.all(np.isfinite(values)) and np.all(values >= 0.0)
    _, weight, pdf, _ = Material(spec).sample(direction(cosine), unit_interval(4096))
    for values in (weight, pdf):
        assert np.all(np.isfinite(values)) and np.all(values >= 0.0)


def asymmetry(spec):
    """Largest of |f(wo, wi) - f(wi, wo)| over their sum, for directions on the same side."""
    material = Material(spec)
    wo, wi = unit_vectors(20_000, 1), unit_vectors(20_000, 2)
    wo[2], wi[2] = np.abs(wo[2]), np.abs(wi[2])
    there, _ = material.evaluate(wo, wi)
    back, _ = material.evaluate(wi, wo)
    there, back = there / wi[2], back / wo[2]
    total = there + back
    return np.max(np.abs(there - back)[total > 0.0] / total[total > 0.0], initial=0.0)


@pytest.mark.parametrize("spec", EXAMPLES, ids=NAMES)
def test_reciprocity_is_as_declared(spec):
    # Rounding of the chord between two directions, through an exponent of 300.
    if is_reciprocal(spec):
        assert asymmetry(spec) < 3e-5
    else:
        assert asymmetry(spec) > 0.5, "declared to be not reciprocal, yet it is"


def test_uniform_scatter_is_the_model_that_is_not_reciprocal():
    assert not is_reciprocal(UniformScatter())


@each_delta_example
def test_light_goes_back_the_way_it_came(spec, cosine):
    material, wo = Material(spec), direction(cosine)
    wi, weight, pdf, flags = material.sample(wo, unit_interval(512))
    ok = pdf > 0.0
    if not ok.any():
        return
    assert np.all(flags & DELTA)
    # From the other end, with the random number that chooses the same lobe.
    u = unit_interval(512)
    wo_again, weight_back, pdf_back, flags_back = material.sample(wi, u)
    same = ok & (flags_back == flags)
    assert same.sum() >= 0.99 * ok.sum()
    # At grazing angles the cosine of a refracted ray is the root of a small difference.
    atol = 2e-6 / abs(cosine)
    np.testing.assert_allclose(wo_again[:, same], (wo + 0.0 * wi)[:, same], atol=atol)
    np.testing.assert_allclose(pdf_back[same], pdf[same], atol=atol)
    # f(wo, wi) / eta_i^2 = f(wi, wo) / eta_o^2: the factors 1 / eta^2 of both ways cancel.
    there, back = (weight * pdf)[:, same], (weight_back * pdf_back)[:, same]
    eta2 = 1.0
    if hasattr(spec, "int_ior"):
        eta = spec.int_ior / spec.ext_ior if cosine > 0.0 else spec.ext_ior / spec.int_ior
        eta2 = np.where(flags[same] & TRANSMISSION, eta * eta, 1.0)
    np.testing.assert_allclose(there * eta2, back / eta2, atol=atol)


@pytest.mark.parametrize("cosine", [c for c in COSINES if c > 0.0])
@pytest.mark.parametrize("spec", EXAMPLES, ids=NAMES)
def test_models_without_a_back_are_black_there(spec, cosine):
    if has_back(spec):
        return
    material, below = Material(spec), direction(-cosine)
    assert not material.evaluate(below, CELLS.points)[0].any()
    _, weight, pdf, _ = material.sample(below, unit_interval(512))
    assert not weight.any() and not pdf.any()
    # Nor does light from below come through.
    under = CELLS.points[:, CELLS.points[2] < 0.0]
    assert not material.evaluate(direction(cosine), under)[0].any()
