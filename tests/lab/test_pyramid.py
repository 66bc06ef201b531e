"""`alight why` of paths from both ends: the pyramid of techniques."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.integrators.bidirectional import Bidirectional
from alight.integrators.strategies import DEEPEST, LONGER, ROWS, row_of
from alight.lab.why.pyramid import lengths_of
from alight.rendering.tracing.strategy_recorder import StrategyRecorder
from alight.scene import flatten
from tests.rendering.light_scenes import CASES

RUNS, SPP = 16, 32
#: Without delta lobes, every technique finds all light but that which the camera sees directly.
MATT = (
    CASES["a lamp"]
    .replace("type: plastic", "type: diffuse")
    .replace("type: phong", "type: diffuse")
)
SCENE = loads(MATT.replace("[48, 48]", "[24, 40]"), "scene.yaml").replaced(
    integrator=Bidirectional()
)


@pytest.fixture(scope="module")
def told():
    """Some renders of a lamp above a block."""
    recorder = StrategyRecorder(compile_scene(flatten(SCENE)))
    return [recorder.run(SPP, seed) for seed in range(RUNS)]


def test_weighted_techniques_add_up_to_the_picture(told):
    for one in told:
        np.testing.assert_allclose(one.weighted.sum(axis=0), one.picture, rtol=1e-5, atol=1e-7)
    film = alight.render(SCENE, spp=SPP, seed=3, replicates=1)
    np.testing.assert_allclose(told[3].picture, film.image, rtol=1e-6, atol=1e-9)


def test_each_technique_alone_finds_all_light_of_its_length(told):
    means = np.array([one.unweighted.mean(axis=(1, 2, 3)) for one in told])
    weighted = np.array([one.weighted.mean(axis=(1, 2, 3)) for one in told])
    for k in (2, 3, 4):
        whole = weighted[:, row_of(0, k) : row_of(k, k) + 1].sum(axis=1)
        for s in range(1, k + 1):
            gap = means[:, row_of(s, k)] - whole
            assert abs(gap.mean()) < 5.0 * gap.std(ddof=1) / np.sqrt(RUNS)
            assert gap.std(ddof=1) / np.sqrt(RUNS) < 0.05 * whole.mean()


def test_rows_are_numbered_one_by_one():
    rows = [row_of(s, k) for k in range(1, DEEPEST + 1) for s in range(k + 1)]
    assert rows == list(range(LONGER))
    assert [lengths_of(row) for row in (0, 1, 2, LONGER)] == [(0, 1), (1, 1), (0, 2), None]
    assert row_of(3, DEEPEST + 1) == LONGER == ROWS - 1


def test_why_tells_each_technique_from_the_others(tmp_path):
    found = alight.why(SCENE, size=16, spp=32, output=tmp_path / "pyramid.png")
    pyramid = found.pyramid
    assert pyramid is not None
    assert sum(one.light for one in pyramid.techniques) == pytest.approx(1.0)
    assert sum(one.variance.value for one in pyramid.techniques) == pytest.approx(1.0)
    np.testing.assert_allclose(pyramid.weighted.sum(axis=0), found.shares.picture)
    assert "(1, 2)" in str(found) and "by light:" not in str(found)
    plain = json.loads(json.dumps(found.to_dict()))["pyramid"]
    assert {"s": 1, "t": 2}.items() <= next(row for row in plain if row["s"] == 1).items()
    assert "found by (s, t) = (1, 2)" in found._repr_html_()
    with Image.open(tmp_path / "pyramid.png") as sheet:
        assert sheet.width > sheet.height
