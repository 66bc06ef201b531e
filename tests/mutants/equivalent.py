"""Slips of the campaign that change nothing that is promised, each with its reason."""

#: Name of the mutant, as the campaign prints it: why no test could find it.
EQUIVALENT: dict[str, str] = {
    "accel/batch.py occluded_range: 1.0 -> 1.02": "whoever reads it asks whether it is positive",
    "accel/collapse.py assign_columns: 0 -> 1 (6)": (
        "how the levels of a tree are shared out among nodes, of which any way is right"
    ),
    "accel/other_leaves.py _write_meet_shape.meet_shape: 0 -> 1 (2)": (
        "all lanes hold the same ray, and so the same hit"
    ),
    "accel/rays.py box_ray_of: vector_of(rays, ORIGIN, i) -> vector_of(rays, i, ORIGIN)": (
        "the sum of both is where it is read"
    ),
    "accel/references.py bin_scale: 0.99999 -> 1.0199898": (
        "how finely a tree is divided: references are divided without loss at any scale, see "
        "`test_any_scale_of_bins_divides_references_without_loss`"
    ),
    "accel/references.py fill_bins: 1 -> 0": (
        "a second guard: the bins' scale is 1e-5 smaller than would reach the bin beyond the last"
    ),
    "accel/references.py half_area: -scale -> (scale)": "products of two of them: signs cancel",
    "accel/references.py half_area: 3 -> 2": "the fourth place, which nobody reads",
    (
        "bsdfs/disney/burley.py _values: burley_diffuse(params.roughness, params.flatness, wo.z, "
        "wi.z, cos_i) -> burley_diffuse(params.roughness, params.flatness, wi.z, wo.z, cos_i)"
    ): "reciprocal: symmetric in both directions",
    "bsdfs/disney/burley.py _values: Vec3(0.0, 0.0, 1.0) -> Vec3(0.0, 1.0, 0.0)": (
        "stands in for directions that are invalid, whose result is thrown away"
    ),
    "bsdfs/conductors/coated_conductor.py sample: Vec3(0.0, 0.0, 1.0) -> Vec3(0.0, 1.0, 0.0)": (
        "stands in for directions from below, whose result is thrown away"
    ),
    "bsdfs/plastics/coating.py chance_of_coat: 1.0 -> 1.02 (2)": (
        "divides 0 by something other than 0; the quotient is thrown away"
    ),
    "bsdfs/dispatch.py layer_of: 0 -> 1 (7)": (
        "idle lanes read the second word of the table; what they find is thrown away"
    ),
    (
        "bsdfs/matte/eon.py evaluate: _weight(params, where(above, wo, up), where(above, wi, up)) "
        "-> _weight(params, where(above, wi, up), where(above, wo, up))"
    ): "reciprocal: symmetric in both directions",
    (
        "bsdfs/matte/eon.py sample: _weight(params, where(above, wo, up), where(above, wi, up)) -> "
        "_weight(params, where(above, wi, up), where(above, wo, up))"
    ): "reciprocal: symmetric in both directions",
    "bsdfs/plastics/phong.py _chance_of_lobe: 1.0 -> 1.02": (
        "divides 0 by something other than 0; the quotient is thrown away"
    ),
    (
        "bsdfs/disney/lobes.py _chance_of_reflection.chance: where(view.side.inside, "
        "params.transmission, 1.0) * rest -> (rest)"
    ): "how often facets are reflected from inside; the estimate divides by this very chance",
    "bsdfs/normals/shading_normals.py frame_of_map: n.x -> n.y": (
        "0 times the one or the other, for its lanes"
    ),
    "cameras/connection.py connect_point: 1.0 -> 1.02 (2)": (
        "divides 0 by something other than 0; what lies in the lens is not visible"
    ),
    (
        "core/distributions.py pmf_cell: pmf_discrete(cdf, offset + row * (columns + 1), column) "
        "-> pmf_discrete(cdf, column, offset + row * (columns + 1))"
    ): "the sum of both is where it is read",
    "core/fresnel.py fresnel_dielectric: 1.0 -> 1.02 (4)": (
        "divides something other than 0 by it, or is cut to 1 where light grazes"
    ),
    "core/maths.py arctan2: 1.0 -> 1.02": (
        "divides 0 by something other than 0; the quotient is thrown away"
    ),
    "core/motion.py turn_at: k + BEGIN -> ((k) - (BEGIN))": (
        "BEGIN is 0: the first number of its row"
    ),
    "core/warps.py spherical_rectangle: _corner(u1, v1, w) -> _corner(v1, u1, w)": (
        "the angle of a corner does not change with its two sides exchanged"
    ),
    "films/film.py Film.__init__: 1 -> 0": (
        "the mean that is known before the first sample: 0, that of an empty film"
    ),
    "guiding/lookup.py rest_of: 1.0 -> 1.02 (2)": (
        "divides by something other than 0 what is never drawn"
    ),
    "guiding/parallax.py _jacobian: 1.0 -> 1.02": (
        "divides by something other than 0 where a leaf has no sphere; the quotient is thrown away"
    ),
    "integrators/random_walk.py scatter_uniformly: 2.0 * u -> (u) (2)": (
        "where the coin shows tails, the direction that it chooses is thrown away"
    ),
    "integrators/random_walk.py scatter_uniformly: 2.0 * u -> (2.0) (2)": (
        "a choice of lobe for the side of the coin that goes anywhere on the sphere"
    ),
    "integrators/shadow_rays.py _through_empty_space: 0 -> 1": (
        "surfaces passed in a scene in which there are none to pass: nobody asks"
    ),
    (
        "integrators/volpath.py _write_add_direct_light.add_direct_light: 2 * path.steps + 1 -> "
        "((2 * path.steps) - (1))"
    ): "other random numbers, odd too and once each: flights along paths have the even ones",
    "lab/statistics/intervals.py log_ratio: 0.5 -> 0.51": (
        "without any variance of its own the ratio has infinitely many degrees of freedom"
    ),
    "laws/compiled.py scatter_all: 0.75 -> 0.765": (
        "one of the vertex colours that a law tries; any other is as good"
    ),
    "lights/environment.py sample: turn - 1.0 -> ((turn) + (1.0))": (
        "sine and cosine of whole turns more or less are the same"
    ),
    "lights/projector.py brightness_of: 1e-6 -> 1.02e-06": (
        "points within a millionth of the projector's own plane, which its picture never reaches"
    ),
    (
        "lights/tree/traversal.py is_far: p - row_vec3(cdf, MIDDLE) -> "
        "((p) + (row_vec3(cdf, MIDDLE)))"
    ): ("how often a lamp is chosen; sampling and its probability ask the same"),
    "media/sampling.py _kind: medium * INFO + KIND -> ((medium * INFO) - (KIND))": (
        "KIND is 0: the first number of its row"
    ),
    "media/tables.py pick.the_first: v.x -> v.y": "chosen where all three channels are alike",
    "media/voxels.py color_at: 0 -> 1 (3)": (
        "idle lanes look up the first medium in place of none; nobody reads what they find"
    ),
    "metrics/noisy_pixels.py poisson_tail: 0.5 -> 0.51 (2)": (
        "the normal approximation itself errs by more than this correction moves it"
    ),
    "metrics/error_estimate.py Figure.quantile: 600.0 -> 612.0": (
        "keeps an exponential from overflowing; any such number does"
    ),
    (
        "metrics/statistics.py _beta_fraction: _not_zero(1.0 - (a + b) * x / (a + 1.0), tiny) -> "
        "_not_zero(tiny, 1.0 - (a + b) * x / (a + 1.0))"
    ): (
        "the larger of two numbers, of which the first is above 0 wherever the fraction is "
        "evaluated"
    ),
    "metrics/statistics.py _beta_fraction: c * d - 1.0 -> ((c * d) + (1.0))": (
        "goes on to its last term; the factors after convergence are 1"
    ),
    "metrics/statistics.py f_quantile: max(1.0, abs(low)) -> min(1.0, abs(low))": (
        "halves the interval a few more times"
    ),
    (
        "phases/rayleigh.py sample: 1.0 - where(c < 0.0, -mu, mu) -> ((1.0) + (where(c < 0.0, "
        "-mu, mu)))"
    ): "the phase function is the same forwards and backwards",
    "phases/rayleigh.py sample: where(c < 0.0, -mu, mu) -> where(c < 0.0, mu, -mu)": (
        "the phase function is the same forwards and backwards"
    ),
    (
        "rendering/tiles/both_ends_tile.py render_both_ends.render_both_ends: LONGEST - 1 -> "
        "((LONGEST) + (1))"
    ): (
        "a second guard: light paths are active while depth + 1 < LONGEST (`joined_up_to`, "
        "`write_follow`), so that they end after LONGEST - 1 vertices"
    ),
    "rendering/tiles/tile_loop.py tile_loop.render_samples: 0 -> 1 (8)": (
        "when a packet is filled again; each path is followed to its end in any case"
    ),
    "samplers/halton.py _divide: 0.5 -> 0.51": (
        "the quotient is exact for any number well inside of (0, 1)"
    ),
    (
        "samplers/multijittered.py make_kernels.get_2d: sample_keys(a, b, state.index) -> "
        "sample_keys(b, a, state.index)"
    ): "other keys of the hash, as random as these",
    (
        "samplers/permutation.py make_permute.scatter: (i ^ key) * ((key >> 15) | 1) + (key >> 8) "
        "-> (((i ^ key) * ((key >> 15) | 1)) - (key >> 8))"
    ): "another bijection, as random as this one",
    (
        "samplers/stratified.py make_kernels.get_1d: hash_1(a, b, dimension) -> hash_1(a, "
        "dimension, b)"
    ): (
        "another order of the words of a hash: single numbers of different dimensions stay as "
        "little correlated as independent ones, see `pairs_of_dimensions_are_not_correlated`"
    ),
    (
        "samplers/stratified.py make_kernels.get_1d: sample_keys(a, b, state.index) -> "
        "sample_keys(b, a, state.index)"
    ): "other keys of the hash, as random as these",
    "shapes/cylinder.py sample: 1.0 -> 1.02 (3)": (
        "a bound of an error, larger than it must be by 2 % more"
    ),
    (
        "shapes/cylinder.py sample: _GAMMA_12 * dot(absolute_vec3(gather_vec3(data, k)), "
        "lanes_vec3(1.0)) -> (_GAMMA_12)"
    ): (
        "a bound safe on either side: centre less point is exact up to its own rounding, which "
        "`shadow_length` adds"
    ),
    (
        "shapes/mesh.py triangle_error: larger(absolute_vec3(v1 - v0), absolute_vec3(v2 - v0)) -> "
        "larger(absolute_vec3(v2 - v0), absolute_vec3(v1 - v0))"
    ): "the larger of two is that of the two exchanged",
    "shapes/quadric.py excess: two_sum(xx, -rr) -> two_sum(-rr, xx)": (
        "the sum of two and its exact error, in either order"
    ),
    "shapes/sphere.py pdf: q * (1.0 / sqrt(length_squared(q))) -> (q)": (
        "the point of a hit is on the unit sphere but for rounding"
    ),
    "shapes/sphere.py sample: 1.0 -> 1.02 (5)": (
        "a bound of an error, larger than it must be by 2 % more"
    ),
    "shapes/sphere.py sample: 1.0 -> 1.02 (6)": (
        "a bound of an error, larger than it must be by 2 % more"
    ),
    (
        "shapes/sphere.py sample: _GAMMA_12 * dot(absolute_vec3(gather_vec3(data, k)), "
        "lanes_vec3(1.0)) -> (_GAMMA_12)"
    ): (
        "a bound safe on either side: centre less point is exact up to its own rounding, which "
        "`shadow_length` adds"
    ),
    "textures/bitmap.py _folded: 1.0 -> 1.02 (2)": (
        "columns beyond the last one are that one, see `_neighbours`"
    ),
    "textures/bitmap.py _folded: 1.0 -> 1.02 (3)": (
        "columns beyond the last one are that one, see `_neighbours`"
    ),
    "textures/composed.py _pop_two.two: operate(params, s.b, s.a) -> operate(params, s.a, s.b)": (
        "sums and products are the only textures of two parts, and both commute"
    ),
    "view/movable.py Movable.coarse_job: height - 1 -> ((height) + (1))": (
        "a second guard: a row of the picture over 4 is below its height over 4, rounded up"
    ),
    "view/shades.py _spread: 1.0 -> 1.02": "divides 0 where all pixels are alike",
    "bsdfs/normals/coat_normals.py axes_of: own.normal.x -> own.normal.y": (
        "times 0: it gives a number its lanes"
    ),
    "integrators/shadow_rays.py transmittance_through_holes: crossing.passed.x -> "
    "crossing.passed.y": ("without media nothing colours what is passed: 0 or 1 in all channels"),
    "metrics/survey.py _bands: 1 -> 2": ("two rows lie in one band, which is all of them"),
    "films/sample_ranges.py SampleRanges.union: _union(self, other) -> _union(other, self)": (
        "ranges are put in order whichever come first"
    ),
    "rendering/tiles/tile_kernel.py next_samples: 3 * LANES -> (LANES) (2)": (
        "lanes without a sample have another replicate's number, and nobody sees what they do"
    ),
}
