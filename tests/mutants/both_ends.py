"""Bugs of paths from both ends: what joins them, and what they weigh."""

from tests.mutants.mutant import Mutant

TESTS = "tests/rendering/test_bidirectional.py"
FINDS = f"{TESTS}::test_it_finds_what_path_tracing_finds"
HIDDEN = f"{TESTS}::test_it_finds_what_hides_in_glass_and_among_many_lamps"
PYRAMID = "tests/lab/test_pyramid.py"
LONGEST = f"{TESTS}::test_no_path_is_longer_than_the_longest"
STAINED = f"{TESTS}::test_stained_water_dims_what_the_camera_sees_in_it"
WEIGHTS = f"{TESTS}::test_weights_are_the_shares_of_densities_and_sum_to_one"

BOTH_ENDS = (
    Mutant(
        "one light path stands for all pixels in the weight of a splat",
        "integrators/both_ends/light_subpath.py",
        (("geometry / paths * all_behind", "geometry * all_behind"),),
        f"{FINDS}[a lamp]",
    ),
    Mutant(
        "as many light paths in the weights as are traced together",
        "rendering/tiles/both_ends_tile.py",
        (
            (
                "as_float((window.x1 - window.x0) * (window.y1 - window.y0))",
                "as_float((tile.x1 - tile.x0) * (tile.y1 - tile.y0))",
            ),
        ),
        f"{TESTS}::test_threads_passes_and_merging_leave_the_bits",
    ),
    Mutant(
        "vertices of light paths without Veach's correction for shading normals",
        "integrators/both_ends/light_subpath.py",
        (
            ("path.beta * per_cos, behind", "path.beta * (1.0 / absolute(arrival.wl.z)), behind"),
            ("absolute(dot(surface.ng, c.w)) * c", "absolute(dot(surface.ns, c.w)) * c"),
        ),
        f"{HIDDEN}[in glass]",
    ),
    Mutant(
        "flux of joined paths is concentrated in glass as radiance is",
        "integrators/both_ends/light_walk.py",
        (("turned = turned * inside / outside", "turned = turned * 1.0"),),
        f"{FINDS}[under water]",
    ),
    Mutant(
        "densities of all earlier techniques without the cosine of arrival",
        "integrators/both_ends/connection_weights.py",
        (
            (
                "minimum(techniques.far * per_cos, LARGEST)",
                "minimum(techniques.far, LARGEST)",
            ),
        ),
        f"{WEIGHTS}[3-power]",
    ),
    Mutant(
        "the density of a vertex without its distance",
        "integrators/both_ends/connection_weights.py",
        (("(distance * distance * per_cos)", "per_cos"),),
        f"{WEIGHTS}[3-balance]",
    ),
    Mutant(
        "a vertex with a delta lobe is thought to be joined",
        "integrators/both_ends/connection_weights.py",
        (
            (
                "Techniques(where(delta, 0.0, per_pdf),",
                "Techniques(per_pdf + where(delta, 0.0, 0.0),",
            ),
        ),
        f"{WEIGHTS}[6-power]",
    ),
    Mutant(
        "light that a camera path hits forgets that light paths find it too",
        "integrators/both_ends/camera_subpath.py",
        (("emission * behind.far, 0.0)", "0.0 * behind.far, 0.0)"),),
        f"{HIDDEN}[in glass]",
    ),
    Mutant(
        "paths of the greatest length that is joined count twice",
        "integrators/both_ends/camera_subpath.py",
        (("where(depth <= LONGEST, emission", "where(depth < LONGEST, emission"),),
        f"{TESTS}::test_paths_that_are_too_long_to_be_joined_are_found_all_the_same",
    ),
    Mutant(
        "light paths know the density of lamps by the light tree, camera paths by their power",
        "lights/emission/density.py",
        (("where(light.delta, choice_of(scene, lanes_u32(0) + index), light.pdf)", "light.pdf"),),
        f"{HIDDEN}[many]",
    ),
    Mutant(
        "joined paths one edge too long",
        "integrators/both_ends/camera_subpath.py",
        (("(edges <= settings.max_depth)", "(edges <= settings.max_depth + 1)"),),
        f"{LONGEST}[Bidirectional]",
    ),
    Mutant(
        "the pyramid counts a splat as often as there are pixels",
        "integrators/both_ends/light_subpath.py",
        (("splat.value * (1.0 / paths)", "splat.value"),),
        f"{PYRAMID}::test_weighted_techniques_add_up_to_the_picture",
    ),
    Mutant(
        "joined paths are told apart by one vertex too few",
        "integrators/both_ends/camera_subpath.py",
        (("(y.depth + 1, edges)", "(y.depth, edges)"),),
        f"{PYRAMID}::test_each_technique_alone_finds_all_light_of_its_length",
    ),
    Mutant(
        "light paths come through coloured glass undimmed",
        "integrators/both_ends/light_walk.py",
        (("come_to(scene, path, surface, hit.t, active, active)", "path"),),
        f"{HIDDEN}[in stained glass]",
    ),
    Mutant(
        "water around the camera does not dim what it sees of light paths",
        "integrators/both_ends/splats.py",
        (("dimmed(value, left_along(bodies, end, lit))", "value"),),
        f"{STAINED}[Light]",
    ),
    Mutant(
        "light from infinity starts behind what would stop it",
        "integrators/both_ends/light_subpath.py",
        (("active=path.active & ~stopped", "active=path.active"),),
        f"{TESTS}::test_shapes_without_bounds_stop_light_from_infinity",
    ),
)
