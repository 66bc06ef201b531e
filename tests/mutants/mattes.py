"""Bugs of Cryptomattes."""

from tests.mutants.mutant import Mutant

TESTS = "tests/rendering/test_cryptomatte.py"
TABLES = "tests/film/test_mattes.py"

MATTES = (
    Mutant(
        "ids that are no ordinary numbers",
        "outputs/cryptomatte.py",
        (("in (0, 255):", "in (255,):"),),
        f"{TESTS}::test_every_id_is_an_ordinary_number",
    ),
    Mutant(
        "the last bytes of a name read from the other end",
        "outputs/cryptomatte.py",
        (('data[whole:], "little"', 'data[whole:], "big"'),),
        f"{TESTS}::test_hashes_are_those_of_the_published_algorithm",
    ),
    Mutant(
        "weights by the number of the triangle",
        "integrators/coverage.py",
        (("store_lanes(rows, 0, hit.shape)", "store_lanes(rows, 0, hit.prim)"),),
        f"{TESTS}::test_a_matte_is_the_picture_of_that_object_alone_in_white",
    ),
    Mutant(
        "one surface a pixel",
        "films/coverage.py",
        ((" | (surfaces[1:] != surfaces[:-1])", ""),),
        f"{TESTS}::test_a_matte_is_the_picture_of_that_object_alone_in_white",
    ),
    Mutant(
        "what waits is forgotten when films merge",
        "films/merging.py",
        (("result.coverage.add(part.coverage.sums)", "pass"),),
        f"{TESTS}::test_parts_merge_to_the_bits_of_the_whole",
    ),
    Mutant(
        "names of what is merged not compared",
        "films/coverage.py",
        (("            if a != b:\n", "            if a == b + what:\n"),),
        f"{TESTS}::test_films_of_things_with_other_names_do_not_merge",
    ),
    Mutant(
        "pixels of a tile counted from the corner of the film",
        "films/tiles.py",
        (("(top + y) * film.crop[2] + left + x", "(top + y) * film.crop[2] + x"),),
        f"{TESTS}::test_tiles_add_up_to_the_bits_of_the_whole",
    ),
    Mutant(
        "the smallest coverages as the first ranks",
        "films/mattes.py",
        (("joined.surfaces, -share, joined.pixels", "joined.surfaces, share, joined.pixels"),),
        f"{TESTS}::test_more_objects_than_ranks_lose_the_least_in_the_file_alone",
    ),
    Mutant(
        "names that begin alike belong to one another",
        "films/mattes.py",
        (("one.startswith(name + _BELOW)", "one.startswith(name)"),),
        f"{TESTS}::test_a_name_stands_for_all_below_it",
    ),
    Mutant(
        "holes are not looked through",
        "integrators/coverage.py",
        (("passes = active & ((flags & NULL) != 0)", "passes = active & ((flags & NULL) == -1)"),),
        f"{TESTS}::test_what_is_partly_there_covers_its_part",
    ),
    Mutant(
        "hidden lights cover what is behind them",
        "integrators/coverage.py",
        (("hidden = active & (surface.light != 0)", "hidden = active & (surface.light == 77)"),),
        f"{TESTS}::test_what_is_partly_there_covers_its_part",
    ),
    Mutant(
        "answers of workers without weights",
        "rendering/executors/block_tasks.py",
        (('arrays |= pack_sums(f"{number}.coverage", partial.coverage)', "pass"),),
        f"{TESTS}::test_a_worker_answers_with_the_table",
    ),
    Mutant(
        "things that cover nothing have ranks",
        "films/mattes.py",
        (("order[share[order] > 0.0]", "order[share[order] >= 0.0]"),),
        f"{TABLES}::test_ranks_are_those_of_the_sums_of_each_name",
    ),
    Mutant(
        "materials that belong to others by their names",
        "films/mattes.py",
        (
            (
                "(_is_hierarchical(layer) and one.startswith(name + _BELOW))",
                "one.startswith(name + _BELOW)",
            ),
        ),
        f"{TABLES}::test_names_of_materials_are_no_branches",
    ),
    Mutant(
        "tables whose pairs stand in any order",
        "films/coverage.py",
        (("((step == 0) & further)", "(step == 0)"),),
        f"{TABLES}::test_a_film_file_whose_rows_are_out_of_order_is_refused",
    ),
    Mutant(
        "holes of mattes by the numbers of the vertex before",
        "integrators/coverage.py",
        (("vertex_dimension(path.depth + 1)", "vertex_dimension(path.depth)"),),
        f"{TESTS}::test_what_passes_a_veil_in_the_picture_passes_it_in_the_matte",
    ),
    Mutant(
        "hidden lights are vertices of mattes",
        "integrators/coverage.py",
        (("depth = where(hidden, path.depth, depth)", "depth = where(hidden, depth, depth)"),),
        f"{TESTS}::test_what_passes_a_veil_in_the_picture_passes_it_in_the_matte",
    ),
)
