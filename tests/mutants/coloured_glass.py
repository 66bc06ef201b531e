"""Bugs of bodies that absorb: which body a segment lies in, and who forgets to ask."""

from tests.mutants.mutant import Mutant

TESTS = "tests/estimators/test_absorption.py"

NESTED = "tests/estimators/test_nested_bodies.py"

COLOURED_GLASS = (
    Mutant(
        "volumetric paths come through coloured glass undimmed",
        "integrators/volpath.py",
        (("come_to(scene, path, surface, t, shining, met | scattered)", "path"),),
        f"{TESTS}::test_haze_elsewhere_leaves_glass_as_it_is",
    ),
    Mutant(
        "volumetric shadow rays come through coloured glass undimmed",
        "integrators/volpath.py",
        (("dimmed(light.radiance, left)", "light.radiance"),),
        f"{TESTS}::test_light_between_two_things_inside_is_dimmed[volpath]",
    ),
    Mutant(
        "paths forget which body they have entered",
        "integrators/path.py",
        (("bodies_beyond(scene, path.bodies, surface, path.d, d)", "path.bodies"),),
        f"{TESTS}::test_a_lamp_inside_is_dimmed_on_its_way_out[path]",
    ),
    Mutant(
        "shadow rays within coloured glass are not dimmed",
        "integrators/direct_light.py",
        (("dimmed(light.radiance, left)", "light.radiance"),),
        f"{TESTS}::test_light_between_two_things_inside_is_dimmed[path]",
    ),
    Mutant(
        "shadow rays through holes are not dimmed by bodies",
        "integrators/interiors/enclosing.py",
        (("left * _left_along(bodies, t, going)", "left * 1.0"),),
        f"{TESTS}::test_shadow_rays_through_holes_are_dimmed_inside",
    ),
    Mutant(
        "behind a hole the body goes on",
        "integrators/interiors/enclosing.py",
        (("entered, within, where(left, around, bodies)", "entered, within, bodies"),),
        f"{TESTS}::test_holes_lead_into_bodies_and_out_of_them[path-0.4]",
    ),
    Mutant(
        "whoever leaves a bubble is in empty space",
        "integrators/interiors/enclosing.py",
        (("Bodies(bodies.middle, bodies.outer", "Bodies(lanes_vec3(0.0), bodies.outer"),),
        f"{TESTS}::test_each_of_nested_bodies_dims_its_part_of_the_way",
    ),
    Mutant(
        "paths begin in empty space, even inside of a body",
        "integrators/interiors/enclosing.py",
        (("around = bounds & inner & (entered == 0)", "around = bounds & inner & (entered > 0)"),),
        f"{TESTS}::test_a_camera_inside_sees_through_the_body[lamp-0.8]",
    ),
    Mutant(
        "where paths begin, the outer of two bodies counts",
        "integrators/interiors/enclosing.py",
        (
            ("inner=where(around & (found == 0), body", "inner=where(around & (found == 1), body"),
            ("middle=where(around & (found == 1)", "middle=where(around & (found == 0)"),
        ),
        f"{TESTS}::test_a_camera_inside_sees_through_the_body[lamp-0.8]",
    ),
    Mutant(
        "masks of no opacity have no body",
        "bsdfs/interiors/bodies.py",
        (("1.0 if masked else factors[part.share]", "factors[part.share]"),),
        f"{TESTS}::test_holes_lead_into_bodies_and_out_of_them[path-0.0]",
    ),
    Mutant(
        "blends absorb less for every part that is no body",
        "bsdfs/interiors/bodies.py",
        (
            (
                "share * body[i] for share, body in found) / whole",
                "share * body[i] for share, body in found)",
            ),
        ),
        f"{TESTS}::test_blends_absorb_as_their_bodies_do_by_their_shares",
    ),
    Mutant(
        "the outermost of three bodies is never left",
        "integrators/interiors/enclosing.py",
        (
            (
                "Bodies(bodies.middle, bodies.outer, lanes_vec3(0.0))",
                "Bodies(bodies.middle, bodies.outer, bodies.outer)",
            ),
        ),
        f"{NESTED}::test_each_body_dims_its_part_of_the_way[0]",
    ),
    Mutant(
        "the second body around a camera is taken for the first",
        "integrators/interiors/enclosing.py",
        (
            (
                "around & (found == 1), body, bodies.middle",
                "around & (found == 0), body, bodies.middle",
            ),
        ),
        f"{NESTED}::test_each_body_dims_its_part_of_the_way[1]",
    ),
    Mutant(
        "bodies beside the camera are around it",
        "integrators/interiors/enclosing.py",
        (("around = bounds & inner & (entered == 0)", "around = bounds & inner"),),
        f"{NESTED}::test_each_body_dims_its_part_of_the_way[1]",
    ),
    Mutant(
        "a box around bodies that is as high as wide",
        "integrators/interiors/enclosing.py",
        (("(p.z <= box[5])", "(p.z <= box[4])"),),
        f"{NESTED}::test_each_body_dims_its_part_of_the_way[1]",
    ),
    Mutant(
        "the inner side of a boundary tells nothing",
        "integrators/interiors/enclosing.py",
        (
            (
                "_at_arrival(scene, path.bodies, surface, path.d, met)\n    beta",
                "path.bodies\n    beta",
            ),
        ),
        f"{NESTED}::test_what_paths_forget_of_many_bodies_their_boundaries_tell[path]",
    ),
    Mutant(
        "the box around the last body alone",
        "compiled/bodies.py",
        (("np.minimum(low, around[0]), np.maximum(high, around[1])", "around[0], around[1]"),),
        f"{NESTED}::test_each_body_dims_its_part_of_the_way[1]",
    ),
    Mutant(
        "the box around a moving body as it rests",
        "compiled/bodies.py",
        (("None if placed.motion else box_of(flat, placed)", "box_of(flat, placed)"),),
        f"{NESTED}::test_a_camera_in_a_body_that_moves_is_in_it_wherever_it_has_moved",
    ),
    Mutant(
        "parts of a blend that varies count in full",
        "bsdfs/interiors/bodies.py",
        (("isinstance(weight, float) else VARYING_SHARE", "isinstance(weight, float) else 1.0"),),
        f"{NESTED}::test_blends_in_blends_absorb_by_their_shares[0]",
    ),
)
