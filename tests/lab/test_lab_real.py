"""Real control studies: the laboratory finds no difference where there is none."""

import pytest

from alight.lab.results import UNBIASED
from alight.lab.run import run_study
from alight.lab.study import ArmSpec, SceneSpec, Study


@pytest.mark.proofs
def test_twenty_control_studies_raise_at_most_four_alarms(tmp_path):
    alarms, biased = 0, 0
    for seed in range(20):
        arms = [ArmSpec(name) for name in ("first", "second", "third")]
        scene = SceneSpec("cornell-box", options={"size": 128})
        study = Study("control", arms=arms, scenes=[scene], spp=(4, 16), seed=seed)
        found = run_study(study, tmp_path / str(seed), quick=True).scenes[0].arms
        alarms += any(arm.speedup.significant for arm in found if arm.speedup)
        biased += any(arm.bias.verdict != UNBIASED for arm in found)
    print(f"{alarms} of 20 control studies with a difference, {biased} with a bias")
    assert alarms <= 4
    assert biased <= 2
