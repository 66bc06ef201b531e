"""Paths from both ends as advice: where they are tried, and what they are measured by."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.lab.why import trials
from alight.lab.why.shares import shares_of
from alight.lab.why.trials import FilmSums, alternatives, try_alternatives
from alight.lab.why.words import ranked
from alight.laws.scene.pictures import Sums, small
from alight.scene import flatten
from tests.lab.test_why import CAMERA, FLOOR

FROSTED = (
    CAMERA
    + "integrator: {type: path, max_depth: 8}\n"
    + "bsdfs: {frost: {type: rough_dielectric, alpha: 0.3}}\nnodes:"
    + FLOOR
    + """  ball: {shape: {type: sphere, center: [0, 1, 0], radius: 0.3}, bsdf: frost}
  lamp:
    shape: {type: sphere, center: [0, 1, 0], radius: 0.05}
    light: {type: area, radiance: 500}
"""
)


@pytest.mark.parametrize("integrator", ["type: path, hide_emitters: true", "type: direct"])
def test_another_picture_is_no_alternative(integrator):
    text = FROSTED.replace("type: path, max_depth: 8", integrator)
    assert not any(".type=" in change for change in alternatives(loads(text, "lamp")))


def test_caustics_that_no_path_finds_are_another_picture():
    lamp = FROSTED.replace("{type: rough_dielectric, alpha: 0.3}", "{type: dielectric}")
    point = lamp[: lamp.index("  lamp:")] + "  point: {light: {type: point}}\n"
    assert "integrator.type=bidirectional" in alternatives(loads(lamp, "lamp"))
    assert "integrator.type=bidirectional" not in alternatives(loads(point, "point"))


def test_sums_of_films_are_those_of_tiles():
    arm = compile_scene(flatten(small(alight.load("cornell-box"), size=16)))
    sums, film_sums = Sums(arm).of(5, 8, 4), FilmSums(arm).of(5, 8, 4)
    assert sums.max() > 0.0
    np.testing.assert_allclose(film_sums, sums, rtol=1e-6)


@pytest.mark.proofs
def test_a_lamp_in_a_frosted_ball_takes_paths_from_both_ends(monkeypatch):
    scene, change = loads(FROSTED, "frosted"), "integrator.type=bidirectional"
    cause = next(iter(ranked(shares_of(scene, size=16, spp=64))))
    one = {change: alternatives(scene, cause)[change]}
    monkeypatch.setattr(trials, "alternatives", lambda scene, cause: one)
    (trial,), _ = try_alternatives(scene, cause=cause)
    assert trial.helps
    assert trial.efficiency.value > 5.0
