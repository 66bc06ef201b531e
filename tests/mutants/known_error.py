"""Bugs of a picture's known error, of stopping, steering and planning."""

from tests.mutants.mutant import Mutant

CHANCE = "tests/known_error/test_light_by_chance.py"
PROMISES = "tests/known_error/test_promises.py"
BIASES = "tests/known_error/test_biases.py"
NOISY = "tests/metrics/test_noisy_pixels.py"
DOUBTS = "tests/metrics/test_doubts_about_noisy_pixels.py"
BARS = "tests/metrics/test_pixel_bars.py"
SURVEY = "tests/metrics/test_survey.py"
UNMET = "tests/metrics/test_unmet_light.py"

KNOWN_ERROR = (
    Mutant(
        "the whole doubt for each look, however much errors deviate",
        "rendering/schedules/stopping.py",
        (("look_doubt(promise.doubt, estimate.figure.deviation)", "promise.doubt"),),
        "tests/known_error/test_laws_of_promises.py::test_a_look_at_one_noisy_pixel_asks_for_more",
    ),
    Mutant(
        "an indicator where chance alone finds light",
        "rendering/schedules/unseen.py",
        (("return bound if self.by_chance else", "return"),),
        f"{CHANCE}::test_where_chance_alone_finds_light_only_a_bound_of_it_counts",
    ),
    Mutant(
        "films that forget that no path was led to a light",
        "films/storage.py",
        (('bool(described.get("by_chance"))', "False"),),
        f"{CHANCE}::test_a_lamp_that_is_found_by_chance_is_not_promised_away",
    ),
    Mutant(
        "a few pixels that pass for many where the products of their halves are small",
        "metrics/own_error.py",
        (("    spread = few.at_least(spread, value)\n", ""),),
        "tests/metrics/test_few_noisy_pixels.py::"
        "test_the_interval_holds_where_few_pixels_carry_the_error",
    ),
    Mutant(
        "degrees of freedom from the squared sum of estimates, which is too large",
        "metrics/few_pixels.py",
        (("alike - 2.0 / self._freedom", "alike"),),
        "tests/metrics/test_few_noisy_pixels.py::"
        "test_one_pixel_is_one_term_whatever_its_replicates_are",
    ),
    Mutant(
        "pixels that share paths counted as independent",
        "metrics/own_error.py",
        (("max(spread, shared.spread / ways**2) if shared else spread", "spread"),),
        "tests/metrics/test_shared_paths.py::test_the_interval_holds_where_patterns_are_shared",
    ),
    Mutant(
        "shared paths by the error of one replicate, not of the picture",
        "metrics/shared_paths.py",
        (("(self._sums / self._replicates) ** 2", "self._sums**2 / self._replicates"),),
        "tests/metrics/test_shared_paths.py::test_the_spread_is_that_of_the_covariance",
    ),
    Mutant(
        "an interval from replicates that tell the error and the brightness alike",
        "metrics/error_estimate.py",
        (("LEAST_FOR_INTERVAL = 4", "LEAST_FOR_INTERVAL = 3"),),
        "tests/metrics/test_edges_of_intervals.py::test_the_summary_tells_why_there_is_no_interval",
    ),
    Mutant(
        "a promise that replicates without an interval cannot keep",
        "rendering/schedules/steering.py",
        (("if film.replicates < LEAST_FOR_INTERVAL", "if film.replicates < 0"),),
        f"{PROMISES}::test_no_error_is_promised_without_an_interval",
    ),
    Mutant(
        "a clock that ends between two looks says met",
        "rendering/schedules/steering.py",
        (
            (
                "        if not judgement.met:\n            return self._say",
                "        if True:\n            return self._say",
            ),
        ),
        f"{PROMISES}::test_only_a_look_that_was_planned_says_met",
    ),
    Mutant(
        "a bound for samples of lights that a tree chooses",
        "rendering/schedules/sample_bound.py",
        (("if by_tree or flat.lights", "if flat.lights"),),
        "tests/known_error/test_sample_bound.py::test_samples_of_lights_that_a_tree_chooses_have_no_bound",
    ),
    Mutant(
        "pixels of one bright sample in the classes of all others",
        "metrics/noisy_pixels.py",
        (("np.uint8(CLASSES // 2) * (error", "np.uint8(0) * (error"),),
        f"{NOISY}::test_pixels_that_one_replicate_lights_are_in_classes_of_their_own",
    ),
    Mutant(
        "one class for all pixels below twice the brightness around them",
        "metrics/noisy_pixels.py",
        (("EDGES = (0.5**2, 1.0, 2.0**2,", "EDGES = (2.0**2, 2.0**2, 2.0**2,"),),
        f"{NOISY}::test_the_interval_holds_where_lamps_cover_any_part_of_a_pixel",
    ),
    Mutant(
        "noisy pixels as bright as the half that tells their error",
        "metrics/own_error.py",
        (("= b.brightness.ravel()", "= a.brightness.ravel()"),),
        f"{NOISY}::test_the_interval_holds_the_error_of_noisy_pictures",
    ),
    Mutant(
        "rows that are no whole cell left out of their sums",
        "metrics/surroundings.py",
        (("if whole < h:", "if whole < h - CELL:"),),
        f"{SURVEY}::test_cells_are_the_sums_of_their_pixels",
    ),
    Mutant(
        "the answer about a film's earlier samples",
        "films/judgement.py",
        (("same = known.samples == _samples_of(film)", "same = known.samples > 0"),),
        f"{SURVEY}::test_a_film_answers_anew_once_it_has_other_samples",
    ),
    Mutant(
        "no bright sample seen, so no brightness believed",
        "metrics/noisy_pixels.py",
        (
            (
                "mean = (seen + prior) / (expected + prior)",
                "mean = (seen + 1e-6) / (expected + 1e-6)",
            ),
        ),
        f"{NOISY}::test_without_a_sample_pixels_are_as_bright_as_their_surroundings",
    ),
    Mutant(
        "a jackknife of unequal groups as of equal ones",
        "metrics/noisy_pixels.py",
        (("(moves * np.sqrt(left))", "(moves * math.sqrt(1.0 - 1.0 / GROUPS))"),),
        f"{NOISY}::test_groups_of_any_size_add_up_to_the_variance",
    ),
    Mutant(
        "Student's factor by the groups alone, where no group tells anything",
        "metrics/noisy_pixels.py",
        (
            (
                "freedom = (between + within) ** 2 / doubt if doubt > 0.0 else math.inf",
                "freedom = max(effective(groups) - 1.0, _LEAST_FREEDOM)",
            ),
        ),
        f"{DOUBTS}::test_pixels_that_differ_are_as_many_degrees_of_freedom",
    ),
    Mutant(
        "pixels that differ because nothing is known of them",
        "metrics/noisy_pixels.py",
        (("share * mean * mean, mean * mean)", "share, mean * mean)"),),
        f"{NOISY}::test_where_b_sees_nothing_the_prior_alone_speaks",
    ),
    Mutant(
        "no doubt about few bright samples where one group tells nothing",
        "metrics/noisy_pixels.py",
        (("+ found.few[:, 0] * single)", "+ 0.0 * single)"),),
        f"{DOUBTS}::test_few_bright_samples_leave_open_what_a_rate_is",
    ),
    Mutant(
        "noise that makes pixels unlike their surroundings",
        "metrics/own_error.py",
        (("(logs[0] * logs[1])", "(logs[0] * logs[0])"),),
        f"{DOUBTS}::test_how_unlike_pixels_are_is_seen_in_precise_ones",
    ),
    Mutant(
        "a trace of other pixels speaks for a whole class",
        "metrics/noisy_pixels.py",
        (("(moves * np.sqrt(left))", "moves"),),
        f"{SURVEY}::test_a_part_that_vanishes_has_no_say",
    ),
    Mutant(
        "pixels that differ as their brightness, not as its square, tells",
        "metrics/noisy_pixels.py",
        (("1.0 / np.sqrt(pairs)", "0.5 / np.sqrt(pairs)"),),
        f"{DOUBTS}::test_pixels_differ_by_no_more_than_their_number_and_coincidences_tell",
    ),
    Mutant(
        "one pixel that differs from itself",
        "metrics/noisy_pixels.py",
        (("mean * mean * pixels)", "mean * mean * (pixels + 1.0))"),),
        f"{DOUBTS}::test_pixels_differ_by_no_more_than_their_number_and_coincidences_tell",
    ),
    Mutant(
        "samples of both signs that leave nothing open",
        "metrics/noisy_pixels.py",
        (("math.log1p(2.0 * float(sums[-1]", "math.log1p(0.0 * float(sums[-1]"),),
        f"{DOUBTS}::test_the_interval_holds_where_samples_cancel",
    ),
    Mutant(
        "a half that met no light, taken for samples that cancel",
        "metrics/noisy_pixels.py",
        (("np.flatnonzero(rho < 0.0)", "np.flatnonzero(rho <= 0.0)"),),
        f"{DOUBTS}::test_where_samples_have_both_signs_pixels_may_be_black",
    ),
    Mutant(
        "a doubt that counts upwards only, in both directions",
        "metrics/error_estimate.py",
        (("(self.rise if upper else 0.0)", "self.rise"),),
        f"{NOISY}::test_doubts_about_error_and_brightness_add_up",
    ),
    Mutant(
        "a pixel in its own surroundings",
        "metrics/surroundings.py",
        (("            near -= here\n", ""),),
        f"{NOISY}::test_a_pixel_has_no_part_in_its_own_surroundings",
    ),
    Mutant(
        "the larger of two doubts for both",
        "metrics/error_estimate.py",
        (("doubt = math.hypot(", "doubt = max("),),
        f"{NOISY}::test_doubts_about_error_and_brightness_add_up",
    ),
    Mutant(
        "bars without room for what is missing",
        "metrics/pixel_bars.py",
        (("part * pooled + rare,", "part * pooled,"),),
        f"{BARS}::test_a_cell_beside_bright_samples_has_longer_bars_than_its_own_noise_says",
    ),
    Mutant(
        "bars by the pixel's own replicates",
        "metrics/pixel_bars.py",
        (("_POOLED = 5.0", "_POOLED = 0.0"),),
        f"{BARS}::test_bars_hold_as_often_as_they_say",
    ),
    Mutant(
        "every promise that is not kept is doubted",
        "rendering/schedules/stopping.py",
        (("doubted = not within and known <= promise.error**2", "doubted = not within"),),
        f"{PROMISES}::test_an_error_that_hangs_on_unknown_brightness_is_not_certifiable",
    ),
    Mutant(
        "an interval half as wide as the spread says",
        "metrics/few_pixels.py",
        (("alike = value * value / spread", "alike = 4.0 * value * value / spread"),),
        f"{PROMISES}::test_the_interval_covers_and_is_no_wider_than_it_must_be",
    ),
    Mutant(
        "the estimate in the place of what is not exceeded",
        "rendering/schedules/stopping.py",
        (
            (
                "achieved = estimate.relrmse_below(sure)",
                "achieved = estimate.relrmse.value",
            ),
        ),
        f"{PROMISES}::test_a_look_asks_for_the_error_that_is_not_exceeded",
    ),
    Mutant(
        "twice the doubt at every look",
        "rendering/schedules/stopping.py",
        (("return doubt * (WHOLE_DOUBT", "return 2.0 * doubt * (WHOLE_DOUBT"),),
        "tests/known_error/test_laws_of_promises.py"
        "::test_looks_without_end_are_wrong_no_more_often_than_one_promises",
    ),
    Mutant(
        "looks that miss the powers of two",
        "rendering/schedules/stopping.py",
        (("step * (rounds // step + 1)", "(rounds + step)"),),
        "tests/known_error/test_laws_of_promises.py"
        "::test_looks_are_even_numbers_of_points_in_every_replicate",
    ),
    Mutant(
        "rare light passed over",
        "rendering/schedules/stopping.py",
        (("met = within and unseen.figure <= promise.error", "met = within"),),
        f"{PROMISES}::test_one_spike_makes_a_noiseless_picture_uncertain",
    ),
    Mutant(
        "a pilot that is in the picture",
        "rendering/schedules/steering.py",
        (
            (
                "return Goal.uniform(film, self.first, pilot, round=1)",
                "return Goal.uniform(film, self.first, pilot)",
            ),
        ),
        f"{PROMISES}::test_a_steered_render_asks_for_pilot_and_picture_in_different_films",
    ),
    Mutant(
        "samples by the variance, not by its root",
        "rendering/schedules/adaptive.py",
        (
            (
                "return np.sqrt((1.0 - _AROUND) * variance + _AROUND * box(variance))",
                "return (1.0 - _AROUND) * variance + _AROUND * box(variance)",
            ),
        ),
        f"{PROMISES}::test_samples_go_where_the_noise_is",
    ),
    Mutant(
        "Cycles' rule one decision too early",
        "rendering/schedules/cycles.py",
        (("((least + 1) // STEP + 1)", "(least // STEP + 1)"),),
        f"{PROMISES}::test_cycles_decides_first_where_cycles_does",
    ),
    Mutant(
        "a plan that forgets the looks",
        "rendering/plan.py",
        (("rate * samples + look * count", "rate * samples"),),
        f"{PROMISES}::test_a_plan_follows_the_slope_of_the_pilot",
    ),
    Mutant(
        "an effect as a share of the biased mean",
        "films/ledger.py",
        (("whole = mean - self.effect", "whole = mean"),),
        f"{BIASES}::test_cycles_rule_is_recorded_with_its_effect",
    ),
    Mutant(
        "a compiled picture that overflows",
        "films/readout.py",
        (("(film.counts.max(initial=0)) * replicates <=", "(film.counts.max(initial=0)) <="),),
        "tests/film/test_film.py::test_machine_code_reads_films_as_numpy_does",
    ),
    Mutant(
        "one replicate that knows its error",
        "metrics/survey.py",
        (("if replicates > 1:", "if replicates >= 1:"),),
        "tests/metrics/test_errors_of_pictures.py"
        "::test_one_replicate_or_one_sample_says_nothing_of_the_error",
    ),
    Mutant(
        "doubt from the brightness, not from its square",
        "metrics/noisy_pixels.py",
        (("np.log(np.maximum(mean * mean, 1.0))", "np.log(np.maximum(mean, 1.0))"),),
        "tests/metrics/test_noisy_pixels.py"
        "::test_the_doubt_reaches_from_what_is_believed_to_what_a_saw",
    ),
    Mutant(
        "pixels that know themselves weighed 2 % too heavily for their spread",
        "metrics/own_error.py",
        (("np.append(weights, 1.0)", "np.append(weights, 1.02)"),),
        "tests/metrics/test_noisy_pixels.py"
        "::test_the_freedom_of_even_pictures_is_their_number_of_pixels",
    ),
    Mutant(
        "a bar of one degree of freedom fewer",
        "metrics/pixel_bars.py",
        (
            (
                "own = np.float32(max(seen.replicates - 1, 1))",
                "own = np.float32(max(seen.replicates - 2, 1))",
            ),
        ),
        "tests/metrics/test_pixel_bars.py"
        "::test_bars_of_an_even_picture_are_students_with_five_more_degrees",
    ),
    Mutant(
        "doubt about some pixels, cubed by their share",
        "metrics/own_error.py",
        (("(believed.value / total) ** 2", "(believed.value / total) ** 3"),),
        "tests/metrics/test_noisy_pixels.py"
        "::test_the_doubt_about_noisy_pixels_counts_by_their_share",
    ),
    Mutant(
        "products of errors by brightness that excuses them",
        "metrics/own_error.py",
        (("if not some.size:", "if True:"),),
        f"{UNMET}::test_a_bright_sample_does_not_excuse_its_part_in_the_spread",
    ),
    Mutant(
        "light that was not met in no interval",
        "metrics/own_error.py",
        (("believed.rise * share + unmet * unmet", "believed.rise * share"),),
        f"{UNMET}::test_the_interval_reaches_up_to_light_that_was_not_met",
    ),
    Mutant(
        "unmet light by events of any number",
        "metrics/unmet_light.py",
        (("variance * np.float32(EVENTS) > picture", "variance * np.float32(99.0) > picture"),),
        f"{UNMET}::test_light_of_many_events_is_not_overlooked",
    ),
    Mutant(
        "unmet light without regard to how many samples a pixel has",
        "metrics/unmet_light.py",
        (("price, cost = n * (m + root), n * root", "price, cost = m + root, n.mean() * root"),),
        f"{UNMET}::test_one_event_tells_how_much_more_darkness_may_hide",
    ),
    Mutant(
        "unmet light in bright pixels first",
        "metrics/unmet_light.py",
        (
            ("np.argpartition(price, most)", "np.argpartition(-price, most)"),
            ("np.argsort(price[order])", "np.argsort(-price[order])"),
        ),
        f"{UNMET}::test_no_way_to_hide_the_light_makes_more_of_it",
    ),
    Mutant(
        "unseen light upwards only where samples have both signs",
        "rendering/schedules/unseen.py",
        (("signed = bool((means < 0.0).any())", "signed = False"),),
        f"{PROMISES}::test_where_samples_have_both_signs_a_dip_tells_as_much_as_a_spike",
    ),
    Mutant(
        "unseen light of replicates that lack what the others have",
        "rendering/schedules/unseen.py",
        (("signed = bool((means < 0.0).any())", "signed = True"),),
        f"{PROMISES}::test_where_samples_have_both_signs_a_dip_tells_as_much_as_a_spike",
    ),
)
