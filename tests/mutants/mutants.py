"""Classical bugs of path tracers as small patches, each with the test that must find it."""

from __future__ import annotations

from typing import NamedTuple


class Mutant(NamedTuple):
    """One bug.

    Attributes
    ----------
    name : str
        The bug, in words.
    file : str
        Inside the package.
    edits : tuple of (str, str)
        Texts that occur exactly once in the file, and what takes their places.
    killer : str
        The test, as pytest names it, that passes without the bug and fails with it.
    """

    name: str
    file: str
    edits: tuple[tuple[str, str], ...]
    killer: str


LAWS = "tests/physics/test_bsdf_laws.py"
FORMS = "tests/estimators/test_closed_forms.py"
LIGHTS = "tests/lights/test_light_sampling.py"
MAPS = "tests/lights/test_environment.py"
STRATEGIES = "tests/lights/test_environment_strategies.py"
LAMPS = "tests/lights/test_spot_and_textured.py"
TWIN = "tests/rendering/test_in_the_twin.py"
BITS = "tests/determinism/test_same_bits.py"
BITMAPS = "tests/textures/test_bitmap.py"
ROUGH = "tests/physics/test_rough_models.py"
LAYERED = "tests/physics/test_layered_models.py"
ORACLES = "tests/accel/test_against_oracles.py"

SCATTERING = (
    Mutant(
        "value of a BSDF without the cosine",
        "bsdfs/diffuse.py",
        (("cosine = where(above, INV_PI * wi.z, 0.0)", "cosine = where(above, INV_PI, 0.0)"),),
        f"{LAWS}::test_white_furnace_of_lossless_models",
    ),
    Mutant(
        "eta for eta^2 in refracted radiance",
        "bsdfs/dielectric.py",
        (("where(reflects, 1.0, 1.0 / (eta * eta))", "where(reflects, 1.0, 1.0 / eta)"),),
        f"{LAWS}::test_white_furnace_of_lossless_models",
    ),
    Mutant(
        "indices of refraction swapped",
        "bsdfs/dielectric.py",
        (
            (
                "where(wo.z > 0.0, params.eta, 1.0 / params.eta)",
                "where(wo.z < 0.0, params.eta, 1.0 / params.eta)",
            ),
        ),
        f"{LAWS}::test_white_furnace_of_lossless_models",
    ),
    Mutant(
        "density of the other way of sampling",
        "bsdfs/diffuse.py",
        (("where(above, INV_TWO_PI, 0.0)", "cosine"),),
        "tests/sampling/test_bsdf_sampling.py::test_samples_follow_their_density",
    ),
    Mutant(
        "two-sided surface that turns only wo",
        "bsdfs/switch.py",
        (("_flip(back, wo), _flip(back, wi), active", "_flip(back, wo), wi, active"),),
        "tests/sampling/test_dispatch.py"
        "::test_the_back_of_a_two_sided_surface_looks_like_its_front",
    ),
    Mutant(
        "u for sqrt(u) in the disk",
        "core/warps.py",
        (("r = sqrt(u2[0])", "r = u2[0]"),),
        "tests/sampling/test_warps.py::test_disk_points_are_uniform",
    ),
    Mutant(
        "cosine-weighted directions without the root of the projection",
        "core/warps.py",
        (("sqrt(maximum(0.0, 1.0 - x * x - y * y))", "maximum(0.0, 1.0 - x * x - y * y)"),),
        "tests/sampling/test_warps.py::test_directions_follow_their_density",
    ),
    Mutant(
        "left-handed shading frame",
        "core/frame.py",
        (("cross(n, s), t0", "cross(s, n), t0"),),
        "tests/unit/test_frame.py::test_frame_from_tangent_is_right_handed_and_orthonormal",
    ),
    Mutant(
        "normals by the matrix, not its inverse transpose",
        "shapes/sphere.py",
        (
            (
                "gradient = transposed_times(data, k + INVERSE, q)",
                "gradient = times(data, k + MATRIX, q)",
            ),
        ),
        "tests/shapes/test_surfaces.py::test_normals_go_by_the_inverse_transpose",
    ),
)

