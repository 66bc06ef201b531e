"""Bugs of light behind clear glass, which only chance finds."""

from tests.mutants.mutant import Mutant

GLASS = "tests/known_error/test_light_behind_glass.py"
MEDIA = "tests/known_error/test_rare_light_in_media.py"
MIRRORS = "tests/known_error/test_light_off_mirrors.py"
SURFACES = "tests/known_error/test_light_off_surfaces.py"
PLANS = "tests/known_error/test_laws_of_plans.py"

BEHIND_GLASS = (
    Mutant(
        "noise and missing light held against the error one by one",
        "rendering/schedules/stopping.py",
        (("math.hypot(achieved, unseen.hidden)", "max(achieved, unseen.hidden)"),),
        f"{GLASS}::test_noise_and_missing_light_are_held_against_the_error_together",
    ),
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
        (("seen_as = wider * chosen / safe", "seen_as = wider / safe"),),
        f"{GLASS}::test_the_pilot_sees_what_the_lamp_would_give_without_the_pane[3]",
    ),
    Mutant(
        "every glass passes for clear",
        "rendering/pilot_rays.py",
        (("(delta | (self.pdf > SHARP))", "(delta | (self.pdf > 1e-4 * SHARP))"),),
        f"{GLASS}::test_nothing_is_found_where_light_is_not_behind_clear_glass_or_paths_are_led_to_it",
    ),
    Mutant(
        "a render that goes on without what its promise asks for",
        "rendering/job.py",
        (("                film.rare_light = self", "                self"),),
        f"{GLASS}::test_a_render_that_goes_on_to_an_error_looks_for_it",
    ),
    Mutant(
        "holes that stop light on its way to glass",
        "rendering/light_behind_glass.py",
        (("& (turns.holes | bent)", "& bent"),),
        f"{GLASS}::test_holes_let_light_on[a null sheet]",
    ),
    Mutant(
        "a cap's pilot sure of light behind glass that it did not meet",
        "rendering/depth_cap.py",
        (("math.hypot(error, _unmet(", "math.hypot(error, 0.0 * _unmet("),),
        f"{GLASS}::test_a_caps_pilot_looks_often_enough_or_says_what_it_may_have_missed",
    ),
    Mutant(
        "light paths that are aimed count twice",
        "rendering/light_off_mirrors.py",
        (("return 0.5 * plain_p * plain_d + 0.5 * other", "return 0.5 * plain_p * plain_d"),),
        f"{MIRRORS}::test_a_mirror_is_a_window_to_an_image_of_the_lamp[at rest]",
    ),
    Mutant(
        "mirrors that are met by every sample",
        "rendering/arriving_light.py",
        (("* share * some.reached\n    return by_size", "* 0.0 + 1.0\n    return by_size"),),
        f"{MIRRORS}::test_a_picture_that_no_such_light_has_met_is_not_promised",
    ),
    Mutant(
        "a slab too narrow for the nearest light paths",
        "rendering/arriving_light.py",
        (("side = 1.001 * np.sqrt(", "side = 0.1 * np.sqrt("),),
        f"{MIRRORS}::test_the_nearest_light_paths_are_those_of_a_list_of_all[4000]",
    ),
    Mutant(
        "what moves is looked at as the shutter opens",
        "rendering/pilot_rays.py",
        (("if not self.program.motion:", "if True:"),),
        f"{GLASS}::test_what_moves_is_looked_at_too",
    ),
    Mutant(
        "light paths aimed at where casters were before they moved",
        "compiled/casters.py",
        (("        if motion:", "        if False:"),),
        "tests/lights/test_targets.py::test_boxes_of_what_moves_hold_it_while_the_shutter_is_open",
    ),
    Mutant(
        "light paths that strong lamps far away have all to themselves",
        "rendering/nearby_lamps.py",
        (("0.5 * by_power + 0.5 *", "0.99999 * by_power + 1e-5 *"),),
        f"{SURFACES}::test_lamps_that_outshine_it_from_afar_do_not_hide_it[20]",
    ),
    Mutant(
        "media that light paths do not feel",
        "rendering/light_off_surfaces.py",
        (("if not light.medium.any():", "if True:"),),
        f"{MEDIA}::test_fog_takes_its_part_of_light_and_of_the_paths_that_meet_it",
    ),
    Mutant(
        "light that is lost where ratio tracking leaves nothing of it",
        "rendering/light_off_surfaces.py",
        ((" & (dots(light.radiance, left) > 0.0)", ""),),
        f"{MEDIA}::test_smoke_around_a_lamp_keeps_its_power[grid]",
    ),
    Mutant(
        "fog that every path comes through",
        "rendering/pilot_rays.py",
        (("on.reached * left.mean(axis=1)", "on.reached"),),
        f"{MEDIA}::test_fog_takes_its_part_of_light_and_of_the_paths_that_meet_it",
    ),
    Mutant(
        "lamps as near as the last hole before them",
        "rendering/light_off_surfaces.py",
        (("way = light.way + hit.t", "way = hit.t"),),
        f"{MEDIA}::test_a_hole_on_the_way_to_a_lit_card_changes_nothing[a point]",
    ),
    Mutant(
        "samples told from an error without a bound",
        "rendering/schedules/stopping.py",
        (("if achieved > LARGEST_TOLD:", "if False:"),),
        "tests/known_error/test_laws_of_plans.py"
        "::test_samples_are_told_where_the_error_has_a_bound_of_use[100000.0]",
    ),
    Mutant(
        "plans that know no more than their samples",
        "rendering/plan.py",
        (("if _LITTLE * whole < self.rare.noise:", "if False:"),),
        f"{PLANS}::test_the_plan_is_what_the_rule_takes_within_a_factor_of_two",
    ),
    Mutant(
        "each direction to a light taken for all of it",
        "rendering/light_behind_glass.py",
        (("q / np.where(chosen > 0.0, chosen, 1.0)", "q"),),
        f"{GLASS}::test_the_pilot_sees_what_the_lamp_would_give_without_the_pane[3]",
    ),
    Mutant(
        "more samples without the noise of what none has met",
        "rendering/schedules/stopping.py",
        (("(achieved**2 + unmet) / promise", "achieved**2 / promise"),),
        "tests/known_error/test_rare_light.py"
        "::test_more_samples_are_told_for_the_noise_of_what_none_has_met",
    ),
    Mutant(
        "light that each cell lacks in part",
        "rendering/schedules/unseen.py",
        (("np.exp(-0.5 * factor", "np.exp(-factor"),),
        f"{GLASS}::test_what_is_missing_is_the_mean_square_of_what_cells_lack",
    ),
    Mutant(
        "a cap's pilot that misses each light in part",
        "rendering/depth_cap.py",
        (("np.exp(-0.5 * found)", "np.exp(-found)"),),
        f"{GLASS}::test_a_caps_pilot_looks_often_enough_or_says_what_it_may_have_missed",
    ),
    Mutant(
        "a promise without an interval",
        "metrics/error_estimate.py",
        (
            (
                "return not self.shares_paths and not math.isnan(self.relmse.high)",
                "return not self.shares_paths",
            ),
        ),
        "tests/metrics/test_what_is_promised.py::test_a_promise_takes_an_interval[3]",
    ),
    Mutant(
        "small bright surfaces as bright as their lamp",
        "rendering/light_off_surfaces.py",
        (("both = np.where(light.turned, 0.0, led) +", "both = 0.0 * led +"),),
        f"{SURFACES}::test_a_lit_card_gives_the_light_that_it_throws_and_is_met_as_often_as_it_is_large",
    ),
    Mutant(
        "lamps at a point as likely as light paths have them",
        "rendering/light_off_surfaces.py",
        (("if len(alone):", "if False:"),),
        f"{SURFACES}::test_lamps_at_a_point_are_as_likely_as_light_sampling_has_them[tree]",
    ),
    Mutant(
        "small bright surfaces in what mirrors and glass turn first",
        "rendering/light_off_surfaces.py",
        (("on &= ~(first & turns.sharp", "on &= ~(~first & turns.sharp"),),
        f"{SURFACES}::test_what_clear_glass_turns_first_is_left_to_the_other_pilot_and_keeps_its_power",
    ),
    Mutant(
        "radiance that stays concentrated where light leaves glass",
        "rendering/pilot_rays.py",
        (("self.weight * (self.squares**2)[:, None]", "self.weight"),),
        f"{SURFACES}::test_what_clear_glass_turns_first_is_left_to_the_other_pilot_and_keeps_its_power",
    ),
    Mutant(
        "promises that forget small bright surfaces",
        "rendering/rare_light.py",
        (("[self.behind_glass, light_off_surfaces(self._sight)]", "[self.behind_glass]"),),
        f"{SURFACES}::test_only_a_promise_looks_for_it",
    ),
    Mutant(
        "lamps in glass as large as without it",
        "rendering/light_behind_glass.py",
        (("wider * chosen / safe", "chosen / safe"),),
        "tests/known_error/test_magnified_lamps.py::test_a_slab_lifts_a_lamp",
    ),
    Mutant(
        "lamps in glass as bright as without it",
        "rendering/light_behind_glass.py",
        (("value * (wider / index / safe)", "value * (wider / safe)"),),
        "tests/known_error/test_magnified_lamps.py"
        "::test_a_ball_shows_a_lamp_inside_by_the_formula_of_one_refracting_surface[0.0]",
    ),
    Mutant(
        "light of beams that the medium leaves as it is",
        "rendering/light_in_media.py",
        (("at.weight * edge.radiance * left * share", "at.weight * edge.radiance * share"),),
        "tests/known_error/test_rare_light_in_media.py"
        "::test_light_that_fog_scatters_into_the_camera_is_known",
    ),
    Mutant(
        "collisions of the camera's rays as if all collided",
        "rendering/pilot_rays.py",
        (("left[there] * often[:, None]", "left[there]"),),
        "tests/known_error/test_rare_light_in_media.py"
        "::test_light_that_fog_scatters_into_the_camera_is_known",
    ),
    Mutant(
        "beams by their distance, not its square",
        "rendering/light_in_media.py",
        (("least, square[least]", "least, np.sqrt(square[least])"),),
        "tests/known_error/test_rare_light_in_media.py"
        "::test_light_that_fog_scatters_into_the_camera_is_known",
    ),
    Mutant(
        "fog that only mirrors light",
        "rendering/light_off_surfaces.py",
        ((".some(light.turned & (", ".some(light.turned & ~light.turned & ("),),
        "tests/known_error/test_rare_light_in_media.py"
        "::test_light_of_a_frosted_bulb_that_only_fog_shows_is_looked_for",
    ),
)
