"""Bugs of the maps by which points of textured lamps are chosen."""

from tests.mutants.mutant import Mutant

MAPS = "tests/lights/test_area_maps.py"
RAYS = "tests/lights/test_rays_of_textured_lamps.py"

LAMP_MAPS = (
    Mutant(
        "densities on textured lamps without the share of the map",
        "lights/area_map.py",
        (("(1.0 - share) * by_shape + share * by_map", "by_shape + share * by_map"),),
        f"{MAPS}::test_samples_have_the_density_of_hits_and_bring_the_same_light"
        "[nearest-near-rectangle]",
    ),
    Mutant(
        "maps of lamps with one more column",
        "lights/area_map.py",
        (
            (
                "maximum(x * to_float(columns), 0.0)), columns - 1)",
                "maximum(x * to_float(columns), 0.0)), columns)",
            ),
        ),
        f"{MAPS}::test_the_last_cell_holds_the_edge_of_the_square",
    ),
    Mutant(
        "maps of lamps transposed",
        "lights/area_map.py",
        (
            (
                "minimum(x, ONE_MINUS_EPSILON), minimum(y, ONE_MINUS_EPSILON)",
                "minimum(y, ONE_MINUS_EPSILON), minimum(x, ONE_MINUS_EPSILON)",
            ),
        ),
        f"{MAPS}::test_bright_texels_are_drawn_by_their_light[rectangle]",
    ),
    Mutant(
        "maps of lamps whatever they gain",
        "compiled/area_maps.py",
        (("< LEAST_GAIN * weights.sum() ** 2", "<= weights.sum() ** 2"),),
        f"{MAPS}::test_a_map_gains_half_of_the_mean_square_or_there_is_none[5.0-False]",
    ),
    Mutant(
        "densities by the place that a sample has become",
        "lights/area_radiance.py",
        (
            (
                "where(by_map, numbers[0], x), where(by_map, numbers[1], y), per_area",
                "x, y, per_area",
            ),
        ),
        f"{MAPS}::test_points_are_weighed_in_the_cell_that_they_were_drawn_in",
    ),
    Mutant(
        "cells of a map without their areas",
        "compiled/area_maps.py",
        (
            (
                "np.where(found.density > 0.0, 1.0 / np.where(",
                "np.where(found.density > 0.0, 1.0 + 0.0 * np.where(",
            ),
        ),
        f"{RAYS}::test_cells_of_a_map_have_the_light_of_their_area",
    ),
    Mutant(
        "rectangles reach as far as the square of that",
        "compiled/area_maps.py",
        (
            (
                "np.max(np.sum((found.p - middle) ** 2, axis=1))",
                "np.sqrt(np.max(np.sum((found.p - middle) ** 2, axis=1)))",
            ),
        ),
        f"{MAPS}::test_far_rectangles_are_drawn_by_their_picture_and_near_ones_by_what_stands_out",
    ),
    Mutant(
        "all triangles by the map of the first",
        "lights/area_map.py",
        (("where(listed, start + prim, 0)", "where(listed, start, 0)"),),
        f"{RAYS}::test_rays_have_nearly_the_same_flux[mesh]",
    ),
    Mutant(
        "rays of textured lamps without the density of the map",
        "lights/emission/from_shapes.py",
        (("s.pdf * square_density(scene, at, x, y)", "s.pdf"),),
        f"{RAYS}::test_rays_bring_what_light_sampling_finds[nearest-disk]",
    ),
    Mutant(
        "triangles of textured lamps by their areas",
        "compiled/light_tree.py",
        (
            (
                "cumulative(self.areas if self.spread is None else self.strengths)",
                "cumulative(self.areas)",
            ),
        ),
        f"{MAPS}::test_triangles_are_chosen_by_their_light",
    ),
    Mutant(
        "light paths of pilots that start anywhere on a textured lamp",
        "compiled/lights.py",
        (('emits="if possible", textures=textures)', 'emits="if possible")'),),
        "tests/known_error/test_light_off_mirrors.py"
        "::test_a_mirror_shows_a_texel_as_it_shows_a_lamp_of_its_size",
    ),
    Mutant(
        "light paths that start anywhere on a textured lamp",
        "lights/emission/from_shapes.py",
        (("mapped = MAPPED in program.lights", "mapped = False"),),
        "tests/known_error/test_light_off_surfaces.py"
        "::test_a_texel_throws_as_much_as_a_lamp_of_its_size",
    ),
)
