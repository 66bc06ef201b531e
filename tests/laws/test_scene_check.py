"""`alight check`: what is right passes, what is wrong is found, and equal pictures rarely fail."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.bsdfs.matte.diffuse import Diffuse
from alight.cli.main import app
from alight.formats import loads
from alight.laws.mutants import MUTANTS, plant, run_with
from alight.laws.scene import Finding, Verdict, check_scene
from alight.laws.scene.dump import write_failures
from alight.laws.scene.findings import adjusted_by_holm
from alight.laws.scene.lights import Cone, _difference
from alight.laws.scene.materials import check_materials
from alight.laws.scene.pictures import SEEDS, SPP, Side, compared
from tests.portion import portion

PACKAGE = Path(alight.__file__).parent
SCENE = Path(__file__).parent / "glass_and_lamps.yaml"

#: Which part of the check is asked to find each bug.
FOUND_BY = {
    "dropped-cosine": "pictures",
    "pdf-per-area": "lights",
    "u-for-root-u": "materials",
    "mis-on-one-side": "pictures",
    "no-survival": "pictures",
    "eta-for-eta2": "materials",
    "reused-dimension": "paths",
    "depth-off-by-one": "paths",
    "light-choice-forgotten": "pictures",
    "both-ways-in-full": "pictures",
}
#: Those that need no machine code, and so little time.
QUICK = ("u-for-root-u", "depth-off-by-one")
SLOW = [name for name in MUTANTS if name not in QUICK]


# ---------------------------------------------------------------- a scene without a bug


def test_a_scene_without_a_bug_keeps_all_laws():
    verdict = check_scene(alight.load(SCENE), only=("materials", "lights", "numbers", "paths"))
    assert verdict.ok, verdict.failures
    laws = {finding.law for finding in verdict.findings}
    assert "lights are chosen as often as their probability says" in laws
    assert "unit directions, weights, energy, furnace, reciprocity" in laws
    # Three lights that can be hit, from two points each.
    assert sum("follow their density" in f.law and f.part.startswith("light ") for f in
               verdict.findings) == 6  # fmt: skip
    assert all(f.p is not None or f.holds is not None for f in verdict.findings)


def test_a_verdict_is_true_if_all_laws_hold():
    good, bad = Finding("a", "law", holds=True), Finding("b", "law", holds=False)
    assert bool(Verdict((good,), 0.05)) is True
    assert bool(Verdict((good, bad), 0.05)) is False


def test_so_many_materials_are_looked_at_and_the_others_are_counted(monkeypatch):
    monkeypatch.setattr("alight.laws.scene.materials.MOST", 2)
    monkeypatch.setattr(
        "alight.laws.scene.materials._of_one",
        lambda name, material, rng: iter([Finding(name, "law", holds=True)]),
    )
    specs = {name: Diffuse() for name in "abcde"}
    found = [(finding.part, finding.detail) for finding in check_materials(specs, 1)]
    assert found == [
        ("material a", ""), ("material b", ""), ("materials", "3 more were not looked at"),
    ]  # fmt: skip
    del specs["c"], specs["d"], specs["e"]
    assert len(list(check_materials(specs, 1))) == 2


@pytest.mark.parametrize(
    "sky",
    ["{type: sky, sun_direction: [0.6, 0.5, 0.2]}", "{type: sunsky, sun_direction: [0.6, 0.5, 0]}"],
    ids=["sky", "sunsky"],
)
def test_light_that_varies_over_the_sky_keeps_all_laws(sky):
    scene = loads(f"""
