"""Bugs of readers and writers that no test found, with the laws that do now."""

from tests.mutants.mutant import Mutant

G = "tests/formats/gltf/test_general_places.py"
W = "tests/formats/gltf/test_written_defaults.py"
MAPS = "tests/formats/test_options_of_maps.py"
SPELLED = "tests/meshes/test_spellings.py"
SCOPES = "tests/formats/materialx/test_scopes.py"
FACES = "tests/formats/usd/test_faces.py"
SOLIDS = "tests/formats/usd/test_solids.py"
CAMERAS = "tests/formats/usd/test_cameras.py"
DOMES = "tests/formats/usd/test_lights.py"
PLACES = "tests/formats/usd/test_places.py"
SKINS = "tests/formats/usd/test_skins_askew.py"
RANGES = "tests/formats/usd/test_ranges.py"
NAMES = "tests/formats/pbrt/test_names_of_textures.py"
RADIANCE = "tests/outputs/test_radiance.py"
FRAMES = "tests/formats/mitsuba/test_laws_of_frames.py"
KEPT = "tests/formats/pbrt/test_kept_transforms.py"
ORDER = "tests/formats/pbrt/test_order_plays_no_part.py"

READERS = (
    Mutant(
        "a body of glTF whose reflection has the strength of glass",
        "formats/gltf/bodies.py",
        (
            (
                "ior = index_of(specular * reflectance(ior))",
                "ior = index_of(specular * reflectance(1.5))",
            ),
        ),
        f"{G}::test_the_reflection_of_a_body_is_that_of_its_index_by_its_strength",
    ),
    Mutant(
        "deep nodes of glTF that stand before those above them",
        "formats/gltf/nodes.py",
        (
            (
                "own = matrix if task.before is None else task.before @ matrix",
                "own = matrix if task.before is None else matrix @ task.before",
            ),
        ),
        f"{G}::test_every_node_of_a_chain_stands_where_the_product_says",
    ),
    Mutant(
        "morph targets that rest where their node has a matrix",
        "formats/gltf/animations.py",
        (('if "matrix" in node and path != "weights":', 'if "matrix" in node:'),),
        f"{G}::test_targets_of_a_node_with_a_matrix_are_animated",
    ),
    Mutant(
        "a spot that is written without its soft edge",
        "formats/gltf/write.py",
        (("beam = 0.75 * fields", "beam = 1.0 * fields"),),
        f"{W}::test_a_spot_is_even_as_far_as_ours_is",
    ),
    Mutant(
        "a written coat with bumps deeper than those below it",
        "formats/gltf/write_materials.py",
        (
            (
                'coat["clearcoatNormalTexture"] = below',
                'coat["clearcoatNormalTexture"] = {**below, "scale": 1.0}',
            ),
        ),
        f"{W}::test_a_coat_says_whether_it_follows_the_bumps_below",
    ),
    Mutant(
        "one scale of an MTL picture for both of its sides",
        "formats/obj/maps.py",
        (("scale = [*values, 1.0][:2]", "scale = [*values, values[0]][:2]"),),
        f"{MAPS}::test_pictures_are_scaled_and_then_shifted",
    ),
    Mutant(
        "corners that count back from the last vertex in all tables",
        "meshes/obj.py",
        (
            (
                "index - 1 if index > 0 else counts[i] + index",
                "index - 1 if index > 0 else counts[0] + index",
            ),
        ),
        f"{SPELLED}::test_corners_of_obj_files_count_from_the_start_or_from_the_end",
    ),
    Mutant(
        "corners that are counted back from an earlier end",
        "meshes/obj.py",
        (('if b"-" not in word:', 'if b"+" not in word:'),),
        f"{SPELLED}::test_corners_of_obj_files_count_from_the_start_or_from_the_end",
    ),
    Mutant(
        "corners of OBJ files without coordinates take those of the first row",
        "meshes/obj.py",
        (("(keys < 0) & _IS_UV, len(uvs), keys)", "(keys < 0) & _IS_UV, 0, keys)"),),
        "tests/formats/test_messy_obj.py::"
        "test_faces_keep_their_texture_coordinates_beside_faces_without_any",
    ),
    Mutant(
        "headers of PLY with ends of lines of one kind",
        "meshes/ply_header.py",
        (('.replace("\\r", "\\n")', ""),),
        f"{SPELLED}::test_ply_files_hold_what_was_put_into_them",
    ),
    Mutant(
        "a PLY header whose remarks are properties",
        "meshes/ply_header.py",
        (('("ply", "comment", "obj_info")', '("ply", "comment")'),),
        f"{SPELLED}::test_ply_files_hold_what_was_put_into_them",
    ),
    Mutant(
        "an element of PLY with two counts",
        "meshes/ply_header.py",
        (
            (
                'words[0] == "element" and len(words) == 3',
                'words[0] == "element" and len(words) >= 3',
            ),
        ),
        f"{SPELLED}::test_headers_that_make_no_sense_are_refused",
    ),
    Mutant(
        "lists of floats that are refused for what they hold",
        "meshes/ply_header.py",
        (('TYPES[kinds[0]][0] == "f"', 'TYPES[kinds[1]][0] == "f"'),),
        f"{SPELLED}::test_lists_of_floats_may_be_counted_by_whole_numbers",
    ),
    Mutant(
        "rows of PLY that are all as long as the first and one more",
        "meshes/ply.py",
        (
            (
                'if any((rows[f"n{i}"] != length).any() for i, length in lengths.items()):',
                'if any((rows[f"n{i}"] != length).all() for i, length in lengths.items()):',
            ),
        ),
        f"{SPELLED}::test_ply_files_hold_what_was_put_into_them",
    ),
    Mutant(
        "faces that strips take the place of",
        "meshes/ply.py",
        (
            (
                "faces = np.concatenate([faces, _to_indices(more, len(vertices))])",
                "faces = _to_indices(more, len(vertices))",
            ),
        ),
        f"{SPELLED}::test_ply_files_hold_what_was_put_into_them",
    ),
    Mutant(
        "a colour space of a file before that of a node",
        "formats/materialx/document.py",
        (
            (
                "child.attributes.setdefault(key, root.attributes[key])",
                "child.attributes[key] = root.attributes[key]",
            ),
        ),
        f"{SCOPES}::test_the_inner_one_counts",
    ),
    Mutant(
        "two prefixes of a file name, one behind the other",
        "formats/materialx/document.py",
        (
            (
                '(prefix or top.attributes.get("fileprefix", "")) + text',
                'prefix + top.attributes.get("fileprefix", "") + text',
            ),
        ),
        f"{SCOPES}::test_the_inner_one_counts",
    ),
    Mutant(
        "what is included looks beside what includes it",
        "formats/materialx/document.py",
        (
            (
                "return self._read(text, str(path), path.parent).children",
                "return self._read(text, str(path), folder).children",
            ),
        ),
        f"{SCOPES}::test_files_that_are_included_look_beside_themselves",
    ),
    Mutant(
        "faces that are counted without holes",
        "formats/usd/meshes.py",
        (("origin = np.flatnonzero(keep)", "origin = np.arange(int(keep.sum()))"),),
        f"{FACES}::test_faces_belong_to_the_first_subset_that_names_them",
    ),
    Mutant(
        "solids of revolution inside out",
        "formats/usd/meshes.py",
        (
            (
                "quads = np.stack([a, b, b + _AROUND, a + _AROUND], axis=-1)",
                "quads = np.stack([b, a, a + _AROUND, b + _AROUND], axis=-1)",
            ),
        ),
        f"{SOLIDS}::test_solids_of_revolution",
    ),
    Mutant(
        "a parallel camera that sees ten times as much",
        "formats/usd/cameras.py",
        (("Parallel(height * _TENTH)", "Parallel(height)"),),
        f"{CAMERAS}::test_pictures_show_as_much",
    ),
    Mutant(
        "transforms that are reset with the axes of the stage",
        "formats/usd/graph.py",
        (
            (
                "np.linalg.solve(parent_to_world, self.root @ matrix)",
                "np.linalg.solve(parent_to_world, matrix)",
            ),
        ),
        f"{PLACES}::test_meshes_stand_where_the_library_says",
    ),
    Mutant(
        "a mesh that is bound after its joints have moved it",
        "formats/usd/skins.py",
        (("(bound @ moves @ back)", "(moves @ bound @ back)"),),
        f"{SKINS}::test_points_are_where_openusd_bakes_them",
    ),
    Mutant(
        "of two shapes that move a point the last one",
        "formats/usd/skins.py",
        (("np.add.at(shifts, chosen, weight * offsets)", "shifts[chosen] = weight * offsets"),),
        f"{SKINS}::test_points_are_where_openusd_bakes_them",
    ),
    Mutant(
        "the red of a fallback for all of its channels",
        "formats/usd/textures.py",
        (("found[_CHANNELS.index(output) if output in _CHANNELS else 0]", "found[0]"),),
        f"{RANGES}::test_without_a_picture_the_output_of_the_fallback_is_taken",
    ),
    Mutant(
        "a number that asks for a texture of colours",
        "formats/pbrt/textures.py",
        (("found = found[::-1]", "found = found[:]"),),
        f"{NAMES}::test_a_name_means_a_texture_of_the_kind_that_is_asked_for",
    ),
    Mutant(
        "colours in the space of the texture before them",
        "formats/pbrt/textures.py",
        (
            (
                "        context.colors.space = space\n",
                "        context.colors.space = item.space\n",
            ),
        ),
        f"{NAMES}::test_a_texture_is_in_the_space_of_its_definition_and_nothing_else_is",
    ),
    Mutant(
        "a texture in the space of what asks for it",
        "formats/pbrt/textures.py",
        (
            (
                "space, context.colors.space = context.colors.space, item.space",
                "space, context.colors.space = context.colors.space, context.colors.space",
            ),
        ),
        f"{NAMES}::test_a_texture_is_in_the_space_of_its_definition_and_nothing_else_is",
    ),
    Mutant(
        "of several exposures of a picture the last one",
        "outputs/hdr.py",
        (("product *= float(value)", "product = float(value)"),),
        f"{RADIANCE}::test_all_exposures_of_a_picture_are_undone",
    ),
    Mutant(
        "runs of 128 bytes as they are that are taken for none",
        "outputs/hdr.py",
        (
            (
                "run = code - 128 if code > 128 else code",
                "run = code - 128 if code >= 128 else code",
            ),
        ),
        f"{RADIANCE}::test_runs_of_all_lengths_are_read",
    ),
    Mutant(
        "inches per pixel in an OpenEXR file",
        "outputs/exr.py",
        (("float(display.dpi)", "1.0 / float(display.dpi)"),),
        f"{RADIANCE}::test_the_resolution_of_an_exr_is_in_dots_per_inch",
    ),
    Mutant(
        "an up of Mitsuba that leans where the view goes to -z",
        "formats/mitsuba/transforms.py",
        (
            (
                "return [1.0 + sign * x * x * a, sign * x * y * a, -sign * x]",
                "return [1.0 + sign * x * x * a, x * y * a, -sign * x]",
            ),
        ),
        f"{FRAMES}::test_what_stands_in_for_up_is_at_right_angles_to_the_view",
    ),
    Mutant(
        "what moves inside of TransformBegin moves on behind it",
        "formats/pbrt/attributes.py",
        (
            (
                "state.matrix, state.ends, state.changes_start, state.changes_end = kept",
                "state.matrix, _, state.changes_start, state.changes_end = kept",
            ),
        ),
        f"{KEPT}::test_both_times_and_what_is_active_are_kept",
    ),
    Mutant(
        "a sphere between two ends that have changed places",
        "formats/pbrt/shapes.py",
        (
            (
                'sorted([p.number("zmin", -radius), p.number("zmax", radius)])',
                '[p.number("zmin", -radius), p.number("zmax", radius)]',
            ),
        ),
        f"{ORDER}::test_the_ends_of_a_shape_may_change_places",
    ),
    Mutant(
        "a file that is turned wherever it stands",
        "formats/pbrt/shapes.py",
        (("key = (path, placed.reverse, placed.textured)", "key = (path, placed.textured)"),),
        f"{ORDER}::test_a_file_that_stands_twice_may_be_turned_in_one_place",
    ),
    Mutant(
        "a dome that is not mirrored with its prim",
        "formats/usd/lights.py",
        (("1e-9 or np.linalg.det(axes) < 0.0:", "1e-9:"),),
        f"{DOMES}::test_a_mirror_and_a_missing_turn_of_a_dome",
    ),
    Mutant(
        "a dome whose pole is turned to z the other way",
        "formats/usd/lights.py",
        (("[:, [0, 2, 1]] * [1.0, 1.0, -1.0]", "[:, [0, 2, 1]] * [1.0, -1.0, 1.0]"),),
        f"{DOMES}::test_a_dome_stands_as_its_prim_does",
    ),
    Mutant(
        "a stage that is read outlives its reader",
        "formats/materialx/evaluate.py",
        (("WeakMethod(self.value))", "lambda: self.value)"),),
        "tests/formats/test_frames.py::test_no_stage_is_left_when_its_layers_are_opened_again",
    ),
)
