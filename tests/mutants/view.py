"""Bugs of the live view: other bits than those of a render, and doors left open."""

from tests.mutants.mutant import Mutant

SESSION, SERVER = "tests/view/test_session.py", "tests/view/test_server.py"
EDITING, INSPECTION = "tests/view/test_editing.py", "tests/view/test_inspection.py"

VIEW = (
    Mutant(
        "a camera that was moved keeps the name of the scene before",
        "compiled/recompile.py",
        (("content_hash=hash_of(parts),", "content_hash=self.compiled.content_hash,"),),
        f"{SESSION}::test_the_saved_scene_gives_the_same_picture",
    ),
    Mutant(
        "a settled film without the effect of its depth cap",
        "view/live.py",
        (("        job.record_biases()\n", ""),),
        f"{SESSION}::test_the_settled_film_is_that_of_a_render[plain]",
    ),
    Mutant(
        "a render that goes on for another view",
        "view/live.py",
        (("wish.spp is None or self._number != wish.number", "wish.spp is None"),),
        f"{SESSION}::test_a_camera_that_moves_after_more_samples_gives_its_own_picture",
    ),
    Mutant(
        "a view that has moved on is stopped by a late key",
        "view/live.py",
        ((' and self._number == self._wish.number:', ":"),),
        f"{SESSION}::test_what_is_stopped_is_the_picture_of_this_view",
    ),
    Mutant(
        "more samples cannot be stopped before the loop begins them",
        "view/live.py",
        (("if self.phase not in _ENDED and", 'if self._phase == "rendering" and'),),
        f"{SESSION}::test_more_samples_can_be_stopped_before_the_loop_begins_them",
    ),
    Mutant(
        "a state ahead of the pictures that it tells of",
        "view/mailbox.py",
        (("sorted(self._newest, key=STATE.__eq__)", "sorted(self._newest, key=STATE.__ne__)"),),
        f"{SERVER}::test_a_state_is_never_ahead_of_the_pictures_before_it",
    ),
    Mutant(
        "a new view is done as the old one was",
        "view/live.py",
        (("if phase not in _ENDED or wish is self._done:", "if True:"),),
        f"{SESSION}::test_nothing_is_done_before_the_loop_has_heard_of_it",
    ),
    Mutant(
        "sockets for the pages of strangers",
        "view/access.py",
        (('origin in (f"http://{host}", f"https://{host}") and ', ""),),
        f"{SERVER}::test_a_strangers_page_gets_no_socket",
    ),
    Mutant(
        "any name for this machine will do",
        "view/access.py",
        (("            return name in LOOPBACK\n", "            return True\n"),),
        f"{SERVER}::test_a_strangers_name_for_this_machine_is_refused",
    ),
    Mutant(
        "the tree of shapes that have moved is used again",
        "compiled/kept.py",
        (("            and np.array_equal(_bytes_of(one), _bytes_of(other))\n", ""),),
        f"{EDITING}::test_what_is_kept_is_of_equal_arguments_only",
    ),
    Mutant(
        "a page makes the server read a file",
        "view/editing.py",
        (('if found is None or found.kind == "told":', "if found is None:"),),
        f"{EDITING}::test_files_are_told_but_not_offered",
    ),
    Mutant(
        "a camera that waits for its kernels is forgotten by the next edit",
        "view/live.py",
        (("keeps_camera and (self._next is None or self._keeps_camera)", "keeps_camera"),),
        f"{EDITING}::test_a_camera_that_waits_for_its_kernels_is_in_later_edits_too",
    ),
    Mutant(
        "undo takes the camera back to where it was",
        "view/editor.py",
        (
            (
                "self.live.change(scene, keeps_camera=not is_of_camera(path))",
                "self.live.change(scene, keeps_camera=False)",
            ),
        ),
        f"{EDITING}::test_undo_leaves_a_camera_that_was_moved_where_it_is",
    ),
    Mutant(
        "the path of another pixel, where the picture is a part",
        "view/inspection.py",
        (
            (
                "at = left + min(x, width - 1), top + min(y, height - 1)",
                "at = min(x, width - 1), min(y, height - 1)",
            ),
        ),
        f"{INSPECTION}::test_a_cropped_picture_traces_its_own_pixels",
    ),
    Mutant(
        "the noise of a region as a mean over the whole picture",
        "lab/why/shares.py",
        ((" * (weights.size / weights[rows, columns].size)", ""),),
        f"{INSPECTION}::test_the_noise_of_regions_adds_up_to_that_of_the_picture",
    ),
    Mutant(
        "a denoised picture is not labelled",
        "view/painter.py",
        (("return self._denoised[2], self._denoised[3]", 'return self._denoised[2], ""'),),
        "tests/view/test_contrast.py::test_a_film_at_rest_is_denoised_on_the_page_only",
    ),
    Mutant(
        "white balance is seen but not saved",
        "view/saving.py",
        (('        "white_balance": display.white_balance,\n', ""),),
        "tests/view/test_contrast.py::test_white_balance_is_seen_and_saved",
    ),
    Mutant(
        "a lens focuses at the distance from its centre, not at that of the plane",
        "view/pose.py",
        ((
            "return -float((np.linalg.inv(self.to_world) @ [*point, 1.0])[2])",
            "return float(np.linalg.norm((np.linalg.inv(self.to_world) @ [*point, 1.0])[:3]))",
        ),),
        "tests/view/test_pose.py::test_the_depth_of_a_point_is_that_of_its_plane_of_focus",
    ),
    Mutant(
        "the command of a picture leaves out what was edited",
        "view/command.py",
        (("(*made.changes, *editor.assignments())", "made.changes"),),
        "tests/view/test_focus_and_command.py"
        "::test_the_command_gives_the_bits_of_edits_and_of_a_moved_camera",
    ),
    Mutant(
        "the command of a picture whose file is another one by now",
        "view/command.py",
        (("if content_hash(now) != content_hash(origin.scene):", "if False:"),),
        "tests/view/test_focus_and_command.py::test_a_file_that_has_changed_since_is_told",
    ),
    Mutant(
        "layers to choose from are those of the coarse picture while the camera moves",
        "view/session.py",
        (("names_with(self.live.movable.compiled.program.aovs)", "self.live.layers.names"),),
        "tests/view/test_session.py::test_layers_are_there_to_choose_while_the_camera_moves",
    ),
    Mutant(
        "counts of a growing film read after its picture",
        "view/layers.py",
        ((
            "empty = self.film.sample_count == 0\n        image = self.film.image",
            "image = self.film.image\n        empty = self.film.sample_count == 0",
        ),),
        "tests/view/test_layers.py"
        "::test_samples_that_come_while_a_picture_is_painted_leave_no_holes",
    ),
)  # fmt: skip
