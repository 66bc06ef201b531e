"""How long a guide is trained where the scene leaves the choice."""

import math

import numpy as np
import pytest

import alight
from alight.options.render import RenderOptions
from alight.rendering import training_plan
from alight.rendering.schedules import planned_spp
from alight.rendering.training_plan import (
    COST,
    FIRST_GATE,
    GATES,
    LEAST_GAIN,
    MOST_ROUNDS,
    MOST_SPENT,
    MOST_SPENT_LONG,
    MOST_SPENT_WELL,
    ROUNDS,
    Step,
    TrainingPlan,
)
from tests.guiding.test_gain import GLOBE, scene_with

PIXELS = 2**14


def rounds_of(plan, gains):
    """How many rounds are run, what they cost as a part of the picture, and how it ends."""
    if not plan.begins:
        return 0, 0.0, Step.GIVE_UP
    number, step = 0, Step.GO_ON
    while step is Step.GO_ON:
        step = plan.step(number, gains[number])
        number += 1
    return number, COST * PIXELS * (2**number - 1) / plan.samples, step


def test_a_guide_that_never_pays_costs_little():
    """Whatever it seems to be worth below that; one that pays may cost half of the picture."""
    rng, seen = np.random.default_rng(1), set()
    for samples in np.exp(rng.uniform(np.log(1e5), np.log(1e10), 400)):
        plan = TrainingPlan(ROUNDS, True, samples, PIXELS)
        rounds, cost, step = rounds_of(plan, rng.uniform(0.5, LEAST_GAIN, ROUNDS))
        assert step is Step.GIVE_UP
        assert cost <= MOST_SPENT
        assert rounds == 0 or rounds > FIRST_GATE
        rounds, cost, step = rounds_of(plan, np.full(MOST_ROUNDS, LEAST_GAIN))
        most = MOST_SPENT_LONG if rounds > ROUNDS else MOST_SPENT_WELL
        assert cost <= most
        # As long as that allows, once there is anything to be seen; one more would be too many.
        next_most = MOST_SPENT_LONG if rounds >= ROUNDS else MOST_SPENT_WELL
        assert rounds in (0, MOST_ROUNDS) or 2.2 * cost > next_most
        assert step is (Step.USE if rounds else Step.GIVE_UP)
        seen.add(rounds)
    assert {0, ROUNDS, MOST_ROUNDS} < seen


@pytest.mark.parametrize(
    ("gains", "rounds", "step"),
    [
        # Nothing is known before the first gate.
        ([1, 0.1, 0.1, 1, 1.6, 2.1, 3], ROUNDS, Step.USE),
        ([1, 9, 9, 1, 1.4, 9, 9], 5, Step.GIVE_UP),
        ([1, 1, 1, 1, 1.6, 1.9, 9], 6, Step.GIVE_UP),
        ([1, 1, 1, 4, 4, 4, 2.9], ROUNDS, Step.GIVE_UP),
    ],
)
def test_gates_rise(gains, rounds, step):
    """Where nobody knows how long the render is."""
    assert sorted(GATES.values()) == list(GATES.values())
    plan = TrainingPlan(ROUNDS, True, math.inf, PIXELS)
    assert rounds_of(plan, gains)[::2] == (rounds, step)
    assert rounds_of(TrainingPlan(ROUNDS, False, 1.0, PIXELS), gains)[::2] == (ROUNDS, Step.USE)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, 32),
        ({"spp": 8}, 8),
        ({"spp": 8, "part": (2, 4)}, 8),
        ({"spp": 8, "time_limit": 5}, 8),
        ({"time_limit": 5}, None),
        ({"error": 0.1}, None),
        ({"error": 0.1, "max_spp": 9}, 9),
    ],
)
def test_parts_plan_with_the_whole_render(options, expected):
    """Their guide must be the same one."""
    assert planned_spp(RenderOptions(**options), 32) == expected


def test_a_render_that_goes_on_keeps_its_guide(tmp_path, monkeypatch):
    """Twice the samples would be worth a longer training; merging needs the same guide."""
    scene = scene_with(GLOBE, max_depth=4)
    # Such a small picture is worth no training at all, otherwise.
    monkeypatch.setattr(training_plan, "COST", 3e-4)
    monkeypatch.setattr(training_plan, "MOST_SPENT_WELL", 0.08)
    path = tmp_path / "half.ckpt"
    half = alight.render(scene, spp=8, seed=3, threads=1, checkpoint=str(path))
    assert half.stats["guide"]["used"]
    rest = alight.resume(str(path), scene=scene, spp=16, threads=1)
    assert rest.options["guide"] == half.options["guide"] != "none"
    assert rest.stats["guide"]["rounds"] == half.options["guide_rounds"] < ROUNDS
