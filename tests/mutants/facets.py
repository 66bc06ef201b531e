"""Bugs of rough surfaces."""

from tests.mutants.mutant import Mutant

ROUGH = "tests/physics/test_rough_models.py"

FACETS = (
    Mutant(
        "wrong Jacobian of the half vector",
        "bsdfs/conductors/rough_conductor.py",
        (("pdf = 0.25 * facet_density", "pdf = 0.5 * facet_density"),),
        "tests/laws/test_bsdfs.py::test_it_obeys_the_laws_of_bsdfs[rough_conductor-0]",
    ),
    Mutant(
        "G1 for G: no shadow on the way in",
        "bsdfs/conductors/rough_conductor.py",
        (("where(above, masking, 0.0)", "where(above, 1.0 + 0.0 * masking, 0.0)"),),
        f"{ROUGH}::test_rough_metal_is_walters_formula[beckmann]",
    ),
    Mutant(
        "radiance through a rough interface without 1 / eta^2",
        "bsdfs/dielectrics/rough_dielectric.py",
        (("(masking / (eta * eta))", "(masking + 0.0 * eta)"),),
        f"{ROUGH}::test_glass_loses_only_what_meets_two_facets",
    ),
    Mutant(
        "indices of rough glass swapped",
        "bsdfs/dielectrics/rough_dielectric.py",
        (
            (
                "    eta = where(below, 1.0 / params.eta, params.eta)\n    weight, pdf = _scatter",
                "    eta = where(below, params.eta, 1.0 / params.eta)\n    weight, pdf = _scatter",
            ),
        ),
        f"{ROUGH}::test_rough_glass_is_walters_formula[ggx]",
    ),
    Mutant(
        "refraction with the Jacobian of reflection",
        "bsdfs/dielectrics/rough_dielectric.py",
        (
            (
                "jacobian = where(reflects, 0.25 * fresnel, refracted)",
                "jacobian = 0.25 * fresnel + 0.0 * refracted",
            ),
        ),
        f"{ROUGH}::test_rough_glass_is_walters_formula[ggx]",
    ),
    Mutant(
        "all facets for those that are seen",
        "core/microfacet.py",
        (
            (
                "facets.alpha_y, absolute(wo.z)))",
                "facets.alpha_y, 1e4 * absolute(wo.z)))",
            ),
        ),
        "tests/sampling/test_microfacet.py::test_visible_normals_follow_their_density",
    ),
    Mutant(
        "pane of one interface",
        "bsdfs/dielectrics/thin_dielectric.py",
        (("reflectance = 2.0 * once / (1.0 + once)", "reflectance = once"),),
        f"{ROUGH}::test_panes_add_up_all_inner_reflections[1.0]",
    ),
)
