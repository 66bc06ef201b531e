"""Bugs of media."""

from tests.mutants.mutant import Mutant

FORMS = "tests/media/test_closed_forms.py"
FLIGHTS = "tests/media/test_flights.py"
LAWS = "tests/laws/test_every_model.py"
BORDERS = "tests/media/test_light_at_borders.py"
NUMBERS = "tests/rendering/test_random_dimensions.py"

MEDIA = (
    Mutant(
        "light sampling's way through a medium as if it were a free flight too",
        "media/homogeneous.py",
        (("exp(chosen * distance))", "0.0 * distance + 1.0)"),),
        f"{FLIGHTS}::test_flights_come_through_as_the_transmittance_says[homogeneous]",
    ),
    Mutant(
        "collisions without the extinction of each channel",
        "media/homogeneous.py",
        (("passed * share(extinction, chosen)", "passed"),),
        f"{FLIGHTS}::test_flights_come_through_as_the_transmittance_says[homogeneous]",
    ),
    Mutant(
        "collisions that do nothing taken for certain",
        "media/grid.py",
        (("where(null, 1.0 / (1.0 - real), 1.0)", "1.0"),),
        f"{FLIGHTS}::test_flights_come_through_as_the_transmittance_says[grid]",
    ),
    Mutant(
        "cells looked up at their corners",
        "media/voxels.py",
        (("to_float(count) - 0.5", "to_float(count)"),),
        f"{FLIGHTS}::test_shadow_rays_come_through_as_the_transmittance_says[grid]",
    ),
    Mutant(
        "shadow rays that survive the roulette do not carry the others",
        "media/grid.py",
        (("weight * (1.0 / KEPT)", "weight"),),
        f"{FLIGHTS}::test_shadow_rays_come_through_as_the_transmittance_says[grid]",
    ),
    Mutant(
        "Henyey and Greenstein sampled with a wrong sign",
        "phases/henyey_greenstein.py",
        (("(1.0 + g * u)", "(1.0 - g * u)"),),
        f"{LAWS}::test_it_obeys_the_laws_of_its_family[phases-henyey_greenstein]",
    ),
    Mutant(
        "borders turned inside out",
        "integrators/interiors/volume_walk.py",
        (("side_of(w, surface.ng) < 0.0", "side_of(w, surface.ng) > 0.0"),),
        f"{FORMS}::test_leaving_a_body_leads_into_its_exterior",
    ),
    Mutant(
        "blue never chooses a distance",
        "integrators/interiors/volume_walk.py",
        (("3.0 * get_1d(sampler, CHANNEL)", "2.0 * get_1d(sampler, CHANNEL)"),),
        f"{FORMS}::test_transmittance_of_a_ball_is_beers_law",
    ),
    Mutant(
        "surfaces that are not there count as edges",
        "integrators/volpath.py",
        (("where(passing, on, vertex)", "where(passing, replace(on, depth=depth), vertex)"),),
        f"{FORMS}::test_light_scattered_once_is_the_integral_along_the_ray",
    ),
    Mutant(
        "shadow rays go through holes undimmed",
        "integrators/shadow_rays.py",
        (("weight * share", "weight"),),
        "tests/estimators/test_holes.py::test_a_point_light_is_dimmed_by_what_stands_before_it",
    ),
    Mutant(
        "light sampling weighed with holes, paths without",
        "integrators/shadow_rays.py",
        (
            (
                "where(met & ~(share > 0.0), lanes_vec3(0.0), passed)",
                "where(met, passed * share, passed)",
            ),
            ("weight * share", "weight"),
        ),
        "tests/estimators/test_holes.py::test_path_and_volpath_see_the_same_through_holes",
    ),
    Mutant(
        "media shine where they scatter too",
        "integrators/interiors/collisions.py",
        (("lanes_vec3(1.0) - albedo", "lanes_vec3(1.0)"),),
        "tests/media/test_emission.py::test_in_a_furnace_as_bright_as_themselves_media_vanish",
    ),
    Mutant(
        "light scattered forward goes backward",
        "media/sampling.py",
        (("length_squared(wi - d)", "length_squared(wi + d)"),),
        f"{FORMS}::test_light_scattered_once_is_the_integral_along_the_ray",
    ),
    Mutant(
        "light looked for in the medium that the path came through",
        "integrators/volpath.py",
        (
            (
                "medium = medium_beyond(scene, surface, light.wi, path.medium)",
                "medium = path.medium",
            ),
        ),
        f"{BORDERS}::test_a_point_light_is_dimmed_by_the_media_on_its_side[a body in haze-behind]",
    ),
    Mutant(
        "albedo of a grid looked up half-way",
        "media/grid.py",
        (("ALBEDOS, way.o + t * way.d)", "ALBEDOS, way.o + 0.5 * t * way.d)"),),
        "tests/media/test_values_on_grids.py"
        "::test_values_are_those_of_the_place_of_the_collision[box]",
    ),
    Mutant(
        "channel and time drawn from one number",
        "integrators/interiors/volume_walk.py",
        (("CHANNEL = 5", "CHANNEL = 4"),),
        f"{NUMBERS}::test_no_number_is_used_for_two_purposes[volpath-1]",
    ),
    Mutant(
        "shadow rays through many borders run into the numbers of the next flight",
        "media/tables.py",
        (
            ("    a, b = sample_keys(stream.a, stream.b, number)\n", ""),
            (
                "Stream(a, b, stream.first)",
                "Stream(stream.a, stream.b, stream.first + number * 4096)",
            ),
        ),
        f"{NUMBERS}::test_no_number_is_used_for_two_purposes[volpath-1]",
    ),
    Mutant(
        "what grey media weaken, by 2 % too little",
        "media/tables.py",
        (
            (
                "def alike(extinction, chosen, distance):\n        return lanes_vec3(1.0)",
                "def alike(extinction, chosen, distance):\n        return lanes_vec3(1.02)",
            ),
        ),
        "tests/media/test_flights.py"
        "::test_grey_media_are_coloured_ones_of_three_equal_channels[homogeneous]",
    ),
)
