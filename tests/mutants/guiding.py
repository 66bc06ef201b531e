"""Bugs of guides: densities, weights, training."""

from tests.mutants.mutant import Mutant

TREE = "tests/guiding/test_tree.py"
LAWS = "tests/guiding/test_laws_of_training.py"
GAIN = "tests/guiding/test_gain.py"
WITHOUT = f"{GAIN}::test_paths_with_a_guide_tell_the_second_moment_without_it"
LIGHT = "tests/guiding/test_light_records.py"
RENDERS = "tests/guiding/test_guided_renders.py"
MEDIA = "tests/guiding/test_guided_media.py"
SHOWN = "tests/rendering/test_aovs.py::test_the_guides_share_is_that_of_the_leaf_where_light_is_scattered"  # noqa: E501
SAME_IN_MEDIA = f"{MEDIA}::test_a_guided_picture_of_media_is_that_of_a_path_tracer"
SAME = f"{RENDERS}::test_a_guided_picture_is_that_of_a_path_tracer"

GUIDING = (
    Mutant(
        "ways go on through what scatters",
        "rendering/training/light_training.py",
        (
            (
                "        way = lanes_vec3(1.0) * where(delta, way, 0.0)\n        return",
                "        way = lanes_vec3(1.0) * way\n        return",
            ),
        ),
        f"{LIGHT}::test_a_way_begins_where_light_was_scattered",
    ),
    Mutant(
        "ways go on through what scatters in media",
        "rendering/training/light_training.py",
        (
            (
                "        way = lanes_vec3(1.0) * where(delta, way, 0.0)\n        unseen",
                "        way = lanes_vec3(1.0) * way\n        unseen",
            ),
        ),
        f"{LIGHT}::test_a_way_begins_where_light_was_scattered",
    ),
    Mutant(
        "weights of the mixture for lamps that paths without a guide would meet",
        "integrators/reach.py",
        (("return replace(path, pdf=path.unguided.pdf)", "return path"),),
        f"{WITHOUT}[path]",
    ),
    Mutant(
        "weights of the mixture for the light sampling of paths without a guide",
        "integrators/direct_light.py",
        (("light_weight(light, of_bsdf)", "light_weight(light, pdf)"),),
        f"{WITHOUT}[path]",
    ),
    Mutant(
        "weights of the mixture for what phase functions meet without a guide",
        "integrators/volpath.py",
        (("return replace(path, lights=path.lights * more)", "return path"),),
        f"{WITHOUT}[volpath]",
    ),
    Mutant(
        "weights of the mixture for light sampling in media without a guide",
        "integrators/volpath.py",
        (
            (
                "chosen_weight(path, light, of_bsdf, crossing)",
                "chosen_weight(path, light, pdf, crossing)",
            ),
        ),
        f"{WITHOUT}[volpath]",
    ),
    Mutant(
        "delta lobes that are as rare without a guide as with one",
        "integrators/guided.py",
        (("where(smooth, likelier, 1.0 - share)", "where(smooth, likelier, 1.0)"),),
        f"{WITHOUT}[lobes]",
    ),
    Mutant(
        "records at the border of glass in fog",
        "integrators/guided.py",
        (
            (
                "record_vertices(settings.log, path, drawn, smooth & possible & going)",
                "record_vertices(settings.log, path, drawn, survived & going)",
            ),
        ),
        f"{MEDIA}::test_borders_without_a_vertex_leave_no_records",
    ),
    Mutant(
        "light sampling in fog does not know the guide",
        "integrators/volpath.py",
        (
            (
                "pdf = mixed_density(settings, here, light.wi, pdf, lit)",
                "pdf = where(scattered, pdf, mixed_density(settings, here, light.wi, pdf, lit))",
            ),
        ),
        f"{MEDIA}::test_light_sampling_in_fog_knows_the_guide",
    ),
    Mutant(
        "records in fog with the transmittance of one channel",
        "integrators/volpath.py",
        (("beta=path.beta * (1.0 / mean(path.ours))", "beta=path.beta"),),
        f"{MEDIA}::test_a_record_in_fog_has_the_throughput_of_its_channels",
    ),
    Mutant(
        "holes without the light of directions that the guide took",
        "integrators/volpath.py",
        (("where(hole, path.beta * weight, path.beta)", "path.beta"),),
        SAME_IN_MEDIA,
    ),
    Mutant(
        "the phase function's density in place of the mixture's",
        "integrators/guided.py",
        (
            (
                "weight=weight, pdf=where(smooth, pdf, found.pdf)), w",
                "weight=weight), w",
            ),
        ),
        f"{MEDIA}::test_directions_in_fog_have_the_density_of_the_mixture",
    ),
    Mutant(
        "a density without the Jacobian of the map",
        "guiding/lookup.py",
        (("lanes(1.0), lanes(INV_FOUR_PI)", "lanes(1.0), lanes(4.0 * INV_FOUR_PI)"),),
        f"{TREE}::test_densities_are_the_weights_of_quadrants",
    ),
    Mutant(
        "a density that is a percent too large",
        "guiding/lookup.py",
        (("density * (4.0 * share)", "density * (4.02 * share)"),),
        f"{TREE}::test_densities_are_the_weights_of_quadrants",
    ),
    Mutant(
        "columns of the other row",
        "guiding/lookup.py",
        (
            (
                "where(lower, parts >> PART_BITS, parts >> (2 * PART_BITS))",
                "where(lower, parts >> (2 * PART_BITS), parts >> PART_BITS)",
            ),
        ),
        f"{TREE}::test_densities_are_the_weights_of_quadrants",
    ),
    Mutant(
        "light sampling does not know the guide",
        "integrators/guided.py",
        (("return mixed(here.share, of_guide, of_bsdf)", "return of_bsdf"),),
        f"{RENDERS}::test_light_sampling_knows_the_guide",
    ),
    Mutant(
        "delta lobes where the guide leads",
        "integrators/guided.py",
        (
            (
                "where(smooth, weight, found.weight / (1.0 - share))",
                "where(smooth, weight, found.weight)",
            ),
        ),
        SAME,
    ),
    Mutant(
        "survivors that do not carry the light of the others",
        "integrators/guided.py",
        (("where(survived, weight / survival,", "where(survived, weight,"),),
        SAME,
    ),
    Mutant(
        "records of vertices with delta lobes alone",
        "integrators/guided.py",
        (
            (
                "record_vertices(settings.log, path, drawn, smooth & possible & going)",
                "record_vertices(settings.log, path, drawn, survived & going)",
            ),
        ),
        f"{RENDERS}::test_vertices_of_mirrors_leave_no_records",
    ),
    Mutant(
        "training that looks up the pixels of the film",
        "rendering/training/trainer.py",
        (
            (
                "frame = framed(box, picture, self.size)",
                "frame = framed(box, picture, self.scene.size)",
            ),
        ),
        f"{RENDERS}::test_a_guide_is_the_same_for_any_threads_and_film_size",
    ),
    Mutant(
        "training with the picture's random numbers of a thread",
        "rendering/training/trainer.py",
        (
            (
                "seed=seed_of_round(seed, TRAINING + number)",
                "seed=seed_of_round(seed, TRAINING + number + self.threads)",
            ),
        ),
        f"{RENDERS}::test_a_guide_is_the_same_for_any_threads_and_film_size",
    ),
    Mutant(
        "a bound of samples that a guide breaks",
        "integrators/path.py",
        (
            (
                'self.light_sampling == "emitter" or self.wants_guide or self',
                'self.light_sampling == "emitter" or self',
            ),
        ),
        f"{RENDERS}::test_bounds_of_samples_are_not_claimed",
    ),
    Mutant(
        "moments without the area of their quadrant",
        "guiding/tree.py",
        (("np.sqrt(totals.cells.shaped * self._area())", "totals.cells.shaped * self._area()"),),
        f"{TREE}::test_weights_follow_the_root_of_moment_times_area",
    ),
    Mutant(
        "directions as the middle sees them, with the density of the point",
        "guiding/lookup.py",
        (("density * where(led, spread_drawn, spread)", "density"),),
        f"{TREE}::test_directions_have_the_density_that_is_told",
    ),
    Mutant(
        "a derivative without the cosine at the sphere",
        "guiding/parallax.py",
        (("1.0) * where(cosine > 0.0, cosine, 1.0))", "1.0))"),),
        f"{TREE}::test_directions_are_moved_to_the_middle_of_a_leaf_and_back",
    ),
    Mutant(
        "a mean of distances, not of their inverses",
        "guiding/light_records.py",
        (
            ("sharp * minimum(size * near, SHORTEST)", "sharp / maximum(size * near, 1e-3)"),
            ("    minimum,\n", "    maximum,\n    minimum,\n"),
        ),
        f"{LIGHT}::test_sums_of_arrivals_are_those_of_their_leaves",
    ),
    Mutant(
        "what a guide gains without its roulette",
        "integrators/guided.py",
        (("path.unguided.rarity * (likelier * survival)", "path.unguided.rarity * likelier"),),
        f"{WITHOUT}[path and roulette]",
    ),
    Mutant(
        "what a guide gains without the roulette of paths that have none",
        "integrators/roulette.py",
        (("        unguided=replace(path.unguided, rarity=rarity),\n", ""),),
        f"{WITHOUT}[volpath and roulette]",
    ),
    Mutant(
        "training pictures with samples that are no numbers",
        "rendering/training/trainer.py",
        (("    ends = np.where(np.isfinite(ends), ends, 0.0)\n", ""),),
        f"{GAIN}::test_samples_that_are_no_numbers_say_nothing",
    ),
    Mutant(
        "light paths in media that do not record their last vertex",
        "rendering/training/light_training.py",
        (
            (
                "        seen = met.active | collided\n",
                "        seen = (met.active | collided) & (depth + 1 < settings.max_depth)\n",
            ),
        ),
        f"{LIGHT}::test_air_that_hardly_scatters_changes_no_arrivals",
    ),
    Mutant(
        "light paths leave records at mirrors",
        "rendering/training/light_training.py",
        (
            (
                "seen & ~path.delta & (~delta | is_mixed(scene, arrival.surface))",
                "seen & ~path.delta",
            ),
        ),
        f"{LIGHT}::test_walls_of_mirrors_and_too_long_paths_leave_no_records",
    ),
    Mutant(
        "light paths record what light sampling finds",
        "rendering/training/light_training.py",
        (
            (
                "seen & ~path.delta & (~delta | is_mixed(scene, arrival.surface))",
                "seen & (~delta | is_mixed(scene, arrival.surface))",
            ),
        ),
        f"{LIGHT}::test_only_what_light_sampling_misses_is_recorded",
    ),
    Mutant(
        "a way that begins again at mirrors",
        "rendering/training/light_training.py",
        (
            (
                "where(delta, way, 0.0)\n        return",
                "where(delta, 0.0, 0.0)\n        return",
            ),
        ),
        f"{LIGHT}::test_the_length_of_a_way_goes_over_mirrors",
    ),
    Mutant(
        "the brightest leaves choose for those that know nothing",
        "guiding/tree.py",
        (("counts * moments / np.maximum(moments.mean(1, keepdims=True), 1.0)", "moments"),),
        f"{TREE}::test_a_leaf_chooses_what_has_the_least_second_moment",
    ),
    Mutant(
        "choices judged by the densities of a leaf's middle",
        "guiding/records.py",
        (("by_camera * spread, by_light * spread", "by_camera, by_light"),),
        f"{LAWS}::test_sums_are_those_of_the_records_one_by_one",
    ),
    Mutant(
        "vertices counted in the quadrants that the point sees",
        "guiding/records.py",
        (
            (
                "d, spread = from_middle(focus_at(guide, leaf, p), d)",
                "_, spread = from_middle(focus_at(guide, leaf, p), d)",
            ),
        ),
        f"{LAWS}::test_sums_are_those_of_the_records_one_by_one",
    ),
    Mutant(
        "two contributions that weigh by the rarity of the later one",
        "guiding/gain.py",
        (
            (
                "found * (weighed + 2.0 * unguided.L)",
                "unguided.rarity * found * (found + 2.0 * unguided.L)",
            ),
        ),
        f"{GAIN}::test_the_second_moment_without_a_guide_is_exact",
    ),
    Mutant(
        "paths that are too rare for a number",
        "rendering/training/trainer.py",
        (("np.where(np.isfinite(without), without, ends**2)", "without"),),
        f"{GAIN}::test_samples_that_are_no_numbers_say_nothing",
    ),
    Mutant(
        "a layer of the guide's share that mirrors have too",
        "integrators/aov.py",
        (("active & ~passes & asks", "active & asks"),),
        SHOWN,
    ),
    Mutant(
        "a layer of the guide's share where nobody asks the guide",
        "integrators/aov.py",
        (("active & ~passes & asks", "active & ~passes"),),
        SHOWN,
    ),
    Mutant(
        "light paths that train a guide for the camera's paths alone",
        "compiled/scene.py",
        (('way_of_guiding in ("on", "auto")', "wants_guide"),),
        f"{RENDERS}::test_a_guide_may_learn_from_the_camera_alone",
    ),
    Mutant(
        "records that count four times, once in each quarter of their box",
        "guiding/records.py",
        (("return rint(0.25 * number)", "return number"),),
        f"{LAWS}::test_sums_are_those_of_the_records_one_by_one",
    ),
    Mutant(
        "records that are not spread over their box",
        "guiding/records.py",
        (("around_edges(x + right * side, y + up * side)", "around_edges(x, y)"),),
        f"{LAWS}::test_sums_are_those_of_the_records_one_by_one",
    ),
    Mutant(
        "records that go on beside the edge of the square, not across it",
        "core/equal_area.py",
        (("_folded(x), where(beyond, 1.0 - y, y)", "_folded(x), y"),),
        f"{TREE}::test_beyond_an_edge_of_the_square_the_map_goes_on",
    ),
    Mutant(
        "paths that nothing is known of never end",
        "integrators/roulette.py",
        (("unlearnt = gain == 0.0", "unlearnt = gain < 0.0"),),
        f"{GAIN}::test_a_guide_that_knows_nothing_changes_nothing",
    ),
)
