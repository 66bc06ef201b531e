"""Bugs of intersection."""

from tests.mutants.mutant import Mutant

ORACLES = "tests/accel/test_against_oracles.py"

RAYS = (
    Mutant(
        "any-hit that looks beyond the end of the ray",
        "accel/lists.py",
        (
            (
                "accel.triangles, 9 * i, origin, shear, found.t)",
                "accel.triangles, 9 * i, origin, shear, found.t if nearest else lanes(1e38))",
            ),
        ),
        f"{ORACLES}::test_any_hit_agrees_with_closest_and_t_max_ends_the_ray[list]",
    ),
    Mutant(
        "ties go to the highest shape",
        "accel/lists.py",
        (("met & (hit.t < found.t)", "met & (hit.t <= found.t)"),),
        "tests/accel/test_scenes.py"
        "::test_ties_go_to_the_lowest_shape_then_the_lowest_primitive[list]",
    ),
    Mutant(
        "children as near as the nearest are forgotten",
        "accel/stack.py",
        (("met & ~mask_of(CHILDREN, 1 << first)", "met & (enter > least)"),),
        f"{ORACLES}::test_every_builder_finds_the_same_hits[sah]",
    ),
    Mutant(
        "nodes that halve what is below them, whatever it costs",
        "accel/collapse.py",
        (("    if level < CHOSEN_LEVELS:", "    if level < 0:"),),
        "tests/accel/test_collapse.py::test_no_other_choice_of_nodes_costs_less",
    ),
    Mutant(
        "box test that culls what it should keep",
        "accel/node_test.py",
        (("STRETCH = 1.0 + 2.0**-20", "STRETCH = 1.0 - 2.0**-10"),),
        f"{ORACLES}::test_every_builder_finds_the_same_hits[sah]",
    ),
    Mutant(
        "points of shining triangles thought to be exact",
        "shapes/mesh.py",
        (
            (
                "(wi, distance, cosine, error, density)",
                "(wi, distance, cosine, 0.0 * error, density)",
            ),
        ),
        "tests/shapes/test_robust_rays.py"
        "::test_shadow_rays_from_the_air_do_not_meet_their_light[mesh-far]",
    ),
    Mutant(
        "dp/dv of instances left in the space of their mesh",
        "shapes/charts.py",
        (
            (
                "where(instanced, along_rows(tables.data, k, across), across)",
                "where(instanced, across, along_rows(tables.data, k, across))",
            ),
        ),
        "tests/shapes/test_surfaces.py::test_instances_look_like_copies",
    ),
    Mutant(
        "threads together give the right part a box of other bins",
        "accel/top.py",
        (("first + per_axis - 1)", "first + per_axis + 1)"),),
        "tests/accel/test_build.py::test_the_tree_does_not_depend_on_who_divides_the_first_levels",
    ),
)
