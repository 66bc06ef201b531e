"""Where no path is led to a light, the picture does not tell of lamps that no sample has met."""

import math

import numpy as np
import pytest

import alight
from alight.rendering.schedules.stopping import Promise, judge_means

SCENE = """
alight: 1
camera: {fov: 35, transform: {look_at: {origin: [0, 0, 6], target: [0, 0, 0]}}}
film: {size: [16, 16]}
integrator: {type: path, light_sampling: bsdf, max_depth: 4}
environment: {type: constant, radiance: 0.2}
nodes:
  card: {shape: rectangle, transform: {scale: 0.2}}
  lamp:
    shape: {type: sphere, radius: 0.2}
    light: {type: area, radiance: 50}
    transform: {translate: [0, 3, 2]}
"""


def test_where_chance_alone_finds_light_only_a_bound_of_it_counts():
    """A lamp that no sample has met is in no contribution: the pixels agree, and are all dark."""
    means, counts = np.ones((64, 64, 4, 3), np.float32), np.full((64, 64, 4), 4)
    asked = Promise(0.03)
    assert judge_means(means, counts, asked, None, by_chance=False).met
    unknown = judge_means(means, counts, asked, None, by_chance=True)
    assert not unknown.met and unknown.unseen == math.inf and unknown.doubtful == 1.0
    # Of samples up to c, 3 c / (64 * 16) may be missing everywhere.
    for largest, met in ((10.0, True), (11.0, False)):
        found = judge_means(means, counts, asked, largest, by_chance=True)
        assert found.met == met
        assert found.unseen == pytest.approx(3 * largest / 1024 / math.sqrt(1.01))
        assert found.doubtful == (0.0 if met else 1.0)


def test_a_lamp_that_is_found_by_chance_is_not_promised_away(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    words = set()
    for seed in range(4):
        film = alight.render(tmp_path / "scene.yaml", error=0.05, max_spp=64, seed=seed)
        words.add(film.stats["verdict"]["word"])
        film.save(tmp_path / "film.alight")
        assert alight.Film.load(tmp_path / "film.alight").by_chance
    assert "met" not in words
    # Light sampling is led to the lamp.
    scene = alight.load(tmp_path / "scene.yaml", ["integrator.light_sampling=mis"])
    assert not alight.render(scene, spp=4).by_chance
