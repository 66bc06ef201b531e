"""Bugs of objects of other packages as scenes, and of transparent backgrounds."""

from tests.mutants.mutant import Mutant

TESTS = "tests/formats/test_objects.py"
KEPT = "tests/compiled/test_recompile.py"
MOVES = "tests/rendering/test_animation.py"
AOVS = "tests/rendering/test_aovs.py"
FORMATS = "tests/outputs/test_formats.py"

OBJECTS = (
    Mutant(
        "lines counted as no cells of a surface",
        "formats/objects/vtk_objects.py",
        (("polygon += surface.GetNumberOfVerts() + surface.GetNumberOfLines()", "polygon += 0"),),
        f"{TESTS}::test_polygons_of_vtk_stand_upright_in_the_colours_of_their_cells",
    ),
    Mutant(
        "numbers of faces interpolated from face to face",
        "formats/objects/assembly.py",
        (("np.repeat(painted, 3, axis=0)", "np.concatenate([painted] * 3)"),),
        f"{TESTS}::test_numbers_of_faces_leave_no_vertex_to_two_faces",
    ),
    Mutant(
        "the ends of a colour map at the edges of its texels",
        "formats/objects/color_maps.py",
        (("(0.5 + (TEXELS - 1) * np.where(is_none, 0.0, t)) / TEXELS", "np.where(is_none, 0, t)"),),
        f"{TESTS}::test_numbers_lie_where_the_map_has_their_colour",
    ),
    Mutant(
        "edges smooth up to twice the angle",
        "formats/objects/creases.py",
        (("np.cos(np.radians(0.5 * angle))", "np.cos(np.radians(angle))"),),
        f"{TESTS}::test_only_faces_within_the_angle_share_a_normal",
    ),
    Mutant(
        "coverage draws holes of its own",
        "integrators/coverage.py",
        (("u = get_1d(path.sampler, dimension + BSDF_CHOICE)\n                u2",
          "u = get_1d(path.sampler, dimension + BSDF_CHOICE + 16)\n                u2"),),
        f"{AOVS}::test_alpha_and_the_light_beside_black_surfaces_are_all_of_a_pixel",
    ),
    Mutant(
        "the sky seen through holes of a picture without background",
        "integrators/reach.py",
        (("first = path.delta & (path.pdf == 0.0)", "first = path.depth == 0"),),
        f"{AOVS}::test_a_transparent_background_shows_no_light_and_hides_it_from_alpha",
    ),
    Mutant(
        "PNG with colours multiplied by alpha",
        "outputs/png.py",
        (("image, bits = picture.straight", "image, bits = picture.image"),),
        f"{FORMATS}::test_png_keeps_straight_alpha_and_exr_what_is_multiplied_by_it",
    ),
    Mutant(
        "the last scene taken whatever else changed",
        "compiled/recompile.py",
        (("return a is b or (not isinstance(a, Mapping) and a == b)", "return True"),),
        f"{KEPT}::test_whatever_else_changes_is_compiled_to_the_bits_of_a_fresh_scene",
    ),
    Mutant(
        "a scene that was compiled before its model was registered anew",
        "compiled/recompile.py",
        (("known != versions(described(last.flat)) or ", ""),),
        "tests/extension/test_register.py::test_what_was_compiled_of_a_scene_is_of_the_version_of_its_models",
    ),
    Mutant(
        "the hash of the camera before",
        "compiled/recompile.py",
        (("camera_part(placed), *self.parts", "camera_part(self.flat.camera), *self.parts"),),
        f"{KEPT}::test_another_camera_takes_what_is_known_and_has_the_hash_of_a_fresh_scene",
    ),
    Mutant(
        "frames kept because they exist",
        "rendering/animation.py",
        (("if label_in(path) != label]", "if not path.exists()]"),),
        f"{MOVES}::test_only_frames_that_are_whole_and_of_these_settings_are_kept",
    ),
    Mutant(
        "the shutter in seconds",
        "rendering/frame_scenes.py",
        (("shutter = ((number + opens) / fps, (number + closes) / fps)",
          "shutter = (number / fps + opens, number / fps + closes)"),),
        f"{MOVES}::test_frames_lie_between_the_frames_before_and_after",
    ),
    Mutant(
        "frames in the order in which they end",
        "rendering/animation.py",
        (("yield begun.popleft().result()", "yield begun.pop().result()"),),
        f"{MOVES}::test_two_frames_in_work_give_what_one_gives",
    ),
    Mutant(
        "frames begun after one that failed",
        "rendering/animation.py",
        (("many - len(begun)):", "9):"),),
        f"{MOVES}::test_no_frame_is_begun_after_one_that_fails",
    ),
    Mutant(
        "frames in whole hundredths of a second",
        "outputs/apng.py",
        (("w, h, 0, 0, 1, fps, 0, 0)", "w, h, 0, 0, round(100 / fps), 100, 0, 0)"),),
        "tests/outputs/test_moving.py::test_apng_keeps_frames_that_are_alike_and_their_exact_time",
    ),
    Mutant(
        "frames that wait for the end of a film",
        "outputs/moving.py",
        (("queue.Queue(_WAITING)", "queue.Queue()"),),
        "tests/outputs/test_moving.py::test_frames_do_not_wait_in_memory_for_the_end",
    ),
)  # fmt: skip
