"""Study files: what is read, and what every mistake is told."""

import pytest

from alight.core.errors import AlightError
from alight.formats import builtin_names, load
from alight.lab.arms import load_arms
from alight.lab.study import StudyError
from alight.lab.study_file import load_study, parse_share, parse_study, ready_names

GOOD = """
title: Direct light
scenes:
  - {scene: cornell-box, set: {size: [64, 64]}}
arms:
  mis: {}
  bsdf: {label: BSDF, light_sampling: bsdf}
  cap: {max_depth: 3, declares_different: true}
baseline: mis
spp: [2, 4]
replicates: 4
"""

#: (what is replaced, by what, parts of the message)
MISTAKES = [
    ("title: Direct", "tittle: Direct", ["study.yaml:2:", 'unknown key "tittle"', '"title"']),
    ("[2, 4]", "[4, 2]", ["study.yaml:10:", "rising"]),
    ("[2, 4]", "[0, 2]", ["rising whole numbers >= 1"]),
    ("[2, 4]", "many", ["list of whole numbers", '"many"']),
    ("replicates: 4", "replicates: 1", ["study.yaml:11:", "at least 4, got 1"]),
    ("replicates: 4", "replicates: four", ["must be a whole number", '"four"']),
    ("baseline: mis", "baseline: miss", ['unknown arm "miss"', 'did you mean "mis"']),
    ("label: BSDF", "declares_different: 3", ["arms.bsdf.declares_different", "true or false"]),
    ("scene: cornell-box", "scenery: cornell-box", ['unknown key "scenery"', "scene is missing"]),
    ("mis: {}", "mis: {}\n  mis: {}", ["given twice"]),
    ("replicates: 4", "settings: {relmse_after: soon}", ["must be seconds > 0", '"soon"']),
    ("replicates: 4", "settings: {relmse_after: 0}", ["must be seconds > 0, got 0"]),
    (
        "spp: [2, 4]",
        "spp: [2]\nsettings: {relmse_after: 9}",
        ["study.yaml:11:", "two steps of spp, cornell-box has one"],
    ),
    (
        "baseline: mis",
        "baseline: cap\nsettings: {relmse_after: 9}",
        ["baseline, cap, which declares itself different"],
    ),
    ("replicates: 4", "kind: paintings", ['unknown kind of study "paintings"']),
    ("replicates: 4", "settings: [", ["is not YAML"]),
    ("{size: [64, 64]}}", "{}, reference: {error: 2}}", ["scenes[0].reference.error", "0.5%"]),
    ("{size: [64, 64]}}", "{}, reference: {arm: mes}}", ['unknown arm "mes"', '"mis"']),
    ("{size: [64, 64]}}", "{}, crops: [[1, 2]]}", ["[x, y, width, height]"]),
    ("{size: [64, 64]}}", "{}, arms: [mix]}", ['unknown arm "mix"']),
]

#: Mistakes that only the scene tells.
SCENE_MISTAKES = [
    ("light_sampling: bsdf", "light_sampling: bdsf", ["study.yaml:7:", "light_sampling", '"bdsf"']),
    ("light_sampling: bsdf", "light_smapling: bsdf", ['option "light_smapling"', "light_sampling"]),
    ("light_sampling: bsdf", "sampler: soboll", ['"soboll"', '"sobol"', "study.yaml:7:"]),
    ("light_sampling: bsdf", "bsdfs.whit.sampling: uniform", ["bsdfs.whit", "arms.bsdf"]),
    ("light_sampling: bsdf", "schedule: adaptve", ['unknown schedule "adaptve"', '"adaptive"']),
    ("light_sampling: bsdf", "schedule: {type: cycles, threshold: 0}", ["in (0, 1], got 0"]),
    ("light_sampling: bsdf", "schedule: {type: cycles, treshold: 1}", ['"treshold"', "threshold"]),
    ("light_sampling: bsdf", "schedule: {type: adaptive, threshold: 1}", ["only cycles has"]),
    ("light_sampling: bsdf", "builder: shh", ['unknown builder "shh"', "sah"]),
    ("light_sampling: bsdf", "max_depth: 4", ["another picture", "max_depth 4", "study.yaml:7:"]),
    ("light_sampling: bsdf", "filter: gaussian", ["another picture", "filter"]),
    ("light_sampling: bsdf", "size: 32", ["another size or crop"]),
    ("cornell-box", "cornel-box", ["no such scene", '"cornell-box"', "study.yaml:4:"]),
    ("[64, 64]", "[64, 0]", ["film.size", "study.yaml:4:"]),
]


