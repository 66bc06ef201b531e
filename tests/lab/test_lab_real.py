"""Real control studies: the laboratory finds no difference where there is none."""

import pytest
from scipy.stats import binom

from alight.lab.results import UNBIASED
from alight.lab.run import run_study
from alight.lab.study import ArmSpec, SceneSpec, Study
from tests.portion import portion


@pytest.mark.proofs
def test_twenty_control_studies_raise_as_many_alarms_as_their_levels_say(tmp_path):
    alarms, biased, seeds = 0, 0, portion(range(20))
    for seed in seeds:
        arms = [ArmSpec(name) for name in ("first", "second", "third")]
        scene = SceneSpec("cornell-box", options={"size": 128})
        study = Study("control", arms=arms, scenes=[scene], spp=(4, 16), seed=seed)
        found = run_study(study, tmp_path / str(seed), quick=True).scenes[0].arms
        alarms += any(arm.speedup.significant for arm in found if arm.speedup)
        biased += any(arm.bias.verdict != UNBIASED for arm in found)
    count = len(seeds)
    print(f"{alarms} of {count} control studies with a difference, {biased} with a bias")
    # More have a chance of less than 3e-3: of 20, four and two.
    assert alarms <= binom.isf(3e-3, count, 0.05)
    assert biased <= binom.isf(3e-3, count, 0.01)