LIGHT = (
    Mutant(
        "density per area for one per solid angle",
        "shapes/hit.py",
        (
            (
                "pdf_area * distance * distance / where(edge_on, 1.0, absolute(cosine))",
                "pdf_area + 0.0 * distance",
            ),
        ),
        f"{LIGHTS}::test_solid_angle_of_a_disk_on_its_axis",
    ),
    Mutant(
        "probability of the light's choice forgotten",
        "lights/sampling.py",
        (("pdf = s.pdf * pmf", "pdf = s.pdf"),),
        f"{LIGHTS}::test_lights_are_chosen_as_asked",
    ),
    Mutant(
        "density of the environment forgotten",
        "lights/sampling.py",
        (
            (
                "return density(scene, d) * scene.lights.data[scene.lights.data.size - STRIDE + 3]",
                "return lanes(0.0)",
            ),
        ),
        f"{LIGHTS}::test_constant_environment",
    ),
    Mutant(
        "light's choice forgotten where a ray finds the environment",
        "lights/sampling.py",
        (
            (
                "return density(scene, d) * scene.lights.data[scene.lights.data.size - STRIDE + 3]",
                "return density(scene, d)",
            ),
        ),
        f"{LIGHTS}::test_lights_are_chosen_as_asked",
    ),
    Mutant(
        "light's choice forgotten where a ray finds a lamp",
        "lights/sampling.py",
        (("density * gather(scene.lights.data, index * STRIDE + 3), 0.0)", "density, 0.0)"),),
        f"{LIGHTS}::test_lights_are_chosen_as_asked",
    ),
    Mutant(
        "density of an environment map without the sine of the latitude",
        "lights/environment.py",
        (
            (
                "(0.5 * INV_TWO_PI) / absolute(size)",
                "(0.5 * INV_TWO_PI) * as_float(as_int(scene.lights.map[ROWS]))",
            ),
        ),
        f"{MAPS}::test_density_integrates_to_one",
    ),
    Mutant(
        "cells of an environment map chosen without the sine of the latitude",
        "lights/environment_map.py",
        (("cumulative_2d(share * seen)", "cumulative_2d(seen)"),),
        f"{MAPS}::test_importance_has_little_variance",
    ),
    Mutant(
        "environment map turned the wrong way round",
        "lights/environment.py",
        (
            ("arctan2(d.x, -d.z)", "arctan2(-d.x, -d.z)"),
            ("Vec3(sine * s, cosine, -sine * z)", "Vec3(-sine * s, cosine, -sine * z)"),
        ),
        f"{MAPS}::test_middle_of_the_map_is_along_z_and_its_left_half_towards_x",
    ),
    Mutant(
        "importance compensated where nothing complements it",
        "compiled/scene.py",
        (('== "mis"', '!= "bsdf"'),),
        f"{STRATEGIES}::test_only_combined_sampling_is_compensated",
    ),
    Mutant(
        "textured lamp whose samples show another point",
        "lights/emission.py",
        (
            (
                "x, y = where(mine, x1, x), where(mine, y1, y)",
                "x, y = where(mine, y1, x), where(mine, x1, y)",
            ),
        ),
        f"{LAMPS}::test_samples_show_the_texture_of_the_point_that_they_hit",
    ),
    Mutant(
        "light from both sides of a lamp",
        "lights/sampling.py",
        (("(surface.light > 0) & (dot(wo, surface.ng) > 0.0)", "surface.light > 0"),),
        f"{LIGHTS}::test_area_lights_shine_on_their_outer_side_only",
    ),
    Mutant(
        "point light that does not fall with the square of the distance",
        "lights/point.py",
        (("1.0 / squared", "1.0 / sqrt(squared)"),),
        f"{LIGHTS}::test_point_light",
    ),
    Mutant(
        "shadow rays as long as the way to the light",
        "shapes/hit.py",
        (("return where(distance < 1e30, length, distance)", "return distance"),),
        "tests/shapes/test_robust_rays.py::test_shadow_rays_do_not_meet_their_light",
    ),
    Mutant(
        "rays that start on the surface itself",
        "shapes/hit.py",
        (("return p + copysign(error, side_of(w, ng)) * ng", "return p"),),
        "tests/shapes/test_robust_rays.py::test_spawn_origin_moves_to_the_side_of_the_direction",
    ),
    Mutant(
        "power heuristic without its square",
        "core/mis.py",
        (("squared = ratio * ratio", "squared = ratio"),),
        "tests/unit/test_mis.py::test_weights_are_the_closed_form",
    ),
)

