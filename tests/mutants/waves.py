"""Bugs of the water that is computed."""

from tests.mutants.mutant import Mutant

WAVY = "tests/scene/test_waves.py"

WAVES = (
    Mutant(
        "normals that lean with the slope",
        "scene/builtin/waves.py",
        (("np.stack([-slope_x,", "np.stack([slope_x,"),),
        f"{WAVY}::test_normals_are_those_of_the_water",
    ),
    Mutant(
        "one wave counted as two",
        "scene/builtin/waves.py",
        (("if kept and (-m, -n) not in found:", "if kept:"),),
        f"{WAVY}::test_the_slope_is_as_told",
    ),
    Mutant(
        "half of the triangles upside down",
        "scene/builtin/waves.py",
        (("np.stack([b, c, d], axis=1)", "np.stack([b, d, c], axis=1)"),),
        f"{WAVY}::test_triangles_cover_the_square_and_look_up",
    ),
    Mutant(
        "waves that do not repeat",
        "scene/builtin/waves.py",
        (("kx, kz = np.pi * ", "kx, kz = 3.0 * "),),
        f"{WAVY}::test_squares_continue_each_other",
    ),
)
