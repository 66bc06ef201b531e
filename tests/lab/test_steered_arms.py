"""Arms with a schedule render what `alight.render` renders, and pay for their decisions."""

from types import SimpleNamespace

import numpy as np
import pytest

import alight
from alight.lab.arms import compile_arm, load_arms
from alight.lab.pictures import run_scene
from alight.lab.replicates import measure, steering
from alight.lab.replicates.session import Session
from alight.lab.run import relmse_gains
from alight.lab.store import Store
from alight.lab.study import ArmSpec, ReferenceSpec, SceneSpec, Study, StudyError
from alight.metrics.estimate import Estimate
from alight.rendering.schedules.cycles import Cycles
from alight.rendering.schedules.steering import Steered

SCENE = SceneSpec("soft-shadows", options={"size": [40, 24]})
#: The threshold makes the rule decide after 48 samples, and finish some cells.
ARMS = {
    "even": {},
    "adaptive": {"schedule": "adaptive"},
    "cycles": {"schedule": {"type": "cycles", "threshold": 0.1}},
}
STUDY = Study("steered", [ArmSpec(name, options) for name, options in ARMS.items()], [SCENE])
LADDER = (16, 96)


@pytest.fixture(scope="module")
def arms():
    loaded = load_arms(STUDY, SCENE, quick=False)
    return {arm.name: compile_arm(arm, loaded[arm.name], 1) for arm in STUDY.arms}


@pytest.mark.parametrize("name", ["adaptive", "cycles"])
def test_an_arm_is_the_render_with_that_schedule(arms, name):
    scene = alight.load("soft-shadows", ["film.size=[40,24]"])
    rungs = list(arms[name].render(5, LADDER, 1))
    assert [rung.spp for rung in rungs] == list(LADDER)
    for rung in rungs:
        own = Steered(0, rung.spp, None, adaptive=True) if name == "adaptive" else None
        film = alight.render(scene, seed=5, schedule=own or Cycles(0, rung.spp, 0.1))
        np.testing.assert_array_equal(rung.picture, film.image)
    even = list(arms["even"].render(5, LADDER, 1))
    assert (rungs[-1].picture != even[-1].picture).any()


def test_the_pilot_is_paid_for(arms, monkeypatch):
    counts = []

    def noting(kernels, scene, settings, tile, ranges, scratch):
        counts.append((settings.seed, int(ranges[..., 1].max())))
        return render_tile(kernels, scene, settings, tile, ranges, scratch)

    render_tile = measure.render_tile
    monkeypatch.setattr(measure, "render_tile", noting)
    list(arms["adaptive"].render(5, LADDER[:1], 1))
    # The pilot's samples have a seed of their own, and are not in the picture.
    assert counts[0][1] == 8
    assert counts[0][0] != 5
    assert {seed for seed, _ in counts[2:]} == {5}


def test_arms_with_and_without_a_schedule_are_told_apart(arms):
    assert len({arm.key for arm in arms.values()}) == 3
    same = compile_arm(
        ArmSpec("x", {"schedule": "uniform"}), load_arms(STUDY, SCENE, False)["even"], 1
    )
    # What was measured before there were schedules stays known.
    assert same.key == arms["even"].key


def test_who_decides_by_kept_samples_is_no_reference(tmp_path):
    scene = SceneSpec("soft-shadows", options=SCENE.options, reference=ReferenceSpec("cycles"))
    study = Study("steered", STUDY.arms, [scene], spp=(4,), replicates=4)
    with Store(tmp_path / "results.sqlite") as store, pytest.raises(StudyError) as found:
        run_scene(Session(study, store, False, 1, lambda _: None), scene)
    assert 'arm "cycles" decides by the samples that it keeps' in str(found.value)


def test_the_words_of_schedules():
    assert steering.is_steered("adaptive")
    assert steering.is_biased({"type": "cycles"})
    assert not steering.is_steered("uniform")
    assert not steering.is_steered(None)
    assert not steering.is_biased("adaptive")


def test_gains_are_of_relmse_and_of_its_product_with_time():
    def arm(name, error, seconds, is_baseline=False):
        def point(relmse):
            return SimpleNamespace(
                relmse=Estimate(relmse, relmse / 1.1, relmse * 1.1),
                seconds=Estimate(seconds, seconds / 1.2, seconds * 1.2),
            )

        bias = SimpleNamespace(difference=[Estimate(0.01 * c, -0.02, 0.04) for c in (0, 1, 2)])
        samples, times = [point(9.0), point(error)], [point(9.0), point(2.0 * error)]
        return SimpleNamespace(
            label=name, is_baseline=is_baseline, samples=samples, times=times, bias=bias
        )

    arms = [arm("even", 4.0, 1.0, True), arm("adaptive", 1.0, 2.0)]
    table = relmse_gains([SimpleNamespace(label="scene", arms=arms)])
    ((scene, name, same, time, mean),) = table.rows
    assert (scene, name) == ("scene", "adaptive")
    width = 1.1 ** np.sqrt(2.0)
    assert same == pytest.approx([4.0, 4.0 / width, 4.0 * width])
    width = np.exp(np.sqrt(2.0 * np.log(1.1) ** 2 + 2.0 * np.log(1.2) ** 2))
    assert time == pytest.approx([2.0, 2.0 / width, 2.0 * width])
    assert mean == pytest.approx([1.0, -2.0, 4.0])


def test_guides_are_made_ready_alike_with_and_without_a_schedule(arms, monkeypatch):
    class ReadyError(Exception):
        pass

    def made_ready(*given):
        raise ReadyError(given)

    told = []
    for module, name in ((measure, "even"), (steering, "adaptive")):
        monkeypatch.setattr(module, "made_ready", made_ready)
        with pytest.raises(ReadyError) as found:
            list(arms[name].render(5, LADDER, 1))
        told.append(found.value.args[0])
    even, steered = told
    assert even[2:] == steered[2:] == (5, 1, LADDER[-1])
