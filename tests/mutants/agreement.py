"""Bugs of the tests whether two pictures are the same."""

from tests.mutants.mutant import Mutant

AGREE = "tests/metrics/test_agreement.py"
SUMS = "tests/metrics/test_block_sums.py"
PICTURES = "tests/metrics/test_comparison.py"

AGREEMENT = (
    Mutant(
        "what the other picture says of the noise passed over",
        "metrics/block_sums.py",
        (("np.maximum(safe, self.exchanged), safe)", "safe, safe)"),),
        f"{AGREE}::test_without_the_other_pictures_noise_the_darker_one_would_be_called_different",
    ),
    Mutant(
        "numbers of samples exchanged the wrong way",
        "metrics/block_sums.py",
        (
            (
                "squares[0] * ratio + squares[1] / ratio",
                "squares[0] / ratio + squares[1] * ratio",
            ),
        ),
        f"{SUMS}::test_what_each_picture_says_of_the_other_is_exchanged",
    ),
    Mutant(
        "replicates believed where pixels say otherwise",
        "metrics/block_sums.py",
        (("safe = np.where(among > chance, among, self.variance)", "safe = self.variance"),),
        f"{AGREE}::test_replicates_that_met_the_same_are_no_proof_that_there_is_no_noise",
    ),
    Mutant(
        "a third cumulant that is the sum of both sides' and not their difference",
        "metrics/block_sums.py",
        (
            (
                """third = planes[_SUMMED.index("difference")]""",
                """third = abs(planes[_SUMMED.index("difference")])""",
            ),
        ),
        f"{SUMS}::test_the_third_cumulant_is_that_of_the_noise",
    ),
    Mutant(
        "one side of the largest deviation of all blocks",
        "metrics/agreement.py",
        (("int(judged.sum()) * largest", "largest"),),
        f"{AGREE}::test_false_alarms_are_as_rare_as_promised",
    ),
    Mutant(
        "twice the spread of squares",
        "metrics/statistics.py",
        (("scale = max(seen, 2.0) / 2.0", "scale = max(seen, 2.0)"),),
        "tests/metrics/test_statistics.py::test_sums_of_squares_of_normal_numbers_are_chi_square",
    ),
    Mutant(
        "blocks of skewed noise that stay small",
        "metrics/comparison.py",
        (("or sums.skewness > LARGEST_SKEWNESS", "or False"),),
        f"{PICTURES}::test_noise_that_is_skewed_on_one_side_is_judged_on_larger_blocks",
    ),
    Mutant(
        "blocks of three seeds that know their variance",
        "metrics/comparison.py",
        (("sums.block**2 * freedom < _FREEDOM_WANTED or ", ""),),
        f"{PICTURES}::test_few_seeds_against_many_keep_the_level",
    ),
    Mutant(
        "no test of the whole by the noise of its blocks",
        "metrics/comparison.py",
        (
            (
                'names["mean luminance"] = 1.0 if math.isnan(whole)',
                'names["mean luminance"] = 1.0 if True',
            ),
        ),
        f"{PICTURES}::test_few_seeds_find_a_small_change_of_all_the_light",
    ),
    Mutant(
        "blocks that agree too well called biased",
        "lab/statistics/block_means.py",
        (
            (
                'found.p_values | {"rms(z)": sum_of_squares_tails(judged)[1]}',
                "found.p_values",
            ),
        ),
        "tests/lab/test_coverage.py::test_blocks_that_agree_too_well_are_no_bias",
    ),
    Mutant(
        "the smallest difference told as the largest",
        "metrics/agreement.py",
        (("_rms(z), float(np.abs(z[judged]).max())", "_rms(z), float(np.abs(z[judged]).min())"),),
        "tests/metrics/test_agreement.py"
        "::test_the_figures_beside_a_verdict_are_those_of_its_blocks_and_pictures",
    ),
)
