"""Bugs of showing pictures again, and of lists and axes that must fit."""

from tests.mutants.mutant import Mutant

SHOWN = "tests/cli/test_shown_again.py"
WARNINGS = "tests/cli/test_warnings_everywhere.py"

SHOWN_AGAIN = (
    Mutant(
        "a picture shown again without its alpha",
        "outputs/image.py",
        (("return Picture(image, alpha=np.float32(alpha))", "return Picture(image)"),),
        f"{SHOWN}::test_alpha_of_an_exr_stays",
    ),
    Mutant(
        "a picture shown again without its exposure",
        "cli/tonemap.py",
        (("write_image(path, shown, **vars(display))", "write_image(path, shown)"),),
        f"{SHOWN}::test_a_linear_picture_is_shown_as_a_render_would_have_been",
    ),
    Mutant(
        "a description that starts beside a name without room for it",
        "cli/scenes.py",
        (("if columns - width - 2 < _NARROW:", "if False:"),),
        f"{SHOWN}::test_a_scene_fits_the_terminal",
    ),
    Mutant(
        "advice that makes another picture",
        "lab/why/trials.py",
        (("in noise_only_fields(spec):", "in set(type(spec).model_fields) - {'type'}:"),),
        "tests/lab/test_why.py::test_alternatives_are_the_other_choices",
    ),
    Mutant(
        "advice that shows caustics which the picture lacks",
        "lab/why/trials.py",
        (("if has_chains(program) and has_delta_lights(program):", "if False:"),),
        "tests/lab/test_advice_from_both_ends.py::test_caustics_that_no_path_finds_are_another_picture",
    ),
    Mutant(
        "advice from samples that one arm has missed by chance",
        "lab/why/trials.py",
        (("max(both.p_value, few.p_value)", "both.p_value"),),
        "tests/lab/test_bright_samples.py::"
        "test_sparks_that_one_arm_has_not_met_by_chance_are_no_advice",
    ),
    Mutant(
        "warnings of a film that come after its samples",
        "rendering/job.py",
        (("tuple(scene.warnings), self.largest_sample", "(), self.largest_sample"),),
        f"{WARNINGS}::test_it_is_told_before_threads_or_a_cluster_begin",
    ),
    Mutant(
        "a page without what the compiler of scenes warns of",
        "view/session.py",
        (("self.live.movable.compiled.warnings if", "self.live.movable.scene.warnings if"),),
        f"{WARNINGS}::test_every_way_in_tells_everything_once[page]",
    ),
    Mutant(
        "a bias and its error to different decimals",
        "films/ledger.py",
        (("± {100.0 * error:.{decimals}f}", "± {100.0 * error:.2g}"),),
        "tests/known_error/test_biases.py::test_a_bias_and_its_error_have_the_same_decimals",
    ),
    Mutant(
        "numbers of an axis that are all kept",
        "lab/report/charts.py",
        (("if not kept or math.log(value / kept[-1]) >= share", "if not kept or share"),),
        "tests/lab/report/test_numbers.py::test_numbers_of_an_axis_do_not_overprint",
    ),
)
