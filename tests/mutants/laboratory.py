"""Bugs of the statistics that pictures and studies are judged by."""

from tests.mutants.mutant import Mutant

INTERVALS = "tests/lab/test_laws_of_intervals.py"
BLOCKS = "tests/lab/test_laws_of_blocks.py"
STUDIES = "tests/lab/test_laws_of_studies.py"
METRICS = "tests/metrics/test_laws_of_metrics.py"
PROMISES = "tests/known_error/test_laws_of_promises.py"
SHARES = "tests/known_error/test_laws_of_shares.py"
BOUNDS = "tests/known_error/test_sample_bound.py"
RARE = "tests/lab/test_rare_trials.py"

LABORATORY = (
    Mutant(
        "paths from both ends joined at what is seen in mirrors",
        "rendering/rare_light.py",
        (("return table[turned[", "return table[~turned["),),
        f"{RARE}::test_what_an_integrator_leaves_to_chance",
    ),
    Mutant(
        "glass that the camera looks through forgotten at the next surface",
        "rendering/pilot_rays.py",
        (("turned=on.turned | turns.sharp", "turned=on.turned"),),
        f"{RARE}::test_a_point_is_turned_where_glass_is_before_it",
    ),
    Mutant(
        "advice in spite of noise that the alternative shows itself",
        "lab/why/trials.py",
        (("rare / (other + left)", "rare / (1e-9 + left)"),),
        f"{RARE}::test_other_light_is_none",
    ),
    Mutant(
        "advice by light that the alternative leaves to chance as well",
        "lab/why/trials.py",
        (("rare / (other + left)", "rare / (1e-9 + other)"),),
        f"{RARE}::test_other_light_is_none",
    ),
    Mutant(
        "trusted trials that have not met the light",
        "lab/why/trials.py",
        (("not (trial.bright or rare > own)", "not trial.bright"),),
        f"{RARE}::test_light_that_no_sample_has_met_is_advice_too",
    ),
    Mutant(
        "rare light as noisy as if every sample met it",
        "lab/why/rare_trials.py",
        (("(squares.sum(axis=1) / rows[:, -1]).sum()", "squares.sum()"),),
        f"{RARE}::test_noise_of_a_lamps_image_is_that_of_its_formula",
    ),
    Mutant(
        "a paired ratio with twice its degrees of freedom",
        "lab/statistics/intervals.py",
        (("dof = len(upper.pseudo) - 1.0", "dof = 2.0 * (len(upper.pseudo) - 1.0)"),),
        f"{INTERVALS}::test_ratios_are_the_t_tests_of_scipy",
    ),
    Mutant(
        "a bootstrap-t with its quantiles swapped",
        "lab/statistics/intervals.py",
        (
            (
                "centre - high * width, centre - low * width",
                "centre + low * width, centre + high * width",
            ),
        ),
        f"{INTERVALS}::test_the_bootstrap_reaches_farther_to_where_the_data_are_skewed",
    ),
    Mutant(
        "blocks of an exact reference with sixteen times their variance",
        "lab/statistics/block_means.py",
        (("sum(axis=(1, 3)) / block**4", "sum(axis=(1, 3)) / (block / 2) ** 4"),),
        f"{BLOCKS}::test_without_a_bias_z_is_standard_normal_and_the_level_is_kept",
    ),
    Mutant(
        "the noise of references left out of the speed-up",
        "lab/evaluate.py",
        (
            (
                "paired=study.paired, extra_variance=shared)",
                "paired=study.paired)",
            ),
        ),
        f"{STUDIES}::test_the_noise_of_references_is_in_the_speedup",
    ),
    Mutant(
        "FLIP of the reference against the picture",
        "metrics/flip.py",
        (("evaluate(ref, x, dynamic_range", "evaluate(x, ref, dynamic_range"),),
        f"{METRICS}::test_flip_shows_exposures_of_the_reference",
    ),
    Mutant(
        "a side of the cube of arriving light with rows for columns",
        "lab/guide/incidence.py",
        (("picture[row, column]", "picture[column, row]"),),
        "tests/lab/test_guide.py::test_light_arrives_from_where_it_is",
    ),
    Mutant(
        "a share of pixels without its margin",
        "rendering/schedules/stopping.py",
        (("return share - z * math.sqrt", "return share - 0.0 * math.sqrt"),),
        f"{PROMISES}::test_the_share_is_students_and_its_margin_the_binomial_one",
    ),
    Mutant(
        "a share of pixels whose margin is always that of 99 %",
        "rendering/schedules/stopping.py",
        (("    z = -_NORMAL.inv_cdf(doubt)", "    z = 2.576"),),
        f"{PROMISES}::test_the_share_is_students_and_its_margin_the_binomial_one",
    ),
    Mutant(
        "adaptive shares that forget the epsilon of dark pixels",
        "rendering/schedules/adaptive.py",
        (("np.maximum(box(mean) ** 2 + epsilon,", "np.maximum(box(mean) ** 2,"),),
        f"{SHARES}::test_shares_are_the_root_of_the_relative_variance_and_epsilon_holds_the_dark_back",
    ),
    Mutant(
        "a bound of samples that no light was sampled for",
        "integrators/largest_sample.py",
        (("(weight * share if d < depth else 0.0)", "0.0"),),
        f"{BOUNDS}::test_without_roulette_it_is_a_geometric_series",
    ),
    Mutant(
        "the longest paths in the words of their replicates",
        "integrators/contributions.py",
        (("minimum_u32(found.depth, lanes_u32((1 << HALF) - 1))", "found.depth"),),
        "tests/lab/test_why.py"
        "::test_words_hold_all_numbers_up_to_their_limits_and_the_longest_path_beyond",
    ),
    Mutant(
        "the spread of a reference as if its variance were known",
        "lab/statistics/decomposition.py",
        (("1.0 + 1.0 / max(blocks - 1.0, 1.0)", "1.0 + 0.0 / max(blocks - 1.0, 1.0)"),),
        "tests/lab/test_laws_of_blocks.py"
        "::test_the_spread_of_a_reference_is_how_its_noise_moves_every_error",
    ),
    Mutant(
        "a bench that looks at one channel of a lamp twice",
        "laws/lights.py",
        (("i + 4 * n, s.radiance.x)", "i + 4 * n, s.radiance.y)"),),
        "tests/laws/test_compiled_benches.py::test_of_lights",
    ),
    Mutant(
        "a bench that forgets a normal's y where nothing is hit",
        "laws/shapes.py",
        (("for_misses * g.ng.y", "for_misses"),),
        "tests/laws/test_compiled_benches.py::test_of_shapes",
    ),
)
