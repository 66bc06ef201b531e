"""What a study measures by, where it names nothing: never by what is wrong with an arm."""

import json
from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

from alight.lab import pictures
from alight.lab.arms import Arm, compile_arm
from alight.lab.pictures import run_scene
from alight.lab.references import _kept
from alight.lab.replicates.session import Session
from alight.lab.report.scenes import sentences
from alight.lab.results import BIASED, DISPUTED, UNBIASED
from alight.lab.statistics.block_means import block_size
from alight.lab.store import Store
from alight.lab.study import ArmSpec, ReferenceSpec, SceneSpec, Study

OPTIONS = {"size": 32}
STILL = {"sampler": "independent"}


class Dark(Arm):
    """Loses a hundredth of the light, and is less noisy for it."""

    def render(self, seed, ladder, threads):
        """As all arms do, but for the light."""
        for rung in super().render(seed, ladder, threads):
            yield rung._replace(picture=0.99 * rung.picture)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run a study of these arms; those called "dark" are."""

    def compiled(spec, scene, threads):
        arm = compile_arm(spec, scene, threads)
        kind = Dark if spec.name == "dark" else Arm
        values = {field.name: getattr(arm, field.name) for field in fields(Arm)}
        # Neither knows of the other's reference.
        return kind(**{**values, "key": f"{arm.key} {kind.__name__}"})

    monkeypatch.setattr(pictures, "compile_arm", compiled)

    def study(*names, seed=1, reference=""):
        spec = ReferenceSpec(reference)
        scene = SceneSpec("smooth-direct-light", options=OPTIONS, reference=spec)
        made = Study(
            "small", [ArmSpec(name, STILL) for name in names], [scene], spp=(16,), replicates=6,
            seed=seed, equal_time=False,
        )  # fmt: skip
        with Store(tmp_path / f"{seed}.sqlite") as store:
            return run_scene(Session(made, store, False, 1, lambda _: None), scene)

    return study


def _verdicts(result):
    return {arm.name: arm.bias.verdict for arm in result.arms}


def test_a_dark_arm_is_named_and_renders_no_reference(run):
    result = run("a", "b", "c", "dark")
    assert result.reference.arm == "a"
    assert _verdicts(result) == {"a": UNBIASED, "b": UNBIASED, "c": UNBIASED, "dark": BIASED}
    assert not result.notes or "in its place" not in result.notes[0]


def test_a_dark_baseline_is_named_and_another_arm_renders_the_reference(run):
    result = run("dark", "a", "b", "c")
    assert result.reference.arm == "a"
    assert _verdicts(result) == {"dark": BIASED, "a": UNBIASED, "b": UNBIASED, "c": UNBIASED}
    assert result.notes[0].startswith("dark disagrees with most arms: a renders the reference")
    # All that is told was measured by the new reference.
    for arm in result.arms:
        off = 0.01 if arm.name == "dark" else 0.0
        for value, _, high in arm.bias.difference:
            assert abs(value + off) < 2.5 * (high - value) < 0.01


def test_of_two_arms_none_is_called_biased(run):
    result = run("a", "dark")
    assert _verdicts(result) == {"a": DISPUTED, "dark": DISPUTED}
    assert result.reference.arm == "a"
    words = " ".join(sentences(result))
    assert "a and dark disagree, and no majority of the arms says which of them is biased" in words
    assert "No arm is more efficient" not in words


def test_a_named_reference_is_taken_for_the_truth(run):
    result = run("a", "b", "dark", reference="dark")
    assert _verdicts(result) == {"a": BIASED, "b": BIASED, "dark": UNBIASED}


def test_pilots_belong_to_an_arm_and_to_the_seed_of_the_study(run, tmp_path):
    """Else all studies of a scene would make the same mistake about the time of an arm."""
    known = []
    for seed in (1, 3):
        run("a", "b", seed=seed)
        with Store(tmp_path / f"{seed}.sqlite") as store:
            rows = store._base.execute("SELECT value FROM facts WHERE key LIKE 'pilot %'")
            # Seconds differ in any case.
            known += [json.loads(row[0])[1] for row in rows]
    assert len(set(known)) == len(known) == 4


def test_references_belong_to_the_seed_of_the_study(run):
    one, other, again = run("a", "b"), run("a", "b", seed=3), run("a", "b")
    assert one.reference.key != other.reference.key
    assert (one.reference_image != other.reference_image).any()
    assert again.reference.key == one.reference.key
    assert again.reference.source == "cached"
    # Their noise is measured; only files have one that somebody states.
    assert not any(run.declared for run in (one.reference, other.reference, again.reference))


def test_a_kept_reference_of_another_size_is_not_taken(tmp_path):
    block = block_size((8, 6))
    rows = np.zeros((2, 3 + (8 // block) * (6 // block)))
    image = np.ones((6, 8, 3), np.float32)
    facts = json.dumps({"spp": 4, "seconds": 1.0, "key": "k"})
    np.savez(tmp_path / "a.npz", image=image, variance=image, rows=rows, facts=facts)
    for size in ((8, 6), (6, 8), (7, 6), (8, 5)):
        arm = SimpleNamespace(size=size, spec=SimpleNamespace(name="base"))
        assert (_kept(tmp_path / "a.npz", arm) is not None) == (size == (8, 6))
