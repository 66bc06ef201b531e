"""Bugs of paths."""

from tests.mutants.mutant import Mutant

FORMS = "tests/estimators/test_closed_forms.py"
TWIN = "tests/rendering/test_in_the_twin.py"

TRANSPORT = (
    Mutant(
        "both ways of sampling with full weight",
        "integrators/mis_weights.py",
        (
            ("where(path.delta, 1.0, heuristic(path.pdf, light_pdf))", "lanes(1.0)"),
            ("where(light.delta, 1.0, heuristic(light.pdf, bsdf_pdf))", "lanes(1.0)"),
        ),
        f"{FORMS}::test_furnace_box_returns_le_over_one_minus_albedo[mis]",
    ),
    Mutant(
        "light behind a mirror weighed as if lights were sampled for it",
        "integrators/mis_weights.py",
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
        "integrators/roulette.py",
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
        "integrators/reach.py",
        (("found, shining, depth <= 2)", "found, shining, depth <= 1)"),),
        f"{TWIN}::test_the_direct_layer_is_the_picture_of_two_edges",
    ),
    Mutant(
        "NaN in the value of a BSDF taken for darkness",
        "integrators/direct_light.py",
        (("~(max_component(f_cos) <= 0.0)", "(max_component(f_cos) > 0.0)"),),
        f"{TWIN}::test_samples_that_are_not_finite_are_counted_and_add_nothing",
    ),
    Mutant(
        "NaN swallowed by the end of a path",
        "integrators/path.py",
        (("~(brightness <= 0.0)", "(brightness > 0.0)"),),
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
    Mutant(
        "a light behind a hole as near as the hole",
        "integrators/reach.py",
        (("distance = length(surface.p - path.p)", "distance = hit.t"),),
        "tests/estimators/test_nothing_in_between.py"
        "::test_surfaces_that_are_not_there_change_no_sample[nothing/nothing-path]",
    ),
    Mutant(
        "all light so far as direct light, behind a hole too",
        "integrators/walk.py",
        (("path.L_direct + found, path.L_direct", "path.L + found, path.L_direct"),),
        "tests/rendering/test_in_the_twin.py"
        "::test_the_direct_layer_is_the_picture_of_two_edges[clear]",
    ),
    Mutant(
        "what a medium emits behind the second edge as direct light",
        "integrators/interiors/collisions.py",
        (("scattered, path.depth <= 1)", "scattered, path.depth <= 2)"),),
        "tests/rendering/test_in_the_twin.py"
        "::test_the_direct_layer_is_the_picture_of_two_edges[glow]",
    ),
    Mutant(
        "panes taken for holes, which shadow rays do not see",
        "bsdfs/dielectrics/thin_dielectric.py",
        (("lanes_u32(TRANSMISSION | DELTA)", "lanes_u32(TRANSMISSION | DELTA | 8)"),),
        "tests/sampling/test_holes_of_materials.py"
        "::test_holes_of_mixtures_are_as_likely_as_they_are_open[pane and hole-0.7]",
    ),
    Mutant(
        "paths that a filter weighs negatively end",
        "integrators/path.py",
        (("max_component(absolute_vec3(beta))", "max_component(beta)"),),
        "tests/estimators/test_closed_forms.py"
        "::test_filters_with_negative_lobes_keep_the_radiance_of_a_furnace",
    ),
)
