"""A small study from end to end: what is found, what is kept, what is refused."""

import numpy as np
import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.core.errors import AlightError
from alight.formats import load as load_scene
from alight.lab.integrals import INTEGRANDS, jittered_points, product_error, run_integrals
from alight.lab.make_reference import make_reference
from alight.lab.replicates.session import Session
from alight.lab.result_files import load
from alight.lab.results import DIFFERENT
from alight.lab.run import STORE, run_study
from alight.lab.statistics.intervals import holm_adjusted
from alight.lab.store import Store
from alight.lab.study import ArmSpec, ReferenceSpec, SceneSpec, Study, StudyError
from alight.metrics.relmse import relrmse
from alight.outputs.exr import read_layers

SCENE = SceneSpec("smooth-direct-light", options={"size": 32})
SOBOL = ArmSpec("sobol", {"sampler": "sobol"})
INDEPENDENT = ArmSpec("independent", {"sampler": "independent"}, expected_slope=-0.5)
TWIN = ArmSpec("twin", {"sampler": "independent"})


def _study(*arms, scene=SCENE, **changes):
    # Equal times would let the machine's mood choose the samples: one study has them.
    fixed = {
        "spp": (4, 16), "replicates": 6, "baseline": "independent", "scenes": [scene],
        "equal_time": False,
    }  # fmt: skip
    return Study("small", arms=arms, **{**fixed, **changes})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def reports():
    """What the study of `result` said while it ran."""
    return []


@pytest.fixture(scope="module")
def result(folder, reports):
    return run_study(_study(INDEPENDENT, SOBOL, TWIN), folder, progress=reports.append)


def _arm(result, name):
    return next(arm for arm in result.scenes[0].arms if arm.name == name)


def test_the_better_sampler_is_found(result):
    sobol, twin = _arm(result, "sobol"), _arm(result, "twin")
    # Times of a millisecond jump about on a busy machine; errors do not.
    assert sobol.samples[-1].mse.high < _arm(result, "independent").samples[-1].mse.low / 4.0
    assert sobol.efficiency.value > _arm(result, "independent").efficiency.value
    assert sobol.slope_spp.high < -0.6
    assert twin.speedup.p_adjusted > 0.001
    slope = _arm(result, "independent").slope_spp
    assert slope.low < -0.5 < slope.high
    # One study in a hundred calls something biased, and each change of the kernels is another one.
    assert min(arm.bias.p_value for arm in result.scenes[0].arms) > 1e-4


def test_p_values_are_corrected_over_the_arms(result):
    found = [arm.speedup for arm in result.scenes[0].arms if arm.speedup]
    corrected = holm_adjusted([speedup.p_value for speedup in found])
    assert [speedup.p_adjusted for speedup in found] == corrected
    assert corrected != [speedup.p_value for speedup in found]


@pytest.mark.usefixtures("result")
def test_blocks_hold_all_arms_in_random_order(reports):
    texts = [report.text for report in reports if ": replicate " in report.text]
    orders = [tuple(text.split(", ")[1] for text in texts[i : i + 3]) for i in range(0, 18, 3)]
    assert all(sorted(order) == ["independent", "sobol", "twin"] for order in orders)
    assert len(set(orders)) > 1


def test_parts_add_up_and_seeds_differ(result):
    seeds = [seed for arm in result.scenes[0].arms for seed in arm.seeds]
    assert len(set(seeds)) == len(seeds) == 18
    for arm in result.scenes[0].arms:
        assert [point.spp for point in arm.samples] == [4, 16]
        for point in arm.samples + arm.times:
            assert point.bias2.value + point.variance.value == pytest.approx(point.mse.value)
            assert point.mse.low < point.mse.value < point.mse.high
        assert arm.images.example.shape == arm.images.mean.shape == (32, 32, 3)


def test_results_are_saved_whole(result, folder):
    again = load(folder / "results.json")
    assert again.scenes[0].reference == result.scenes[0].reference
    assert _arm(again, "sobol").speedup == _arm(result, "sobol").speedup
    assert np.array_equal(_arm(again, "sobol").images.mean, _arm(result, "sobol").images.mean)


def test_the_same_command_renders_nothing_new(result, folder):
    again = run_study(_study(INDEPENDENT, SOBOL, TWIN), folder)
    assert again.seconds["render"] == again.seconds["reference"] == 0.0
    assert [a.efficiency for a in again.scenes[0].arms] == [
        a.efficiency for a in result.scenes[0].arms
    ]


def test_an_arm_that_is_added_is_all_that_runs(result, folder):
    other = ArmSpec("other", {"sampler": "independent"})
    again = run_study(_study(INDEPENDENT, SOBOL, TWIN, other), folder)
    alone = again.scenes[0].arms[3].replicates * again.scenes[0].arms[3].samples[-1].seconds.value
    assert 0.0 < again.seconds["render"] < 2.0 * alone
    assert _arm(again, "sobol").seeds == _arm(result, "sobol").seeds
    assert _arm(again, "sobol").efficiency == _arm(result, "sobol").efficiency


def test_more_replicates_keep_the_first_ones(result, folder):
    again = run_study(_study(INDEPENDENT, SOBOL, TWIN, replicates=8), folder)
    assert _arm(again, "twin").seeds[:6] == _arm(result, "twin").seeds
    assert len(_arm(again, "twin").seeds) == 8


