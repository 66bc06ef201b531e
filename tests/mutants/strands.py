"""Bugs of curves and hair."""

from tests.mutants.mutant import Mutant

TREE, HAIR = "tests/accel/test_curves.py", "tests/physics/test_hair.py"
FRUSTA = f"{TREE}::test_hits_are_those_of_fine_frusta"
VALUES = f"{HAIR}::test_values_are_mitsubas"

STRANDS = (
    Mutant(
        "a tube is entered where it is left",
        "shapes/tube.py",
        (("root = sqrt(maximum(discriminant, 0.0))", "root = -sqrt(maximum(discriminant, 0.0))"),),
        FRUSTA,
    ),
    Mutant(
        "pieces that bend away from their chords are missed",
        "shapes/tube.py",
        (("reach = maximum(ra, rb) + tube.slack", "reach = 0.9 * maximum(ra, rb)"),),
        FRUSTA,
    ),
    Mutant(
        "hits in tubes that taper and bend lie where a cone cuts them",
        "shapes/tube.py",
        (("cuts = absolute(dr * turned * inverse)", "cuts = 0.0 * inverse"),),
        f"{TREE}::test_rays_that_go_straight_on_leave_strands_that_fold",
    ),
    Mutant(
        "whole balls at the joints of straight lines",
        "shapes/tube.py",
        (("(squared >= 0.0) & past & not_yet &", "(squared >= 0.0) &"),),
        f"{TREE}::test_joints_of_straight_lines_are_met_where_tubes_leave_a_gap",
    ),
    Mutant(
        "varying widths of OpenUSD go round by no point",
        "formats/usd/curves.py",
        (("closed = np.append(radii, radii[0])", "closed = np.append(radii[1:], radii[:2])"),),
        "tests/formats/usd/test_curves.py::test_varying_widths_are_those_at_the_ends_of_segments",
    ),
    Mutant(
        "a slender segment begins where its first half ends",
        "shapes/strands.py",
        (("first[left + 1] += span[left + 1]", "first[left] += span[left + 1]"),),
        "tests/shapes/test_curves.py::test_slender_segments_are_divided_and_stay_where_they_are",
    ),
    Mutant(
        "widths of OpenUSD for radii",
        "formats/usd/curves.py",
        (("radii = 0.5 * np.maximum(", "radii = 1.0 * np.maximum("),),
        "tests/formats/usd/test_curves.py::test_widths_belong_to_curves_segments_or_points",
    ),
    Mutant(
        "scales of hair that point to the tip",
        "bsdfs/fibres/hair.py",
        (("s1, c1 = params.sine, params.cosine", "s1, c1 = -params.sine, params.cosine"),),
        VALUES,
    ),
    Mutant(
        "hair that is met on the other side of its axis",
        "bsdfs/fibres/hair.py",
        (("maximum(-wo.y / cosine, -1.0)", "maximum(wo.y / cosine, -1.0)"),),
        f"{HAIR}::test_light_is_mirrored_at_the_surface_where_it_is_met",
    ),
    Mutant(
        "hair whose light comes back without having passed twice",
        "bsdfs/fibres/hair.py",
        (("a2 = a1 * passes * f\n", "a2 = a1 * f\n"),),
        VALUES,
    ),
)
