"""Bugs that examples do not meet: offsets of nought, the first of several, one side of two."""

from tests.mutants.mutant import Mutant

LIFTED = "tests/formats/test_displacement.py"
TARGETS = "tests/lights/test_targets.py"
DISK = f"{TARGETS}::test_a_light_without_a_size_is_a_disk_of_its_irradiance"
BOXES = f"{TARGETS}::test_mirrors_and_glass_are_aimed_at_alike_and_everywhere"
SIZES = f"{TARGETS}::test_each_light_that_can_be_aimed_at_has_its_middle_and_its_size"
ANIMATION = "tests/rendering/test_animation.py"
FRAMES = "tests/rendering/test_files_of_frames.py"
WRAPS = "tests/formats/usd/test_wraps_of_pictures.py::test_an_axis_has_its_own_word_or_that_of_both"

BEYOND_EXAMPLES = (
    Mutant(
        "a height that reaches as far as if it had no level of rest",
        "formats/geometry/displacement.py",
        (("abs(self.scale * (end - self.midlevel))", "abs(self.scale * end)"),),
        f"{LIFTED}::test_heights_are_a_factor_and_an_offset_and_reach_as_far_as_they_can[0]",
    ),
    Mutant(
        "meshes that are counted one by one against the memory of all",
        "formats/geometry/displacement.py",
        (("        self.count += count\n", "        self.count = count\n"),),
        f"{LIFTED}::test_meshes_are_cut_until_memory_holds_no_more",
    ),
    Mutant(
        "a disk of a delta light whose edge is its radius",
        "lights/targets.py",
        (("radiance * (INV_PI / (size * size))", "radiance * (0.25 * INV_PI / (size * size))"),),
        f"{DISK}[a bulb]",
    ),
    Mutant(
        "the last of the boxes that cast caustics is never aimed at",
        "lights/targets.py",
        (
            (
                "count = _count_of_boxes(scene)",
                "count = _count_of_boxes(scene) - 1",
            ),
        ),
        BOXES,
    ),
    Mutant(
        "a lamp that is flat as a ball of its longest side",
        "compiled/light_targets.py",
        (("else np.linalg.norm(half))", "else half.max())"),),
        f"{SIZES}[nothing around]",
    ),
    Mutant(
        "a film of PNG pictures that is shown once",
        "outputs/apng.py",
        (('struct.pack(">II", length, 0)', 'struct.pack(">II", length, 1)'),),
        "tests/outputs/test_moving.py::test_every_chunk_of_an_apng_says_what_the_standard_asks",
    ),
    Mutant(
        "one memory of tiles for all threads",
        "rendering/executors/blocks.py",
        (
            (
                "ThreadPoolExecutor(count), threading.local()",
                'ThreadPoolExecutor(count), type("", (), {})()',
            ),
        ),
        "tests/rendering/test_crew.py::test_each_thread_keeps_memory_of_its_own",
    ),
    Mutant(
        "a turntable that begins where frame 0 would be",
        "rendering/animation.py",
        (("-360.0 * (number - self.numbers.start) / len", "-360.0 * number / len"),),
        f"{ANIMATION}::test_a_turntable_goes_once_around_the_middle_of_the_scene[3:7]",
    ),
    Mutant(
        "frames that share threads have the tiles of a picture alone",
        "rendering/main_loop.py",
        (("    if executor.is_shared:\n", "    if False:\n"),),
        f"{ANIMATION}::test_frames_that_share_threads_have_larger_tiles",
    ),
    Mutant(
        "an animation in which only the camera moves is taken to be still",
        "rendering/frame_scenes.py",
        (("        nodes.append(scene.camera)\n", "        pass\n"),),
        f"{ANIMATION}::test_an_animation_in_which_nothing_moves_says_so",
    ),
    Mutant(
        "a pass of an animation as long as one row",
        "rendering/animation.py",
        (("* seconds / (width * height)", "* seconds / width"),),
        f"{ANIMATION}::test_frames_after_the_first_have_passes_as_long_as_they_should_be",
    ),
    Mutant(
        "a film of frames that shows colours without their alpha",
        "rendering/animation.py",
        (("display.apply(picture.image)", "display.apply(picture.straight)"),),
        f"{FRAMES}::test_a_film_is_the_same_of_new_and_of_kept_frames",
    ),
    Mutant(
        "frames as they were before they were denoised",
        "rendering/animation.py",
        (("return denoise(film)[0] if self.single.denoise else film", "return film"),),
        f"{FRAMES}::test_frames_are_denoised_in_all_files",
    ),
    Mutant(
        "a single cell that knows its error",
        "rendering/depth_cap.py",
        (("one, replicates = len(tiles) == 1,", "one, replicates = False,"),),
        "tests/known_error/test_biases.py"
        "::test_what_a_cap_cuts_off_has_an_error_however_few_cells_are_looked_at[size1-4]",
    ),
    Mutant(
        "a render that begins over one that was stopped",
        "rendering/checkpoints/checkpoint.py",
        (("        return False\n    # A goal", "        return True\n    # A goal"),),
        "tests/rendering/test_checkpoints.py::test_a_render_is_not_begun_over_one_that_was_stopped",
    ),
    Mutant(
        "a render that begins over one that was stopped at a look",
        "rendering/checkpoints/checkpoint.py",
        (("return isinstance(schedule.next(state.rounds), Verdict)", "return True"),),
        "tests/rendering/test_stopped_at_a_look.py::test_it_is_not_over_before_its_promise_is_kept",
    ),
    Mutant(
        "a picture of 16 bits that is white",
        "outputs/png.py",
        (("float(np.iinfo(texels.dtype).max)", "255.0"),),
        "tests/outputs/test_formats.py::test_what_a_png_holds_is_read_to_its_last_bit[16]",
    ),
    Mutant(
        "pixels are known whose last replicate is empty",
        "metrics/packets.py",
        (("range(1, picture.replicates)", "range(1, picture.replicates - 1)"),),
        "tests/metrics/test_large_pictures.py"
        "::test_machine_code_adds_up_what_numpy_does[4-uneven-False]",
    ),
    Mutant(
        "shapes that are far away on one side alone",
        "compiled/warnings/sizes.py",
        (("np.maximum(np.abs(low), np.abs(high)).max(axis=1)", "high.max(axis=1)"),),
        "tests/scene/test_warnings_of_sizes.py"
        "::test_what_is_far_away_for_its_size_is_rounded[node1]",
    ),
    Mutant(
        "light tracing that sees what is in mirrors",
        "rendering/unfound_light.py",
        (
            (
                "integrator.splats and not integrator.transports",
                "integrator.splats and integrator.transports",
            ),
        ),
        "tests/rendering/test_unfound_light.py"
        "::test_caustics_of_lights_without_a_size_are_told[light-keys3-what is seen in mirrors "
        "and through clear glass is missing-bsdf0-light0]",
    ),
    Mutant(
        "strands behind one that is opaque",
        "scene/translucent_strands.py",
        (
            (
                "            if found is not None:\n",
                "            if found is None:\n                return []\n            else:\n",
            ),
        ),
        "tests/scene/test_translucent_strands.py::test_strands_are_looked_at_beyond_the_first",
    ),
    Mutant(
        "a picture's word for both axes before that for one",
        "outputs/wraps.py",
        (
            (
                'str(header.get(f"wrap{axis}", "")) or both[i % len(both)]',
                'both[i % len(both)] or str(header.get(f"wrap{axis}", ""))',
            ),
        ),
        f"{WRAPS}[clamp-black-clamp,mirror]",
    ),
    Mutant(
        "concave polygons seen along the axis that they are narrowest on",
        "meshes/concave.py",
        (("np.abs(normal).argmax()", "np.abs(normal).argmin()"),),
        "tests/meshes/test_concave_polygons.py"
        "::test_no_triangle_covers_what_the_polygon_does_not[False-comb]",
    ),
    Mutant(
        "edges of a chain of creases that each have a sharpness, by the chain",
        "formats/usd/subdivision.py",
        (("len(edges) if by_edge else chain", "chain if by_edge else len(edges)"),),
        "tests/formats/usd/test_creases.py"
        "::test_each_edge_has_its_own_sharpness_or_that_of_its_chain[0-False]",
    ),
    Mutant(
        "what a medium in coloured glass emits, as bright as from its surface",
        "integrators/interiors/collisions.py",
        (("dimmed(path.beta * absorbed * Le, left)", "(path.beta * absorbed * Le)"),),
        "tests/estimators/test_absorption.py"
        "::test_what_media_in_coloured_glass_emit_is_dimmed_from_where_it_is",
    ),
)
