"""Bugs of renders by several processes or machines."""

from tests.mutants.mutant import Mutant

PARTS = "tests/cli/test_parts.py"
TASKS = "tests/cluster/test_block_tasks.py"
LIGHT = "tests/cluster/test_light_tasks.py"
SHARED = "tests/cluster/test_shared_file.py"
DISPATCH = "tests/cluster/test_dispatch.py"
FILMS = "tests/cluster/test_films.py"
STUDIES = "tests/cluster/test_studies.py"
FORKS = "tests/cluster/test_fork_server.py"

CLUSTER = (
    Mutant(
        "parts that forget the first sample",
        "rendering/schedules/selection.py",
        (("Uniform(whole.first + begin, end - begin)", "Uniform(begin, end - begin)"),),
        f"{PARTS}::test_parts_hold_each_sample_once_and_are_equal_but_for_one",
    ),
    Mutant(
        "a missing part merged all the same",
        "films/merging.py",
        (("if (count == spp).all():", "if (count <= spp).all():"),),
        f"{PARTS}::test_a_missing_part_is_told_by_the_exit_code",
    ),
    Mutant(
        "a cut block whose halves share a sample",
        "rendering/executors/cluster_executor.py",
        (
            (
                "np.stack([first + taken, count - taken]",
                "np.stack([first + taken - 1, count - taken]",
            ),
        ),
        f"{TASKS}::test_tasks_hold_each_sample_once",
    ),
    Mutant(
        "the rest of a cut block forgotten",
        "rendering/executors/cluster_executor.py",
        (("self._blocks.append(rest)", "pass"),),
        f"{TASKS}::test_tasks_hold_each_sample_once",
    ),
    Mutant(
        "workers with a seed of their own",
        "rendering/executors/block_tasks.py",
        (("shared.settings._replace(seed=task.seed)", "shared.settings"),),
        f"{TASKS}::test_an_answer_is_the_sums_of_its_blocks",
    ),
    Mutant(
        "answers with other samples than asked for let in",
        "rendering/executors/block_tasks.py",
        (("if (_array(arrays, name, expected.shape) != expected).any():", "if False:"),),
        f"{TASKS}::test_a_malformed_answer_is_refused",
    ),
    Mutant(
        "what two renders share under one name",
        "cluster/worker.py",
        (('{self.digest[:16]}-{uuid.uuid4().hex}"', '{self.digest[:16]}"'),),
        f"{DISPATCH}::test_two_renders_of_the_same_take_nothing_from_each_other",
    ),
    Mutant(
        "frames on a cluster one after the other",
        "rendering/animation.py",
        (("(self.threads == 1 and self.single.cluster is None)", "self.single.cluster"),),
        f"{FILMS}::test_frames_of_an_animation_are_those_of_one_machine",
    ),
    Mutant(
        "answers of another task let in",
        "rendering/executors/block_tasks.py",
        (('if archive.content["task"] != task.digest:', "if False:"),),
        f"{TASKS}::test_a_malformed_answer_is_refused",
    ),
    Mutant(
        "an answer that leaves its task open, to be answered again",
        "cluster/dispatch.py",
        (("        self._forget(number)\n        take(", "        take("),),
        f"{DISPATCH}::test_every_task_is_answered_once",
    ),
    Mutant(
        "a failing task sent once too often",
        "cluster/dispatch.py",
        (("if issue.failures < MOST_FAILURES:", "if issue.failures <= MOST_FAILURES:"),),
        f"{DISPATCH}::test_a_failing_task_is_tried_again_and_at_last_done_here",
    ),
    Mutant(
        "tasks of a worker that the scene did not reach",
        "cluster/worker.py",
        (("if shared.name not in get_worker().plugins:", "if False:"),),
        f"{DISPATCH}::test_workers_that_the_scene_did_not_reach_are_brought_it",
    ),
    Mutant(
        "workers of any fingerprint let in",
        "cluster/worker.py",
        (("if fingerprint(asked.target) != asked.fingerprint:", "if False:"),),
        f"{DISPATCH}::test_a_worker_of_another_fingerprint_is_refused",
    ),
    Mutant(
        "late tasks not issued again",
        "cluster/dispatch.py",
        (("if not late:", "if True:"),),
        f"{DISPATCH}::test_a_late_task_is_issued_again_and_its_first_answer_counts",
    ),
    Mutant(
        "the most samples of a pixel taken for its last one",
        "rendering/checkpoints/resume.py",
        (
            ("ends = (end for cell in", "ends = (cell.count for cell in"),
            ("cells.flat for _, end in cell)", "cells.flat)"),
        ),
        "tests/rendering/test_samples_out_of_order.py"
        "::test_samples_that_came_out_of_order_leave_no_hole",
    ),
    Mutant(
        "keys that lie beside the current folder, not beside the cluster file",
        "cluster/files.py",
        (('Path(path).parent / data["keys"]', 'data["keys"]'),),
        "tests/cluster/test_files.py::test_keys_lie_beside_the_file_unless_others_are_given",
    ),
    Mutant(
        "seconds that are no number let in",
        "cluster/files.py",
        (("not 0 < value < math.inf", "value <= 0"),),
        "tests/cluster/test_files.py::test_a_wrong_file_is_refused_before_anything_starts",
    ),
    Mutant(
        "answers of another replicate let in",
        "lab/replicates/spread.py",
        (('if content["task"] != task.digest:', "if False:"),),
        f"{STUDIES}::test_a_malformed_answer_is_refused",
    ),
    Mutant(
        "times of different processors compared",
        "lab/replicates/spread.py",
        (("if equal_time and others:", "if False:"),),
        f"{STUDIES}::test_times_of_another_processor_are_refused_or_marked",
    ),
    Mutant(
        "a store that does not know what replicates were timed on",
        "lab/store.py",
        (("if replicate.processor:", "if False:"),),
        "tests/lab/test_store.py::test_processors_are_those_of_an_arm",
    ),
    Mutant(
        "equal times of another processor taken from the store",
        "lab/replicates/run_blocks.py",
        (("if others := sorted(found - {own}):", "if others := []:"),),
        f"{STUDIES}::test_times_of_another_processor_in_the_store_are_refused_or_marked",
    ),
    Mutant(
        "files of clusters that speak without encryption",
        "cluster/files.py",
        (
            (
                '{"processes": 1, **file.options, "protocol": "tls://", "security": security}',
                '{"processes": 1, "protocol": "tls://", "security": security, **file.options}',
            ),
        ),
        "tests/cluster/test_files.py::test_options_of_a_file_do_not_open_a_queue_to_others",
    ),
    Mutant(
        "light paths of the next replicate",
        "rendering/executors/light_tasks.py",
        (("first + (self.replicate - first) % self.replicates", "first"),),
        f"{LIGHT}::test_tasks_and_what_is_left_of_them_hold_each_sample_once",
    ),
    Mutant(
        "a strip taken for the whole window",
        "rendering/executors/light_tasks.py",
        (("        if key not in self._pending:", "        if True:"),),
        f"{LIGHT}::test_tasks_and_what_is_left_of_them_hold_each_sample_once",
    ),
    Mutant(
        "sums of strips that are not joined",
        "rendering/executors/light_tasks.py",
        (("    add_sums(a.sums, b.sums)\n", ""),),
        f"{LIGHT}::test_answers_add_up_to_the_film_of_a_render",
    ),
    Mutant(
        "a shared file of other bytes",
        "cluster/shared_file.py",
        (("if not ours or hashlib", "if False and hashlib"),),
        f"{SHARED}::test_a_file_of_other_bytes_is_not_used",
    ),
    Mutant(
        "a server of forks that waits until options are checked",
        "cli/words.py",
        (
            (
                """            if first is not None:
                first(said)
            command(**texts, options=table.parsed(said))
""",
                """            options = table.parsed(said)
            if first is not None:
                first(said)
            command(**texts, options=options)
""",
            ),
        ),
        f"{FORKS}::test_the_server_starts_before_anything_heavy_is_imported",
    ),
    Mutant(
        "processes that nobody ends",
        "rendering/executors/cluster_executor.py",
        (("thread.submit(self._stack.enter_context, found)", "thread.submit(found.__enter__)"),),
        f"{FORKS}::test_processes_that_are_still_starting_end_with_a_render_that_fails",
    ),
)
