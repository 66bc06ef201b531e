"""Trials that few samples leave open are told by paths from the lamps."""

import math

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.lab.why.rare_trials import CLEAR, rare_noises
from alight.lab.why.trials import Trial, _told
from alight.lab.why.words import trial_data, trial_lines
from alight.metrics.estimate import Estimate
from alight.rendering.pilot_rays import POINTS
from alight.rendering.rare_light import RareLight
from alight.rendering.sight import Sight
from alight.scene import flatten
from tests.known_error.test_light_off_mirrors import ALBEDO, RADIANCE, of_image, room

ALONE = room()
#: What the camera sees of one half of the floor it sees through a slab of glass.
SLAB = {
    "slab": {
        "shape": "cube",
        "bsdf": {"type": "dielectric"},
        "transform": [{"scale": [2.0, 4.0, 0.01]}, {"translate": [2.0, 0.0, 1.2]}],
    }
}


@pytest.fixture(scope="module")
def half():
    flat = flatten(room(more=SLAB))
    return Sight(flat, compile_scene(flat))


def integrator(**options):
    return room(integrator={"type": "path"} | options).integrator


def test_a_point_is_turned_where_glass_is_before_it(half):
    x = half.seen.o.x + half.seen.hit.t * half.seen.d.x
    assert 0.3 * POINTS < half.seen.turned.sum() < 0.7 * POINTS
    # Seen straight down; the last piece of the way begins below the slab.
    assert np.array_equal(half.seen.turned, half.seen.o.z < 1.3)
    assert (x[half.seen.turned] > -0.01).all() and (x[~half.seen.turned] < 0.01).all()


def test_what_an_integrator_leaves_to_chance(half):
    rare = RareLight(half)
    table = rare.everywhere
    assert table is not None
    assert np.array_equal(rare.left_by(integrator()), table)
    assert np.array_equal(rare.left_by(integrator(light_sampling="emitter")), table)
    both = rare.left_by(room(integrator={"type": "bidirectional"}).integrator)
    assert both is not None
    there = np.isin(table[:, 0], half.seen.point[half.seen.turned])
    assert np.array_equal(both, table[there]) and 0 < len(both) < len(table)
    walks = rare.left_by(integrator(caustics="manifold"))
    assert walks is not None and rare.behind_glass is not None
    assert len(walks) == len(table) - len(rare.behind_glass)


def test_noise_of_a_lamps_image_is_that_of_its_formula():
    """Each pixel is met with the probability q, by samples of the lamp's radiance."""
    flat = flatten(ALONE)
    _, q = of_image()
    others = [room(integrator=i).integrator for i in ({"type": "bidirectional"}, {"type": "path"})]
    even = np.full((32, 32, 3), 1.0 / (32 * 32 * 3))
    own, both, same = rare_noises(ALONE, compile_scene(flat), others, even)
    assert own / (ALBEDO * RADIANCE) ** 2 == pytest.approx(q, rel=0.2)
    assert both == 0.0 and same == own


def told(rare, left, shown, bright=5, own=1e9):
    one = Estimate(1.0, 0.5, 2.0)
    trial = Trial("a=b", one, Estimate(0.5, 0.4, 0.6), one, 1.0, bright)
    return _told(trial, (own, shown), left, rare)


def test_light_that_an_alternative_looks_for_is_advice():
    found = told(rare=100.0, left=4.0, shown=1.0)
    assert found.at_least == pytest.approx(100.0 / 5.0 * 0.5)
    assert found.helps and found.worth == found.at_least
    assert trial_data(found)["at_least"] == found.at_least
    (line,) = trial_lines([found], [])
    assert line.startswith("advice: --set a=b  efficiency x 10 or more")


def test_light_that_no_sample_has_met_is_advice_too():
    """The scene as it is seems to be quiet beyond doubt: its trial has not met that light."""
    quiet = told(rare=100.0, left=0.0, shown=2.0, bright=0, own=1.0)
    assert quiet.at_least == pytest.approx(100.0 / 2.0 * 0.5) and quiet.helps
    (line,) = trial_lines([quiet], [])
    assert "as hardly a sample has met the light of most noise" in line
    (line,) = list(trial_lines([told(100.0, 0.0, 90.0, bright=0, own=1.0)], []))[1:]
    assert "unknown, as hardly a sample" in line


@pytest.mark.parametrize(
    ("rare", "left", "shown", "bright"),
    [
        # It is left to chance as well; what it shows is as noisy; nobody knows of any; many met it.
        (100.0, 100.0, 0.0, 5),
        (100.0, 0.0, 100.0 * 0.5 / CLEAR + 1.0, 5),
        (0.0, 0.0, 1.0, 5),
        (100.0, 0.0, 1.0, 0),
    ],
)
def test_other_light_is_none(rare, left, shown, bright):
    found = told(rare, left, shown, bright)
    assert not found.helps
    assert math.isnan(found.at_least) == (not bright)
    assert next(iter(trial_lines([found], []))).startswith("no advice")
