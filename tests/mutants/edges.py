"""Bugs at the edges: rows of other models, ends of ranges, many levels."""

from tests.mutants.mutant import Mutant

MODELS = "tests/edges/test_materials.py"
LIGHTS = "tests/edges/test_lights.py"

EDGES = (
    Mutant(
        "a checkpoint that chooses what code is run",
        "rendering/checkpoints/resume.py",
        (
            (
                "load_plugins(plugins)",
                "load_plugins([*Targets.noted(notes).plugins, *plugins])",
            ),
        ),
        "tests/extension/test_scripts_of_checkpoints.py"
        "::test_a_checkpoint_runs_no_scripts_but_those_that_are_asked_for",
    ),
    Mutant(
        "models that read the rows of other models",
        "bsdfs/switch.py",
        (("where(active, row, some) * stride", "row * stride"),),
        f"{MODELS}::test_models_read_rows_of_their_own_kind_only",
    ),
    Mutant(
        "reflectance that rounding makes negative",
        "bsdfs/disney/lobes.py",
        (
            (
                "dielectric = Vec3(_unit(dielectric.x), _unit(dielectric.y), _unit(dielectric.z))",
                "pass",
            ),
        ),
        f"{MODELS}::test_principled_is_finite_where_a_lobe_has_nothing",
    ),
    Mutant(
        "light bent where it is reflected totally",
        "bsdfs/disney/lobes.py",
        (("open_ = (params.thin | (cos_t > 0.0)) & ~coat", "open_ = ~coat"),),
        f"{MODELS}::test_principled_is_finite_where_a_lobe_has_nothing",
    ),
    Mutant(
        "angles of many turns left to the kernels",
        "bsdfs/disney/parameters.py",
        (
            ("return math.remainder(angle, 2.0 * math.pi)", "return 1e15"),
            (
                "sincos(minimum(maximum(row.anisotropy_rotation, -MOST_TURNED), MOST_TURNED))",
                "sincos(row.anisotropy_rotation)",
            ),
        ),
        f"{MODELS}::test_principled_is_finite_where_a_lobe_has_nothing",
    ),
    Mutant(
        "light at the light itself",
        "lights/at_point.py",
        (("where(apart, 1.0 / squared, 0.0)", "1.0 / squared"),),
        f"{LIGHTS}::test_no_light_arrives_at_the_light_itself",
    ),
    Mutant(
        "surroundings chosen one inside of the other",
        "lights/halves.py",
        (("half = len(parts) // 2", "half = 1"),),
        "tests/edges/test_depths.py::test_as_many_surroundings_as_allowed_can_be_written",
    ),
    Mutant(
        "depth of a texture counted anew for each order of its parts",
        "textures/nesting.py",
        (
            (
                "depths = [depth_of(inner) for inner in part.parts]",
                "depths = [depth_of(inner) for inner in part.ordered]",
            ),
        ),
        "tests/edges/test_depths.py::test_deep_sums_are_measured_at_once",
    ),
    Mutant(
        "photos turned the other way",
        "outputs/texels.py",
        (
            ("6: (True, False, True)", "6: (True, True, False)"),
            ("8: (True, True, False)", "8: (True, False, True)"),
        ),
        "tests/textures/test_placed_pictures.py::test_photos_stand_upright_and_it_is_told",
    ),
    Mutant(
        "pixels at the corner of their display window",
        "outputs/texels.py",
        (("left, top = x - display.low[0], y - display.low[1]", "left, top = 0, 0"),),
        "tests/textures/test_placed_pictures.py::test_pixels_lie_where_the_display_window_has_them",
    ),
    Mutant(
        "warnings of the first of merged films only",
        "films/merging.py",
        (
            (
                "for part in parts for text in part.scene_warnings",
                "for text in parts[0].scene_warnings",
            ),
        ),
        "tests/film/test_all_that_a_film_holds.py::test_merged_films_warn_of_what_any_warns_of",
    ),
)
