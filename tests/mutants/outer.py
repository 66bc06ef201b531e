"""Bugs of what users touch: commands, reports, comparisons, clusters, views and films."""

from tests.mutants.mutant import Mutant

THIN = "tests/cli/test_thin.py"
DRAWN = "tests/lab/report/test_what_is_drawn.py"
COMPARE, INPUTS = "tests/lab/compare/test_compare.py", "tests/lab/compare/test_inputs.py"

OUTER = (
    Mutant(
        "the status of a cluster for another target than that of renders",
        "cli/cluster.py",
        (("    ] = NATIVE,\n", '    ] = "portable",\n'),),
        f"{THIN}::test_the_status_of_a_cluster_is_that_of_what_renders_use",
    ),
    Mutant(
        "commands of clusters end in a traceback",
        "cli/main.py",
        (("cluster.command()(reporting_errors(command))", "cluster.command()(command)"),),
        f"{THIN}::test_every_command_reports_what_its_user_can_mend",
    ),
    Mutant(
        "the line of a fit with the slope of its lower bound",
        "lab/report/charts.py",
        (("kinds.append((line.slope.value, 1.4", "kinds.append((line.slope.low, 1.4"),),
        f"{DRAWN}::test_fitted_lines_have_the_slope_that_is_written_beside_them",
    ),
    Mutant(
        "colours of arms counted with the baseline",
        "lab/report/style.py",
        (("_COLORS[n % len(_COLORS)], mark", "_COLORS[i % len(_COLORS)], mark"),),
        f"{DRAWN}::test_looks_repeat_only_where_all_colours_are_taken",
    ),
    Mutant(
        "heads of a table one column to the left",
        "lab/report/page.py",
        (("heads[1:], rows, [])", "heads[:-1], rows, [])"),),
        f"{DRAWN}::test_a_table_of_a_study_shows_each_value_under_its_own_head",
    ),
    Mutant(
        "whole numbers below a power of ten that they are not divided by",
        "lab/report/page.py",
        (("_numbers(cell)[:1]], plain=plain)", "_numbers(cell)[:1]])"),),
        f"{DRAWN}::test_a_table_of_a_study_shows_each_value_under_its_own_head",
    ),
    Mutant(
        "digits of a bias by its size",
        "lab/report/tables.py",
        (("[e.high - e.low for e in estimates if e]", "[e.high for e in estimates if e]"),),
        f"{DRAWN}::test_the_digits_of_a_bias_are_those_of_its_noise",
    ),
    Mutant(
        "a page whose suffix is in capitals is tried without its packages",
        "lab/report/targets.py",
        (("    if suffix in drawn:", "    if path.suffix in drawn:"),),
        "tests/lab/report/test_report.py"
        "::test_missing_packages_are_named_with_the_remedy_and_nothing_is_written",
    ),
    Mutant(
        "biases of a picture are not told",
        "lab/picture_info.py",
        (('"fingerprint", "biases")', '"fingerprint")'),),
        "tests/lab/test_picture_info.py::test_a_picture_of_that_film_tells_the_same_origin",
    ),
    Mutant(
        "the noise of a rendered reference passes for one that was stated",
        "lab/references.py",
        (
            (
                'facts["spp"], _relative(image, variance), False,',
                'facts["spp"], _relative(image, variance), True,',
            ),
        ),
        "tests/lab/test_references.py::test_references_belong_to_the_seed_of_the_study",
    ),
    Mutant(
        "counts of samples as one more channel of a layer",
        "lab/compare/inputs.py",
        (('not in ("A", "samples")]', 'not in ("A",)]'),),
        f"{INPUTS}::test_the_only_channel_of_a_layer_is_its_picture",
    ),
    Mutant(
        "tests of one picture missing where another has none",
        "lab/compare/views.py",
        (("if any(c.agreement for c in found):", "if all(c.agreement for c in found):"),),
        f"{COMPARE}::test_a_picture_without_known_noise_has_its_column_beside_one_that_has",
    ),
    Mutant(
        "bounds of a comparison in the other order",
        "metrics/comparison.py",
        (
            (
                "    rms_low: float\n    rms_high: float\n",
                "    rms_high: float\n    rms_low: float\n",
            ),
        ),
        "tests/metrics/test_comparison.py::test_the_bounds_of_a_report_are_around_one",
    ),
    Mutant(
        "sums of joined rows without a carry",
        "films/coverage.py",
        (("        fixed_point.carry(added)\n", ""),),
        "tests/film/test_mattes.py::test_rows_that_are_joined_are_canonical",
    ),
    Mutant(
        "memory kept after a picture that is broken",
        "outputs/texels.py",
        (
            (
                "    try:\n        yield\n    finally:\n        _blocks.close()",
                "    yield\n    _blocks.close()",
            ),
        ),
        "tests/textures/test_pictures_in_scenes.py"
        "::test_memory_of_pictures_is_kept_only_while_more_are_read",
    ),
    Mutant(
        "the header of a PFM file counts as pixels",
        "outputs/pfm.py",
        (("if len(data) - start < size:", "if len(data) < size:"),),
        "tests/outputs/test_formats.py::test_a_pfm_that_was_cut_says_how_many_bytes_there_are",
    ),
    Mutant(
        "rays to lamps drawn beyond them",
        "view/inspection.py",
        (("far = min(light.distance, _FAR * pose.distance)", "far = _FAR * pose.distance"),),
        "tests/view/test_inspection.py"
        "::test_rays_to_lamps_end_there_and_are_shadows_where_something_is_between",
    ),
    Mutant(
        "the interval of another ratio behind an efficiency",
        "lab/why/words.py",
        (
            (
                "x {value:.3g} [{low:.3g}, {high:.3g}]",
                "x {value:.3g} [{least:.3g}, {most:.3g}]",
            ),
        ),
        "tests/lab/test_why.py::test_each_figure_of_a_trial_stands_behind_its_name",
    ),
    Mutant(
        "brackets of an address looked up with it",
        "cluster/addresses.py",
        (('host.strip("[]"), int(port)', "host, int(port)"),),
        "tests/cluster/test_files.py::test_addresses_in_brackets_are_looked_up_without_them",
    ),
    Mutant(
        "arrays that follow their file",
        "outputs/npy.py",
        (('"r" if mapped else None', 'None if mapped else "r"'),),
        "tests/outputs/test_formats.py"
        "::test_an_array_that_was_read_stays_as_it_is_when_its_file_changes",
    ),
    Mutant(
        "ladders without the guide that was trained for them",
        "lab/replicates/measure.py",
        (
            (
                "replicates=replicates, guide=scene.guide)\n    tiles",
                "replicates=replicates)\n    tiles",
            ),
        ),
        "tests/lab/test_measure.py::test_a_ladder_follows_the_guide_that_was_trained_for_it",
    ),
    Mutant(
        "the picture whose noise is known is said to be taken as exact",
        "lab/compare/figures.py",
        (
            (
                "for one in (a, b) if one.error is None]  # fmt",
                "for one in (a, b) if one.error is not None]  # fmt",
            ),
        ),
        f"{COMPARE}::test_a_picture_of_unknown_noise_is_taken_as_exact_and_that_is_said",
    ),
    Mutant(
        "a notebook says of a picture that was written that it was stopped",
        "view/notebook.py",
        (('"done" if is_whole else "stopped"', '"stopped" if self._cancel.is_set() else "done"'),),
        "tests/view/test_notebook.py::test_a_stop_while_its_files_are_written_comes_too_late",
    ),
    Mutant(
        "prototypes of a tree are its nodes once more",
        "lab/info.py",
        (("yield from _branches(scene.prototypes)", "yield from _branches(scene.nodes)"),),
        "tests/cli/test_commands.py::test_the_tree_shows_what_instances_are_of",
    ),
    Mutant(
        "a column of a file with the number of another",
        "lab/report/data_files.py",
        (('_spread("efficiency", arm.efficiency)', '_spread("efficiency", arm.slope_spp)'),),
        f"{DRAWN}::test_each_column_of_a_file_of_arms_has_its_own_number",
    ),
    Mutant(
        "the first picture of a panel is called the reference",
        "lab/compare/views.py",
        (('"reference" if i == count - 1 else', '"reference" if i == 0 else'),),
        f"{COMPARE}::test_a_panel_says_which_picture_is_the_reference",
    ),
    Mutant(
        "a guide is drawn without the warnings of its scene",
        "cli/guide.py",
        (("    warn_of_scene(description)\n", ""),),
        f"{THIN}::test_a_command_passes_on_what_was_typed",
    ),
    Mutant(
        "frames are denoised without the layers that a denoiser asks for",
        "rendering/animation.py",
        (("self.prepared.options.with_loaded_scene()", "single.with_loaded_scene()"),),
        "tests/rendering/test_files_of_frames.py::test_frames_are_denoised_in_all_files",
    ),
    Mutant(
        "a film that starts anew is said to start where it was stopped",
        "cli/frames.py",
        (("starts at frame {made.numbers.start} again", "starts at frame {made.current} again"),),
        f"{THIN}::test_frames_that_were_stopped_say_where_the_same_command_begins",
    ),
    Mutant(
        "variances of channels over the number of pictures",
        "metrics/comparison.py",
        (
            (
                "channels.mean(axis=0), channels.var(axis=0, ddof=1),",
                "channels.mean(axis=0), channels.var(axis=0),",
            ),
        ),
        "tests/metrics/test_comparison.py"
        "::test_statistics_of_pictures_are_means_and_unbiased_variances",
    ),
    Mutant(
        "a coarse picture that does not know yet of which view it is",
        "view/live.py",
        (
            (
                "            layers.number = wish.number\n            # Whoever",
                "            # Whoever",
            ),
        ),
        "tests/view/test_session.py"
        "::test_every_picture_bears_the_number_of_its_view_from_the_moment_it_is_there",
    ),
    Mutant(
        "a cluster that does not start leaves its loop behind",
        "cluster/addresses.py",
        (("                self._loop_runner.stop()\n", ""),),
        "tests/cluster/test_commands.py"
        "::test_a_cluster_that_does_not_start_leaves_no_thread_behind",
    ),
    Mutant(
        "the seconds of a study begin at one",
        "lab/replicates/session.py",
        (('"statistics"), 0.0', '"statistics"), 1.0'),),
        "tests/lab/test_measure.py::test_the_seconds_of_a_study_begin_at_nought_and_are_its_own",
    ),
)
