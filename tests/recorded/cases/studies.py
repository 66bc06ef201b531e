"""Studies: their files, one that is run from end to end, and sheets of scenes."""

from __future__ import annotations

from typing import Any
from unittest import mock

from alight.lab import arms, study_file
from alight.lab.run import run_study
from alight.lab.sheet.scenes import find_scenes
from alight.lab.study import ArmSpec, SceneSpec, Study
from tests.recorded.making import by_twin, command, described, in_folder, outcome, rows

STUDY = """title: Two samplers
description: Which is better?
baseline: a
replicates: 6
spp: [4, 16]
seed: 3
scenes:
  - scene: cornell-box
    label: A box
    set: {film.size: [16, 16]}
    reference: {spp: 64, arm: b}
arms:
  a: {label: Plain, set: {sampler.type: independent}, expected_slope: -0.5}
  b: {set: {sampler.type: sobol}}
  c: {set: {integrator.max_depth: 2}, declares_different: true}
"""


def studies() -> dict[str, Any]:
    """Study files, ready ones and wrong ones."""
    found: dict[str, Any] = {"ready": {}}
    for name in study_file.ready_names():
        one = study_file.load_study(name)
        found["ready"][name] = [
            one.title,
            one.kind,
            len(one.arms),
            len(one.scenes),
            str(described(one.spp)),
            one.replicates,
        ]
    found["first"] = described(study_file.load_study(study_file.ready_names()[0]))
    texts = {
        "good": STUDY,
        "empty": "",
        "no arms": STUDY.partition("arms:")[0],
        "wrong key": STUDY.replace("baseline", "base"),
        "wrong spp": STUDY.replace("[4, 16]", "[4, x]"),
        "no baseline": STUDY.replace("baseline: a", "baseline: d"),
        "wrong type": STUDY.replace("replicates: 6", "replicates: many"),
        "few": STUDY.replace("replicates: 6", "replicates: 1"),
        "twice": STUDY + "  a: {}\n",
        "no scene": STUDY.replace("cornell-box", "cornel-box"),
        "list": "[1]",
    }
    found["files"] = {
        n: outcome(lambda t=t: described(study_file.parse_study(t, "s.yaml").checked()))
        for n, t in texts.items()
    }
    found["shares"] = rows(study_file.parse_share, ["5%", "0.05", 0.05, 1, "x", True, None])
    one = outcome(lambda: study_file.parse_study(STUDY, "s.yaml").checked())
    found["checked"] = isinstance(one, dict)
    study = study_file.parse_study(STUDY, "s.yaml")
    if isinstance(study, Study):
        found["assignments"] = [
            outcome(arms.assignments, study, arm.options, "p") for arm in study.arms
        ]
        loaded = outcome(lambda: list(arms.load_arms(study, study.scenes[0], True)))
        found["arms"] = loaded
    found["seeds"] = [arms.seed_of("a", n) for n in range(3)]
    found["list"] = command("study", "--list")
    found["commands"] = [command("study", n) for n in ("none.yaml", "sampler")] + [command("study")]
    return found


def ran() -> dict[str, Any]:
    """A study from end to end, by the NumPy reading of kernels, without its times."""
    study = Study(
        "small",
        arms=(
            ArmSpec("independent", {"sampler": "independent"}, expected_slope=-0.5),
            ArmSpec("sobol", {"sampler": "sobol"}),
        ),
        spp=(2, 4),
        replicates=4,
        baseline="independent",
        scenes=[SceneSpec("smooth-direct-light", options={"size": 8})],
        equal_time=False,
        seed=5,
    )
    # Seeds belong to the code of kernels, too.
    fixed = mock.patch("alight.lab.arms.fingerprint", lambda: "kernels")
    with in_folder(), by_twin(), fixed:
        result = run_study(study, "out", threads=1)
        scene = result.scenes[0]
        arms_ = [
            {
                "errors": [[p.spp, described(p.errors), described(p.bias2)] for p in arm.samples],
                "bias": described(arm.bias),
                "seeds": arm.seeds,
                "slope": described(arm.slope_spp),
                "images": [described(arm.images.example), described(arm.images.error)],
            }
            for arm in scene.arms
        ]
        reference = [described(scene.reference_image), scene.reference.spp, scene.reference.arm]
        return {"arms": arms_, "reference": reference, "notes": scene.notes}


def sheets() -> dict[str, Any]:
    """Which scenes a sheet shows."""
    with in_folder(
        {
            "a/x.yaml": "alight: 1\n",
            "a/b/y.xml": "<scene/>",
            "a/z.txt": "",
            "a/.h.yaml": "",
            "w.obj": "",
        }
    ):
        return {
            "found": rows(
                find_scenes,
                {n: ([n],) for n in ("a", "w.obj", "cornell-box", "none", "a/z.txt", "a/b")},
            ),
            "commands": [
                command("sheet", *w)
                for w in (
                    ("none.yaml",),
                    ("a", "--tile", "5"),
                    ("a", "--tile", "5x5"),
                    ("a", "-o", "a.txt"),
                    ("a", "--columns", "0"),
                )
            ],
        }


CASES = {"files": studies, "ran": ran, "sheets": sheets}