TRANSPORT = (
    Mutant(
        "both ways of sampling with full weight",
        "integrators/path.py",
        (
            ("where(path.delta, 1.0, heuristic(path.pdf, light_pdf))", "lanes(1.0)"),
            ("where(light.delta, 1.0, heuristic(light.pdf, bsdf_pdf))", "lanes(1.0)"),
        ),
        f"{FORMS}::test_furnace_box_returns_le_over_one_minus_albedo[mis]",
    ),
    Mutant(
        "light behind a mirror weighed as if lights were sampled for it",
        "integrators/path.py",
        (
            (
                "where(path.delta, 1.0, heuristic(path.pdf, light_pdf))",
                "heuristic(path.pdf, light_pdf)",
            ),
        ),
        f"{FORMS}::test_furnace_box_returns_le_over_one_minus_albedo[mis]",
    ),
    Mutant(
        "survivors of the roulette do not carry the light of the others",
        "integrators/path.py",
        (("beta / survival", "beta"),),
        f"{FORMS}::test_roulette_does_not_change_the_mean[1]",
    ),
    Mutant(
        "paths one edge too long",
        "integrators/path.py",
        (("depth < settings.max_depth", "depth <= settings.max_depth"),),
        f"{FORMS}::test_depth_cap_gives_the_partial_geometric_series[mis-1]",
    ),
    Mutant(
        "direct light ends one edge too early",
        "integrators/path.py",
        (("shining & (depth <= 2)", "shining & (depth <= 1)"),),
        f"{TWIN}::test_the_direct_layer_is_the_picture_of_two_edges",
    ),
    Mutant(
        "NaN in the value of a BSDF taken for darkness",
        "integrators/path.py",
        (("~(max_component(f_cos) <= 0.0)", "(max_component(f_cos) > 0.0)"),),
        f"{TWIN}::test_samples_that_are_not_finite_are_counted_and_add_nothing",
    ),
    Mutant(
        "NaN swallowed by the end of a path",
        "integrators/path.py",
        (("~(largest <= 0.0)", "(largest > 0.0)"),),
        f"{TWIN}::test_samples_that_are_not_finite_are_counted_and_add_nothing",
    ),
    Mutant(
        "light and BSDF sampled with the same numbers",
        "integrators/walk.py",
        (("ROULETTE = 0, 1, 3, 4, 6", "ROULETTE = 0, 1, 3, 1, 6"),),
        f"{TWIN}::test_no_random_number_is_used_for_two_purposes",
    ),
    Mutant(
        "the same numbers at every vertex",
        "integrators/walk.py",
        (("CAMERA_DIMENSIONS + (depth - 1) * VERTEX_DIMENSIONS", "CAMERA_DIMENSIONS + 0 * depth"),),
        f"{TWIN}::test_no_random_number_is_used_for_two_purposes",
    ),
)

