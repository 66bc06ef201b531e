"""Bugs of layers and textures of materials."""

from tests.mutants.mutant import Mutant

LAWS = "tests/physics/test_bsdf_laws.py"
BITMAPS = "tests/textures/test_bitmap.py"
LAYERED = "tests/physics/test_layered_models.py"

MATERIALS = (
    Mutant(
        "coat sampled with another probability than stated",
        "bsdfs/plastic.py",
        (("mirrored = u < share", "mirrored = u < 0.5 * share"),),
        f"{LAWS}::test_white_furnace_of_lossless_models",
    ),
    Mutant(
        "weight of a blend taken for the other part",
        "bsdfs/blend.py",
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
        "bsdfs/mask.py",
        (
            (
                'Part(Null(), "rest"), Part(self.bsdf, "weight")',
                'Part(Null(), "weight"), Part(self.bsdf, "rest")',
            ),
        ),
        f"{LAYERED}::test_holes_of_a_mask_let_light_straight_on",
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
        (("_neighbours(1.0 - _folded(t, wrap_v), h", "_neighbours(_folded(t, wrap_v), h"),),
        f"{BITMAPS}::test_lookups_are_those_of_mitsuba[repeat-bilinear]",
    ),
    Mutant(
        "texels half a texel off",
        "textures/bitmap.py",
        (("f * size - 0.5", "f * size"),),
        f"{BITMAPS}::test_bilinear_is_the_formula_over_an_endless_picture[mirror]",
    ),
)
