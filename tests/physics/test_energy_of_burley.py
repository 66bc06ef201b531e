"""The page of `burley` says how much light it makes; the table is what is measured."""

from __future__ import annotations

import re

import numpy as np
import pytest

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.disney import burley, burley_thin
from alight.bsdfs.disney.burley import Burley, burley_facets
from alight.bsdfs.disney.burley_thin import BurleyThin
from alight.bsdfs.matte.diffuse import Diffuse
from alight.cameras.pinhole import Pinhole
from alight.lab.info import energy_notes
from alight.laws.materials import Material, direction
from alight.scene import Node, Scene, flatten
from alight.shapes.sphere import Sphere

SIDE = 128
ANGLES = tuple(map(int, re.findall(r"(\d+)°", burley.__doc__ or "")))
ROWS = re.findall(r"^\| (\w+) ([\d.]+) \|(.*)\|$", burley.__doc__ or "", re.MULTILINE)


def sent_out(spec, degrees):
    """Part of the light of an even environment that a surface sends out: the mean weight."""
    rng = np.random.default_rng(1)
    strata = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE))).reshape(2, -1)
    u = np.vstack([rng.random(SIDE**2), (strata + rng.random(strata.shape)) / SIDE])
    u = np.minimum(u.astype(np.float32), np.float32(1.0 - 2.0**-24))
    _, weight, _, _ = Material(spec).sample(direction(np.cos(np.radians(degrees))), u)
    return float(weight[0].mean(dtype=float))


@pytest.mark.parametrize(("name", "value", "cells"), ROWS, ids=lambda text: text.strip("| "))
def test_the_table_is_what_is_measured(name, value, cells):
    spec = Burley(base_color=1.0, **{name: float(value)})
    said = [float(cell) for cell in cells.split("|")]
    assert len(said) == len(ANGLES) == 6
    found = [sent_out(spec, angle) for angle in ANGLES]
    np.testing.assert_allclose(found, said, atol=0.012)


@pytest.mark.parametrize("model", [burley, burley_thin], ids=["body", "sheet"])
def test_no_more_is_sent_out_than_is_said(model):
    spec = type(model.EXAMPLES[0])(base_color=1.0, sheen=1.0)
    at_most = [
        sent_out(spec.replaced(roughness=roughness, flatness=flatness), angle)
        for roughness in (0.0, 0.5, 1.0)
        for flatness in (0.0, 1.0)
        for angle in (75, 85, 89)
    ]
    assert 0.98 * model.MOST_SENT_OUT < max(at_most) < 1.01 * model.MOST_SENT_OUT


def test_info_says_which_models_make_light_wherever_they_are():
    inside = Blend(bsdfs=(Burley(), BurleyThin()))
    for bsdf, names in ((inside, ["burley", "burley_thin"]), (Diffuse(), [])):
        scene = Scene(camera=Node(camera=Pinhole()), nodes={"a": Node(shape=Sphere(), bsdf=bsdf)})
        assert [text.split()[0] for text in energy_notes(flatten(scene))] == names


def test_facets_are_stretched_along_the_tangent():
    roughness = np.array([0.3, 0.8], np.float32)
    for anisotropic in (0.0, 0.5, 1.0):
        facets = burley_facets(roughness, np.float32(anisotropic))
        aspect = np.sqrt(1.0 - 0.9 * anisotropic)
        np.testing.assert_allclose(facets.alpha_x, roughness**2 / aspect, rtol=1e-6)
        np.testing.assert_allclose(facets.alpha_y, roughness**2 * aspect, rtol=1e-6)
