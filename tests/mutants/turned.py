"""Bugs of what is turned, mirrored or moved."""

from tests.mutants.mutant import Mutant

BRUSHED = "tests/sampling/test_turned_materials.py"
AT_REST = "tests/motion/test_as_at_rest.py"
BOUNDS = "tests/shapes/test_bounds.py"
MAPS = "tests/physics/test_maps_on_charts.py"
TANGENTS = "tests/shapes/test_tangents.py"

TURNED = (
    Mutant(
        "samples of brushed facets turned the wrong way back",
        "bsdfs/disney/view.py",
        (
            (
                "turn.cosine * w.x - turn.sine * w.y, turn.cosine * w.y + turn.sine * w.x",
                "turn.cosine * w.x + turn.sine * w.y, turn.cosine * w.y - turn.sine * w.x",
            ),
        ),
        f"{BRUSHED}::test_samples_turn_with_the_brush[0.5-metal]",
    ),
    Mutant(
        "brushed the other way round",
        "bsdfs/disney/parameters.py",
        (("Turn(s, c, a)", "Turn(-s, c, a)"),),
        f"{BRUSHED}::test_values_turn_with_the_brush[0.5-metal]",
    ),
    Mutant(
        "roughness along the tangent for that across it",
        "bsdfs/microfacets/facets.py",
        (
            (
                "            return self.alpha_u, self.alpha_v",
                "            return self.alpha_u, self.alpha_u",
            ),
        ),
        f"{BRUSHED}::test_roughness_along_and_across_change_places_by_a_right_angle",
    ),
    Mutant(
        "density of a moving light asked with the world's direction",
        "lights/moving.py",
        (("direction_at_rest(w, hit.wi)", "hit.wi"),),
        f"{AT_REST}::test_lights_and_their_densities_are_those_of_what_rests_there[power]",
    ),
    Mutant(
        "shading normals moved as if they were directions",
        "shapes/surfaces.py",
        (("normalize(turned(w, surface.ns))", "normalize(turned(m, surface.ns))"),),
        f"{AT_REST}::test_surfaces_are_those_of_what_rests_there",
    ),
    Mutant(
        "tangents moved without what the shading normal took of them",
        "shapes/surfaces.py",
        (
            (
                "frame_from_tangent(ns, turned(m, tangent))",
                "frame_from_tangent(ns, turned(m, surface.s))",
            ),
        ),
        f"{AT_REST}::test_surfaces_are_those_of_what_rests_there",
    ),
    Mutant(
        "box of a disk by its axes alone",
        "shapes/disk.py",
        (
            (
                "np.hypot(row[16:19], row[20:23])",
                "np.maximum(np.abs(row[16:19]), np.abs(row[20:23]))",
            ),
        ),
        f"{BOUNDS}::test_the_box_is_that_of_the_points_farthest_out",
    ),
    Mutant(
        "box of a cylinder without the other end",
        "shapes/cylinder.py",
        (("high = c + np.maximum(axis, 0.0) + half", "high = c + half"),),
        f"{BOUNDS}::test_the_box_is_that_of_the_points_farthest_out",
    ),
    Mutant(
        "tangents against u on mirrored charts",
        "shapes/mesh.py",
        (("        turned = where(determinant < 0.0, -turned, turned)\n", ""),),
        f"{TANGENTS}::test_the_tangent_is_the_way_that_u_grows",
    ),
    Mutant(
        "second axis of a normal map by the right hand on mirrored charts too",
        "bsdfs/normals/shading_normals.py",
        (("where(turned & follows, -y, y)", "where(turned & ~turned, -y, y)"),),
        f"{MAPS}::test_the_normal_leans_along_u_and_v",
    ),
    Mutant(
        "mirrored pictures of normals taken for turned ones",
        "bsdfs/normals/shading_normals.py",
        (("above = turn.z * (turn.x", "above = 1.0 * (turn.x"),),
        f"{MAPS}::test_the_normal_leans_along_the_sides_of_a_turned_picture",
    ),
    Mutant(
        "normals turned the same way as their picture's coordinates",
        "bsdfs/normals/tangent_space.py",
        (("-side * c / length", "side * c / length"),),
        f"{MAPS}::test_the_normal_leans_along_the_sides_of_a_turned_picture",
    ),
    Mutant(
        "no coordinates for the axes of a map of one colour",
        "shapes/hit.py",
        (("bends = BENT in program.bsdfs or ", "bends = "),),
        f"{MAPS}::test_the_normal_leans_along_u_and_v",
    ),
    Mutant(
        "axes of pictures stay where they were while their surface moves",
        "shapes/derivatives.py",
        (
            (
                "along = where(moving, turned(m, along), along)",
                "along = where(moving, along, along)",
            ),
        ),
        f"{AT_REST}::test_surfaces_are_those_of_what_rests_there",
    ),
    Mutant(
        "spots shine along the rows of their node's matrix",
        "lights/spot.py",
        (("axis = to_world[:3, 2] /", "axis = to_world[2, :3] /"),),
        "tests/rendering/test_turned_worlds.py::test_lights_turn_with_the_world[spot-0]",
    ),
    Mutant(
        "light lost in glass given back where a coat is in the scene",
        "bsdfs/disney/view.py",
        (
            (
                "    if GLASS not in program.bsdfs:\n        return _no_glass",
                "    if COAT not in program.bsdfs:\n        return _no_glass",
            ),
        ),
        "tests/rendering/test_unseen_neighbours.py"
        "::test_what_nobody_sees_changes_no_sample[principled-2]",
    ),
)
