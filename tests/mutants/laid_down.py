"""Bugs of what other programs lay down: frames, formulas, spaces; and of what films hold."""

from tests.mutants.mutant import Mutant

PBRT = "tests/formats/pbrt/test_laws_of_cameras_and_films.py"
PBRT_LIGHTS = "tests/formats/pbrt/test_laws_of_lights.py"
PBRT_SHAPES = "tests/formats/pbrt/test_laws_of_shapes.py"
MITSUBA = "tests/formats/mitsuba/test_laws_of_frames.py"
MITSUBA_MORE = "tests/formats/mitsuba/test_laws_of_spectra_and_grids.py"
PLACES = "tests/formats/materialx/test_laws_of_places.py"
BRUSH = f"{PLACES}::test_brushes_stretch_facets_as_their_shader_says"
FILM = "tests/film/test_all_that_a_film_holds.py"
WRAPS = "tests/formats/usd/test_wraps_of_pictures.py"

LAID_DOWN = (
    Mutant(
        "a crop of pbrt that ends above its last row",
        "formats/pbrt/settings.py",
        (("[math.ceil(size[1] * y) for y in (y0, y1)]", "[int(size[1] * y) for y in (y0, y1)]"),),
        f"{PBRT}::test_crops_hold_the_pixels_that_pbrt_renders[0]",
    ),
    Mutant(
        "bounds of pixels by their corners",
        "formats/pbrt/settings.py",
        (
            (
                "ends = [int(x) for x in limits[:2]], [int(y) for y in limits[2:]]",
                "ends = [int(x) for x in limits[::2]], [int(y) for y in limits[1::2]]",
            ),
        ),
        f"{PBRT}::test_crops_hold_the_pixels_that_pbrt_renders[1]",
    ),
    Mutant(
        "an upright picture of pbrt whose angle lies across its height",
        "formats/pbrt/settings.py",
        (("else [-1.0, 1.0, -1 / aspect, 1 / aspect]", "else [-aspect, aspect, -1.0, 1.0]"),),
        f"{PBRT}::test_each_place_of_the_film_shows_what_it_does_in_pbrt[-perspective-size1]",
    ),
    Mutant(
        "a bell of pbrt by its variance",
        "formats/pbrt/settings.py",
        (("1.0 / math.sqrt(2.0 * alpha) if", "1.0 / (2.0 * alpha) if"),),
        f"{PBRT}::test_filters_are_those_of_pbrt[gaussian-True]",
    ),
    Mutant(
        "a shutter of pbrt 3 that exposes",
        "formats/pbrt/settings.py",
        (
            (
                "        return sorted((open_, close))",
                "        context.exposure *= close - open_\n        return sorted((open_, close))",
            ),
        ),
        f"{PBRT_LIGHTS}::test_what_exposes_the_film_brightens_every_light[point]",
    ),
    Mutant(
        "a lamp of pbrt that starts from where the world does",
        "formats/pbrt/lights.py",
        (
            (
                'place = _moved(matrix, p.triple("from", (0.0, 0.0, 0.0)))',
                'place = matrix[:3, 3] + p.triple("from", (0.0, 0.0, 0.0))',
            ),
        ),
        f"{PBRT_LIGHTS}::test_what_transforms_the_world_moves_a_light[point]",
    ),
    Mutant(
        "an illuminance that comes from below too",
        "formats/pbrt/lights.py",
        (("np.maximum(z, 0.0) * (square", "np.abs(z) * (square"),),
        f"{PBRT_LIGHTS}::test_illuminance_is_that_of_the_upper_half_as_pbrt_adds_it_up",
    ),
    Mutant(
        "a cubic term of roughness that is ten times as large",
        "formats/pbrt/roughness.py",
        (("x * (0.0171201", "x * (0.171201"),),
        f"{PBRT_LIGHTS}::test_roughness_of_pbrt_3_is_its_polynomial",
    ),
    Mutant(
        "two control points of a spline change places",
        "formats/pbrt/strands.py",
        (("[0, 4, 2, 0], [0, 2, 4, 0]", "[0, 2, 4, 0], [0, 4, 2, 0]"),),
        f"{PBRT_SHAPES}::test_splines_are_the_curves_that_their_points_define[4-3]",
    ),
    Mutant(
        "a hyperboloid that begins to turn at x",
        "formats/pbrt/shapes_of_3.py",
        (("z, u * phi + np.arctan2(y, x))", "z, u * phi)"),),
        f"{PBRT_SHAPES}::test_vertices_lie_where_their_coordinates_say[hyperboloid-0]",
    ),
    Mutant(
        "a bell of Mitsuba that ends at two pixels",
        "formats/mitsuba/films.py",
        (('draft.put("radius", 4.0 * stddev, "stddev")', 'draft.put("radius", 2.0, "stddev")'),),
        f"{MITSUBA}::test_filters_are_those_of_mitsuba[gaussian-True]",
    ),
    Mutant(
        "small matrices of Mitsuba by their columns",
        "formats/mitsuba/transforms.py",
        (("numbers.reshape(3, 3)", "numbers.reshape(3, 3).T"),),
        f"{MITSUBA}::test_transforms_apply_one_after_the_other[small matrix]",
    ),
    Mutant(
        "pictures of Mitsuba that are turned over before they are placed",
        "formats/mitsuba/textures.py",
        (
            (
                '[*steps, {"scale": [1.0, -1.0]}, {"translate": [0.0, 1.0]}]',
                '[{"scale": [1.0, -1.0]}, {"translate": [0.0, 1.0]}, *steps]',
            ),
        ),
        f"{MITSUBA}::test_bitmaps_are_looked_up_row_by_row_from_their_top[False]",
    ),
    Mutant(
        "half as much reflection as specular says",
        "formats/mitsuba/bsdfs.py",
        (("math.sqrt(0.08 *", "math.sqrt(0.04 *"),),
        f"{MITSUBA_MORE}::"
        "test_specular_is_the_reflection_straight_on_over_eight_per_cent[0.5]",
    ),
    Mutant(
        "regular spectra that end where eyes do",
        "formats/mitsuba/colors.py",
        (('p.number("wavelength_max", 830.0)', 'p.number("wavelength_max", 780.0)'),),
        f"{MITSUBA_MORE}::test_regular_spectra_begin_and_end_where_the_observer_does",
    ),
    Mutant(
        "the box of a grid moves its transform",
        "formats/mitsuba/interiors.py",
        (("rows = (matrix @ box_of(path, name))", "rows = (box_of(path, name) @ matrix)"),),
        f"{MITSUBA_MORE}::test_the_box_of_a_grid_is_moved_as_a_whole",
    ),
    Mutant(
        "sides of a cube upside down",
        "formats/mitsuba/shapes.py",
        (
            (
                "[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]",
                "[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]",
            ),
        ),
        f"{MITSUBA_MORE}::test_sides_of_a_cube_show_pictures_as_in_mitsuba",
    ),
    Mutant(
        "a space of ACES with television's primaries",
        "formats/materialx/spaces.py",
        (('"g22_ap1": (_gamma(2.2), _AP1)', '"g22_ap1": (_gamma(2.2), np.eye(3))'),),
        "tests/formats/materialx/test_laws_of_spaces.py::"
        "test_colours_are_those_of_their_primaries_and_curve[g22_ap1]",
    ),
    Mutant(
        "coordinates of OpenUSD that turn with the clock",
        "formats/materialx/placing.py",
        (
            (
                'rotate(-self.numbers(node, "rotation", (0.0,))[0])',
                'rotate(self.numbers(node, "rotation", (0.0,))[0])',
            ),
        ),
        f"{PLACES}::test_nodes_of_coordinates_are_their_formulas_one_after_the_other"
        "[UsdTransform2d]",
    ),
    Mutant(
        "a brush whose turns are degrees",
        "formats/materialx/standard_surface.py",
        (("2.0 * math.pi * turned", "math.radians(turned)"),),
        f"{BRUSH}[0.2-0.2]",
    ),
    Mutant(
        "a brush of OpenPBR that is strongest where it is weak",
        "formats/materialx/shading.py",
        (("2.0 / (1.0 + (1.0 - strength) ** 2)", "2.0 / (1.0 + strength**2)"),),
        f"{BRUSH}[0.2-0.2]",
    ),
    Mutant(
        "a picture whose wrap along u holds along v too",
        "formats/usd/textures.py",
        (("wrap = own[axis]", "wrap = own[0]"),),
        f"{WRAPS}::test_pictures_say_what_is_beyond_their_edges[png-wraps0]",
    ),
    Mutant(
        "a picture that is left along v is told of where it is left along u",
        "formats/usd/textures.py",
        (("along = table[:, :2] @ matrix[axis, :2]", "along = table[:, :2] @ matrix[0, :2]"),),
        f"{WRAPS}::test_a_picture_that_says_nothing_repeats_and_it_is_told_where_it_shows"
        "[1.5-1.0]",
    ),
    Mutant(
        "a film whose light came by chance is read as one that found it",
        "films/storage.py",
        (('film.by_chance = bool(described.get("by_chance"))', "film.by_chance = False"),),
        f"{FILM}::test_nothing_is_lost[file]",
    ),
    Mutant(
        "names of the first sample over all of them",
        "films/film.py",
        (("n = np.minimum(n, 1) if name in tiles.FIRST_SAMPLE_LAYERS else n", "n = n * 1"),),
        f"{FILM}::test_layers_that_name_things_hold_the_first_sample_whole",
    ),
    Mutant(
        "tables of a window by the rows of its tiles",
        "films/tiles.py",
        (("(top + y) * film.crop[2] + left", "(top + y) * partial.counts.shape[1] + left"),),
        f"{FILM}::test_tables_of_tiles_go_where_their_pixels_are",
    ),
    Mutant(
        "the error of alpha as if its mean were known",
        "films/readout.py",
        (("np.where(n > 1, n - 1.0, np.nan)", "np.where(n > 1, n, np.nan)"),),
        f"{FILM}::test_the_error_of_alpha_is_that_of_a_mean_of_hits",
    ),
    Mutant(
        "any lamp is the one that a chain was led to",
        "integrators/caustics/specular_chain.py",
        (("arrived & (surface.light == target.light + 1)", "arrived & (surface.light != 0)"),),
        "tests/estimators/test_chains_end_at_their_lamp.py::"
        "test_lamps_before_each_other_are_told_apart",
    ),
    Mutant(
        "waves of pbrt as fine as they are coarse",
        "formats/pbrt/patterns.py",
        (("(size * np.diag(linear)).tolist()", "(np.diag(linear) / size).tolist()"),),
        "tests/formats/pbrt/test_stand_ins.py::test_waves_are_finer_by_their_scale[marble-3.0]",
    ),
    Mutant(
        "two greens of a space change places",
        "formats/pbrt/colors.py",
        (("[-0.0196, -0.0786, 1.0982]", "[-0.0786, -0.0196, 1.0982]"),),
        f"{PBRT_LIGHTS}::test_colours_are_those_of_the_space_that_is_named[dci-p3-p3]",
    ),
    Mutant(
        "a bias that is a part of the light with it",
        "films/ledger.py",
        (("whole = mean - self.effect", "whole = mean + self.effect"),),
        "tests/film/test_laws_of_errors.py::"
        "test_a_bias_is_a_part_of_the_light_that_there_would_be_without_it[0.125]",
    ),
    Mutant(
        "a new size within the crop of the old one",
        "options/scene.py",
        (('["film.crop=null", f"film.size', '[f"film.size'),),
        "tests/options/test_sizes_and_crops.py::"
        "test_a_new_size_shows_all_of_the_picture_unless_a_crop_is_asked_for[48x36-None]",
    ),
    Mutant(
        "arms that are no pairs draw the same replicates",
        "lab/statistics/intervals.py",
        (("other = index if paired else", "other = index if above.size == below.size else"),),
        "tests/lab/test_lab_statistics.py::test_two_arms_that_are_not_pairs_share_no_noise",
    ),
    Mutant(
        "what moves in pbrt moves from nought to one",
        "formats/pbrt/transforms.py",
        (("pairs = zip(times, (begin, end)", "pairs = zip((0.0, 1.0), (begin, end)"),),
        f"{PBRT}::test_what_moves_is_where_pbrt_has_it_at_its_times",
    ),
    Mutant(
        "spectra of Mitsuba from red to blue",
        "formats/mitsuba/colors.py",
        (("return checked(wavelengths, values)", "return checked(wavelengths, values[::-1])"),),
        f"{MITSUBA_MORE}::test_regular_spectra_begin_and_end_where_the_observer_does",
    ),
    Mutant(
        "fog of pbrt that no shutter dims",
        "formats/pbrt/media.py",
        (("[scale * context.exposure * channel for", "[scale * channel for"),),
        f"{PBRT_LIGHTS}::test_what_exposes_the_film_brightens_lamps_and_fog[fog]",
    ),
    Mutant(
        "rays of a large moving camera are long",
        "cameras/rays.py",
        (("normalize(turned(m, d))", "turned(m, d)"),),
        "tests/motion/test_moving_cameras.py::"
        "test_rays_are_those_of_the_camera_where_it_is_then[pinhole]",
    ),
    Mutant(
        "hours of six minutes",
        "options/quantities.py",
        (('"h": 3600', '"h": 360'),),
        "tests/options/test_times.py::test_a_time_is_its_number_of_units[-1-h]",
    ),
    Mutant(
        "dissimilarity up to two",
        "metrics/dssim.py",
        (("return (1.0 - ssim(*planes)) / 2.0", "return 1.0 - ssim(*planes)"),),
        "tests/metrics/test_metrics_by_their_formulas.py::test_a_metric_is_its_formula[dssim]",
    ),
    Mutant(
        "strata of pbrt that are a square of those along x",
        "formats/pbrt/settings.py",
        (("spp = x * y\n", "spp = x * x\n"),),
        f"{PBRT}::test_strata_along_both_sides_are_multiplied",
    ),
    Mutant(
        "pictures that repeat where they should be black",
        "formats/usd/textures.py",
        (('found.append(_WRAPS.get(wrap, "clamp"))', 'found.append(_WRAPS.get(wrap, "repeat"))'),),
        f"{WRAPS}::test_black_beyond_the_edges_becomes_their_colour_and_it_is_told",
    ),
    Mutant(
        "noise that breaks off at the sides of its cells",
        "textures/noise.py",
        (("where(one_z, fz - 1.0, fz),", "where(one_z, fz + 1.0, fz),"),),
        "tests/textures/test_noise.py::test_it_goes_on_smoothly_from_cell_to_cell[2]",
    ),
    Mutant(
        "turbulence about the middle of its colours",
        "textures/noise.py",
        (("where(turbulent, mean, 0.5 + 0.5 * mean)", "0.5 + 0.5 * mean"),),
        "tests/textures/test_noise.py::"
        "test_patterns_are_weighted_means_of_octaves[1-0.5-turbulence]",
    ),
    Mutant(
        "each of two windows as likely as both",
        "lights/emission/from_environments.py",
        (("share = 0.5 / len(windows)", "share = 0.5"),),
        "tests/lights/test_lines_through_windows.py::"
        "test_the_mean_of_one_over_the_density_is_the_area_of_the_disk[2]",
    ),
    Mutant(
        "rows of a sun that reach down to the next ones",
        "lights/bright_disk.py",
        (("theta) + 0.5 * theta[1], 0.0", "theta) + theta[1], 0.0"),),
        "tests/lights/test_lines_through_windows.py::test_a_sun_has_the_light_of_its_texels[60]",
    ),
    Mutant(
        "searches of any density are taken",
        "integrators/caustics/manifold_sampling.py",
        (("return u * trial.most < density", "return density > 0.0"),),
        "tests/estimators/test_directions_near_solutions.py::"
        "test_a_search_is_taken_by_its_density_over_the_largest[0.7]",
    ),
    Mutant(
        "a picture is opaque if no texel is half clear",
        "textures/images.py",
        (("if (alpha >= opaque).all():", "if (alpha >= 0.5 * opaque).all():"),),
        "tests/textures/test_composed.py::"
        "test_a_picture_has_alpha_where_a_texel_is_not_quite_opaque[200]",
    ),
    Mutant(
        "a pixel is around itself",
        "metrics/surroundings.py",
        (
            (
                "cell /= np.maximum(spread_out(pixels[:, cells], *size) - 1.0, 1.0)",
                "cell /= np.maximum(spread_out(pixels[:, cells], *size), 1.0)",
            ),
        ),
        "tests/metrics/test_survey.py::"
        "test_what_is_around_a_pixel_is_the_mean_of_its_cell_without_it",
    ),
    Mutant(
        "kept references lie on their side",
        "lab/references.py",
        (("!= arm.size[::-1]:", "!= arm.size:"),),
        "tests/lab/test_references.py::test_a_kept_reference_of_another_size_is_not_taken",
    ),
    Mutant(
        "frames in a notebook that take as long as the render",
        "view/notebook.py",
        (("(1.0 / _SHARE - 1.0)", "(1.0 - _SHARE)"),),
        "tests/view/test_notebook.py::"
        "test_frames_take_their_share_of_the_time_and_no_more",
    ),
)  # fmt: skip