RAYS = (
    Mutant(
        "any-hit that looks beyond the end of the ray",
        "accel/lists.py",
        (
            (
                "_, _, _, hit = intersect_triangle(accel.triangles, 9 * i, origin, shear, t_max)",
                "_, _, _, hit = intersect_triangle(accel.triangles, 9 * i, origin, shear, 1e38)",
            ),
        ),
        f"{ORACLES}::test_any_hit_agrees_with_closest_and_t_max_ends_the_ray[list]",
    ),
    Mutant(
        "ties go to the highest shape",
        "accel/lists.py",
        (("hit & (t < found.t)", "hit & (t <= found.t)"),),
        "tests/accel/test_scenes.py"
        "::test_ties_go_to_the_lowest_shape_then_the_lowest_primitive[list]",
    ),
    Mutant(
        "box test that culls what it should keep",
        "accel/single.py",
        (("STRETCH = 1.0 + 2.0**-20", "STRETCH = 1.0 - 2.0**-10"),),
        f"{ORACLES}::test_every_builder_finds_the_same_hits[sah]",
    ),
)

FILM = (
    Mutant(
        "sums in float32",
        "rendering/tile_kernel.py",
        (
            ("    as_int,\n", "    as_int,\n    as_float,\n"),
            (
                "+= as_int(limbs[i * LANES + lane])",
                "= as_int(as_float(film.sums[at * 6 + i]) + limbs[i * LANES + lane])",
            ),
        ),
        f"{BITS}::test_two_halves_are_the_whole",
    ),
    Mutant(
        "replicate and index of a sample swapped",
        "rendering/tile_kernel.py",
        (("first // replicates, first % replicates", "first % replicates, first // replicates"),),
        f"{TWIN}::test_every_sample_of_a_tile_is_visited_once_with_its_index_and_replicate",
    ),
    Mutant(
        "the same scramble for all replicates",
        "samplers/state.py",
        (("pixel_keys(x, y, scramble, seed)", "pixel_keys(x, y, 0, seed)"),),
        "tests/samplers/test_samplers.py::test_neighbours_are_not_correlated",
    ),
    Mutant(
        "random numbers reach 1",
        "core/rng.py",
        (("return to_float(word >> 8) * TO_UNIT", "return to_float(word >> 1) * (2.0**-31)"),),
        "tests/samplers/test_rng.py::test_unit_float_stays_below_one",
    ),
    Mutant(
        "weight of the pixel filter forgotten",
        "rendering/tile_kernel.py",
        (("lanes_vec3(1.0) * weight", "lanes_vec3(1.0)"),),
        f"{TWIN}::test_an_edge_rings_as_the_mitchell_filter_says",
    ),
    Mutant(
        "camera rays by the pixel's place in the tile",
        "rendering/tile_kernel.py",
        (("to_float(x) + 0.5 + dx", "to_float(x - tile.x0) + 0.5 + dx"),),
        f"{BITS}::test_crop_equals_the_cut_out",
    ),
    Mutant(
        "random numbers that depend on the tile",
        "rendering/tile_kernel.py",
        (("3 * ROOM), lanes_u32(settings.seed)", "3 * ROOM), lanes_u32(settings.seed + tile.x0)"),),
        f"{BITS}::test_tile_order_and_size",
    ),
    Mutant(
        "standard error without R / (R - 1)",
        "films/statistics.py",
        (("squares * (replicates / (replicates - 1))", "squares"),),
        "tests/film/test_film.py::test_standard_error_is_the_formula_of_the_replicates",
    ),
    Mutant(
        "many tests, each at the level of one",
        "metrics/statistics.py",
        (("level / (len(p_values) - rank)", "level"),),
        "tests/metrics/test_statistics.py::test_holm_steps_down",
    ),
)

