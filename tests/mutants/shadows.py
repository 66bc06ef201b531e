"""Bugs of shadows that are caught."""

from tests.mutants.mutant import Mutant

TESTS = "tests/rendering/test_shadow_catcher.py"
DOME = f"{TESTS}::test_the_shadow_of_a_disk_under_a_uniform_dome"

SHADOWS = (
    Mutant(
        "both techniques of the ground count in full",
        "lights/ground.py",
        (("s.pdf + INV_PI * cosine", "s.pdf"),),
        f"{TESTS}::test_the_light_of_surroundings_is_known",
    ),
    Mutant(
        "light to the ground without its cosine",
        "lights/ground.py",
        (("(environment_radiance(scene, d)) * w.z", "(environment_radiance(scene, d))"),),
        f"{TESTS}::test_the_light_of_surroundings_is_known",
    ),
    Mutant(
        "the first lamp stays",
        "lights/ground.py",
        (("takes = u < share", "takes = (u < share) & (row == 0)"),),
        f"{TESTS}::test_lights_of_all_kinds_share_the_ground",
    ),
    Mutant(
        "the number that has chosen a lamp used as it is",
        "lights/ground.py",
        (("where(takes, u, u - share) / where(takes, share, 1.0 - share)", "u"),),
        f"{TESTS}::test_lights_of_all_kinds_share_the_ground",
    ),
    Mutant(
        "shadows are what lets light through",
        "integrators/shadow_catcher.py",
        (("return where(mask, 1.0 - share, 0.0)", "return where(mask, share, 0.0)"),),
        f"{TESTS}::test_holes_let_light_through",
    ),
    Mutant(
        "the lamp beside the sky forgotten",
        "integrators/shadow_catcher.py",
        (("film.ground.sky + lamps,", "film.ground.sky + 0.0 * lamps,"),),
        f"{TESTS}::test_lights_of_all_kinds_share_the_ground",
    ),
    Mutant(
        "the mean of shadows in the place of their square",
        "integrators/shadow_catcher.py",
        (("Vec3(shadow, shadow * shadow, lanes(0.0))", "Vec3(shadow, shadow, lanes(0.0))"),),
        f"{TESTS}::test_lights_of_all_kinds_share_the_ground",
    ),
    Mutant(
        "what covers is no part of alpha's error",
        "integrators/shadow_catcher.py",
        (("Vec3(lanes(0.0), weight * weight,", "Vec3(lanes(0.0), 0.0 * weight,"),),
        f"{TESTS}::test_edges_have_the_error_of_a_coin",
    ),
    Mutant(
        "shadows blended as linear light",
        "outputs/picture.py",
        (("encode_srgb(np.clip(1.0 - self.shadow / beside, 0.0, 1.0))",
          "np.clip(1.0 - self.shadow / beside, 0.0, 1.0)"),),
        "tests/outputs/test_formats.py::test_shadows_are_black_where_nothing_covers",
    ),
    Mutant(
        "things behind a lamp are in its way",
        "integrators/shadow_catcher.py",
        (("s.wi, end, down & (lamps", "s.wi, lanes(INFINITY), down & (lamps"),),
        "tests/rendering/test_shadows_of_many_lamps.py"
        "::test_the_shadow_is_the_share_of_the_light_that_is_kept_away[0]",
    ),
    Mutant(
        "lamps below the ground light it",
        "lights/ground.py",
        (("(s.pdf > 0.0) & (s.wi.y > 0.0) &", "(s.pdf > 0.0) &"),),
        "tests/rendering/test_shadows_of_many_lamps.py"
        "::test_the_shadow_is_the_share_of_the_light_that_is_kept_away[3]",
    ),
    Mutant(
        "the green of a lamp is its light",
        "lights/ground.py",
        (("where(lit, luminance(radiance) *", "where(lit, radiance.y *"),),
        "tests/rendering/test_shadows_of_many_lamps.py"
        "::test_the_shadow_is_the_share_of_the_light_that_is_kept_away[0]",
    ),
    Mutant(
        "the ground seen from below",
        "integrators/shadow_catcher.py",
        (("(path.d.y < 0.0) & (path.o.y > height)", "(path.d.y < 0.0)"),),
        "tests/rendering/test_shadows_of_many_lamps.py::test_from_below_the_ground_no_shadow_is_seen",
    ),
    Mutant(
        "shadows without the filter's weight",
        'integrators/shadow_catcher.py',
        (('shadow = path.beta.x * kept', 'shadow = kept'),),
        "tests/rendering/test_shadows_of_many_lamps.py"
        "::test_filters_with_negative_parts_overshoot_at_the_edge_of_a_shadow",
    ),
)  # fmt: skip
