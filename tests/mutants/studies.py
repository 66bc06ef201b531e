"""Bugs of a study's references, verdicts and equal times."""

from tests.mutants.mutant import Mutant

VOTE = "tests/lab/test_agreement.py"
TIME = "tests/lab/test_equal_time.py"
NOISE = "tests/lab/test_noise_only.py"
REFERENCES = "tests/lab/test_references.py"

MEASURE = "tests/lab/test_measure.py"

STUDIES = (
    Mutant(
        "the time of the whole program",
        "lab/replicates/measure.py",
        (
            (
                "        begin = time.thread_time()\n        parts",
                "        begin = time.process_time()\n        parts",
            ),
            (
                "seconds += time.thread_time() - begin\n        done",
                "seconds += time.process_time() - begin\n        done",
            ),
        ),
        f"{MEASURE}::test_other_threads_of_the_program_cost_nothing",
    ),
    Mutant(
        "a reference by another arm than the baseline",
        "lab/references.py",
        (("return baseline if baseline in fit or not fit else fit[0]", "return fit[-1]"),),
        f"{REFERENCES}::test_a_dark_arm_is_named_and_renders_no_reference",
    ),
    Mutant(
        "a wrong baseline that stays the reference",
        "lab/pictures.py",
        (("if is_named(scene) or verdicts[first] != BIASED or not heirs:", "if True:"),),
        f"{REFERENCES}::test_a_dark_baseline_is_named_and_another_arm_renders_the_reference",
    ),
    Mutant(
        "pilots of every study alike",
        "lab/pictures.py",
        (("(arm.key, arm.spec.name, session.study.seed)", "(arm.key, arm.spec.name)"),),
        f"{REFERENCES}::test_pilots_belong_to_an_arm_and_to_the_seed_of_the_study",
    ),
    Mutant(
        "half of the arms for a majority",
        "lab/statistics/agreement.py",
        (("range(len(names) // 2 + 1, len(names) + 1)", "range(len(names) // 2, len(names) + 1)"),),
        f"{VOTE}::test_who_is_named",
    ),
    Mutant(
        "the smallest of many p-values as it is",
        "lab/statistics/agreement.py",
        (("min(1.0, len(inside) * inside[0])", "inside[0]"),),
        f"{VOTE}::test_the_p_value_is_that_of_the_majority_that_agrees_best",
    ),
    Mutant(
        "an arm that its own reference contradicts",
        "lab/statistics/agreement.py",
        (("if a in members and b in members]", "if a in members and b in members and a != b]"),),
        f"{VOTE}::test_an_arm_that_its_own_reference_contradicts_is_named",
    ),
    Mutant(
        "the nearer number of samples with the lesser weight",
        "lab/statistics/equal_time.py",
        (("(1.0 - w, w), strict=True)", "(w, 1.0 - w), strict=True)"),),
        f"{TIME}::test_a_power_law_is_met_exactly",
    ),
    Mutant(
        "an arm's own time left out",
        "lab/statistics/equal_time.py",
        (
            (
                'self._between(JUDGED) + self._between("seconds", -self.slope)',
                "self._between(JUDGED)",
            ),
        ),
        f"{TIME}::test_a_speed_up_is_the_ratio_of_errors_in_one_time",
    ),
    Mutant(
        "an error that would not fall with the baseline's time",
        "lab/statistics/equal_time.py",
        (("(clock, own - other.slope)", "(clock, own)"),),
        f"{TIME}::test_a_speed_up_is_the_ratio_of_errors_in_one_time",
    ),
    Mutant(
        "any number of samples taken for a natural one",
        "lab/statistics/equal_time.py",
        (("        whole *= 2\n", "        whole += 1\n"),),
        f"{TIME}::test_natural_counts_are_doubled_blocks_of_every_replicate",
    ),
    Mutant(
        "a block as long as its side",
        "samplers/stratified.py",
        (("return self.strata**2", "return self.strata"),),
        f"{TIME}::test_a_block_is_one_whole",
    ),
    Mutant(
        "compensation of facets for a matter of noise",
        "core/noise_only.py",
        (
            (
                "if NoiseOnly() in field.metadata",
                'if NoiseOnly() in field.metadata or name == "compensation"',
            ),
        ),
        f"{NOISE}::test_a_material_scatters_the_same",
    ),
    Mutant(
        "choices inside of lists overlooked",
        "lab/arms.py",
        (("items = tuple(map(without_choices, value))", "items = value"),),
        f"{NOISE}::test_choices_inside_of_materials_are_found",
    ),
)