FACETS = (
    Mutant(
        "wrong Jacobian of the half vector",
        "bsdfs/rough_conductor.py",
        (("pdf = 0.25 * facet_density", "pdf = 0.5 * facet_density"),),
        "tests/sampling/test_bsdf_sampling.py::test_samples_follow_their_density",
    ),
    Mutant(
        "G1 for G: no shadow on the way in",
        "bsdfs/rough_conductor.py",
        (("where(above, masking, 0.0)", "where(above, 1.0 + 0.0 * masking, 0.0)"),),
        f"{ROUGH}::test_rough_metal_is_walters_formula[beckmann]",
    ),
    Mutant(
        "radiance through a rough interface without 1 / eta^2",
        "bsdfs/rough_dielectric.py",
        (("(masking / (eta * eta))", "(masking + 0.0 * eta)"),),
        f"{ROUGH}::test_glass_loses_only_what_meets_two_facets",
    ),
    Mutant(
        "indices of rough glass swapped",
        "bsdfs/rough_dielectric.py",
        (
            (
                "    eta = where(below, 1.0 / params.eta, params.eta)\n    weight, pdf = _scatter",
                "    eta = where(below, params.eta, 1.0 / params.eta)\n    weight, pdf = _scatter",
            ),
        ),
        f"{ROUGH}::test_rough_glass_is_walters_formula[ggx]",
    ),
    Mutant(
        "refraction with the Jacobian of reflection",
        "bsdfs/rough_dielectric.py",
        (
            (
                "jacobian = where(reflects, 0.25 * fresnel, refracted)",
                "jacobian = 0.25 * fresnel + 0.0 * refracted",
            ),
        ),
        f"{ROUGH}::test_rough_glass_is_walters_formula[ggx]",
    ),
    Mutant(
        "all facets for those that are seen",
        "core/microfacet.py",
        (
            (
                "facets.alpha_y, absolute(wo.z)))",
                "facets.alpha_y, 1e4 * absolute(wo.z)))",
            ),
        ),
        "tests/sampling/test_microfacet.py::test_visible_normals_follow_their_density",
    ),
    Mutant(
        "pane of one interface",
        "bsdfs/thin_dielectric.py",
        (("reflectance = 2.0 * once / (1.0 + once)", "reflectance = once"),),
        f"{ROUGH}::test_panes_add_up_all_inner_reflections[1.0]",
    ),
)

TEXTURES = (
    Mutant(
        "pictures of whole numbers taken for linear",
        "textures/images.py",
        (("(decode_srgb(values) if encoded else values)", "(values)"),),
        f"{BITMAPS}::test_whole_numbers_are_srgb_unless_they_are_data",
    ),
    Mutant(
        "pictures upside down",
        "textures/bitmap.py",
        (("_neighbours(1.0 - _folded(t, wrap), height", "_neighbours(_folded(t, wrap), height"),),
        f"{BITMAPS}::test_lookups_are_those_of_mitsuba[repeat-bilinear]",
    ),
    Mutant(
        "texels half a texel off",
        "textures/bitmap.py",
        (("f * size - 0.5", "f * size"),),
        f"{BITMAPS}::test_bilinear_is_the_formula_over_an_endless_picture[mirror]",
    ),
)

MATERIALS = (
    Mutant(
        "coat sampled with another probability than stated",
        "bsdfs/plastic.py",
        (("mirrored = u < share", "mirrored = u < 0.5 * share"),),
        f"{LAWS}::test_white_furnace_of_lossless_models",
    ),
    Mutant(
        "weight of a blend taken for the other part",
        "bsdfs/blend.py",
        (
            (
                'Part(self.bsdfs[0], "rest"), Part(self.bsdfs[1], "weight")',
                'Part(self.bsdfs[0], "weight"), Part(self.bsdfs[1], "rest")',
            ),
        ),
        f"{LAYERED}::test_values_and_densities_are_weighted_sums",
    ),
    Mutant(
        "opacity taken for transparency",
        "bsdfs/mask.py",
        (
            (
                'Part(Null(), "rest"), Part(self.bsdf, "weight")',
                'Part(Null(), "weight"), Part(self.bsdf, "rest")',
            ),
        ),
        f"{LAYERED}::test_holes_of_a_mask_let_light_straight_on",
    ),
)

MUTANTS = SCATTERING + LIGHT + TRANSPORT + RAYS + FILM + FACETS + TEXTURES + MATERIALS
