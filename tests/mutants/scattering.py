"""Bugs of scattering at surfaces, and the directions and frames it is drawn in."""

from tests.mutants.mutant import Mutant

LAWS = "tests/laws/test_bsdfs.py"

SCATTERING = (
    Mutant(
        "value of a BSDF without the cosine",
        "bsdfs/matte/diffuse.py",
        (("cosine = where(above, INV_PI * wi.z, 0.0)", "cosine = where(above, INV_PI, 0.0)"),),
        LAWS,
    ),
    Mutant(
        "eta for eta^2 in refracted radiance",
        "bsdfs/dielectrics/dielectric.py",
        (("where(reflects, 1.0, 1.0 / (eta * eta))", "where(reflects, 1.0, 1.0 / eta)"),),
        LAWS,
    ),
    Mutant(
        "indices of refraction swapped",
        "bsdfs/dielectrics/dielectric.py",
        (
            (
                "where(wo.z > 0.0, params.eta, 1.0 / params.eta)",
                "where(wo.z < 0.0, params.eta, 1.0 / params.eta)",
            ),
        ),
        LAWS,
    ),
    Mutant(
        "density of the other way of sampling",
        "bsdfs/matte/diffuse.py",
        (("where(above, INV_TWO_PI, 0.0)", "cosine"),),
        LAWS,
    ),
    Mutant(
        "two-sided surface that turns only wo",
        "bsdfs/switch.py",
        (
            (
                "mirrored_if(back, wo), mirrored_if(back, wi), active",
                "mirrored_if(back, wo), wi, active",
            ),
        ),
        "tests/sampling/test_dispatch.py"
        "::test_the_back_of_a_two_sided_surface_looks_like_its_front",
    ),
    Mutant(
        "u for sqrt(u) in the disk",
        "core/warps.py",
        (("r = sqrt(u2[0])", "r = u2[0]"),),
        "tests/sampling/test_warps.py::test_disk_points_are_uniform",
    ),
    Mutant(
        "cosine-weighted directions without the root of the projection",
        "core/warps.py",
        (("sqrt(maximum(0.0, 1.0 - x * x - y * y))", "maximum(0.0, 1.0 - x * x - y * y)"),),
        "tests/sampling/test_warps.py::test_directions_follow_their_density",
    ),
    Mutant(
        "left-handed shading frame",
        "core/frame.py",
        (("cross(n, s), t0", "cross(s, n), t0"),),
        "tests/unit/test_frame.py::test_frame_from_tangent_is_right_handed_and_orthonormal",
    ),
    Mutant(
        "normals by the matrix, not its inverse transpose",
        "shapes/sphere.py",
        (
            (
                "gradient = transposed_times(data, k + INVERSE, q)",
                "gradient = times(data, k + MATRIX, q)",
            ),
        ),
        "tests/shapes/test_surfaces.py::test_normals_go_by_the_inverse_transpose",
    ),
    Mutant(
        "a coat of Burley's with 2 % too much density",
        "bsdfs/disney/burley.py",
        (("where(right, 0.25 * d * wm.z", "where(right, 0.255 * d * wm.z"),),
        "tests/physics/test_bsdf_formulas.py"
        "::test_the_coat_of_burley_is_its_formula_in_value_and_density",
    ),
)
