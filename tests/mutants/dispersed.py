"""Bugs of glass that disperses light."""

from tests.mutants.mutant import Mutant

TESTS = "tests/physics/test_dispersion.py"

DISPERSED = (
    Mutant(
        "weights of a wavelength at every surface",
        "integrators/interiors/dispersed.py",
        (("first = active & ~path.monochromatic &", "first = active &"),),
        f"{TESTS}::test_white_glass_is_white",
    ),
    Mutant(
        "red light that is refracted most",
        "bsdfs/dielectrics/dispersion.py",
        (("return eta + (x - 1.0) * (a", "return eta - (x - 1.0) * (a"),),
        f"{TESTS}::test_a_prism_beside_media",
    ),
    Mutant(
        "all glass with one wavelength a path",
        "bsdfs/dielectrics/dispersion.py",
        (("return () if dispersion == 0.0 else (DISPERSIVE,)", "return (DISPERSIVE,)"),),
        f"{TESTS}::test_only_what_disperses_light_is_followed_by_wavelengths[dielectric]",
    ),
    Mutant(
        "blends that disperse light without weights",
        "compiled/materials.py",
        (("MIXED | SPREADS * any(map(_spreads, found))", "MIXED"),),
        f"{TESTS}::test_parts_of_a_blend_disperse_light_too",
    ),
    Mutant(
        "wavelengths by another density than their weights'",
        "core/wavelengths.py",
        (("(0.5 / _RATE) * log(", "(0.6 / _RATE) * log("),),
        f"{TESTS}::test_each_wavelength_has_the_colour_of_the_published_tables",
    ),
    Mutant(
        "Abbe's number with the lines exchanged",
        "bsdfs/dielectrics/dispersion.py",
        (("(_F**-2 - _C**-2)", "(_C**-2 - _F**-2)"),),
        "tests/physics/test_laws_of_dispersion.py::test_abbes_number_compares_the_lines_f_and_c",
    ),
    Mutant(
        "indices that spread in water as in air",
        "bsdfs/dielectrics/dispersion.py",
        (("number / outside for number in spread", "number for number in spread"),),
        "tests/physics/test_laws_of_dispersion.py"
        "::test_kernels_have_the_index_over_that_outside[1.33-bk7]",
    ),
    Mutant(
        "the last term of an index without its one",
        "bsdfs/dielectrics/dispersion.py",
        (("((x + 1.0) * x + 1.0) * c", "((x + 1.0) * x) * c"),),
        "tests/physics/test_laws_of_dispersion.py"
        "::test_kernels_have_the_index_over_that_outside[1.0-bk7]",
    ),
    Mutant(
        "materials with a name are not asked whether they disperse light",
        "scene/dispersion.py",
        (("return spec in known and disperses_light(known[spec], known)", "return False"),),
        "tests/physics/test_laws_of_dispersion.py"
        "::test_integrators_that_see_no_wavelengths_refuse_them_wherever_they_stand[as a part]",
    ),
)
