"""Bugs of lights."""

from tests.mutants.mutant import Mutant

LIGHTS = "tests/lights/test_light_sampling.py"
MAPS = "tests/lights/test_environment.py"
STRATEGIES = "tests/lights/test_environment_strategies.py"
LAMPS = "tests/lights/test_spot_and_textured.py"
TREE = "tests/lights/test_light_tree.py"
SOLID_ANGLES = "tests/lights/test_solid_angles.py"
DAYLIGHT = "tests/lights/test_daylight.py"
POWER = (
    "tests/formats/usd/test_light_power.py"
    "::test_the_power_is_pi_times_the_intensity_or_times_the_area"
)

LIGHT = (
    Mutant(
        "a rectangle lights its own back",
        "shapes/rectangle.py",
        (("seen.by_area | (seen.z0 <= error)", "seen.by_area"),),
        "tests/lights/test_solid_angles.py::test_no_light_reaches_a_flat_lamp_from_itself"
        "[turned-shape0]",
    ),
    Mutant(
        "densities of lamps at rest by the motion of the second",
        "lights/moving.py",
        (
            (
                (
                    "where(moving, number - 1, 0), scene.time))\n"
                    "            p = where(moving, point_at_rest(w, p), p)\n"
                    "            hit ="
                ),
                (
                    "where(moving, number - 1, 1), scene.time))\n"
                    "            p = where(moving, point_at_rest(w, p), p)\n"
                    "            hit ="
                ),
            ),
        ),
        "tests/motion/test_kernels.py::test_lamps_at_rest_read_the_motion_of_none_that_is_not_there",
    ),
    Mutant(
        "samples of lamps at rest by the motion of the second",
        "lights/moving.py",
        (
            (
                (
                    "where(moving, number - 1, 0), scene.time))\n"
                    "            p = where(moving, point_at_rest(w, p), p)\n"
                    "        s ="
                ),
                (
                    "where(moving, number - 1, 1), scene.time))\n"
                    "            p = where(moving, point_at_rest(w, p), p)\n"
                    "        s ="
                ),
            ),
        ),
        "tests/motion/test_kernels.py::test_lamps_at_rest_read_the_motion_of_none_that_is_not_there",
    ),
    Mutant(
        "density per area for one per solid angle",
        "shapes/hit.py",
        (
            (
                "pdf_area * distance * distance / where(edge_on, 1.0, absolute(cosine))",
                "pdf_area + 0.0 * distance",
            ),
        ),
        f"{SOLID_ANGLES}::test_solid_angle_of_a_disk_on_its_axis",
    ),
    Mutant(
        "probability of the light's choice forgotten",
        "lights/sampling.py",
        (("pdf = s.pdf * choice.mis_pmf", "pdf = s.pdf"),),
        f"{LIGHTS}::test_lights_are_chosen_as_asked",
    ),
    Mutant(
        "density of the environment forgotten",
        "lights/misses.py",
        (
            (
                "return density(scene, back, p, d) * scene.lights.data[row_of(scene, back) + 3]",
                "return lanes(0.0)",
            ),
        ),
        f"{LIGHTS}::test_constant_environment",
    ),
    Mutant(
        "light's choice forgotten where a ray finds the environment",
        "lights/misses.py",
        (
            (
                "return density(scene, back, p, d) * scene.lights.data[row_of(scene, back) + 3]",
                "return density(scene, back, p, d)",
            ),
        ),
        f"{LIGHTS}::test_lights_are_chosen_as_asked",
    ),
    Mutant(
        "light's choice forgotten where a ray finds a lamp",
        "lights/choice.py",
        (("return gather(scene.lights.data, index * STRIDE + 3)", "return lanes(1.0)"),),
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
        "integrators/options.py",
        (('self.light_sampling == "mis"', 'self.light_sampling != "bsdf"'),),
        f"{STRATEGIES}::test_only_combined_sampling_is_compensated",
    ),
    Mutant(
        "textured lamp whose samples show another point",
        "lights/area_radiance.py",
        (
            (
                "x, y, prim = where(mine, x1, x), where(mine, y1, y)",
                "x, y, prim = where(mine, y1, x), where(mine, x1, y)",
            ),
        ),
        f"{LAMPS}::test_samples_show_the_texture_of_the_point_that_they_hit",
    ),
    Mutant(
        "light from both sides of a lamp",
        "lights/hits.py",
        (("(surface.light > 0) & (dot(wo, surface.ng) > 0.0)", "surface.light > 0"),),
        f"{LIGHTS}::test_area_lights_shine_on_their_outer_side_only",
    ),
    Mutant(
        "point light that does not fall with the square of the distance",
        "lights/at_point.py",
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
    Mutant(
        "light tree whose choice is not divided by its probability",
        "lights/sampling.py",
        (
            (
                "radiance * (choice.mis_pmf / where(valid, choice.pmf, 1.0))",
                "radiance * (choice.mis_pmf / choice.mis_pmf)",
            ),
        ),
        f"{TREE}::test_tree_and_power_agree_on_the_light",
    ),
    Mutant(
        "light tree's choice forgotten where a ray finds a lamp",
        "lights/hits.py",
        (("density * chosen_probability(scene, index, prim, p, shines)", "density"),),
        f"{TREE}::test_rays_find_the_density_that_light_sampling_says",
    ),
    Mutant(
        "light tree that knows only the first primitive of a strand",
        "compiled/light_tree.py",
        (("        ways[:strands] = ways[0]\n", ""),),
        f"{TREE}::test_strands_that_shine_are_one_leaf_whichever_part_of_them_is_met",
    ),
    Mutant(
        "light tree that takes a group's lights to be in its middle",
        "lights/tree/bounds.py",
        (("    towards += group.behind * inverse\n", ""),),
        f"{TREE}::test_a_group_is_not_dark_where_one_of_it_shines",
    ),
    Mutant(
        "light tree that forgets the rest of its number where the first lights are dark",
        "lights/tree/traversal.py",
        (("u = where(walking & (share > 0.0), rest, u)", "u = where(walking, rest, u)"),),
        f"{TREE}::test_choice_where_groups_are_dark",
    ),
    Mutant(
        "light tree that knows where a turning lamp faces at the start only",
        "compiled/light_tree.py",
        (("normal, spread = row.motion.turned(normal)", "spread = np.zeros(n)"),),
        "tests/motion/test_light_tree.py::test_leaves_bound_their_lights_at_every_time",
    ),
    Mutant(
        "far lights whose densities forget their group",
        "lights/tree/traversal.py",
        (("mis_pmf * (to_float(mine) / to_float(size))", "to_float(mine) / to_float(size)"),),
        f"{TREE}::test_rays_find_the_density_that_light_sampling_says",
    ),
    Mutant(
        "environments whose samples bring the light of one only",
        "lights/sampling.py",
        (("where(around, environment_radiance(scene, wi), radiance)", "radiance"),),
        "tests/lights/test_several_environments.py::test_samples_bring_the_light_of_all",
    ),
    Mutant(
        "portal that is forgotten where a ray leaves",
        "lights/portal.py",
        (("where(ahead & inside, density, 0.0)", "where(ahead & inside, 0.0, 0.0)"),),
        "tests/lights/test_portals.py::test_samples_bring_the_light_of_the_surroundings",
    ),
    Mutant(
        "sun whose samples do not know those of the sky",
        "lights/sunsky.py",
        (("(1.0 - share) * pdf_of_sky(scene, back, p, d)", "pdf_of_sky(scene, back, p, d)"),),
        f"{DAYLIGHT}::test_light_sampling_finds_all_the_light",
    ),
    Mutant(
        "photometric file without the factor of its ballast",
        "lights/photometry.py",
        (("first[2] * rest[4] * rest[5]", "first[2] * rest[5]"),),
        "tests/lights/test_profiles.py::test_a_file_is_read_with_its_factors",
    ),
    Mutant(
        "radiance of the sun by the square of its diameter",
        "lights/sun.py",
        (("solid_angle(DIAMETER) / solid_angle(diameter)", "(DIAMETER / diameter) ** 2"),),
        "tests/lights/test_sun_of_any_size.py"
        "::test_the_light_of_the_sun_does_not_depend_on_its_size[Sun-20.0]",
    ),
    Mutant(
        "power of a sphere of OpenUSD normalised by its area before it is placed",
        "formats/usd/lights.py",
        (("area_of_ball(world, max(", "area_of_ball(np.eye(4), max("),),
        f"{POWER}[sphere-larger-1]",
    ),
    Mutant(
        "area of a slanted rectangle by the lengths of its edges",
        "formats/scenes/lamps.py",
        (
            (
                "np.linalg.norm(np.cross(to_world[:3, 0], to_world[:3, 1]))",
                "np.prod(np.linalg.norm(to_world[:3, :2], axis=0))",
            ),
        ),
        f"{POWER}[rectangle-slanted-1]",
    ),
)
