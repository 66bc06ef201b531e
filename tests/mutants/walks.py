"""Bugs of walks that look for caustics: their steps, their ends, where they begin."""

from tests.mutants.mutant import Mutant

TESTS = "tests/estimators/test_walks_to_lamps.py"
SLOPES = f"{TESTS}::test_walks_end_at_the_ray_through_water_with_the_slopes_that_it_has"
BODY = "tests/estimators/test_where_caustics_are_sought.py::test_no_chain_begins_inside_of_a_body"

WALKS = (
    Mutant(
        "a step of Gauss and Newton that forgets how its derivatives lean",
        "integrators/caustics/manifold_walk.py",
        (("(c * x - b * y), scale * (a * y - b * x)", "(c * x + b * y), scale * (a * y + b * x)"),),
        f"{TESTS}::test_a_step_leads_to_where_a_linear_map_is_nought[0.01]",
    ),
    Mutant(
        "derivatives over five times the width of the lamp",
        "integrators/caustics/manifold_search.py",
        (
            (
                "size = 0.5 * radius_at(target, distance) / distance",
                "size = 5.0 * radius_at(target, distance) / distance",
            ),
        ),
        SLOPES,
    ),
    Mutant(
        "seeds about a lamp that stay outside of it",
        "integrators/caustics/manifold_search.py",
        (("maximum(0.5 * size * size, LEAST_TURN)", "maximum(size, LEAST_TURN)"),),
        f"{TESTS}::test_seeds_go_from_the_edge_of_the_lamp_to_the_other_side_of_the_world[0.5]",
    ),
    Mutant(
        "directions of a narrow solution that are never refused",
        "integrators/caustics/manifold_sampling.py",
        (("accept * drawn < minimum(drawn, most)", "accept * drawn < drawn"),),
        f"{TESTS}::test_what_is_drawn_and_refused_adds_up_to_the_solid_angle",
    ),
    Mutant(
        "chains that begin inside of a body",
        "integrators/caustics/specular_chain.py",
        (("(surface.light == 0) & outside)", "(surface.light == 0))"),),
        BODY,
    ),
)
