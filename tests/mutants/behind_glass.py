"""Bugs of light behind clear glass, which only chance finds."""

from tests.mutants.mutant import Mutant

GLASS = "tests/known_error/test_light_behind_glass.py"

BEHIND_GLASS = (
    Mutant(
        "promises that forget light behind glass",
        "rendering/schedules/stopping.py",
        (("promise.error, largest, by_chance, behind)", "promise.error, largest, by_chance)"),),
        f"{GLASS}::test_a_picture_that_no_such_light_has_met_is_not_promised",
    ),
    Mutant(
        "light behind glass that each sample of a pixel finds alone",
        "rendering/schedules/unseen.py",
        (("samples.ravel()[cells] * behind[:, 5]", "samples.ravel()[cells] / 64 * behind[:, 5]"),),
        f"{GLASS}::test_what_is_missing_by_its_formula",
    ),
    Mutant(
        "the sun behind a window as wide as the chance to choose it",
        "rendering/light_behind_glass.py",
        (("_wide(choice.mis_pmf, n) / safe", "1.0 / safe"),),
        f"{GLASS}::test_the_pilot_sees_what_the_lamp_would_give_without_the_pane[3]",
    ),
    Mutant(
        "every glass passes for clear",
        "rendering/light_behind_glass.py",
        (("(pdf > _SHARP)", "(pdf > 0.0 * _SHARP)"),),
        f"{GLASS}::test_nothing_is_found_where_light_is_not_behind_clear_glass_or_paths_are_led_to_it",
    ),
    Mutant(
        "a render that goes on without what its promise asks for",
        "rendering/job.py",
        (("= self.behind_glass if self.schedule.promises else film", "= film"),),
        f"{GLASS}::test_a_render_that_goes_on_to_an_error_looks_for_it",
    ),
    Mutant(
        "holes that stop light on its way to glass",
        "rendering/light_behind_glass.py",
        (("& (hole | bent)", "& bent"),),
        f"{GLASS}::test_holes_let_light_on[a null sheet]",
    ),
    Mutant(
        "a cap's pilot sure of light behind glass that it did not meet",
        "rendering/depth_cap.py",
        (("math.hypot(error, _unmet(", "math.hypot(error, 0.0 * _unmet("),),
        f"{GLASS}::test_a_caps_pilot_looks_often_enough_or_says_what_it_may_have_missed",
    ),
)
