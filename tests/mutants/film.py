"""Bugs of samples, films and statistics."""

from tests.mutants.mutant import Mutant

TWIN = "tests/rendering/test_in_the_twin.py"
BITS = "tests/determinism/test_same_bits.py"

FILM = (
    Mutant(
        "sums in float32",
        "rendering/tiles/tile_kernel.py",
        (
            ("    as_int,\n", "    as_int,\n    as_float,\n"),
            (
                "+= as_int(limbs[i * LANES + lane])",
                "= as_int(as_float(film.sums[at * 6 + i]) + limbs[i * LANES + lane])",
            ),
        ),
        f"{BITS}::test_two_halves_are_the_whole",
    ),
    Mutant(
        "replicate and index of a sample swapped",
        "rendering/tiles/tile_kernel.py",
        (("first // replicates, first % replicates", "first % replicates, first // replicates"),),
        f"{TWIN}::test_every_sample_of_a_tile_is_visited_once_with_its_index_and_replicate",
    ),
    Mutant(
        "cells taken to be alike where their goals are",
        "rendering/schedules/passes.py",
        (("            if cells.count(cells[0]) == len(cells):\n", "            if True:\n"),),
        "tests/rendering/test_passes.py"
        "::test_the_gaps_of_cells_whether_or_not_they_are_alike[False]",
    ),
    Mutant(
        "cells taken to hold alike where tiles add alike",
        "films/sample_ranges.py",
        (("for cells in (ours, theirs)", "for cells in (theirs,)"),),
        "tests/film/test_sample_ranges.py::test_cells_are_united_whether_or_not_they_are_alike",
    ),
    Mutant(
        "the same scramble for all replicates",
        "samplers/state.py",
        (("pixel_keys(x, y, scramble, seed)", "pixel_keys(x, y, 0, seed)"),),
        "tests/samplers/test_samplers.py::test_neighbours_are_not_correlated",
    ),
    Mutant(
        "random numbers reach 1",
        "core/rng.py",
        (("return to_float(word >> 8) * TO_UNIT", "return to_float(word >> 1) * (2.0**-31)"),),
        "tests/samplers/test_rng.py::test_unit_float_stays_below_one",
    ),
    Mutant(
        "weight of the pixel filter forgotten",
        "integrators/walk.py",
        (("lanes_vec3(1.0) * weight", "lanes_vec3(1.0)"),),
        f"{TWIN}::test_an_edge_rings_as_the_mitchell_filter_says",
    ),
    Mutant(
        "camera rays by the pixel's place in the tile",
        "rendering/tiles/tile_kernel.py",
        (("to_float(x) + 0.5 + dx", "to_float(x - tile.x0) + 0.5 + dx"),),
        f"{BITS}::test_crop_equals_the_cut_out",
    ),
    Mutant(
        "random numbers that depend on the tile",
        "rendering/tiles/tile_kernel.py",
        (
            (
                "3 * LANES), lanes_u32(settings.seed)",
                "3 * LANES), lanes_u32(settings.seed + tile.x0)",
            ),
        ),
        f"{BITS}::test_tile_order_and_size",
    ),
    Mutant(
        "standard error without R / (R - 1)",
        "films/statistics.py",
        (("np.maximum(whole - own, 1.0)", "whole"),),
        "tests/film/test_film.py::test_standard_error_is_the_formula_of_the_replicates",
    ),
    Mutant(
        "standard error of unequal replicates as of equal ones",
        "films/statistics.py",
        (("(whole / np.maximum(whole - own, 1.0))", "(replicates / (replicates - 1))"),),
        "tests/film/test_laws_of_errors.py::"
        "test_squared_errors_of_unequal_replicates_are_unbiased_for_independent_samples",
    ),
    Mutant(
        "many tests, each at the level of one",
        "metrics/statistics.py",
        (("level / (len(p_values) - rank)", "level"),),
        "tests/metrics/test_statistics.py::test_holm_steps_down",
    ),
    Mutant(
        "a fourth channel among the errors of the picture",
        "films/readout.py",
        (("(s, n)[1][..., :3]", "(s, n)[1][..., :4]"),),
        "tests/film/test_laws_of_errors.py"
        "::test_a_fourth_channel_changes_nothing_of_the_picture_and_its_error",
    ),
    Mutant(
        "a base of Halton's points that is no prime",
        "samplers/halton.py",
        (("109, 113, 127", "109, 115, 127"),),
        "tests/core/test_tables_of_constants.py::test_the_bases_of_halton_are_the_first_primes",
    ),
    Mutant(
        "layers that choose at glass with other random numbers than the picture",
        "integrators/aov.py",
        (
            (
                "-path.d)\n            dimension = vertex_dimension(path.depth + 1)",
                "-path.d)\n            dimension = vertex_dimension(path.depth + 2)",
            ),
        ),
        "tests/rendering/test_aovs.py"
        "::test_the_layers_take_the_way_of_the_picture_sample_by_sample",
    ),
)
