"""Bugs of what readers make of people's files."""

from tests.mutants.mutant import Mutant

USD = "tests/formats/usd"
GLTF = "tests/formats/gltf"
MITSUBA = "tests/formats/mitsuba"
MATERIALX = "tests/formats/materialx"

SEEN = "tests/formats/test_seen_whole.py"

STUDIO = "tests/formats/test_studio.py"

FORMATS = (
    Mutant(
        "tiles of pictures counted from the top",
        "formats/materials/udim.py",
        (("top = (rows - 1 - row) * height", "top = row * height"),),
        "tests/formats/test_udim.py::test_tiles_lie_where_their_numbers_say",
    ),
    Mutant(
        "tiles of pictures are read through links that lead elsewhere",
        "formats/materials/udim.py",
        (("reach.inside(reach.name_of(tile), shown=tile.name)", "pass"),),
        "tests/formats/test_udim.py::test_tiles_that_are_links_stay_within_reach",
    ),
    Mutant(
        "functions of ramps are straight lines",
        "formats/materialx/pictures.py",
        (("_STEPS = 1024", "_STEPS = 2"),),
        f"{MATERIALX}/test_nodes.py::test_functions_of_ramps_are_no_straight_lines",
    ),
    Mutant(
        "place2d turns the other way",
        "formats/materialx/placing.py",
        (("[[c, s, 0.0], [-s, c, 0.0]", "[[c, -s, 0.0], [s, c, 0.0]"),),
        f"{MATERIALX}/test_nodes.py::test_coordinates_go_through_place2d_as_its_graph_says",
    ),
    Mutant(
        "what lies below a coat of MaterialX is not tinted by it",
        "formats/materialx/standard_surface.py",
        (("s.product(matte, tint)", "matte"),),
        f"{MATERIALX}/test_shaders.py::test_layers_of_standard_surface",
    ),
    Mutant(
        "pictures computed anew from encoded texels",
        "formats/materialx/baking.py",
        (('image.linear(texture.get("color_space", "auto"))', 'image.linear("linear")'),),
        f"{MATERIALX}/test_nodes.py::test_other_nodes_compute_the_picture_anew",
    ),
    Mutant(
        "inputs of a graph keep the value of its definition",
        "formats/materialx/document.py",
        (
            (
                "Scope(graph, interface | node.inputs, self.root)",
                "Scope(graph, interface, self.root)",
            ),
        ),
        f"{MATERIALX}/test_nodes.py::test_graphs_and_their_interfaces",
    ),
    Mutant(
        "a skinned mesh is flattened by its own node",
        "formats/gltf/nodes.py",
        (("            self._flattened(task.index)\n", ""),),
        f"{GLTF}/test_skins.py::test_a_node_without_size_shows_what_its_joints_hold",
    ),
    Mutant(
        "far from the origin, cameras keep the scale of their nodes",
        "formats/gltf/nodes.py",
        (("rtol=0.0, atol=1e-5)", "rtol=0.0, atol=1e-6 * np.abs(to_world).max())"),),
        f"{GLTF}/test_gltf.py::test_cameras_far_away_are_not_scaled",
    ),
    Mutant(
        "borders of media that say nothing of their material are grey",
        "formats/mitsuba/shapes.py",
        (('draft.put("bsdf", {"type": "null"})', "pass"),),
        "tests/formats/mitsuba/test_stand_ins.py"
        "::test_the_border_of_an_old_medium_is_not_seen_unless_it_says_of_what_it_is",
    ),
    Mutant(
        "pixels without light count as too dark",
        "rendering/writing.py",
        (("[(np.nan_to_num(linear) > 0.0).any(axis=2)]", ".reshape(-1, 3)"),),
        "tests/rendering/test_exposure_advice.py::test_pictures_that_show_what_they_hold_are_left_alone",
    ),
    Mutant(
        "shapes with a formula shine as if they were not scaled",
        "formats/scenes/emission.py",
        (("model.pack(part, to_world @ place)", "model.pack(part, place)"),),
        "tests/formats/test_glow.py::test_shapes_with_a_formula_shine_with_their_area",
    ),
    Mutant(
        "the backdrop forgets the light of the soft boxes on the floor",
        "scene/builtin/studio.py",
        (("edge = EDGE * a /", "edge = EDGE * 0.5 * a /"),),
        f"{STUDIO}::test_floor_and_backdrop_meet_without_a_line",
    ),
    Mutant(
        "the studio's floor stays under another sky",
        "formats/scenes/made_up.py",
        (("        after = without_floor(after)\n", "        pass\n"),),
        f"{STUDIO}::test_the_floor_goes_with_the_studio",
    ),
    Mutant(
        "an automatic camera sees where moving shapes begin",
        "formats/mitsuba/framing.py",
        (("here.matrix, here.motion)", "here.matrix)"),),
        f"{SEEN}::test_instances_and_motion_of_mitsuba",
    ),
    Mutant(
        "an automatic camera of a Mitsuba file stays for another picture's shape",
        "formats/loading.py",
        (("source, check), parsed.framed", "source, check), None"),),
        f"{SEEN}::test_shapes_of_mitsuba",
    ),
    Mutant(
        "of a cube one side is framed",
        "formats/geometry/bounds.py",
        (("np.max(highs, axis=0)", "highs[0]"),),
        f"{SEEN}::test_gprims_of_usd",
    ),
    Mutant(
        "instances share whatever they inherit",
        "formats/usd/inherited.py",
        (("return _bindings(prim), _primvars(stage, prim)", "return ()"),),
        f"{USD}/test_instances.py::test_a_material_bound_on_an_instance_is_shown",
    ),
    Mutant(
        "pictures of USD's normals without scale and bias",
        "formats/usd/textures.py",
        (("return normals(picture, scale[:3], bias[:3])", "return picture"),),
        f"{USD}/test_normals.py::test_normals_are_scaled_and_shifted_texels",
    ),
    Mutant(
        "skinned meshes left in the space of their skeleton",
        "formats/usd/skins.py",
        (("placed * places.GetLocalToWorldTransform(prim).GetInverse()", "placed"),),
        f"{USD}/test_skins.py::test_meshes_are_where_openusd_itself_bakes_them",
    ),
    Mutant(
        "blend shapes added after the joints have moved",
        "formats/usd/skins.py",
        (
            (
                "self.matrices, points + self.shifts, None)[0]",
                "self.matrices, points, None)[0] + self.shifts",
            ),
        ),
        f"{USD}/test_skins.py::test_meshes_are_where_openusd_itself_bakes_them",
    ),
    Mutant(
        "normalised numbers of Draco streams taken as they are",
        "formats/gltf/draco.py",
        (('said.get("normalized") is True', "False"),),
        f"{GLTF}/test_draco.py::test_all_attributes_come_out_by_their_identifiers",
    ),
    Mutant(
        "Draco streams believed, whatever they announce",
        "formats/gltf/draco.py",
        (("if number > most:", "if False:"),),
        f"{GLTF}/test_draco.py::test_streams_do_not_get_the_memory_that_they_announce",
    ),
    Mutant(
        "instances of a node scaled after they are turned",
        "formats/gltf/instances.py",
        (('tables["SCALE"][:, None, :]', 'tables["SCALE"][:, :, None]'),),
        f"{GLTF}/test_instances.py::test_scale_comes_first_then_rotation_then_translation",
    ),
    Mutant(
        "the camera sees one instance of a node",
        "formats/gltf/instances.py",
        (("for move in moves:", "for move in moves[:1]:"),),
        f"{GLTF}/test_instances.py::test_the_camera_sees_all_instances",
    ),
    Mutant(
        "variants of materials taken by their place in the list of mappings",
        "formats/gltf/variants.py",
        (
            (
                'if number in mapping.indices("variants", len(names), "variants"):',
                'if mapping.pointer.endswith(f"/{number}"):',
            ),
        ),
        f"{GLTF}/test_variants.py::test_a_variant_shows_its_materials",
    ),
    Mutant(
        "animated rotations that turn the longer way",
        "formats/gltf/animations.py",
        (("if cosine < 0.0:", "if cosine < -2.0:"),),
        f"{GLTF}/test_animations.py::test_rotations_turn_evenly_the_shorter_way",
    ),
    Mutant(
        "tangents of splines that do not grow with the time between keys",
        "formats/gltf/animations.py",
        (("+ length * (s**3 - 2", "+ (s**3 - 2"),),
        f"{GLTF}/test_animations.py::test_splines_are_the_cubics_of_their_tangents",
    ),
    Mutant(
        "seconds of a stage counted from the time code 0",
        "formats/usd/stage.py",
        (("code = start + at", "code = at"),),
        f"{USD}/test_skins.py::test_seconds_count_from_the_first_time",
    ),
    Mutant(
        "a sun of version 0.6 in the north at noon",
        "formats/mitsuba/daylight.py",
        (("[east, up, south] if old", "[-east, up, -south] if old"),),
        f"{MITSUBA}/test_daylight_and_projectors.py::test_the_date_gives_mitsubas_sun",
    ),
    Mutant(
        "steps of an animation a key late",
        "formats/gltf/animations.py",
        (("at = float(np.float32(at))", "at = float(at)"),),
        f"{GLTF}/test_animations.py::test_steps_at_their_keys_are_those_of_the_keys_as_they_are_written",
    ),
    Mutant(
        "the first set of joints alone",
        "formats/gltf/meshes.py",
        (("for name in names\n", "for name in names[:1]\n"),),
        f"{GLTF}/test_skins.py::test_weights_are_shares",
    ),
    Mutant(
        "a sun that turns with its sky",
        "formats/mitsuba/daylight.py",
        (("turn = matrix_of(steps)\n", "turn = matrix_of(steps[:1])\n"),),
        f"{MITSUBA}/test_daylight_and_projectors.py::test_the_sun_is_in_the_world_whatever_turns_the_sky",
    ),
    Mutant(
        "scales of the sun and the sky times the common one",
        "formats/mitsuba/daylight.py",
        (("both, each = (1.0, factor) if old", "both, each = (factor, 1.0) if old"),),
        f"{MITSUBA}/test_daylight_and_projectors.py::test_scales_of_version_0_6_take_the_place_of_the_common_one",
    ),
    Mutant(
        "stand-ins for files that are there and broken",
        "formats/reading/report.py",
        (("self.lenient and not isinstance(error, UnreadableError)", "self.lenient"),),
        "tests/formats/test_lenient.py::test_a_broken_include_is_an_error_all_the_same",
    ),
    Mutant(
        "missing pictures of numbers that show squares",
        "formats/gltf/textures.py",
        ((" or (picture is MISSING and not is_color)", ""),),
        "tests/formats/test_lenient.py::test_lenient_reading_lists_what_is_missing_and_shows_the_rest",
    ),
    Mutant(
        "triangles of strips all one way round",
        "meshes/strips.py",
        (("    corners[turned, :2] = corners[turned, 1::-1]\n", ""),),
        "tests/meshes/test_mesh_files.py::test_ply_strips_turn_every_other_triangle_around",
    ),
)
