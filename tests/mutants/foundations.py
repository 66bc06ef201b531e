"""Bugs in what all pictures stand on: meshes, hits, lanes, and what a lamp or a sun is."""

from tests.mutants.mutant import Mutant

NUMBAS = "tests/lanewise/test_numbas_functions.py"
ADAPTER = "tests/lanewise/test_adapter.py::test_instructions_that_do_nothing_are_told"
ALIKE = (
    "tests/motion/test_copies.py"
    "::test_of_copies_that_move_alike_the_first_is_met_as_if_it_were_alone"
)
JOINTS = "tests/shapes/test_curves.py::test_balls_at_joints_know_the_lines_on_both_sides"
CLASS = '"class", value.__qualname__, getattr(value, "_fields", ""))\n            '
DIGEST = "tests/lanewise/test_source_digest.py::test_a_digest_changes_with_what_the_kernel_sees"
NORMALS = "tests/meshes/test_vertex_normals.py"
RECORDS = "tests/lanewise/test_records.py"

FOUNDATIONS = (
    Mutant(
        "albedo of a measured material over angles instead of directions",
        "bsdfs/measured/measured.py",
        (("2.0 * np.pi**2 * s * sine / s.size", "2.0 * np.pi**2 * s * s / s.size"),),
        "tests/physics/test_measured.py"
        "::test_the_albedo_is_what_is_reflected_of_light_from_above[satin]",
    ),
    Mutant(
        "of two suns the brighter one without their colours",
        "compiled/light_targets.py",
        (("a * b for a, b in zip(row.color, disk.mean", "b for a, b in zip(row.color, disk.mean"),),
        "tests/lights/test_targets.py"
        "::test_of_two_suns_the_brighter_one_is_aimed_at_in_its_colour[color1-0]",
    ),
    Mutant(
        "chains that start on lamps",
        "integrators/caustics/specular_chain.py",
        (("(surface.light == 0) & outside)", "outside)"),),
        "tests/estimators/test_chains_end_at_their_lamp.py"
        "::test_chains_start_where_light_is_scattered_but_not_on_lamps",
    ),
    Mutant(
        "edges of three faces are smooth",
        "meshes/polygons.py",
        (("(users != 2)", "(users < 2)"),),
        "tests/meshes/test_polygons.py::test_an_edge_of_three_faces_is_sharp",
    ),
    Mutant(
        "normals by the angles beside those of the corners",
        "meshes/normals.py",
        (("cosine = -(unit", "cosine = (unit"),),
        f"{NORMALS}::test_normals_of_a_box_do_not_depend_on_how_its_sides_are_cut[22]",
    ),
    Mutant(
        "normals weighted by area too",
        "meshes/normals.py",
        (("across = across / _lengths(across)", "across = across * 1.0"),),
        f"{NORMALS}::test_normals_of_a_box_do_not_depend_on_how_its_sides_are_cut[22]",
    ),
    Mutant(
        "u of the end of a strand where its last line begins",
        "shapes/strand_rows.py",
        (("(parts.first + parts.span)[ends]", "parts.first[ends]"),),
        JOINTS,
    ),
    Mutant(
        "steps of composed textures without those of the operators",
        "textures/nesting.py",
        (("return 1 + sum(count_steps", "return sum(count_steps"),),
        "tests/textures/test_composed.py"
        "::test_steps_and_the_depth_of_the_stack_are_those_of_the_list_that_kernels_run",
    ),
    Mutant(
        "signs in what has none",
        "meshes/ply_header.py",
        (('"uint16": "u2"', '"uint16": "i2"'),),
        "tests/meshes/test_spellings.py"
        "::test_every_type_reaches_to_both_of_its_ends[u2-binary_big_endian]",
    ),
    Mutant(
        "shape number 65535 is none",
        "accel/lists.py",
        (("NOTHING = 0xFFFFFFFF", "NOTHING = 0xFFFF"),),
        "tests/accel/test_scenes.py"
        "::test_a_shape_of_any_number_is_met_up_to_the_end_of_the_ray[65535]",
    ),
    Mutant(
        "pairs of triangles whose corners share a coordinate",
        "accel/primitives.py",
        (
            (
                "(corners[:-1, 2] == corners[1:, 1]).all(axis=1)",
                "(corners[:-1, 2] == corners[1:, 1]).any(axis=1)",
            ),
        ),
        "tests/accel/test_pairs.py::test_what_is_a_pair",
    ),
    Mutant(
        "only the first part of a texture may say where it is looked up",
        "textures/nesting.py",
        (
            (
                "return next((number for number in found if number is not None), None)",
                "return next(found, None)",
            ),
        ),
        "tests/textures/test_composed.py"
        "::test_coordinates_are_those_of_the_first_part_that_has_some",
    ),
    Mutant(
        "of a step with two names the first one counts",
        "textures/uv.py",
        (
            ("len(step) != 1:", "len(step) < 1:"),
            ("((name, value),) = step.items()", "name, value = next(iter(step.items()))"),
        ),
        "tests/textures/test_composed.py::test_a_step_of_a_lookup_is_one_of_four[step2]",
    ),
    Mutant(
        "angles around shapes that the layer of (u, v) goes without",
        "shapes/hit.py",
        (('return bends or "uv" in program.aovs or', "return bends or"),),
        "tests/shapes/test_surfaces.py::test_angles_are_found_where_anything_reads_them[layer]",
    ),
    Mutant(
        "unsure where all channels are",
        "metrics/pixel_bars.py",
        (("np.any(thin, axis=0)", "np.all(thin, axis=0)"),),
        "tests/metrics/test_pixel_bars.py::test_one_channel_is_enough_to_be_unsure[1]",
    ),
    Mutant(
        "black bodies by the exponential alone",
        "core/spectra.py",
        (("np.expm1(_SECOND", "np.exp(_SECOND"),),
        "tests/core/test_spectra.py::test_a_black_body_shines_by_plancks_law[40000.0]",
    ),
    Mutant(
        "thin lenses are sharp elsewhere by default",
        "cameras/thin_lens.py",
        (("focus_distance: Positive = 1.0", "focus_distance: Positive = 10.0"),),
        "tests/docs/test_stated_defaults.py::test_defaults_are_as_stated[Camera-thin_lens]",
    ),
    Mutant(
        "the tree of another builder",
        "accel/kept.py",
        (("_TREES, (vertices, faces), method,", '_TREES, (vertices, faces), "sah",'),),
        "tests/accel/test_build.py::test_a_tree_that_is_kept_is_that_of_its_builder",
    ),
    Mutant(
        "shapes of arrays are equal if any field is",
        "shapes/arrays.py",
        (("return all(_same(value,", "return any(_same(value,"),),
        "tests/shapes/test_equal_arrays.py::test_shapes_differ_if_any_field_does[Mesh-uvs]",
    ),
    Mutant(
        "cylinders have a length but at the origin",
        "shapes/cylinder.py",
        (("if self.p0 == self.p1:", "if self.p0 == (0.0, 0.0, 0.0) == self.p1:"),),
        "tests/shapes/test_cylinder.py::test_an_axis_without_length_is_refused[p1]",
    ),
    Mutant(
        "machine code of scripts is stale where a default by keyword has changed",
        "source_digest.py",
        (
            (
                "__kwdefaults__)\n            self.globals(function)",
                "__defaults__)\n            self.globals(function)",
            ),
        ),
        f"{DIGEST}[default by keyword]",
        "lanewise",
    ),
    Mutant(
        "machine code of scripts is stale where a default of a record has changed",
        "source_digest.py",
        ((f"{CLASS}self.feed(", f"{CLASS}repr("),),
        f"{DIGEST}[default of a record]",
        "lanewise",
    ),
    Mutant(
        "object code that calls Numba's own functions",
        "numba_adapter.py",
        (("if outside:\n        names", "if not code:\n        names"),),
        "tests/lanewise/test_object_code.py::test_code_that_calls_numbas_own_functions_is_refused",
        "lanewise",
    ),
    Mutant(
        "vectors shuffled from behind",
        "wide_instructions.py",
        (("builder, args[0], args[0], constants", "builder, args[0], args[0], constants[::-1]"),),
        "tests/lanewise/test_wide.py::test_parts_and_places_of_vectors[True]",
        "lanewise",
    ),
    Mutant(
        "ties between lists and the tree go to the list",
        "accel/query.py",
        (("met & wins(found, best)", "met & (found.t < best.t)"),),
        "tests/accel/test_scenes.py"
        "::test_ties_between_a_list_and_the_tree_go_to_the_lowest_shape[30]",
    ),
    Mutant(
        "of meshes that move alike the last one is met",
        "accel/moving.py",
        (
            (
                "best = take(best, met & wins(hit, best), hit, nearest)\n    return best",
                "best = take(best, met, hit, nearest)\n    return best",
            ),
        ),
        ALIKE,
    ),
    Mutant(
        "moving meshes behind as many triangles as there are meshes",
        "accel/accelerator.py",
        (("sum(len(part) for part in corners)", "len(corners)"),),
        ALIKE,
    ),
    Mutant(
        "indices of 32 bits",
        "view_types.py",
        (("args[0].dtype(args[0], types.int64)", "args[0].dtype(args[0], types.int32)"),),
        "tests/lanewise/test_bounds.py::test_tables_may_be_longer_than_two_to_the_32",
        "lanewise",
    ),
    Mutant(
        "a row for each vector of a record",
        "record_instructions.py",
        (("return 3 * _count_rows(kind.component)", "return _count_rows(kind.component)"),),
        f"{RECORDS}::test_a_record_takes_as_many_rows_as_it_has_components",
        "lanewise",
    ),
    Mutant(
        "types that pickling changes are kept",
        "kept_functions.py",
        (("return pickle.loads(pickle.dumps(kind)) == kind", "return bool(pickle.dumps(kind))"),),
        f"{RECORDS}::test_types_that_pickling_changes_are_not_kept",
        "lanewise",
    ),
    Mutant(
        "LLVM estimates whether functions of Numba are worth inlining",
        "numba_adapter.py",
        (('function.add_function_attribute("alwaysinline")', "pass"),),
        f"{NUMBAS}::test_other_functions_of_numba_are_inlined_whatever_llvm_estimates",
        "lanewise",
    ),
    Mutant(
        "of two numbers of which one is NaN the larger is the other",
        "scalar_instructions.py",
        (("(number, best)), number, best", "(best, number)), best, number"),),
        f"{NUMBAS}::test_extremes_are_pythons_nan_and_signed_zeros_included",
        "lanewise",
    ),
    Mutant(
        "of the elementwise functions the first of each kind are tried",
        "canary_instructions.py",
        (("for function in functions:", "for function in functions[:1]:"),),
        ADAPTER,
        "lanewise",
    ),
    Mutant(
        "what gathers and packings give is not compared",
        "canary_instructions.py",
        (
            (
                "np.testing.assert_allclose(out.array, np.concatenate(expected), rtol=1e-6)",
                "pass",
            ),
        ),
        ADAPTER,
        "lanewise",
    ),
)
