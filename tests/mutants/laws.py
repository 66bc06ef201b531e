"""Bugs that the laws of a family must find, one for each law."""

from tests.mutants.mutant import Mutant

LAWS_OF = "tests/laws/test_every_model.py::test_it_obeys_the_laws_of_its_family"

LAWS = (
    Mutant(
        "directions of the orthographic camera not of unit length",
        "cameras/orthographic.py",
        (
            (
                "lanes_vec3(0.0) + vector(table, FORWARD)",
                "lanes_vec3(1e-3) + vector(table, FORWARD)",
            ),
        ),
        f"{LAWS_OF}[cameras-orthographic]",
    ),
    Mutant(
        "rays of the pinhole camera through the middles of the film's halves",
        "cameras/pinhole.py",
        (("vector(table, FORWARD) + x *", "vector(table, FORWARD) + 0.5 * x *"),),
        f"{LAWS_OF}[cameras-pinhole]",
    ),
    Mutant(
        "rays of a lens as far apart behind it as in it",
        "cameras/thin_lens.py",
        (("normalize(table[FOCUS] * axis - lens)", "normalize(table[FOCUS] * axis)"),),
        f"{LAWS_OF}[cameras-thin_lens]",
    ),
    Mutant(
        "samples of a lens crowd at its centre",
        "cameras/thin_lens.py",
        (
            (
                "lens_x, lens_y = square_to_disk_concentric(u_lens)",
                "lens_x, lens_y = (c * u_lens[0] for c in square_to_disk_concentric(u_lens))",
            ),
        ),
        f"{LAWS_OF}[cameras-thin_lens]",
    ),
    Mutant(
        "weights of the tent filter 2 % too large",
        "filters/tent.py",
        (("lanes(1.0)", "lanes(1.02)"),),
        f"{LAWS_OF}[filters-tent]",
    ),
    Mutant(
        "the box filter to the right of its pixel",
        "filters/box.py",
        (("r * (2.0 * u2[0] - 1.0)", "r * (2.0 * u2[0] - 0.98)"),),
        f"{LAWS_OF}[filters-box]",
    ),
    Mutant(
        "tails of the Gaussian filter too long",
        "filters/inverse_cdf.py",
        (("sqrt(2.0 * minimum(u, 1.0 - u))", "2.0 * minimum(u, 1.0 - u)"),),
        f"{LAWS_OF}[filters-gaussian]",
    ),
    Mutant(
        "negative lobes of a filter counted as positive",
        "filters/mitchell.py",
        (
            (
                "profile(x / half, spec.b, spec.c), spec.radius, change)",
                "profile(x / half, spec.b, spec.c), spec.radius)",
            ),
        ),
        f"{LAWS_OF}[filters-mitchell]",
    ),
    Mutant(
        "the largest value of a checkerboard is that of one colour",
        "textures/checkerboard.py",
        (("(max(pair) for pair", "(min(pair) for pair"),),
        f"{LAWS_OF}[textures-checkerboard]",
    ),
    Mutant(
        "the mean of a sum of textures without one of them",
        "textures/add.py",
        (("_sum(average(self.a), average(self.b))", "_sum(average(self.a), average(self.a))"),),
        f"{LAWS_OF}[textures-add]",
    ),
)
