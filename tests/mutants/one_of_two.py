"""Bugs in one of two ways, and in corners that no test had: crops, half turns, rough panes."""

from tests.mutants.mutant import Mutant

BEHIND = "tests/known_error/test_light_behind_glass.py"
CHAINS = "tests/estimators/test_chains_end_at_their_lamp.py"
NUMBERS = "tests/rendering/test_random_dimensions.py"
PROMISES = "tests/known_error/test_laws_of_promises.py"
SHARES = "tests/known_error/test_laws_of_shares.py"
SPECULAR_CHAIN = "integrators/caustics/specular_chain.py"
WHY = "tests/lab/test_why.py"

ONE_OF_TWO = (
    Mutant(
        "light that may rise is no doubt of the brightness",
        "rendering/schedules/stopping.py",
        (("_replace(brightness=0.0, rise=0.0)", "_replace(brightness=0.0)"),),
        f"{PROMISES}::test_a_promise_is_doubted_where_the_brightness_of_noisy_pixels_alone_stands"
        "_in_its_way[rise]",
    ),
    Mutant(
        "unseen light falls with the root of the samples",
        "rendering/schedules/stopping.py",
        (("unseen.figure / promise.error,", "(unseen.figure / promise.error) ** 2,"),),
        f"{PROMISES}::test_samples_that_are_missing_go_with_the_square_of_the_error[0.003-0.01]",
    ),
    Mutant(
        "halves of replicates as sure as all of them",
        "metrics/few_pixels.py",
        (("replicates - 1, size - 1", "replicates - 1, replicates - 1"),),
        "tests/metrics/test_few_noisy_pixels.py"
        "::test_chance_is_the_deviation_of_a_product_of_two_halves[4]",
    ),
    Mutant(
        "a region as high as it is wide",
        "lab/why/shares.py",
        (("int(np.ceil((y + h) * height))", "int(np.ceil((y + h) * width))"),),
        f"{WHY}::test_a_region_counts_the_pixels_that_it_touches[size0]",
    ),
    Mutant(
        "kinds of contributions of paths up to 7 edges",
        "lab/why/shares.py",
        (("code >> 3 * _BITS\n", "code >> 3 * _BITS & 7\n"),),
        f"{WHY}::test_kinds_of_contributions_keep_all_of_their_fields",
    ),
    Mutant(
        "what passes below a coat fades",
        "bsdfs/normals/coat_normals.py",
        (
            (
                "where(wo.z * wi.z > 0.0, fading(bend.n, bend.fades, wi), 1.0), 0.0)",
                "fading(bend.n, bend.fades, wi), 0.0)",
            ),
        ),
        "tests/physics/test_coat_normals.py"
        "::test_below_a_coat_reflected_light_fades_and_passing_light_does_not",
    ),
    Mutant(
        "one pair of numbers for both directions of a sky on the ground",
        "integrators/shadow_catcher.py",
        (("dimension + BSDF_DIRECTION)", "dimension + LIGHT_POINT)"),),
        f"{NUMBERS}::test_numbers_of_shadows_on_the_ground_have_one_purpose_each",
    ),
    Mutant(
        "free flights with numbers of vertices before",
        "integrators/interiors/collisions.py",
        (
            (
                "vertex_dimension(path.steps + 1) + FREE_FLIGHT",
                "vertex_dimension(path.steps - 1) + FREE_FLIGHT",
            ),
        ),
        f"{NUMBERS}::test_no_number_is_used_for_two_purposes[volpath-2]",
    ),
    Mutant(
        "lamps without a size behind glass, which no path finds",
        "rendering/light_behind_glass.py",
        (("& (pdf > 0.0) & ~wide(light.delta, n)", "& (pdf > 0.0)"),),
        f"{BEHIND}::test_nothing_is_found_where_light_is_not_behind_clear_glass_or_paths_are_led"
        "_to_it",
    ),
    Mutant(
        "rough panes that spread light into their density",
        "rendering/pilot_rays.py",
        (
            (
                "np.where(rough, 1.0 / np.where(rough, self.pdf, 1.0), 0.0)",
                "np.where(rough, self.pdf, 0.0)",
            ),
        ),
        f"{BEHIND}::test_glass_that_is_hardly_rough_spreads_light_into_one_over_its_density",
    ),
    Mutant(
        "half a turn that is mirrored, not turned",
        "bsdfs/measured/measured.py",
        (("-copysign(1.0, wo.x), y)", "-copysign(1.0, wo.x), 1.0)"),),
        "tests/physics/test_measured.py::test_what_was_measured_in_a_part_of_a_turn_is_repeated[2]",
    ),
    Mutant(
        "reflectances that are black beyond their wavelengths",
        "core/spectra.py",
        (("np.interp(_FINE, wavelengths, hat)", "np.interp(_FINE, wavelengths, hat, 0.0, 0.0)"),),
        "tests/physics/test_measured.py"
        "::test_beyond_the_measured_wavelengths_a_reflectance_is_that_of_the_last_one",
    ),
    Mutant(
        "guides of arms with a schedule trained on as many threads as samples",
        "lab/replicates/steering.py",
        (("seed, threads, ladder[-1])", "seed, ladder[-1], threads)"),),
        "tests/lab/test_steered_arms.py"
        "::test_guides_are_made_ready_alike_with_and_without_a_schedule",
    ),
    Mutant(
        "boxes of bodies around the origin",
        "compiled/boxes.py",
        (
            (
                "@ placed.to_world[:3, :3].T + placed.to_world[:3, 3]",
                "@ placed.to_world[:3, :3].T",
            ),
        ),
        "tests/scene/test_warnings_of_bodies.py::test_the_box_around_a_shape_is_where_it_was_put"
        "[mesh]",
    ),
    Mutant(
        "casters that are infinite along one axis",
        "compiled/casters.py",
        (("np.isfinite(box).all()", "np.isfinite(box).any()"),),
        "tests/lights/test_targets.py::test_what_reaches_to_infinity_has_no_box_to_aim_at",
    ),
    Mutant(
        "no direction of a caustic is refused",
        "integrators/caustics/manifold_sampling.py",
        (("holds & _is_kept(accept, drawn, most)", "holds"),),
        "tests/estimators/test_where_caustics_are_sought.py"
        "::test_directions_that_are_refused_bring_no_light",
    ),
    Mutant(
        "chains through one leaf",
        SPECULAR_CHAIN,
        (("(edges < MOST_EDGES)", "(edges < 2)"),),
        f"{CHAINS}::test_a_chain_passes_as_many_leaves_as_there_are[5]",
    ),
    Mutant(
        "chains of one event more than fits",
        SPECULAR_CHAIN,
        (
            (
                "where(chance, passed.count < MOST_EVENTS,",
                "where(chance, passed.count <= MOST_EVENTS,",
            ),
        ),
        f"{CHAINS}::test_a_chain_has_no_more_events_than_its_type_has_bits",
    ),
    Mutant(
        "noisy pixels of a window looked for in the corner of the picture",
        "rendering/schedules/cycles.py",
        (("np.arange(x, x + w) // CELL_SIZE", "np.arange(w) // CELL_SIZE"),),
        f"{SHARES}::test_cycles_goes_on_with_the_noisy_cells_of_a_window[corner1]",
    ),
    Mutant(
        "cells around a window as stopped early",
        "rendering/schedules/cycles.py",
        (
            (
                "np.mean(self.counts[cells_of(*film.crop)] < self.spp)",
                "np.mean(self.counts < self.spp)",
            ),
        ),
        f"{SHARES}::test_cycles_goes_on_with_the_noisy_cells_of_a_window[corner1]",
    ),
    Mutant(
        "bright pixels by their root, and not dark ones",
        "rendering/schedules/cycles.py",
        (("np.where(brightness < 1.0,", "np.where(brightness > 1.0,"),),
        f"{SHARES}::test_the_error_of_cycles_is_over_the_root_of_what_is_dark_and_over_what_is_bright"
        "[5.0]",
    ),
    Mutant(
        "kept references that are as high, whatever their width",
        "lab/references.py",
        (("shape[:2] != arm.size[::-1]", "shape[:1] != arm.size[:0:-1]"),),
        "tests/lab/test_references.py::test_a_kept_reference_of_another_size_is_not_taken",
    ),
    Mutant(
        "references by the first arm that may, and not by the baseline",
        "lab/references.py",
        (
            (
                "return baseline if baseline in fit or not fit else fit[0]",
                "return (fit or [baseline])[0]",
            ),
        ),
        "tests/lab/test_laws_of_references.py"
        "::test_the_baseline_renders_the_reference_if_it_may[False]",
    ),
    Mutant(
        "as long on eight threads as on one",
        "rendering/plan.py",
        (("about {seconds.value / threads:.3g} s", "about {seconds.value:.3g} s"),),
        "tests/known_error/test_laws_of_plans.py"
        "::test_the_time_on_the_clock_is_shared_among_threads",
    ),
    Mutant(
        "media that are dark where one channel absorbs nothing",
        "media/coefficients.py",
        (("min(scattering_albedo(spec)) < 1.0", "max(scattering_albedo(spec)) < 1.0"),),
        "tests/media/test_emission.py::test_a_medium_shines_if_any_channel_absorbs[0]",
    ),
    Mutant(
        "a sun that ends in the middle of its last texel",
        "lights/bright_disk.py",
        (("-1.0, 1.0)).max()) + texel", "-1.0, 1.0)).max())"),),
        "tests/estimators/test_caustics_of_the_sun.py"
        "::test_a_sun_of_one_texel_reaches_as_far_as_the_next_one",
    ),
)
