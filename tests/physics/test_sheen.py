"""Sheen: the lobe is its formula, and its table of albedos is the lobe's."""

from types import SimpleNamespace

import numpy as np
import pytest

from alight.bsdfs.disney.sheen import LEAST_ROUGHNESS, STEPS, sheen_albedo, sheen_f_cos, sheen_rows
from alight.compiled.program import Program
from alight.core.vec import Vec3
from alight.laws.statistics import unit_vectors
from lanewise.jit import instantiate
from lanewise.view import View


def rows_of(roughness):
    return SimpleNamespace(curves=View(sheen_rows(roughness)), row=np.uint32(0))


def by_formula(roughness, wo, wi):
    """f cos theta_i, but for s, in float64."""
    alpha = max(roughness, LEAST_ROUGHNESS) ** 2
    half = wo + wi
    half = half / np.linalg.norm(half, axis=0)
    sine = np.sqrt(np.maximum(1.0 - half[2] ** 2, 0.0))
    d = (2.0 + 1.0 / alpha) * sine ** (1.0 / alpha) / (2.0 * np.pi)
    return d * wi[2] / (4.0 * (wo[2] + wi[2] - wo[2] * wi[2]))


@pytest.mark.parametrize("roughness", [0.05, 0.15, 0.3, 0.6, 1.0])
def test_the_lobe_is_its_formula_and_its_table_holds_its_integral(roughness):
    rows = rows_of(roughness)
    run, albedo = (
        instantiate(root, Program(), compiled=False) for root in (sheen_f_cos, sheen_albedo)
    )
    wo, wi = (np.abs(unit_vectors(20_000, seed)) for seed in (1, 2))
    clear = np.minimum(wo[2], wi[2]) > 1e-2
    wo, wi = wo[:, clear], wi[:, clear]
    scale = float(sheen_rows(roughness)[STEPS])
    assert scale >= 1.0
    found = run(rows, np.float32(roughness), Vec3(*wo), Vec3(*wi))
    wanted = by_formula(roughness, wo.astype(float), wi.astype(float)) / scale
    # The sine of an angle near 0 loses digits, where the lobe is nearly 0.
    np.testing.assert_allclose(found, wanted, 1e-3, 1e-5 * wanted.max())
    # Stratified cosines and angles around the normal.
    n = 400
    z, phi = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * 2.0 * np.pi)
    z = z.ravel() ** 2
    all_wi = np.stack([np.sqrt(1 - z * z) * np.cos(phi.ravel()),
                       np.sqrt(1 - z * z) * np.sin(phi.ravel()), z])  # fmt: skip
    for cosine in (0.1, 0.5, 0.9):
        viewer = np.array([[np.sqrt(1.0 - cosine**2)], [0.0], [cosine]]) * np.ones(n * n)
        value = run(
            rows, np.float32(roughness), *(Vec3(*v.astype(np.float32)) for v in (viewer, all_wi))
        )
        integral = 2.0 * np.pi * (value * 2.0 * np.sqrt(z)).mean()
        told = float(albedo(rows, np.float32(cosine)))
        # The table is interpolated between 48 cosines, which is coarse where the lobe is a line.
        assert integral == pytest.approx(told, abs=2e-3)


@pytest.mark.parametrize("roughness", [0.15, 0.6])
def test_at_the_cosines_of_the_table_the_albedo_is_what_stands_there(roughness):
    albedo = instantiate(sheen_albedo, Program(), compiled=False)
    cosines = (np.arange(STEPS) / (STEPS - 1.0)) ** 2
    found = albedo(rows_of(roughness), cosines.astype(np.float32))
    np.testing.assert_allclose(found, sheen_rows(roughness)[:STEPS], rtol=1e-4)
