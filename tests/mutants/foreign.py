"""Bugs of readers of foreign files: colours, flags, and inputs of shaders."""

from tests.mutants.mutant import Mutant

PBRT_COLORS = "tests/formats/pbrt/test_every_colour_and_flag_counts.py"
MITSUBA_COLORS = (
    "tests/formats/mitsuba/test_every_colour_and_flag_counts.py::"
    "test_colours_have_their_defaults_and_each_channel_matters"
)

GLTF = "tests/formats/gltf/test_every_key_counts.py"
NUMBERS = "tests/formats/pbrt/test_single_numbers.py"

FOREIGN = (
    Mutant(
        "a substrate that is half as shiny",
        "formats/pbrt/materials_of_3.py",
        (('_tint(m, "Ks", 0.5)', '_tint(m, "Ks", 0.25)'),),
        f"{PBRT_COLORS}::test_colours_have_their_defaults_and_each_channel_matters[Material]",
    ),
    Mutant(
        "a lamp of Mitsuba that is given no colour",
        "formats/mitsuba/emitters.py",
        (('light.color("irradiance", 1.0)', 'light.color("irradiance", 0.5)'),),
        f"{MITSUBA_COLORS}[emitter-directional-irradiance]",
    ),
    Mutant(
        "a coat of glTF that is as rough as it is strong",
        "formats/materialx/gltf_pbr.py",
        (('get["clearcoat_roughness"]', 'get["clearcoat"]'),),
        "tests/formats/materialx/test_every_input_counts.py::"
        "test_every_input_of_a_shader_counts[gltf_pbr]",
    ),
    Mutant(
        "samplers of glTF that end at the edges",
        "formats/gltf/textures.py",
        (("sampler.integer(key, 10497)", "sampler.integer(key, 33071)"),),
        f"{GLTF}::test_samplers_repeat_and_are_linear_by_default[sampler0]",
    ),
    Mutant(
        "films of glTF that begin at no thickness",
        "formats/gltf/materials.py",
        (('"iridescenceThicknessMinimum", 100.0', '"iridescenceThicknessMinimum", 0.0'),),
        f"{GLTF}::test_a_picture_of_a_films_thickness_runs_from_its_minimum_to_its_maximum",
    ),
    Mutant(
        "films of glTF with the index of glass",
        "formats/gltf/materials.py",
        (('"iridescenceIor", 1.3,', '"iridescenceIor", 1.5,'),),
        f"{GLTF}::test_numbers_have_their_defaults_and_matter[iridescence.iridescenceIor]",
    ),
    Mutant(
        "the strength of brushes from where they lead",
        "formats/gltf/materials.py",
        (('scaled(strength, picture, "b")', 'scaled(strength, picture, "r")'),),
        f"{GLTF}::test_a_texture_that_is_the_same_everywhere_is_its_number[anisotropy.anisotropyStrength]",
    ),
    Mutant(
        "the colours of glossy metals as they are stored",
        "formats/gltf/materials.py",
        (
            (
                '"specularGlossinessTexture", is_color=True)',
                '"specularGlossinessTexture", is_color=False)',
            ),
        ),
        f"{GLTF}::test_the_colour_of_a_glossy_metal_is_encoded_and_its_gloss_is_not",
    ),
    Mutant(
        "normal maps that are flatter by default",
        "formats/gltf/materials.py",
        (
            (
                '"texture": picture, "scale": info.number("scale", 1.0)',
                '"texture": picture, "scale": info.number("scale", 0.5)',
            ),
        ),
        f"{GLTF}::test_normals_are_numbers_of_a_picture_and_have_the_scale_one",
    ),
    Mutant(
        "splines that leave a key as they reach it",
        "formats/gltf/animations.py",
        (("values[before, 1], values[before, 2]", "values[before, 1], values[before, 0]"),),
        "tests/formats/gltf/test_animations.py::test_splines_are_the_cubics_of_their_tangents",
    ),
    Mutant(
        "light cut out of a surface twice",
        "formats/gltf/write_materials.py",
        (
            (
                "    if isinstance(radiance, tuple):\n        return tuple(channel / share",
                "    if isinstance(radiance, tuple):\n        return tuple(channel * share",
            ),
        ),
        "tests/formats/gltf/test_written_materials.py"
        "::test_what_shines_through_a_cut_surface_is_as_bright_again[radiance0-0.25]",
    ),
    Mutant(
        "temperatures that are not enabled",
        "formats/usd/lights.py",
        (
            (
                "if stage.value(light.GetEnableColorTemperatureAttr(), False):",
                "if light.GetColorTemperatureAttr().IsAuthored():",
            ),
        ),
        "tests/formats/usd/test_every_attribute_counts.py"
        "::test_temperatures_count_where_they_are_enabled",
    ),
    Mutant(
        "hard cones that are soft",
        "formats/usd/lights.py",
        (("cone * (1.0 - min(max(softness, 0.0), 1.0))", "cone * min(max(softness, 0.0), 1.0)"),),
        "tests/formats/usd/test_every_attribute_counts.py"
        "::test_a_soft_cone_is_even_up_to_where_it_begins_to_fade[0.3]",
    ),
    Mutant(
        "coordinates of OpenUSD turned before they are scaled",
        "formats/usd/textures.py",
        (
            (
                '{"scale": scale}, {"rotate": angle}, {"translate": shift}',
                '{"rotate": angle}, {"scale": scale}, {"translate": shift}',
            ),
        ),
        "tests/formats/usd/test_places_of_textures.py"
        "::test_each_transform_scales_turns_and_moves_what_the_one_before_it_gives[1]",
    ),
    Mutant(
        "metals in the workflow of specular colours",
        "formats/usd/materials.py",
        (
            (
                'core |= self._specular(core["base_color"])',
                (
                    'core |= self._specular(core["base_color"])'
                    ' | {"metallic": self._number("metallic")}'
                ),
            ),
        ),
        "tests/formats/usd/test_every_input_counts.py"
        "::test_inputs_of_the_other_workflow_play_no_part[metallic]",
    ),
    Mutant(
        "cones of OpenUSD that point the other way",
        "formats/usd/meshes.py",
        (('{"rotate": {"axis": "y", "angle": 90}}', '{"rotate": {"axis": "y", "angle": -90}}'),),
        "tests/formats/usd/test_usd.py::test_cones_point_along_their_axis[X]",
    ),
    Mutant(
        "the attribute of normals before the primvar",
        "formats/usd/meshes.py",
        (('if "normals" not in values:', "if True:"),),
        "tests/formats/usd/test_usd.py::test_a_primvar_of_normals_counts_more_than_the_attribute",
    ),
    Mutant(
        "lights of meshes that do not know how large they are",
        "formats/usd/lights.py",
        (("area = 0.5 * float(np.linalg", "area = 1.0 * float(np.linalg"),),
        "tests/formats/usd/test_controls_of_lights.py"
        "::test_the_light_of_a_normalised_mesh_is_divided_by_its_area",
    ),
    Mutant(
        "quarters of triangles in another order than Loop's",
        "formats/usd/subdivision.py",
        (("(b, bc, ab), (c, ca, bc)", "(c, ca, bc), (b, bc, ab)"),),
        "tests/formats/usd/test_loop.py::test_a_mesh_lies_on_the_limit_surface_of_loop",
    ),
    Mutant(
        "heights whose bias is not scaled",
        "formats/geometry/displacement.py",
        (("-offset / factor)", "-offset)"),),
        "tests/formats/usd/test_displacement.py"
        "::test_a_channel_of_a_picture_lifts_a_preview_surface",
    ),
    Mutant(
        "parts of a body that are judged alone",
        "formats/usd/graph.py",
        (("closed = whole or has_inside(shape)", "closed = has_inside(shape)"),),
        "tests/formats/usd/test_networks.py::test_parts_of_a_mesh_may_close_a_body_together",
    ),
    Mutant(
        "coats of glTF that follow the base without a texture of their own",
        "formats/gltf/materials.py",
        (('elif below is not None and self.bsdf["clearcoat"] != 0.0:', "elif False:"),),
        "tests/formats/test_normals_of_coats.py"
        "::test_coats_of_gltf_are_smooth_without_a_texture_of_their_own",
    ),
    Mutant(
        "numbers of pbrt that are the luminance of pictures with holes",
        "formats/pbrt/single_numbers.py",
        (("if alpha is not None and not old and kind in INTERPOLATING:", "if False:"),),
        f"{NUMBERS}::test_numbers_of_pictures_are_those_of_pbrt[RGBA-sRGB]",
    ),
    Mutant(
        "numbers of pbrt 4 that are the red of coloured pictures",
        "formats/pbrt/single_numbers.py",
        (("linear.mean(axis=2) if kind in INTERPOLATING", "linear[..., 0] if kind"),),
        f"{NUMBERS}::test_numbers_of_pictures_are_those_of_pbrt[RGB-linear]",
    ),
    Mutant(
        "numbers of pbrt 3 that are decoded before they are weighed",
        "formats/pbrt/single_numbers.py",
        (("    if old:\n", "    if False:\n"),),
        f"{NUMBERS}::test_numbers_of_pictures_are_those_of_pbrt[RGB-sRGB]",
    ),
    Mutant(
        "shapes of pbrt 3 with half of a hole",
        "formats/pbrt/textures.py",
        (("if not self.context.old or alpha is None:", "if True:"),),
        f"{NUMBERS}::test_in_pbrt_3_only_an_alpha_of_nought_is_a_hole",
    ),
    Mutant(
        "folders of pictures that are searched in the order of the file",
        "formats/reading/reach.py",
        (("self.searched.insert(0, path)", "self.searched.append(path)"),),
        "tests/formats/test_reach.py::test_the_folder_that_was_named_last_is_searched_first",
    ),
    Mutant(
        "a common scale of Mitsuba 3 that the sun's own takes the place of",
        "formats/mitsuba/daylight.py",
        (('if old and kind == "sunsky"', 'if kind == "sunsky"'),),
        "tests/formats/mitsuba/test_daylight_and_projectors.py::"
        "test_scales_of_version_3_are_factors_of_the_common_one",
    ),
    Mutant(
        "a text of Mitsuba that may be a number",
        "formats/mitsuba/properties.py",
        (('return self.value(name, "string")', 'return self.value(name, "string", "integer")'),),
        "tests/recorded/test_answers.py::"
        "test_an_answer_is_still_the_recorded_one[reader_edits/mitsuba_3]",
    ),
)
