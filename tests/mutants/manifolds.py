"""Bugs of manifold sampling: what is counted, and how often."""

from tests.mutants.mutant import Mutant

TESTS = "tests/estimators/test_caustics.py"
GLASS = "tests/estimators/test_caustics_at_glass.py::test_caustics_are_those_that_paths_find"
SAME = f"{TESTS}::test_caustics_are_those_that_paths_find"
SUN = "tests/estimators/test_caustics_of_the_sun.py"
UNDER_WATER = f"{SUN}::test_the_sun_lights_the_ground_under_water"
WATER, PANE = (
    f"{TESTS}::test_a_small_lamp_lights_the_ground[{name}]" for name in ("water", "pane")
)

DELTA = "tests/estimators/test_caustics_of_delta_lights.py"
HOLES = "tests/estimators/test_caustics_through_holes.py"
SHARES = f"{HOLES}::test_every_model_of_a_material_refracts_by_its_share"
CHAIN = "integrators/caustics/specular_chain.py"
COUNTED = (
    "tests/estimators/test_counted_searches.py::test_the_mean_count_is_one_over_the_probability"
)
PHOTONS = "tests/lights/test_photons.py::test_a_photon_tells_the_way_of_its_own_lamp"
AIMS = "tests/motion/test_aims_in_motion.py"
PASSING = f"{AIMS}::test_photons_tell_the_way_at_the_time_of_the_path"
DAY_AND_LAMPS = f"{DELTA}::test_lamps_light_the_ground_under_water"

