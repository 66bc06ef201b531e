"""Bugs of layers and textures of materials."""

from tests.mutants.mutant import Mutant

LAWS = "tests/laws/test_bsdfs.py::test_it_obeys_the_laws_of_bsdfs[plastic-0]"
BITMAPS = "tests/textures/test_bitmap.py"
LAYERED = "tests/physics/test_layered_models.py"
COATS = "tests/physics/test_coated_conductor.py"

MATERIALS = (
    Mutant(
        "coat sampled with another probability than stated",
        "bsdfs/plastics/plastic.py",
        (("mirrored = u < chance", "mirrored = u < 0.5 * chance"),),
        LAWS,
    ),
    Mutant(
        "weight of a blend taken for the other part",
        "bsdfs/adapters/blend.py",
        (
            (
                'Part(self.bsdfs[0], "rest"), Part(self.bsdfs[1], "weight")',
                'Part(self.bsdfs[0], "weight"), Part(self.bsdfs[1], "rest")',
            ),
        ),
        f"{LAYERED}::test_values_and_densities_are_weighted_sums",
    ),
    Mutant(
        "opacity taken for transparency",
        "bsdfs/adapters/mask.py",
        (
            (
                'Part(Null(), "rest", is_hole=True), Part(self.bsdf, "weight")',
                'Part(Null(), "weight", is_hole=True), Part(self.bsdf, "rest")',
            ),
        ),
        f"{LAYERED}::test_holes_of_a_mask_let_light_straight_on",
    ),
)

COATED = (
    Mutant(
        "light that a coat throws back to the metal is lost",
        "bsdfs/microfacets/layered.py",
        (("bounce @ (leaving + again @ out)", "bounce @ leaving"),),
        f"{COATS}::test_albedo_is_that_of_walks_between_the_layers[rough]",
    ),
    Mutant(
        "masking of coated layers in which heights are not correlated",
        "bsdfs/microfacets/layered.py",
        (("before / (before + after)", "1.0 / (1.0 + after)"),),
        f"{COATS}::test_albedo_is_that_of_walks_between_the_layers[smooth metal]",
    ),
    Mutant(
        "a grey coat dims light on its way down only",
        "bsdfs/microfacets/layered.py",
        (("kept * crossing(np.maximum(cosine, 1e-7), layers.thickness)", "kept * 1.0"),),
        f"{COATS}::test_one_bounce_through_a_grey_coat_is_a_product",
    ),
    Mutant(
        "a coated metal scaled on one way only",
        "bsdfs/conductors/coated_conductor.py",
        (("_scale(params, wo.z) * _scale(params, wi.z)", "_scale(params, wo.z)"),),
        f"{COATS}::test_the_lobe_has_the_albedo_of_the_table[rough]",
    ),
    Mutant(
        "what a rough coat scatters left out of the metal's lobe",
        "bsdfs/microfacets/layered.py",
        (("0.5 * (bends * layers.coat_alpha) ** 2", "0.0 * bends"),),
        f"{COATS}::test_light_goes_where_the_walks_send_it[smooth metal-0.25]",
    ),
    Mutant(
        "samples of a coated metal that go to all sides left out of the density",
        "bsdfs/conductors/coated_conductor.py",
        (("(1.0 - params.wide) * pdf + params.wide * (INV_PI * wi.z)", "pdf * 1.0"),),
        f"{COATS}::test_the_lobe_has_the_albedo_of_the_table[very rough]",
    ),
    Mutant(
        "pbrt's matte base dimmed on one way through the coat",
        "formats/pbrt/walks.py",
        (("(walked.passed / passed) ** 2", "(walked.passed / passed)"),),
        f"{COATS}::test_matte_bases_of_pbrt_are_plastic_with_another_base[0.0-0.002]",
    ),
    Mutant(
        "events of pbrt's walks taken for bounces",
        "formats/pbrt/materials.py",
        (("(depth + 1) // 2", "depth"),),
        "tests/formats/pbrt/test_objects.py::test_layers_over_metal_keep_their_numbers",
    ),
)

TEXTURES = (
    Mutant(
        "pictures of whole numbers taken for linear",
        "textures/images.py",
        (("(decode_srgb(values) if encoded else values)", "(values)"),),
        f"{BITMAPS}::test_whole_numbers_are_srgb_unless_they_are_data",
    ),
    Mutant(
        "pictures upside down",
        "textures/bitmap.py",
        (("_neighbours(1.0 - _folded(t, wrap_v), p", "_neighbours(_folded(t, wrap_v), p"),),
        f"{BITMAPS}::test_lookups_are_those_of_mitsuba[repeat-bilinear]",
    ),
    Mutant(
        "texels half a texel off",
        "textures/bitmap.py",
        (("f * size - 0.5", "f * size"),),
        f"{BITMAPS}::test_bilinear_is_the_formula_over_an_endless_picture[mirror]",
    ),
    Mutant(
        "one corner of four of a picture of bytes read elsewhere",
        "textures/bitmap.py",
        (("_small(texels, d, table)", "_small(texels, table, d)"),),
        "tests/textures/test_bitmap.py::test_how_a_picture_is_kept_does_not_change_it",
    ),
)
