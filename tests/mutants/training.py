"""Bugs of the training of guides: how long it is, and what leaves learn of distances."""

from tests.mutants.mutant import Mutant

LIGHT = "tests/guiding/test_light_records.py"
PLAN = "tests/guiding/test_training_plan.py"
TREE = "tests/guiding/test_tree.py"

TRAINING = (
    Mutant(
        "a crop that plans by its own pixels",
        "rendering/training/guide_training.py",
        (
            (
                "    width, height = scene.size\n    return Length",
                "    width, height = (scene.crop or scene.size)[-2:]\n    return Length",
            ),
        ),
        f"{PLAN}::test_a_crop_has_the_guide_of_the_whole[a guide]",
    ),
    Mutant(
        "leaves do not look a second time",
        "rendering/training/trainer.py",
        (("elif number == REFOCUS_ROUND:", "elif number == -1:"),),
        f"{PLAN}::test_leaves_look_for_light_a_second_time_once[5-1]",
    ),
    Mutant(
        "ways measured from the point, not the middle",
        "guiding/light_records.py",
        (
            (
                "near = where(moved, near / length(focus.o * near + w), near)",
                "near = where(moved, near, near)",
            ),
        ),
        f"{LIGHT}::test_sums_of_arrivals_are_those_of_their_leaves[False]",
    ),
    Mutant(
        "a limit that makes training longer",
        "rendering/training/training_plan.py",
        (
            (
                "is_long = math.isfinite(samples) and not is_limit",
                "is_long = math.isfinite(samples)",
            ),
        ),
        f"{PLAN}::test_a_limit_makes_no_training_longer",
    ),
    Mutant(
        "a guide that is used whatever it is worth",
        "rendering/training/training_plan.py",
        (("if signs.gain >= LEAST_GAIN:", "if True:"),),
        f"{PLAN}::test_gates_rise",
    ),
    Mutant(
        "all light counts alike where it is asked how far it comes from",
        "guiding/light_records.py",
        (
            (
                "sharp = flux * minimum(direction_density(guide, found, w, active), DENSEST)",
                "sharp = flux",
            ),
        ),
        f"{LIGHT}::test_sums_of_arrivals_are_those_of_their_leaves[False]",
    ),
    Mutant(
        "a new focus where light comes from everywhere",
        "guiding/tree.py",
        (("focus[few, 3] = radius[few]", "focus[:, 3] = radius"),),
        f"{TREE}::test_a_new_focus_forgets_nothing",
    ),
    Mutant(
        "short pictures that never look at a guide",
        "rendering/training/training_plan.py",
        (("GATES = {2: 0.0, 3: 0.5,", "GATES = {3: 0.5,"),),
        f"{PLAN}::test_short_pictures_follow_a_guide_that_promises_early",
    ),
    Mutant(
        "every guide is promising",
        "rendering/training/training_plan.py",
        (("if signs.promising else", "if signs.noise >= NOISY else"),),
        f"{PLAN}::test_short_pictures_follow_a_guide_that_promises_early",
    ),
    Mutant(
        "guides that promise whatever the noise",
        "rendering/training/training_plan.py",
        (("self.gain >= PROMISING and self.noise >= NOISY", "self.gain >= PROMISING"),),
        f"{PLAN}::test_short_pictures_follow_a_guide_that_promises_early",
    ),
    Mutant(
        "one more round than the picture is worth",
        "rendering/training/training_plan.py",
        (
            (
                "signs.gain >= GATES[number] and self._spent(number + 1)",
                "signs.gain >= GATES[number] and self._spent(number)",
            ),
        ),
        f"{PLAN}::test_a_guide_that_never_pays_costs_little",
    ),
    Mutant(
        "the samples of one part in place of the whole render's",
        "rendering/schedules/selection.py",
        (
            (
                "    return options.spp or own_spp or SPP, False",
                "    return (options.spp or 0) // (options.part or (1, 1))[1] or own_spp, False",
            ),
        ),
        f"{PLAN}::test_parts_plan_with_the_whole_render",
    ),
)
