"""How long a guide is trained where the scene leaves the choice."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.guiding.tree import Tree
from alight.options.render import RenderOptions
from alight.rendering.schedules.selection import planned_spp
from alight.rendering.training import training_plan
from alight.rendering.training.guide_training import untrained
from alight.rendering.training.trainer import Trainer
from alight.rendering.training.training_plan import (
    COST,
    FIRST_GATE,
    GATES,
    LEAST_GAIN,
    MOST_ROUNDS,
    MOST_SPENT,
    MOST_SPENT_IN_HOPE,
    MOST_SPENT_LONG,
    MOST_SPENT_WELL,
    NOISY,
    PROMISING,
    ROUNDS,
    Length,
    Signs,
    Step,
    TrainingPlan,
)
from alight.scene import flatten
from tests.guiding.test_gain import GLOBE, scene_with

PIXELS = 2**14


def rounds_of(plan, gains, noise=NOISY):
    """How many rounds are run, what they cost as a part of the picture, and how it ends."""
    if not plan.begins:
        return 0, 0.0, Step.GIVE_UP
    number, step = 0, Step.GO_ON
    while step is Step.GO_ON:
        step = plan.step(number, Signs(gains[number], noise))
        number += 1
    return number, COST * PIXELS * (2**number - 1) / plan.length.samples, step


def test_a_guide_that_never_pays_costs_little():
    """Whatever it seems to be worth below that; one that pays may cost half of the picture."""
    rng, seen = np.random.default_rng(1), set()
    for samples in np.exp(rng.uniform(np.log(1e5), np.log(1e10), 400)):
        plan = TrainingPlan(ROUNDS, True, Length(samples), PIXELS)
        for best, most in ((PROMISING, MOST_SPENT), (LEAST_GAIN, MOST_SPENT_IN_HOPE)):
            rounds, cost, step = rounds_of(plan, rng.uniform(0.5, best, ROUNDS))
            assert step is Step.GIVE_UP
            assert cost <= most
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
        ([1, 1, 0.1, 0.4, 9, 9, 9], 4, Step.GIVE_UP),
        ([1, 1, 1, 4, 4, 4, 2.9], ROUNDS, Step.GIVE_UP),
    ],
)
def test_gates_rise(gains, rounds, step):
    """Where nobody knows how long the render is."""
    assert sorted(GATES.values()) == list(GATES.values())
    plan = TrainingPlan(ROUNDS, True, Length(), PIXELS)
    assert rounds_of(plan, gains)[::2] == (rounds, step)
    assert rounds_of(TrainingPlan(ROUNDS, False, Length(1.0), PIXELS), gains)[::2] == (
        ROUNDS,
        Step.USE,
    )


def test_short_pictures_follow_a_guide_that_promises_early():
    """A quarter of a picture of 640 x 360 pixels and 64 samples is for guides that gain by then.

    What looks like most scenes costs it 5 % at most.
    """
    plan = TrainingPlan(ROUNDS, True, Length(640 * 360 * 64.0), PIXELS)
    dull, cost, step = rounds_of(plan, [1, 1, PROMISING - 0.01, 9, 9, 9, 9])
    assert (dull, step) == (FIRST_GATE + 1, Step.GIVE_UP) and cost <= MOST_SPENT
    rounds, cost, step = rounds_of(plan, [1, 1, PROMISING, PROMISING, LEAST_GAIN, 9, 9])
    assert step is Step.USE and rounds > dull and cost <= MOST_SPENT_WELL
    # Of little noise there is not much more to be taken.
    assert rounds_of(plan, [1, 1, PROMISING, 9, 9, 9, 9], NOISY - 0.01)[0] == dull
    # A promise that is not kept.
    rounds, cost, step = rounds_of(plan, [1, 1, *[LEAST_GAIN - 0.01] * 5])
    assert step is Step.GIVE_UP and cost <= MOST_SPENT_IN_HOPE


def test_a_limit_makes_no_training_longer():
    """The picture may end long before it."""
    gains = np.full(MOST_ROUNDS, LEAST_GAIN)
    for limit, rounds in ((Length(1e12), MOST_ROUNDS), (Length(1e12, True), ROUNDS)):
        assert rounds_of(TrainingPlan(ROUNDS, True, limit, PIXELS), gains)[0] == rounds
    assert not TrainingPlan(ROUNDS, True, Length(1e6, True), PIXELS).begins


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, (32, False)),
        ({"spp": 8}, (8, False)),
        ({"spp": 8, "part": (2, 4)}, (8, False)),
        ({"spp": 8, "time_limit": 5}, (8, True)),
        ({"time_limit": 5}, (None, True)),
        ({"error": 0.1}, (None, True)),
        ({"error": 0.1, "max_spp": 9}, (9, True)),
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


@pytest.mark.parametrize("cost", [3e-4, 1.0], ids=["a guide", "none"])
def test_a_crop_has_the_guide_of_the_whole(cost, monkeypatch):
    """So it has the bits of the cut-out, whatever its own number of samples."""
    scene = scene_with(GLOBE, max_depth=4)
    monkeypatch.setattr(training_plan, "COST", cost)
    monkeypatch.setattr(training_plan, "MOST_SPENT_WELL", 0.08)
    whole, crop = (
        alight.render(scene, spp=8, seed=3, threads=1, crop=window)
        for window in (None, (8, 8, 8, 8))
    )
    assert crop.options["guide"] == whole.options["guide"]
    assert (crop.options["guide"] == "none") == (cost == 1.0)
    np.testing.assert_array_equal(crop.image, whole.image[8:16, 8:16])


def test_a_film_without_a_guide_gets_none_when_it_goes_on(tmp_path, monkeypatch):
    """Even where the longer picture would be worth training: its first samples had none."""
    scene = scene_with(GLOBE, max_depth=4)
    path = tmp_path / "half.ckpt"
    half = alight.render(scene, spp=8, seed=3, threads=1, checkpoint=str(path))
    assert half.options["guide"] == "none"
    monkeypatch.setattr(training_plan, "COST", 1e-6)
    rest = alight.resume(str(path), scene=scene, spp=16, threads=1)
    off = scene_with(GLOBE, max_depth=4, guiding="off")
    plain = alight.render(off, spp=16, seed=3, threads=1)
    assert rest.options["guide"] == "none"
    np.testing.assert_array_equal(rest.sums, plain.sums)


@pytest.mark.parametrize(("rounds", "times"), [(3, 0), (5, 1)])
def test_leaves_look_for_light_a_second_time_once(rounds, times, monkeypatch):
    called = []
    refocused = Tree.refocused
    monkeypatch.setattr(Tree, "refocused", lambda *given: called.append(given) or refocused(*given))
    compiled = compile_scene(flatten(scene_with(GLOBE, max_depth=4, guiding="on")))
    Trainer(untrained(compiled), 1).train(3, TrainingPlan(rounds))
    assert len(called) == times
