"""Bugs of light paths: where they start, on their way, and where they arrive."""

from tests.mutants.mutant import Mutant

LAWS_OF = "tests/laws/test_every_model.py::test_it_obeys_the_laws_of_its_family"
SCENES = "tests/lights/test_emission.py"
TRACING = "tests/rendering/test_light_tracing.py::test_it_finds_what_path_tracing_finds"

EMISSION = (
    Mutant(
        "a light path forgets how likely its light was",
        "lights/emission/sampling.py",
        (("flux=e.flux * (1.0 / choice)", "flux=e.flux"),),
        f"{SCENES}::test_rays_of_several_lights_carry_the_power_of_all[lamps]",
    ),
    Mutant(
        "light leaves a lamp in all directions alike",
        "lights/emission/from_shapes.py",
        (
            ("import square_to_cosine_hemisphere", "import square_to_uniform_hemisphere"),
            ("square_to_cosine_hemisphere(v2)", "square_to_uniform_hemisphere(v2)"),
        ),
        f"{LAWS_OF}[lights-area]",
    ),
    Mutant(
        "light paths leave a rectangle from one half of it",
        "shapes/rectangle.py",
        (
            (
                "x, y = 2.0 * u2[0] - 1.0, 2.0 * u2[1] - 1.0\n    p =",
                "x, y = u2[0], 2.0 * u2[1] - 1.0\n    p =",
            ),
        ),
        f"{LAWS_OF}[shapes-rectangle]",
    ),
    Mutant(
        "the flux of a shape without its pi",
        "lights/emission/from_shapes.py",
        (("PI / where(drawn, pdf, 1.0)", "1.0 / where(drawn, pdf, 1.0)"),),
        f"{LAWS_OF}[lights-area]",
    ),
    Mutant(
        "light that a map leaves to BSDF sampling starts no path",
        "lights/emission/from_environments.py",
        (("rest = lanes(0.0) + left_out(scene, back)", "rest = lanes(0.0)"),),
        f"{LAWS_OF}[lights-environment]",
    ),
    Mutant(
        "lines through a portal not in the density",
        "lights/emission/from_environments.py",
        (("share = 0.5 / len(windows)", "share = 0.0"),),
        f"{SCENES}::test_rays_of_several_lights_carry_the_power_of_all[windows among lamps]",
    ),
    Mutant(
        "light from infinity through a disk of twice the area",
        "lights/ball.py",
        (
            (
                "(radius * x) * s + (radius * y) * t",
                "1.4142 * ((radius * x) * s + (radius * y) * t)",
            ),
        ),
        f"{LAWS_OF}[lights-directional]",
    ),
    Mutant(
        "a spot's density without its cone",
        "lights/spot.py",
        (("lanes(0.0) + uniform_cone_pdf(opening)", "lanes(0.15915494)"),),
        f"{LAWS_OF}[lights-spot]",
    ),
    Mutant(
        "the edge of a cell of a lamp's profile too near to the axis",
        "lights/ies.py",
        (("return 2.0 * inner * inner,", "return inner * inner,"),),
        f"{LAWS_OF}[lights-ies]",
    ),
    Mutant(
        "areas of a projector's picture as solid angles",
        "lights/projector.py",
        (("(0.25 * sqrt(stretch)) / (z * z * z)", "(0.25 * sqrt(stretch)) / (z * z)"),),
        f"{LAWS_OF}[lights-projector]",
    ),
    Mutant(
        "a moving lamp's light paths start where it rests",
        "lights/emission/sampling.py",
        (("turning, placed(m, e.p)), e.p)", "turning, e.p), e.p)"),),
        f"{SCENES}::test_moving_lights_emit_where_they_are[0.4]",
    ),
    Mutant(
        "light paths seen without Veach's correction for shading normals",
        "integrators/light.py",
        (
            (
                "corrected = absolute(dot(surface.ng, c.w)) * per_cos * c.importance",
                "corrected = absolute(dot(surface.ns, c.w)) / absolute(wl.z) * c.importance",
            ),
        ),
        f"{TRACING}[points and directions by a lens, shading normals]",
    ),
    Mutant(
        "flux is concentrated in glass as radiance is",
        "integrators/both_ends/light_walk.py",
        (("turned = turned * inside / outside", "turned = turned * 1.0"),),
        f"{TRACING}[under water]",
    ),
    Mutant(
        "splats over one pixel too few",
        "rendering/tiles/light_tile.py",
        (("(1.0 / as_float(width * height))", "(1.0 / as_float(width * height - width))"),),
        f"{TRACING}[a lamp]",
    ),
    Mutant(
        "the importance of a pinhole per pixel of the picture's middle",
        "cameras/connection.py",
        (("stretch * stretch * stretch /", "stretch /"),),
        f"{LAWS_OF}[cameras-pinhole]",
    ),
    Mutant(
        "points of a thin lens as if it were in its middle",
        "cameras/connection.py",
        (("across * per_ahead + lens_x / table[FOCUS]", "across * per_ahead"),),
        f"{LAWS_OF}[cameras-thin_lens]",
    ),
    Mutant(
        "negative lobes of a filter splatted as positive ones",
        "filters/splatting.py",
        (("where(g < 0.0, -total, total)", "total"),),
        f"{LAWS_OF}[filters-mitchell]",
    ),
    Mutant(
        "a cancelled pass of light paths stays in the film",
        "rendering/job.py",
        (("if apart and not cancel.is_set():", "if apart:"),),
        "tests/rendering/test_light_tracing.py::test_a_pass_that_is_cut_short_leaves_nothing",
    ),
)