def _broken(old, new):
    assert old in GOOD
    return GOOD.replace(old, new)


def test_a_good_file():
    study = parse_study(GOOD)
    assert [arm.name for arm in study.arms] == ["mis", "bsdf", "cap"]
    assert study.arms[1].label == "BSDF"
    assert study.arms[1].options == {"light_sampling": "bsdf"}
    assert study.arms[2].declares_different
    assert study.spp == (2, 4)
    scenes = load_arms(study, study.scenes[0], quick=False)
    assert dict(scenes["bsdf"].integrator)["light_sampling"] == "bsdf"
    assert scenes["cap"].film.size == (64, 64)


@pytest.mark.parametrize(("old", "new", "parts"), MISTAKES)
def test_mistakes_of_the_file(old, new, parts):
    with pytest.raises(AlightError) as found:
        parse_study(_broken(old, new))
    for part in parts:
        assert part in str(found.value)


@pytest.mark.parametrize(("old", "new", "parts"), SCENE_MISTAKES)
def test_mistakes_that_the_scene_tells(old, new, parts):
    study = parse_study(_broken(old, new))
    with pytest.raises(StudyError) as found:
        load_arms(study, study.scenes[0], quick=False)
    for part in parts:
        assert part in str(found.value)


def test_what_changes_the_noise_only_needs_no_declaration():
    options = (
        "sampler: {type: stratified, strata: 8}", "heuristic: balance", "rr_depth: 2",
        "russian_roulette: none", "light_choice: uniform", "replicates: 1", "builder: median",
        "bsdfs.white.sampling: uniform", "light_sampling: emitter", "structure: bvh",
        "schedule: adaptive", "schedule: {type: cycles, threshold: 0.1}",
    )  # fmt: skip
    for option in options:
        study = parse_study(_broken("light_sampling: bsdf", option))
        load_arms(study, study.scenes[0], quick=False)


def test_another_integrator_may_compute_the_same_picture():
    """Those that carry light along all paths must; catches a cap of the depth that is lost."""
    text = _broken("light_sampling: bsdf", "integrator: bidirectional")
    scenes = load_arms(parse_study(text), parse_study(text).scenes[0], quick=False)
    assert scenes["bsdf"].integrator.type == "bidirectional"
    for option, told in (
        ("integrator: bidirectional, max_depth: 3", "max_depth 3"),
        ("integrator: bidirectional, integrator.hide_emitters: true", "hide_emitters"),
        ("integrator: light", "integrator"),
        ("integrator: {type: random_walk, max_depth: 4}", "integrator"),
        ("integrator: volpath", "integrator"),
    ):
        study = parse_study(_broken("light_sampling: bsdf", option))
        with pytest.raises(StudyError, match=told):
            load_arms(study, study.scenes[0], quick=False)


def test_an_unknown_study_names_the_nearest():
    with pytest.raises(StudyError, match='did you mean "control"'):
        load_study("controll")


@pytest.mark.parametrize("name", ready_names())
def test_ready_studies_are_valid(name):
    study = load_study(name)
    assert study.title
    assert study.description
    assert study.teaches
    for scene in study.scenes:
        for quick in (False, True):
            arms = load_arms(study, scene, quick)
            assert len({arm.film.size for arm in arms.values()}) == 1
            assert max(next(iter(arms.values())).film.size) <= (128 if quick else 256)


def test_twelve_studies_are_ready():
    assert len(ready_names()) == 12


@pytest.mark.parametrize("text", ["0%", "100%", "-1", "x", "2"])
def test_shares_out_of_range(text):
    with pytest.raises(ValueError, match="share"):
        parse_share(text)


def test_scenes_of_the_studies_load():
    for name in ("cosine-sky", "matt-room", "many-lights", "rare-spikes", "zone-plate"):
        assert name in builtin_names()
        assert not load(name).warnings
