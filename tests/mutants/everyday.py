"""Bugs of the kind that happens in practice and that no test found, with the laws that do now."""

from tests.mutants.mutant import Mutant

LAWS_OF = "tests/laws/test_every_model.py::test_it_obeys_the_laws_of_its_family"
NODES = "tests/formats/materialx/test_laws_of_nodes.py"
TEXELS = f"{NODES}::test_textures_show_what_the_node_makes_of_their_texels"
PATTERNS = f"{NODES}::test_patterns_show_what_they_say_at_every_point"
MITSUBA = (
    "tests/formats/mitsuba/test_every_number_counts.py::test_numbers_have_their_defaults_and_matter"
)
PBRT = "tests/formats/pbrt/test_every_number_counts.py"
FIELDS = "tests/view/test_laws_of_fields.py"
LAYERS = "tests/view/test_layers.py"
BORDERS = "tests/scene/test_fields_that_bound_each_other.py"

EVERYDAY = (
    Mutant(
        "a ball at the end of a strand is met at a distance in metres",
        "shapes/tube.py",
        (("t = (center.z - half) * inverse\n", "t = center.z - half\n"),),
        f"{LAWS_OF}[shapes-curves]",
    ),
    Mutant(
        "the cone along a tube does not taper",
        "shapes/tube.py",
        (("    k = length + dr * dr\n", "    k = length\n"),),
        "tests/shapes/test_tubes.py::test_the_cone_of_a_straight_tube_is_the_tube",
    ),
    Mutant(
        "a triangle wave that is twice as high",
        "formats/materialx/pointwise.py",
        (
            (
                "lambda x: 0.5 - np.abs(np.abs(x) % 1.0 - 0.5)",
                "lambda x: 1.0 - 2.0 * np.abs(np.abs(x) % 1.0 - 0.5)",
            ),
        ),
        f"{NODES}::test_every_node_is_its_formula",
    ),
    Mutant(
        "an angle of x over y",
        "formats/materialx/pointwise.py",
        (('(("iny", 0.0), ("inx", 1.0))', '(("inx", 1.0), ("iny", 0.0))'),),
        f"{NODES}::test_tables_are_those_of_the_library",
    ),
    Mutant(
        "a share of a mixture that is also the rest",
        "formats/materialx/rules.py",
        (("rest = affine(share, (-1.0,) * share.width, (1.0,) * share.width)", "rest = share"),),
        f"{TEXELS}[mix]",
    ),
    Mutant(
        "a range whose ends change places",
        "formats/materialx/rules.py",
        (("low, high, out_low, out_high], width)", "low, high, out_high, out_low], width)"),),
        f"{TEXELS}[range]",
    ),
    Mutant(
        "a luminance whose weights are never asked for",
        "formats/materialx/rules.py",
        (("return value if abs(total - 1.0) < 1e-6 else", "return value if total < 9.0 else"),),
        f"{TEXELS}[luminance]",
    ),
    Mutant(
        "a first power that is negative",
        "formats/materialx/rules.py",
        (("for low, _ in value.ends) < 0.0:", "for low, _ in value.ends) < -9.0:"),),
        f"{TEXELS}[power]",
    ),
    Mutant(
        "one texel over nothing takes the others with it",
        "formats/materialx/baking.py",
        (("_LARGEST, _LEAST = 1e15, -1e4", "_LARGEST, _LEAST = 1e15, -1e15"),),
        f"{NODES}::test_a_texel_over_nothing_leaves_the_others_as_they_are",
    ),
    Mutant(
        "a texture beyond 1 as the weight of a mixture",
        "formats/materialx/values.py",
        (("not (falls and value.most > 1.0)", "True"),),
        f"{NODES}::test_no_weight_of_a_mixture_exceeds_1",
    ),
    Mutant(
        "parts of a texture are counted without its weight",
        "formats/materialx/values.py",
        (('for key in ("texture", "a", "b", "weight") if', 'for key in ("texture", "a", "b") if'),),
        f"{NODES}::test_all_parts_of_a_texture_are_counted",
    ),
    Mutant(
        "two corners of a ramp change places",
        "formats/materialx/pictures.py",
        (('("bl", "br", "tl", "tr")', '("bl", "tl", "br", "tr")'),),
        f"{PATTERNS}[ramp4]",
    ),
    Mutant(
        "a split on the other side of the middle",
        "formats/materialx/pictures.py",
        (("matrix[axis, 2] = 0.5 - center", "matrix[axis, 2] = center - 0.5"),),
        f"{PATTERNS}[splitlr]",
    ),
    Mutant(
        "noise of half its strength",
        "formats/materialx/pictures.py",
        (("textured(data, 1), (2.0,), (-1.0,))", "textured(data, 1), (1.0,), (-0.5,))"),),
        f"{NODES}::test_noise_is_the_native_one_about_its_pivot",
    ),
    Mutant(
        "all balls of a document in one row",
        "formats/materialx/scene.py",
        (("-APART * (number // columns)]", "-APART * (number // len(materials))]"),),
        "tests/formats/materialx/test_nodes.py::"
        "test_balls_stand_side_by_side_in_rows_as_long_as_there_are_rows[5]",
    ),
    Mutant(
        "a coat as rough as the metal below it",
        "formats/mitsuba/stand_ins.py",
        (("math.sqrt(max(alpha, 0.0)),", "math.sqrt(inner),"),),
        f"{MITSUBA}[3.0.0-bsdf]",
    ),
    Mutant(
        "a lens that is focused at a metre where nothing is said",
        "formats/mitsuba/sensors.py",
        (('"focus_distance", p.number("far_clip", 1e4))', '"focus_distance", 1.0)'),),
        f"{MITSUBA}[3.0.0-sensor]",
    ),
    Mutant(
        "a sun that is asked how bright the sky is",
        "formats/mitsuba/daylight.py",
        (
            (
                '    if kind == "sunsky":\n        sun, sky',
                '    p.number("sky_scale", each)\n    if kind == "sunsky":\n        sun, sky',
            ),
        ),
        f"{MITSUBA}[3.0.0-emitter]",
    ),
    Mutant(
        "a number that is three times its texture",
        "formats/pbrt/textures.py",
        (("return sum(value) / 3.0 if", "return sum(value) if"),),
        f"{PBRT}::test_a_texture_that_is_the_same_everywhere_is_its_number",
    ),
    Mutant(
        "a wind that is asked for its octaves",
        "formats/pbrt/patterns.py",
        (("waves, most = _waves(source, 6, 0.5)", "waves, most = _asked_waves(source)"),),
        f"{PBRT}::test_numbers_have_their_defaults_and_matter[Texture]",
    ),
    Mutant(
        "colours that no vertex carries are white",
        "formats/usd/materials.py",
        (('"vertex_color", "fallback": 0.18}', '"vertex_color", "fallback": 1.0}'),),
        "tests/formats/usd/test_materials.py::"
        "test_colors_of_vertices_that_are_not_there_are_the_usual_grey",
    ),
    Mutant(
        "what only Python has comes first",
        "options/table.py",
        (("return not one.flags, PANELS", "return bool(one.flags), PANELS"),),
        "tests/options/test_tables.py::test_what_only_python_has_goes_last[RenderOptions]",
    ),
    Mutant(
        "a crop that may be as high as the picture is wide",
        "scene/description.py",
        (("y + h > height:", "y + h > width:"),),
        f"{BORDERS}::test_a_crop_lies_inside_of_its_picture",
    ),
    Mutant(
        "a beam without a cone",
        "lights/projector.py",
        (("(self.cutoff_angle or 0.0):", "(self.cutoff_angle or 90.0):"),),
        f"{BORDERS}::test_no_beam_is_wider_than_its_cone[20.0-None]",
    ),
    Mutant(
        "the first of two materials is edited as the second",
        "view/tree.py",
        (('scene, one, f"{path}[{i}]", f"{label}', 'scene, one, f"{path}[{i + 1}]", f"{label}'),),
        f"{FIELDS}::test_every_field_has_the_value_at_its_path[bsdfs]",
    ),
    Mutant(
        "a lamp on a shape may become a spot",
        "view/tree.py",
        (("if _placement(s) == spec.placement}", "if True}"),),
        f"{FIELDS}::test_a_light_may_become_any_that_stands_in_the_same_way",
    ),
    Mutant(
        "five channels as one",
        "view/layers.py",
        (("if len(planes) <= 4 else", "if len(planes) <= 5 else"),),
        f"{LAYERS}::test_what_has_more_channels_than_a_colour_is_shown_channel_by_channel[5]",
    ),
    Mutant(
        "a small picture that is as wide as it is high",
        "view/layers.py",
        (("np.minimum(x // COARSER, columns - 1)", "np.minimum(x // COARSER, rows - 1)"),),
        f"{LAYERS}::test_pixels_without_a_sample_show_the_small_picture[size0]",
    ),
    Mutant(
        "strands that grow by the square root of the volume",
        "shapes/strands.py",
        (("growth = np.cbrt(abs(", "growth = np.sqrt(abs("),),
        "tests/shapes/test_curves.py::test_radii_grow_as_the_third_root_of_the_volume",
    ),
    Mutant(
        "tangents of Catmull and Rom's curve twice as long",
        "shapes/strands.py",
        (
            (
                "[[0, 6, 0, 0], [-1, 6, 1, 0], [0, 1, 6, -1], [0, 0, 6, 0]]",
                "[[0, 6, 0, 0], [-2, 6, 2, 0], [0, 2, 6, -2], [0, 0, 6, 0]]",
            ),
        ),
        "tests/shapes/test_curves.py::"
        "test_segments_begin_and_end_as_their_basis_says[catmull_rom]",
    ),
    Mutant(
        "of two reliefs the outer one counts",
        "bsdfs/nesting.py",
        (
            (
                "leaf.normals or (spec if spec.bends_normals else None)",
                "(spec if spec.bends_normals else None) or leaf.normals",
            ),
        ),
        "tests/physics/test_bent_normals.py::"
        "test_of_two_maps_of_normals_the_inner_one_counts[NormalMap-BumpMap]",
    ),
    Mutant(
        "glass of random scenes that is never denser outside",
        "lab/random_scenes/materials.py",
        (("is_seen = max(ratio, 1.0 / ratio) > 1.1", "is_seen = ratio > 1.1"),),
        "tests/lab/test_random_scenes.py::"
        "test_clear_materials_are_seen_from_either_side_of_their_boundary",
    ),
    Mutant(
        "an interval of the bias that is 1 % too wide where the bias is large",
        "lab/statistics/decomposition.py",
        (("+ 4.0 * crossed", "+ 4.08 * crossed"),),
        "tests/lab/test_lab_statistics.py::"
        "test_the_interval_of_a_bias_has_the_variance_of_its_square[0.3]",
    ),
    Mutant(
        "no pixel at the left of a cell shows anything to turn about",
        "view/movable.py",
        (("tile = Tile(x, y, x + 1, y + 1)", "tile = Tile(x, y, x, y + 1)"),),
        "tests/view/test_session.py::test_the_pivot_is_what_a_pixel_shows",
    ),
    Mutant(
        "the direction that light comes from begins with its second coordinate",
        "guiding/light_records.py",
        (("gather_vec3(log.rows, row + 3)", "gather_vec3(log.rows, row + 4)"),),
        "tests/guiding/test_light_records.py::"
        "test_sums_of_arrivals_are_those_of_their_leaves[False]",
    ),
    Mutant(
        "facets of burley that are stretched along one direction alone",
        "bsdfs/disney/burley.py",
        (("maximum(alpha * aspect, LEAST_ALPHA)", "maximum(alpha, LEAST_ALPHA)"),),
        "tests/physics/test_energy_of_burley.py::test_facets_are_stretched_along_the_tangent",
    ),
    Mutant(
        "a hall without its far wall",
        "lab/random_scenes/kinds/door.py",
        (
            (
                '    draft.rectangle("hall", (left, middle, 0), (0, 0, -room.z), (0, middle, 0))\n',
                "",
            ),
        ),
        "tests/lab/test_random_scenes.py::test_no_light_leaves_a_closed_room[door]",
    ),
    Mutant(
        "notes that are called warnings",
        "lab/info.py",
        (
            (
                '"warning": self.warnings, "note": self.notes',
                '"warning": self.notes, "note": self.warnings',
            ),
        ),
        "tests/lab/test_picture_info.py::test_remarks_are_called_what_they_are",
    ),
    Mutant(
        "a switch whose first two inputs are the same",
        "formats/materialx/evaluate.py",
        (('f"in{which + 1}", (0.0,) * width)', 'f"in{max(which, 1)}", (0.0,) * width)'),),
        "tests/formats/materialx/test_nodes.py::test_switches_show_one_of_their_inputs[1]",
    ),
    Mutant(
        "a film of OpenPBR in nanometres",
        "formats/materialx/open_pbr.py",
        (('"thin_film_thickness"], (1000.0,)', '"thin_film_thickness"], (1.0,)'),),
        "tests/formats/materialx/test_shaders.py::"
        "test_films_have_the_unit_of_their_shader[open_pbr_surface-0.4-thin_film_weight]",
    ),
    Mutant(
        "instances have the usual material, wherever they stand",
        "scene/flatten.py",
        (
            (
                'below.insert(0, (f"{path}/{node.instance}", prototype, *given))',
                'below.insert(0, (f"{path}/{node.instance}", prototype, here, None, material))',
            ),
        ),
        "tests/scene/test_graph.py::"
        "test_instances_have_the_material_of_where_they_stand_unless_they_have_their_own",
    ),
    Mutant(
        "facets of six vertices",
        "meshes/stl.py",
        (("if in_facet != 3:", "if in_facet % 3 != 0:"),),
        "tests/meshes/test_mesh_files.py::test_facets_of_stl_have_three_vertices[6]",
    ),
    Mutant(
        "light between two points of a table goes to the nearer one and beyond",
        "bsdfs/microfacets/layered.py",
        (("minimum(place.astype(np.int64),", "minimum(np.rint(place).astype(np.int64),"),),
        "tests/physics/test_coated_conductor.py::"
        "test_light_is_shared_by_the_points_on_both_sides_of_its_place",
    ),
    Mutant(
        "phase functions of pbrt become less sharp than they must",
        "formats/pbrt/media.py",
        (("_LARGEST_G = 0.99\n", "_LARGEST_G = 0.9\n"),),
        "tests/formats/pbrt/test_media.py::"
        "test_phase_functions_that_are_too_sharp_become_less_so[0.98-0.98]",
    ),
    Mutant(
        "a colour of hair by its roughness along the fibre",
        "bsdfs/fibres/hair.py",
        (("absorption_of(c, self.beta_n) for c", "absorption_of(c, self.beta_m) for c"),),
        "tests/physics/test_hair.py::test_what_a_fibre_absorbs_follows_its_pigments_or_its_colour",
    ),
    Mutant(
        "a red pigment whose green is its blue",
        "bsdfs/fibres/hair.py",
        (("(0.187, 0.4, 1.05)", "(0.187, 1.05, 0.4)"),),
        "tests/physics/test_hair.py::test_what_a_fibre_absorbs_follows_its_pigments_or_its_colour",
    ),
    Mutant(
        "a file that is cut in silence where it is too large",
        "formats/reading/packed.py",
        (("if len(data) > most:", "if len(data) > most + 1:"),),
        "tests/formats/test_packed.py::"
        "test_files_may_have_so_many_bytes_once_they_are_unpacked[1048577-a.txt]",
    ),
    Mutant(
        "hidden lights that light nothing either",
        "integrators/volpath.py",
        (
            (
                "hidden = met & (path.depth == 0) & (surface.light != 0)",
                "hidden = met & (surface.light != 0)",
            ),
        ),
        "tests/physics/test_hidden_lights.py::"
        "test_hidden_lights_light_what_is_beside_them[volpath]",
    ),
    Mutant(
        "the last part of a ray's direction is written over its first ones",
        "laws/emission.py",
        (("store_lanes(out, i + 5 * n, e.d.z)", "store_lanes(out, i + 5, e.d.z)"),),
        "tests/laws/test_compiled_benches.py::test_of_emission",
    ),
    Mutant(
        "balls at the joints of a strand that look ahead for what was before",
        "shapes/strand_rows.py",
        (("np.roll(along, 1, axis=0))", "np.roll(along, -1, axis=0))"),),
        "tests/shapes/test_curves.py::test_balls_at_joints_know_the_lines_on_both_sides",
    ),
    Mutant(
        "hair as wide along the fibre however rough it is",
        "bsdfs/fibres/hair.py",
        ((" + 3.7 * m**20", ""),),
        "tests/physics/test_hair.py::test_lobes_are_as_wide_as_their_roughness_says",
    ),
    Mutant(
        "a scale that makes radii smaller",
        "bsdfs/interiors/subsurface.py",
        (("1.0 / (spec.scale * radius)", "spec.scale / radius"),),
        "tests/estimators/test_subsurface.py::test_the_scale_multiplies_the_radius",
    ),
    Mutant(
        "a coat with the colour of the body below it",
        "bsdfs/interiors/subsurface.py",
        (("return params.color * through + (1.0 - through)", "return params.color"),),
        "tests/estimators/test_subsurface.py::"
        "test_the_layer_of_albedo_is_the_colour_below_a_coat_that_has_none",
    ),
)  # fmt: skip
