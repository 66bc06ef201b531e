"""Bugs that random slips of the campaign stand for, each with the law that closes its class."""

from tests.mutants.mutant import Mutant

LAWS_OF = "tests/laws/test_every_model.py::test_it_obeys_the_laws_of_its_family"

SLIPS = (
    Mutant(
        "a lobe of sheen that is narrower than its table",
        "bsdfs/disney/sheen.py",
        (("exp(0.5 * exponent * log(sin2))", "exp(0.51 * exponent * log(sin2))"),),
        "tests/physics/test_sheen.py::"
        "test_the_lobe_is_its_formula_and_its_table_holds_its_integral",
    ),
    Mutant(
        "a lens that sees the sky through its middle",
        "cameras/thin_lens.py",
        (
            (
                "connect_far_point(table, lens_of(table, u_lens), d)",
                "connect_far_point(table, 0.0 * lens_of(table, u_lens), d)",
            ),
        ),
        f"{LAWS_OF}[cameras-thin_lens]",
    ),
    Mutant(
        "a filter's outer part that is too high where splats are weighed",
        "filters/mitchell.py",
        (("(8.0 * b + 24.0 * c)\n    m =", "(8.0 * b + 24.48 * c)\n    m ="),),
        f"{LAWS_OF}[filters-mitchell]",
    ),
    Mutant(
        "shape and triangle change places among the ids",
        "integrators/aov.py",
        (
            (
                "Vec3(to_float(hit.shape + 1), to_float(hit.prim + 1), ",
                "Vec3(to_float(hit.prim + 1), to_float(hit.shape + 1), ",
            ),
        ),
        "tests/rendering/test_aovs.py::test_ids_name_the_shape_the_triangle_and_what_it_is_made_of",
    ),
    Mutant(
        "the kind of the first medium's phase function for all media",
        "media/sampling.py",
        (
            (
                "kind = gather(scene.media.info, medium * INFO + PHASE)\n        # 1 -",
                "kind = gather(scene.media.info, medium * 0 + INFO + PHASE)\n        # 1 -",
            ),
        ),
        "tests/media/test_several_phases.py::"
        "test_lanes_in_different_media_have_the_phase_functions_of_their_own",
    ),
    Mutant(
        "collisions in a grid beyond the end of the way",
        "media/grid.py",
        (("lanes(0.0), minimum(t_max, FARTHEST))", "lanes(0.0), lanes(FARTHEST))"),),
        "tests/media/test_flights.py::test_flights_come_through_as_the_transmittance_says",
    ),
    Mutant(
        "cells counted from the corner of the window",
        "films/merging.py",
        (("(y + np.arange(h))", "(np.arange(h))"),),
        "tests/film/test_windows.py::test_every_pixel_of_a_window_holds_what_its_cell_says",
    ),
    Mutant(
        "shadow rays that nobody counts",
        "integrators/direct_light.py",
        (("rays += count_lanes(lit)", "rays += 0"),),
        "tests/rendering/test_rays_are_counted.py::test_rays_are_as_many_as_the_edges_of_the_paths",
    ),
    Mutant(
        "nothing passes through rough glass with a bent normal",
        "bsdfs/normals/shading_normals.py",
        (
            (
                "agrees = (inner.z * wi.z > 0.0) & (dot(n, wo) * wo.z > 0.0)\n        left",
                "agrees = (wi.z > 0.0) & (dot(n, wo) * wo.z > 0.0)\n        left",
            ),
        ),
        "tests/physics/test_bent_normals.py::"
        "test_a_bent_surface_is_the_same_one_turned_where_both_agree_on_the_sides",
    ),
    Mutant(
        "blocks as small as the better known picture allows",
        "metrics/agreement.py",
        (("freedom = min((s.replicates", "freedom = max((s.replicates"),),
        "tests/metrics/test_agreement.py::"
        "test_blocks_are_at_most_1024_but_are_large_enough_for_few_replicates",
    ),
    Mutant(
        "the second round of a hash leaves out a word",
        "core/rng.py",
        (("    z += x * y\n    w += y * z\n    return", "    z += x\n    w += y * z\n    return"),),
        "tests/samplers/test_rng.py::test_every_hash_can_be_run_backwards_as_it_was_published",
    ),
    Mutant(
        "a seed one of whose bits is that of another one",
        "samplers/sobol.py",
        (("scramble << 16)", "scramble << 17)"),),
        "tests/samplers/test_samplers.py::"
        "test_the_third_seed_of_a_pair_is_independent_of_either_other_one",
    ),
    Mutant(
        "points of a rectangle at exchanged coordinates, where light starts",
        "shapes/rectangle.py",
        (("p = flat_point(tables.data, k, x, y)", "p = flat_point(tables.data, k, y, x)"),),
        f"{LAWS_OF}[shapes-rectangle]",
    ),
    Mutant(
        "Newton's step for Halley's",
        "core/microfacet.py",
        (("1.0 + 0.5 * step", "1.0 + step"),),
        "tests/sampling/test_microfacet.py::"
        "test_each_step_to_a_visible_slope_is_of_the_third_order",
    ),
    Mutant(
        "boxes with the margin of their shorter edge",
        "accel/references.py",
        (
            (
                "maximum(lane(edges, 0), maximum(lane(edges, 1), lane(edges, 2)))",
                "maximum(lane(edges, 0), minimum(lane(edges, 1), lane(edges, 2)))",
            ),
        ),
        "tests/accel/test_boxes.py::"
        "test_boxes_are_enlarged_by_their_longest_edge_and_their_coordinates",
    ),
    Mutant(
        "tiles go to the row that is their column",
        "films/tiles.py",
        (("return slice(top, top + th)", "return slice(left, left + th)"),),
        "tests/film/test_windows.py::"
        "test_tiles_are_those_within_the_window_and_go_where_they_belong",
    ),
    Mutant(
        "the first column of the picture comes again and again",
        "rendering/tiles/tile_kernel.py",
        (("            if x < 0:", "            if x <= 0:"),),
        "tests/rendering/test_in_the_twin.py::"
        "test_every_sample_of_a_tile_is_visited_once_with_its_index_and_replicate[corner-1]",
    ),
    Mutant(
        "arms without a vote are judged at no level",
        "lab/evaluate.py",
        (("for i in others], share * LEVEL)", "for i in others], share)"),),
        "tests/lab/test_laws_of_studies.py::test_verdicts_are_what_the_p_values_say_at_the_level",
    ),
    Mutant(
        "quadrants of a guide that end a little early",
        "guiding/records.py",
        (("where(lower, 2.0 * y,", "where(lower, 2.04 * y,"),),
        "tests/guiding/test_laws_of_training.py::test_every_direction_lies_in_its_quadrant",
    ),
    Mutant(
        "a profile that jumps from angle to angle",
        "lights/ies.py",
        (("upper + y * (lower - upper)", "upper + y * (lower + upper)"),),
        "tests/lights/test_profiles.py::"
        "test_intensity_is_that_of_the_four_angles_around_a_direction[13]",
    ),
    Mutant(
        "a third channel of layers of two that is white",
        "view/shades.py",
        (("np.zeros_like(share[..., :1])", "np.ones_like(share[..., :1])"),),
        "tests/view/test_shades.py::"
        "test_places_go_from_the_least_to_the_largest_of_each_channel[uv-2]",
    ),
    Mutant(
        "shapes of different models shine as the first one does",
        "lights/hits.py",
        (
            (
                """(scene, index, surface, wo)
        mine = lanes_u32(0) + gather(scene.lights.info, index * INFO) == number""",
                """(scene, index, surface, wo)
        mine = lanes_u32(0) + gather(scene.lights.info, 0 * index) == number""",
            ),
        ),
        "tests/lights/test_lights_side_by_side.py::test_shapes_that_shine_each_in_its_way_are_asked"
        "_by_their_own_model[_emission_chain-emitted]",
    ),
    Mutant(
        "the last path that met a surface is forgotten",
        "rendering/tiles/tile_loop.py",
        (("elif held > 0:", "elif held > 1:"),),
        "tests/rendering/test_in_the_twin.py::test_no_sample_is_left_waiting[path-2-1]",
    ),
    Mutant(
        "the error of a triangle that is high by its width",
        "shapes/mesh.py",
        (("maximum(a.z, b.z))", "maximum(a.z, b.x))"),),
        "tests/shapes/test_bounds.py::"
        "test_the_error_of_a_triangle_reaches_along_its_normal_and_as_far_as_its_edges",
    ),
)
