"""Bugs of scattering at surfaces, and the directions and frames it is drawn in."""

from tests.mutants.mutant import Mutant

LAWS = "tests/laws/test_bsdfs.py::test_it_obeys_the_laws_of_bsdfs"
MEASURED = "tests/physics/test_measured.py"
TWO_SIDES = "tests/physics/test_two_sides.py::test_each_side_is_that_of_its_material"

SCATTERING = (
    Mutant(
        "value of a BSDF without the cosine",
        "bsdfs/matte/diffuse.py",
        (("cosine = where(above, INV_PI * wi.z, 0.0)", "cosine = where(above, INV_PI, 0.0)"),),
        f"{LAWS}[diffuse-0]",
    ),
    Mutant(
        "eta for eta^2 in refracted radiance",
        "bsdfs/dielectrics/dielectric.py",
        (("where(reflects, 1.0, 1.0 / (eta * eta))", "where(reflects, 1.0, 1.0 / eta)"),),
        f"{LAWS}[dielectric-0]",
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
        f"{LAWS}[dielectric-0]",
    ),
    Mutant(
        "density of the other way of sampling",
        "bsdfs/matte/diffuse.py",
        (("where(above, INV_TWO_PI, 0.0)", "cosine"),),
        f"{LAWS}[diffuse-1]",
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
        "fronts for backs",
        "bsdfs/dispatch.py",
        (("where(wo.z < 0.0, lanes_u32(FRONT", "where(wo.z > 0.0, lanes_u32(FRONT"),),
        TWO_SIDES,
    ),
    Mutant(
        "two-sided surface that is chosen from both sides",
        "bsdfs/dispatch.py",
        (
            (
                "row_new, share_new = layer_seen(scene, surface, wo, i, more)",
                "row_new, share_new = layer_of(scene, surface, i, more)",
            ),
        ),
        TWO_SIDES,
    ),
    Mutant(
        "back inside what shows its front twice",
        "bsdfs/nesting.py",
        (('if spec.makes_two_sided and leaf.side == "back"', 'if leaf.side == "none"'),),
        TWO_SIDES,
    ),
    Mutant(
        "azimuths of measured facets not from that of the viewer",
        "bsdfs/measured/measured.py",
        (
            (
                "_to_square(elevation, arctan2(wm.y, wm.x) - turned)",
                "_to_square(elevation, arctan2(wm.y, wm.x))",
            ),
        ),
        f"{MEASURED}::test_values_are_those_of_the_metal[0.6]",
    ),
    Mutant(
        "half of the measured quarters taken for the other",
        "bsdfs/measured/measured.py",
        (("x = where(turns >= 4.0, -copysign(1.0, wo.x), y)", "x = y"),),
        f"{MEASURED}::test_grain_lies_as_that_of_the_metal",
    ),
    Mutant(
        "measured grain without the tangents of shapes",
        "bsdfs/measured/measured.py",
        (("return (ANISOTROPIC,) if turns else ()", "return ()"),),
        f"{MEASURED}::test_only_what_has_a_grain_needs_the_tangents_of_shapes",
    ),
    Mutant(
        "measured directions of the viewer not mixed",
        "bsdfs/measured/warp.py",
        (("return a + viewed.of_elevation * (b - a)", "return a"),),
        f"{MEASURED}::test_between_measured_directions_densities_are_mixed",
    ),
    Mutant(
        "wrong root within a texel",
        "bsdfs/measured/warp.py",
        (("a * a + 2.0 * (b - a) * rest", "a * a + (b - a) * rest"),),
        f"{MEASURED}::test_points_of_the_square_come_back",
    ),
    Mutant(
        "the loss of a reduced spectrum after one reflection, where it says two",
        "core/spectra.py",
        (("color = _seen(spectrum**times,", "color = _seen(spectrum,"),),
        "tests/core/test_spectra.py::test_a_grey_is_off_by_the_reduction_of_white_alone",
    ),
    Mutant(
        "the loss of a reduced spectrum without what sRGB cannot show",
        "core/spectra.py",
        (
            (
                "np.clip(_seen(spectrum, shines=shines), 0.0,",
                "np.clip(_seen(spectrum, shines=shines), -9.0,",
            ),
        ),
        "tests/core/test_spectra.py::test_what_srgb_cannot_show_is_what_a_line_is_off_by",
    ),
    Mutant(
        "reflected spectra seen in no daylight",
        "core/spectra.py",
        (
            (
                "return weights / weights.sum(axis=1, keepdims=True)",
                "return weights / weights.sum()",
            ),
        ),
        f"{MEASURED}::test_spectra_are_reduced_in_daylight_and_it_is_said",
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
