"""Bugs of displaced meshes."""

from tests.mutants.mutant import Mutant

TESTS = "tests/shapes/test_displacement.py"

_OWN = """\
    new = vertex_normals(points, faces)
    own = (rows + heights[:, None] * normals[which]).astype(np.float32)
"""

DISPLACEMENT = (
    Mutant(
        "each vertex moved by its own height",
        "compiled/displacement.py",
        (("vertices=points[which], normals=new", "vertices=own, normals=new"),
         ("    new = vertex_normals(points, faces)\n",
          _OWN)),
        f"{TESTS}::test_charts_and_edges_of_a_cube_do_not_open",
    ),
    Mutant(
        "vertices moved by the sum of heights at their place",
        "compiled/displacement.py",
        (("np.bincount(which, heights) / count", "np.bincount(which, heights)"),),
        f"{TESTS}::test_a_mesh_that_is_inside_out_keeps_its_outer_side",
    ),
    Mutant(
        "the midlevel forgotten",
        "compiled/displacement.py",
        ((" - shape.displacement_midlevel", ""),),
        f"{TESTS}::test_a_ramp_moves_to_the_heights_and_normals_of_its_slope",
    ),
    Mutant(
        "normals as before the vertices were moved",
        "compiled/displacement.py",
        (("normals=new[which]", "normals=normals[which].astype(np.float32)"),),
        f"{TESTS}::test_a_wave_has_the_heights_and_normals_of_its_formula",
    ),
    Mutant(
        "normals on the side of the order of the vertices",
        "compiled/displacement.py",
        (("< 0.0, -new, new)", "< -9.0, -new, new)"),),
        f"{TESTS}::test_a_mesh_that_is_inside_out_keeps_its_outer_side",
    ),
    Mutant(
        "only the first edge of a triangle is halved",
        "meshes/tessellation.py",
        (("parts.append(_stacked(m, b, n))", "parts.append(_stacked(m, b, c))"),),
        f"{TESTS}::test_edges_are_short_enough_and_the_surface_is_the_same",
    ),
    Mutant(
        "long edges measured in two dimensions",
        "meshes/tessellation.py",
        (("np.square(table[a, :3] - table[b, :3]).sum(axis=1) > longest",
          "np.square(table[a, :2] - table[b, :2]).sum(axis=1) > longest"),),
        f"{TESTS}::test_charts_and_edges_of_a_cube_do_not_open",
    ),
    Mutant(
        "what is displaced has the hash of what is not",
        "scene/hashing.py",
        (("    if not is_displaced(spec):\n", "    if True:\n"),),
        f"{TESTS}::test_what_is_displaced_is_told_and_counts_for_the_hash",
    ),
    Mutant(
        "heights by the red of a colour",
        "compiled/displacement.py",
        (("value = luminance(kernel(scene, none + np.uint32(number), surface, nothing))",
"value = kernel(scene, none + np.uint32(number), surface, nothing).x"),),
        f"{TESTS}::test_a_displaced_mesh_is_that_of_its_formula",
    ),
    Mutant(
        "further sets of coordinates the other way round",
        "compiled/displacement.py",
        (("[mesh.uvs, *more]", "[mesh.uvs, *more[::-1]]"),),
        f"{TESTS}::test_a_displaced_mesh_is_that_of_its_formula",
    ),
    Mutant(
        "later vertices by the colours of the first",
        "compiled/displacement.py",
        (("np.arange(band.start, band.start + n, dtype", "np.arange(n, dtype"),),
        f"{TESTS}::test_a_displaced_mesh_is_that_of_its_formula",
    ),
    Mutant(
        "hollows that are hills",
        "compiled/displacement.py",
        (("shape.displacement_scale * heights", "abs(shape.displacement_scale) * heights"),),
        f"{TESTS}::test_a_displaced_mesh_is_that_of_its_formula",
    ),
    Mutant(
        "of two diagonals the longer one",
        "meshes/tessellation.py",
        (("_distances(table, a, n) <=", "_distances(table, a, n) >="),),
        f"{TESTS}::test_of_two_diagonals_the_shorter_one_is_taken",
    ),
)  # fmt: skip