def test_what_computes_something_else_is_named(tmp_path):
    options = {"sampler": "independent", "nodes.lamp.light.radiance": [5.94, 5.544, 4.95]}
    dim = ArmSpec("dim", options, declares_different=True)
    found = run_study(_study(INDEPENDENT, dim, spp=(16,)), tmp_path)
    # One per cent less light.
    assert _arm(found, "dim").bias.verdict == DIFFERENT
    for value, _, high in _arm(found, "dim").bias.difference:
        # Five standard errors.
        assert abs(value + 0.01) < 2.5 * (high - value) < 0.01
    assert _arm(found, "independent").bias.p_value > 1e-4


def test_a_noisy_reference_is_refused_and_nothing_is_lost(tmp_path):
    scene = SceneSpec(
        "smooth-direct-light", options={"size": 32}, reference=ReferenceSpec("independent", 16)
    )
    with pytest.raises(StudyError, match=r"too noisy.*it would need about \d+ spp instead of 16"):
        run_study(_study(INDEPENDENT, TWIN, scene=scene), tmp_path)
    with Store(tmp_path / STORE) as store:
        rows = store._base.execute("SELECT COUNT(*) FROM replicates").fetchone()
    assert rows == (12,)


def test_no_noise_is_a_message(tmp_path):
    # A look into the empty sky.
    up = {"look_at": {"origin": [0, 1.6, 3.2], "target": [0, 10, 9]}}
    options = {"size": 32, "camera.transform": up}
    still = SceneSpec("smooth-direct-light", options=options)
    with pytest.raises(StudyError, match=r"arms\.independent[\s\S]*no noise at all"):
        run_study(_study(INDEPENDENT, TWIN, scene=still), tmp_path)


def test_a_reference_knows_its_error_and_serves_a_study(tmp_path, monkeypatch):
    scene = load_scene("smooth-direct-light", ["film.size=[32,32]", "sampler.type=independent"])
    made = make_reference(scene, 0.01)
    path = made.film.save(tmp_path / "ref.exr")
    found = made.film.relmse_estimate().relrmse
    assert found.value < 0.011
    # Not the pilot's samples.
    assert made.film.spp == made.pilot_spp
    fine = make_reference(scene, 0.003)
    assert relrmse(made.film.image, fine.film.image) == pytest.approx(found.value, rel=0.15)
    assert "standard_error.R" in read_layers(path)[0]
    external = SceneSpec("smooth-direct-light", options={"size": 32},
                         reference=ReferenceSpec(file="ref.exr"))  # fmt: skip
    study = _study(INDEPENDENT, TWIN, scene=external, spp=(4,), folder=tmp_path, equal_time=True)
    result = run_study(study, tmp_path / "out")
    assert result.scenes[0].reference.source == "ref.exr"
    assert [point.spp for point in _arm(result, "independent").times] == [4]
    assert len(_arm(result, "twin").times) == 1
    assert _arm(result, "twin").bias.p_value > 1e-4
    other = SceneSpec("smooth-direct-light", options={"size": 16},
                      reference=ReferenceSpec(file="ref.exr"))  # fmt: skip
    with pytest.raises(StudyError, match="must have 16x16 pixels as the arms, got 32x32"):
        run_study(_study(INDEPENDENT, TWIN, scene=other, folder=tmp_path), tmp_path / "b")


def test_integration_has_the_slopes_of_theory(tmp_path):
    with Store(tmp_path / STORE) as store:
        study = Study("integration", kind="integrals")
        panels, _ = run_integrals(Session(study, store, True, 1, lambda _: None))
    assert len(panels) == 10
    z = [
        (curve.slope.value - curve.expected_slope) / (curve.slope.high - curve.slope.value) * 2.0
        for panel in panels
        for curve in panel.curves
        if curve.expected_slope is not None and curve.label != "sobol"
    ]
    # Twenty slopes; those of the net reach theirs from above.
    assert len(z) == 20
    assert np.abs(z).max() < 4.0
    assert product_error(INTEGRANDS["smooth"], "gauss", 8, 1) < 1e-9
    assert product_error(INTEGRANDS["smooth"], "midpoint", 16, 1) == pytest.approx(
        np.pi / 32 / np.sin(np.pi / 32) - 1.0
    )
    cells = np.floor(jittered_points(3, 2, 1, np.random.default_rng(0))[0] * 3)
    assert len({tuple(cell) for cell in cells}) == 9


def test_the_command_lists_and_refuses(tmp_path):
    shown = CliRunner().invoke(app, ["study", "--list"])
    assert shown.exit_code == 0
    assert len(shown.output.splitlines()) == 12
    wrong = CliRunner().invoke(app, ["study", "direct-ligth"])
    assert wrong.exit_code == 2
    assert 'did you mean "direct-light"' in wrong.output
    file = tmp_path / "s.yaml"
    file.write_text("arms: {a: {max_depth: 3}}\nscenes: [cornell-box]\nrepicates: 4\n")
    wrong = CliRunner().invoke(app, ["study", str(file)])
    assert wrong.exit_code == 2
    assert "s.yaml:3:" in wrong.output
    wrong = CliRunner().invoke(app, ["reference", "cornell-box", "-o", "x.png"])
    assert wrong.exit_code == 2
    assert "must end in .exr" in wrong.output
    bad = CliRunner().invoke(
        app, ["reference", "cornell-box", "-o", str(tmp_path / "x.exr"), "--error", "5"]
    )
    assert bad.exit_code == 2
    assert "--error: must lie in (0, 100 %), got 5" in bad.output


def test_a_study_needs_no_less_than_it_says():
    for changes in ({"replicates": 3}, {"spp": ()}, {"baseline": "x"}, {"scenes": []}):
        with pytest.raises(AlightError):
            _study(INDEPENDENT, **changes).checked()