MANIFOLDS = (
    Mutant(
        "a count that depends on the lanes it was given",
        "integrators/caustics/manifold_sampling.py",
        (("& ((1 << block) - 1)", "& ((1 << width) - 1)"),),
        "tests/estimators/test_counted_searches.py::"
        "test_a_count_does_not_know_how_many_lanes_it_was_given",
    ),
    Mutant(
        "photons of any lamp",
        "lights/photons.py",
        (("^ (key << 16)", "^ (key * 0)"),),
        PHOTONS,
    ),
    Mutant(
        "photons that come from where they landed",
        "compiled/photons.py",
        (("np.where(bent[:, None], p, last)", "np.where(bent[:, None], o, last)"),),
        PHOTONS,
    ),
    Mutant(
        "photons of any time",
        "lights/photons.py",
        (("+ minimum_u32(to_uint(scene.time * SLOTS), lanes_u32(SLOTS - 1))", ""),),
        PASSING,
    ),
    Mutant(
        "photons that come from where the glass was at rest",
        "lights/photons.py",
        (
            (
                "return moved_along(scene, to_uint(where(there, motion, 0.0)), Vec3(x, y, z))",
                "return Vec3(x, y, z)",
            ),
        ),
        PASSING,
    ),
    Mutant(
        "a directional light that turns, aimed at where it has come from",
        "lights/targets.py",
        (("where(target.far, turned(m, c), placed(m, c))", "where(target.far, c, placed(m, c))"),),
        f"{AIMS}::test_lamps_are_aimed_at_where_they_are",
    ),
    Mutant(
        "lamps that move, taken for spheres around their whole way",
        "compiled/light_targets.py",
        (("if rows[number].motion is not None:", "if rows[number].motion is None:"),),
        f"{AIMS}::test_lamps_are_aimed_at_where_they_are",
    ),
    Mutant(
        "delta lights that move and shine from where they rest",
        "lights/targets.py",
        (("own = moving_sample(own)", "own = own"),),
        f"{AIMS}::test_lamps_without_a_size_shine_from_where_they_are",
    ),
    Mutant(
        "mirrors that move, aimed at where they rest",
        "lights/targets.py",
        (("moved_along(scene, to_uint(where(there, motion, 0.0)), point) - p", "point - p"),),
        f"{AIMS}::test_mirrors_are_aimed_at_where_they_are",
    ),
    Mutant(
        "delta lights as disks of the whole radius that walks aim at",
        "lights/targets.py",
        (("radiance * (INV_PI / (size * size))", "radiance * (INV_PI / (FINE * FINE))"),),
        DAY_AND_LAMPS,
    ),
    Mutant(
        "delta lights through what lies in front of them",
        "lights/targets.py",
        (("free = t >= shadow_length(s.distance, s.cosine, s.error, 0.0)", "free = t > 0.0"),),
        f"{DELTA}::test_nothing_comes_through_what_lies_in_front",
    ),
    Mutant(
        "a disk of a delta light of one size in metres",
        "lights/targets.py",
        (("where(target.delta, target.radius * distance, target.radius)", "target.radius"),),
        DAY_AND_LAMPS,
    ),
    Mutant(
        "caustics that paths find once more",
        "integrators/path.py",
        (("surface, active & ~covered)", "surface, active)"),),
        SAME,
    ),
    Mutant(
        "one over the density of a caustic taken for one",
        "integrators/caustics/manifold_sampling.py",
        (
            (
                "made = where(mine, made + mean / _going_on(number), made)",
                "made = where(mine, 1.0, made)",
            ),
        ),
        WATER,
    ),
    Mutant(
        "directions near a solution 2 % too dense",
        "integrators/caustics/manifold_walk.py",
        (("INV_PI / (MARGIN * MARGIN)", "1.02 * INV_PI / (MARGIN * MARGIN)"),),
        WATER,
    ),
    Mutant(
        "searches of a packet counted as if one of them was the last",
        "integrators/caustics/manifold_sampling.py",
        (("(block + 1.0) / (count + 1.0)", "(block + 0.0) / (count + 0.0)"),),
        f"{COUNTED}[0.3]",
    ),
    Mutant(
        "caustics of the sun that paths find once more",
        "integrators/path.py",
        (("left & ~covered)", "left)"),),
        UNDER_WATER,
    ),
    Mutant(
        "the sun of a picture on its other side",
        "lights/bright_disk.py",
        (("Disk(to_map.T @ axis,", "Disk(to_map @ axis,"),),
        f"{SUN}::test_the_sun_of_a_picture_is_found",
    ),
    Mutant(
        "repeated searches that end at chains of another type",
        "integrators/caustics/manifold_search.py",
        (("begun = (starts & wanted)", "begun = starts"),),
        PANE,
    ),
    Mutant(
        "lamps of caustics chosen as if there was one",
        "integrators/caustics/manifold_sampling.py",
        (("(probability * chosen * where", "(probability * where"),),
        SAME,
    ),
    Mutant(
        "repeated searches with the random numbers of the first",
        "integrators/caustics/manifold_sampling.py",
        (("OWN_PAIRS + (number + 1) * PAIRS", "OWN_PAIRS + number * PAIRS"),),
        WATER,
    ),
    Mutant(
        "glass on the way to a lamp that takes no light",
        "integrators/caustics/specular_chain.py",
        (("ray = come_to(scene, ray, surface", "_ = come_to(scene, ray, surface"),),
        SAME,
    ),
    Mutant(
        "chains that start in the body that the path came in",
        "integrators/caustics/manifold_search.py",
        (("bodies_beyond(scene, search.bodies, search.surface, search.d, w)", "search.bodies"),),
        f"{GLASS}[out of coloured glass]",
    ),
    Mutant(
        "caustics at glass that disperses light, in no colour",
        "integrators/caustics/manifold_sampling.py",
        (("factor = arrived.beta * f_cos", "factor = path.beta * f_cos"),),
        f"{GLASS}[through glass that disperses light]",
    ),
    Mutant(
        "splats that are negative in their only channel dropped",
        "integrators/both_ends/splats.py",
        (("max_component(absolute_vec3(value)) <= 0.0", "max_component(value) <= 0.0"),),
        "tests/estimators/test_light_through_glass.py"
        "::test_light_paths_agree_with_camera_paths[a red lamp]",
    ),
    Mutant(
        "chains to lamps that no ray hits",
        "lights/targets.py",
        (("return bool(on_shapes(program)) or has_far_target(program)", "return True"),),
        "tests/estimators/test_where_caustics_are_sought.py"
        "::test_no_chain_leads_to_a_sky_without_a_sun",
    ),
    Mutant(
        "no chains from the lacquer of plastic",
        "integrators/caustics/chain_types.py",
        (("(clear or DELTA_AND_SMOOTH in program.bsdfs)", "clear"),),
        "tests/estimators/test_where_caustics_are_sought.py"
        "::test_chains_are_followed_where_a_material_mirrors",
    ),
    Mutant(
        "chains longer than there are bits for",
        "integrators/caustics/chain_types.py",
        (("MOST_EVENTS = 6", "MOST_EVENTS = 17"),),
        "tests/estimators/test_where_caustics_are_sought.py"
        "::test_the_events_of_the_longest_chain_have_bits_of_their_own",
    ),
    Mutant(
        "light that is dispersed on its way in all colours",
        CHAIN,
        (("ray = meet_dispersion(scene, surface, ray, met)", "pass"),),
        f"{HOLES}::test_light_is_dispersed_on_its_way",
    ),
    Mutant(
        "holes that let all light through",
        CHAIN,
        (("beta * open_share(scene, surface, straight)", "beta"),),
        SHARES,
    ),
    Mutant(
        "a mirror's lobe whatever its share",
        "bsdfs/specular.py",
        (("pdf=where(fine, found.pdf * share, 0.0)", "pdf=where(fine, found.pdf, 0.0)"),),
        SHARES,
    ),
    Mutant(
        "events of the first model, whichever it was",
        "bsdfs/specular.py",
        (("(wanted >> KIND_BITS) == i", "wanted * 0 == i"),),
        SHARES,
    ),
    Mutant(
        "caustics of holes alone",
        CHAIN,
        (("ends = turned & turns(passed)", "ends = turned"),),
        SHARES,
    ),
    Mutant(
        "lamps seen through holes as caustics that count already",
        "integrators/caustics/manifold_sampling.py",
        (("turns(path.chain.type)", "(path.chain.type.count > 0)"),),
        f"{GLASS}[behind clear glass with holes]",
    ),
    Mutant(
        "leaves as events of paths, but not of chains",
        CHAIN,
        (("longer = where(passed, chain, longer)", "pass"),),
        f"{GLASS}[behind leaves]",
    ),
    Mutant(
        "edges through holes for nothing",
        CHAIN,
        (("where(edges <= plan.most, light,", "where(edges < 99, light,"),),
        f"{HOLES}::test_holes_are_edges_of_paths",
    ),
    Mutant(
        "the plane of an ellipse fans out by the square of the cosine",
        "integrators/caustics/manifold_walk.py",
        (
            (
                "solution.density * scale * scale * scale, 0.0",
                "solution.density * scale * scale, 0.0",
            ),
        ),
        "tests/estimators/test_directions_near_solutions.py"
        "::test_the_mean_of_one_over_the_density_is_the_solid_angle[0-0.0]",
    ),
    Mutant(
        "directions about a solution on the other side of its bend",
        "integrators/caustics/manifold_walk.py",
        (("sqrt(solution.across) - solution", "sqrt(solution.across) + solution"),),
        "tests/estimators/test_directions_near_solutions.py"
        "::test_the_mean_of_one_over_the_density_is_the_solid_angle[0-3.0]",
    ),
    Mutant(
        "ellipses that leave the ring of their solutions straight on",
        "integrators/caustics/manifold_walk.py",
        (("bend = step / (axes.look * axes.look)", "bend = 0.0 * step"),),
        "tests/estimators/test_walks_to_lamps.py::test_an_ellipse_bends_with_a_ring_of_solutions",
    ),
    Mutant(
        "ellipses that do not end where the ring of their solutions is no parabola",
        "integrators/caustics/manifold_walk.py",
        (("minimum(minimum(by_rest, by_bend), LONGEST_AXIS)", "LONGEST_AXIS + 0.0 * by_rest"),),
        "tests/estimators/test_walks_to_lamps.py::test_an_ellipse_bends_with_a_ring_of_solutions",
    ),
)
