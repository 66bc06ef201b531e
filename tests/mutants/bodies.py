"""Bugs of light that is scattered inside bodies."""

from tests.mutants.mutant import Mutant

TESTS = "tests/estimators/test_subsurface.py"
HALF_SPACE = f"{TESTS}::test_a_half_space_has_the_colour_that_is_asked_for[path]"
MEDIUM = f"{TESTS}::test_walks_agree_with_a_medium_between_matte_surfaces[slab]"

OPEN = "tests/estimators/test_open_bodies.py"
TOLD = (
    "tests/scene/test_warnings_of_bodies.py"
    "::test_bodies_without_an_end_are_told_unless_something_may_close_them"
)

BODIES = (
    Mutant(
        "light that enters one primitive of a mesh and leaves by a matte one",
        "formats/gltf/bodies.py",
        (("len(shapes) > 1 and all_bodies and has_inside", "len(shapes) > 1 and has_inside"),),
        "tests/formats/gltf/test_bodies.py::test_primitives_close_a_mesh_together[False-0-False]",
    ),
    Mutant(
        "primitives that are asked one by one whether they are closed",
        "formats/gltf/bodies.py",
        (("(together or has_inside(shape))", "has_inside(shape)"),),
        "tests/formats/gltf/test_bodies.py::test_primitives_close_a_mesh_together[True-0-True]",
    ),
    Mutant(
        "rounding makes a card a body",
        "meshes/volume.py",
        (("FLAT = 1e-8", "FLAT = 0.0"),),
        "tests/meshes/test_volume.py"
        "::test_a_card_with_two_faces_encloses_nothing_however_it_is_turned",
    ),
    Mutant(
        "walks that come back from afar as seldom as straight rays",
        "integrators/interiors/endless.py",
        (
            (
                "ball[3] / maximum(sqrt(dot(away, away)), 1e-30)",
                "ball[3] * ball[3] / maximum(dot(away, away), 1e-30)",
            ),
        ),
        f"{OPEN}::test_the_chance_to_come_back_is_harmonic_outside_of_all_shapes",
    ),
    Mutant(
        "walks that leave an open body for good",
        "integrators/interiors/body_walk.py",
        (("    worth = worth * chance_of_return(scene, path.o + distance * path.d)\n", ""),),
        f"{OPEN}::test_walks_that_survive_outside_stand_for_those_that_do_not[60.0]",
    ),
    Mutant(
        "open shapes that close themselves",
        "compiled/warnings/edges.py",
        (("others = (owner != number)", "others = (owner >= 0)"),),
        f"{TOLD}[cylinder-transform0-others0-True]",
    ),
    Mutant(
        "walks weighted as if all of them were led back",
        "integrators/interiors/body_walk.py",
        (("LED * led + (1.0 - LED) * _exponentials(plain)", "led"),),
        HALF_SPACE,
    ),
    Mutant(
        "walks that scatter without their channel's extinction",
        "integrators/interiors/body_walk.py",
        (("plain = n * body.rarity - walk.length * thinner", "plain = -walk.length * thinner"),),
        MEDIUM,
    ),
    Mutant(
        "walks that absorb once too often",
        "integrators/interiors/body_walk.py",
        (("plain + n * body.albedo", "plain + (n + 1.0) * body.albedo"),),
        HALF_SPACE,
    ),
    Mutant(
        "walks that begin below the surface and end at it",
        "integrators/interiors/body_walk.py",
        (("maximum(hit.t - margin, 0.0)", "hit.t"),),
        f"{TESTS}::test_the_smallest_radii_leave_the_colour_as_it_is",
    ),
    Mutant(
        "led walks whose last direction had the density of the others",
        "integrators/interiors/body_walk.py",
        (("(body.nu.z - walk.first) / (body.nu.z - z)", "body.nu.z / (body.nu.z - z)"),),
        HALF_SPACE,
    ),
    Mutant(
        "channels that are all followed alike, and weighted as if they were not",
        "integrators/interiors/body_walk.py",
        (("below, above = share.x, share.x + share.y", "below, above = 0.333, 0.667"),),
        MEDIUM,
    ),
    Mutant(
        "the last walk of a tile is forgotten",
        "rendering/tiles/tile_loop.py",
        (("elif inside > 0:", "elif inside > 1:"),),
        "tests/rendering/test_in_the_twin.py::test_no_sample_is_left_in_a_body[1]",
    ),
    Mutant(
        "walks that wait, and whose paths go on outside",
        "rendering/tiles/tile_loop.py",
        (("~walk.going)\n        film", "True)\n        film"),),
        "tests/rendering/test_in_the_twin.py::test_no_sample_is_left_in_a_body[1]",
    ),
    Mutant(
        "shadow rays that go straight through bodies",
        "integrators/direct_light.py",
        (("lit = lit & ~enters_body(scene, surface, light.wi)", "lit = lit & True"),),
        HALF_SPACE,
    ),
    Mutant(
        "lamps chosen for the inner side of bodies",
        "integrators/interiors/body_walk.py",
        (("n = where(is_body(scene, surface.bsdf), surface.ns, n)", "pass"),),
        f"{TESTS}::test_lamps_that_shine_from_below_a_body_are_not_sampled_where_light_leaves",
    ),
    Mutant(
        "walks that end after some scatterings, come what may",
        "integrators/interiors/body_walk.py",
        (
            (
                "longer = survival * (1.0 - LONG_POWER / maximum(to_float(walk.step), 2.0))",
                "longer = 0.0",
            ),
        ),
        f"{TESTS}::test_long_walks_through_a_white_half_space_come_back",
    ),
    Mutant(
        "coat that dims light on the way out without end",
        "bsdfs/interiors/subsurface.py",
        (('packer.numbers("leaving", 1.0 / mean)', 'packer.numbers("leaving", 1.0)'),),
        f"{TESTS}::test_a_white_body_vanishes_in_a_white_furnace[1.5]",
    ),
    Mutant(
        "albedo of one scattering by the root of what is absorbed",
        "bsdfs/interiors/subsurface.py",
        (("1.0 - s * s", "1.0 - s"),),
        f"{TESTS}::test_the_inverse_of_the_albedo_is_that_of_the_exact_one[0.5]",
    ),
    Mutant(
        "fog inside bodies",
        "scene/flatten.py",
        ((" and not around", ""),),
        f"{TESTS}::test_fog_around_a_body_does_not_fill_it",
    ),
)
