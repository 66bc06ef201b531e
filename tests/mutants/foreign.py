"""Bugs of readers of foreign files: colours, flags, and inputs of shaders."""

from tests.mutants.mutant import Mutant

PBRT_COLORS = "tests/formats/pbrt/test_every_colour_and_flag_counts.py"
MITSUBA_COLORS = (
    "tests/formats/mitsuba/test_every_colour_and_flag_counts.py::"
    "test_colours_have_their_defaults_and_each_channel_matters"
)

FOREIGN = (
    Mutant(
        "a substrate that is half as shiny",
        "formats/pbrt/materials_of_3.py",
        (('_tint(m, "Ks", 0.5)', '_tint(m, "Ks", 0.25)'),),
        f"{PBRT_COLORS}::test_colours_have_their_defaults_and_each_channel_matters[Material]",
    ),
    Mutant(
        "a lamp of Mitsuba that is given no colour",
        "formats/mitsuba/emitters.py",
        (('light.color("irradiance", 1.0)', 'light.color("irradiance", 0.5)'),),
        f"{MITSUBA_COLORS}[emitter-directional-irradiance]",
    ),
    Mutant(
        "a coat of glTF that is as rough as it is strong",
        "formats/materialx/gltf_pbr.py",
        (('get["clearcoat_roughness"]', 'get["clearcoat"]'),),
        "tests/formats/materialx/test_every_input_counts.py::"
        "test_every_input_of_a_shader_counts[gltf_pbr]",
    ),
)
