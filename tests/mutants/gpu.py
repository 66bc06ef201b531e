"""Bugs of renders on a GPU."""

from tests.mutants.mutant import Mutant

EXECUTOR = "rendering/executors/gpu_executor.py"
FILMS, WORK = "tests/gpu/test_gpu_films.py", "tests/gpu/test_work.py"

GPU = (
    Mutant(
        "two threads render the same sample",
        EXECUTOR,
        (("count * (share + 1) // shares\n", "count * (share + 1) // shares + 1\n"),),
        f"{WORK}::test_each_sample_is_rendered_once",
    ),
    Mutant(
        "two threads write to one place",
        EXECUTOR,
        (("at = share * pixels + before + place", "at = before + place"),),
        f"{WORK}::test_each_sample_is_rendered_once",
    ),
    Mutant(
        "one table that is too small beside three that are not",
        EXECUTOR,
        (("if any(size > there", "if all(size > there"),),
        f"{WORK}::test_each_table_has_the_room_that_it_needs",
    ),
    Mutant(
        "films of a GPU in the processor's name",
        EXECUTOR,
        (("**describe_machine(PTX), **self._gpu.description", "**describe_machine()"),),
        f"{FILMS}::test_films_of_both_are_not_added",
    ),
    Mutant(
        "direct light counted as indirect, too",
        EXECUTOR,
        (("sums.sum(axis=2) - direct", "sums.sum(axis=2)"),),
        f"{FILMS}::test_layers_of_direct_and_indirect_light_have_the_same_sums",
    ),
)