alight: 1
camera: {{fov: 45, transform: {{translate: [0.5, 1, 4]}}}}
film: {{size: [8, 8]}}
environment: {sky}
nodes: {{floor: {{shape: rectangle, bsdf: {{type: diffuse}}}}}}
""")
    verdict = check_scene(scene, only=("lights",))
    assert verdict.ok, verdict.failures
    assert sum("follow their density" in finding.law for finding in verdict.findings) == 2


@pytest.mark.proofs
@pytest.mark.parametrize("scene", ["cornell-box", str(SCENE)])
def test_all_ways_give_one_picture(scene):
    verdict = check_scene(alight.load(scene))
    assert verdict.ok, verdict.failures
    assert sum(finding.part == "picture" for finding in verdict.findings) == 8


# ---------------------------------------------------------------- planted bugs


def test_every_bug_has_its_part():
    assert set(FOUND_BY) == set(MUTANTS)
    assert len(MUTANTS) >= 8


@pytest.mark.parametrize("name", MUTANTS)
def test_bugs_fit_and_leave_the_package_alone(name, tmp_path):
    files = {file for file, _, _ in MUTANTS[name].edits}
    before = {file: (PACKAGE / file).read_bytes() for file in files}
    plant(MUTANTS[name], tmp_path)
    for file in files:
        assert (PACKAGE / file).read_bytes() == before[file]
        assert (tmp_path / "alight" / file).read_bytes() != before[file]
        compile((tmp_path / "alight" / file).read_text("utf-8"), file, "exec")


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(n, marks=pytest.mark.proofs) for n in portion(SLOW))]
)
def test_the_bug_is_found(name, tmp_path, capfd):
    words = ["check", str(SCENE), "--only", FOUND_BY[name], "-o", str(tmp_path / "pictures")]
    assert run_with(MUTANTS[name], words) == 1
    shown = capfd.readouterr()
    assert "\nBAD " in shown.out, shown
    assert "Traceback" not in shown.err
    pictures = list((tmp_path / "pictures").glob("*.png"))
    assert bool(pictures) == (FOUND_BY[name] == "pictures")


# ---------------------------------------------------------------- the command line


def invoke(*words):
    return CliRunner().invoke(app, ["check", *words])


def test_bugs_are_listed_where_none_or_a_wrong_one_is_named():
    listed = invoke("--mutant")
    assert listed.exit_code == 0
    assert [line.split()[0] for line in listed.output.splitlines()] == list(MUTANTS)
    wrong = invoke("cornell-box", "--mutant", "no-survivor")
    assert wrong.exit_code == 2
    assert 'unknown bug "no-survivor"; did you mean "no-survival"?' in wrong.output
    assert all(name in wrong.output for name in MUTANTS)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--level", "1"), "--level: must be a number between 0 and 1, got 1"),
        (("--only", "material"), '--only: unknown part "material"; did you mean "materials"?'),
    ],
)
def test_wrong_options(words, message):
    result = invoke("cornell-box", *words)
    assert result.exit_code == 2
    assert message in result.output


# ---------------------------------------------------------------- statistics


def test_holm_corrects_and_a_nan_fails():
    np.testing.assert_allclose(adjusted_by_holm([0.01, 0.5, 0.02]), [0.03, 0.5, 0.04])
    np.testing.assert_allclose(adjusted_by_holm([0.4, 0.3, 0.3]), [0.9, 0.9, 0.9])
    verdict = Verdict((Finding("a", "x", p=float("nan")), Finding("b", "x", p=0.9)), 0.01)
    assert [finding.part for finding in verdict.failures] == ["a"]
    exact = Verdict((Finding("a", "x", holds=True), Finding("b", "x", holds=False)), 0.01)
    assert [finding.part for finding in exact.failures] == ["b"]
    assert Verdict((Finding("a", "not judged"),), 0.01).ok


def pictures(rng, mean=1.0, spread=0.5, pixels=24):
    """Means of SPP samples with skewed noise."""
    shape = (spread**-2) * SPP
    return rng.gamma(shape, mean / shape, (SEEDS, pixels, pixels, 1)).repeat(3, axis=3)


def smallest(a, b):
    """The Bonferroni-corrected p-value of both tests."""
    findings = list(compared("agree", a, b))
    return min(1.0, 2.0 * min(finding.p for finding in findings))


def test_equal_pictures_fail_as_often_as_they_may():
    rng = np.random.default_rng(1)
    p = [
        smallest(Side("a", pictures(rng)), Side("b", pictures(rng, spread=1.5))) for _ in range(300)
    ]
    # 5 % of 300: more than 30 has a probability of 1e-4.
    assert np.sum(np.array(p) < 0.05) <= 30


def test_a_bias_of_one_per_cent_is_found():
    rng = np.random.default_rng(2)
    a, b = Side("a", pictures(rng)), Side("b", pictures(rng, mean=1.01))
    assert smallest(a, b) < 1e-6


def test_light_that_is_hardly_ever_found_is_not_called_missing():
    """Samples of 10 000 with probability 2e-6 in place of 0.02: most runs see none of them."""
    rng = np.random.default_rng(3)
    failed = naive = 0
    for _ in range(20):
        smooth = Side("a", pictures(rng, mean=1.02))
        rare = 1e4 * (rng.random((SEEDS, 24, 24, 1)) < SPP * 2e-6) / SPP + pictures(rng)
        failed += smallest(smooth, Side("b", rare, largest=1e4)) < 0.01
        naive += smallest(smooth, Side("b", rare)) < 0.01
    assert failed == 0
    assert naive >= 5


def test_bright_samples_that_never_come_are_missed():
    """The same with samples that should come often: their absence is a finding."""
    rng = np.random.default_rng(4)
    smooth, without = pictures(rng, mean=1.2), pictures(rng)
    assert smallest(Side("a", smooth), Side("b", without, largest=20.0)) < 1e-6


def test_two_ways_of_drawing_directions():
    """For p = (1 + cos) / (4 pi) on the sphere, and for a density wrong by 10 % in one half."""
    rng = np.random.default_rng(5)
    n = 20_000
    x, y, z = np.eye(3)
    cone = Cone(z, x, y, 2.0)
    even = cone.directions(rng.random((2, n)))
    height = 2.0 * np.sqrt(rng.random(n)) - 1.0
    phi = 2.0 * np.pi * rng.random(n)
    r = np.sqrt(1.0 - height**2)
    drawn = np.stack([r * np.cos(phi), r * np.sin(phi), height])

    def chi2(density):
        q = cone.density
        a, b = q / (density(drawn) + q), density(even) / (density(even) + q)
        return _difference(cone.cells(drawn), a, cone.cells(even), b)

    right, cells = chi2(lambda d: (1.0 + d[2]) / (4.0 * np.pi))
    wrong, _ = chi2(lambda d: (1.0 + d[2]) / (4.0 * np.pi) * np.where(d[0] > 0.0, 1.1, 0.9))
    assert cells >= 30
    assert right < cells + 4.0 * np.sqrt(2.0 * cells)
    assert wrong > cells + 5.0 * np.sqrt(2.0 * cells)


def test_pictures_of_failures_are_written(tmp_path):
    z = np.array([[6.0, -6.0], [0.0, np.nan]])
    sides = {"a": np.full((8, 8, 3), 0.5), "b": np.full((8, 8, 3), 0.25), "z": z}
    findings = tuple(Finding("picture", f"agree, {what}", p=1e-9, pictures=sides) for what in "xy")
    passed = Finding("picture", "agree too", p=0.5, pictures=sides)
    [path] = write_failures(Verdict((*findings, passed), 0.01), tmp_path / "folder")
    from alight.outputs.image import read_image

    image = read_image(path)
    assert image.shape == (384, 3 * 384 + 8, 3)
    np.testing.assert_allclose(image[10, 900], [1.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(image[10, 1100], [0.0, 0.0, 1.0], atol=1e-6)
