"""Every input of the surface shaders matters, each channel by itself, or is told to be left out."""

import pytest

from alight.formats.materialx import gltf_pbr, open_pbr, preview_surface, standard_surface
from tests.formats.materialx.reading import document, parsed, value

SHADERS = {
    "UsdPreviewSurface": preview_surface.INPUTS, "gltf_pbr": gltf_pbr.INPUTS,
    "open_pbr_surface": open_pbr.INPUTS, "standard_surface": standard_surface.INPUTS,
}  # fmt: skip
#: Inputs that are no numbers: their type and another value than the default.
WORDS = {
    "thin_walled": ("boolean", "true"), "geometry_thin_walled": ("boolean", "true"),
    "alpha_mode": ("integer", "2"), "opacityMode": ("integer", "1"),
    "useSpecularWorkflow": ("integer", "1"),
}  # fmt: skip
#: Numbers that count only as to which side of a border they are on.
OTHER = {"alpha_cutoff": 0.1, "thickness": 0.0}
#: A little of everything, so that whatever an input weighs is there: mixed, of glass alone, of
#: metal, thin, and cut out.
KINDS = (
    {}, {"metalness": 0.0, "base_metalness": 0.0, "metallic": 0.0, "transmission": 1.0,
         "transmission_weight": 1.0, "thickness": 0.0},
    {"transmission": 0.0, "transmission_weight": 0.0}, {"alpha_mode": 1}, {"alpha_mode": 2},
    {"useSpecularWorkflow": 1}, {"opacityThreshold": 0.0},
)  # fmt: skip
#: Inputs of what is told to be left out as a whole. Occlusion is worked out.
PARTS = {
    "coat_rotation", "occlusion", "subsurface_anisotropy", "subsurface_radius",
    "subsurface_radius_scale", "subsurface_scale", "subsurface_scatter_anisotropy",
    "transmission_scatter_anisotropy",
}  # fmt: skip


def written(name, number):
    """An input."""
    if name in WORDS:
        default = {"boolean": "false", "integer": "0"}[WORDS[name][0]]
        return value(name, WORDS[name][0], number or default)
    if isinstance(number, tuple):
        return value(name, "color3", ", ".join(map(str, number)))
    return value(name, "float", number)


def outcome(category, inputs, folder):
    """What a document becomes, and what is said."""
    shader = "".join(written(name, number) for name, number in inputs.items())
    found = parsed(document(shader, category=category), folder)
    return repr(found.data), repr(found.warnings)


def lively(defaults):
    """Every input at a value of its own."""
    found = {}
    for place, (name, default) in enumerate(defaults.items()):
        if isinstance(default, tuple):
            found[name] = tuple(c + 0.005 * place for c in (0.2, 0.4, 0.6))
        elif name in WORDS:
            found[name] = ""
        else:
            found[name] = (1.7 if "ior" in name.lower() else 0.4) + 0.005 * place
    return found


def others(name, number):
    """Other values: a number, or a colour in each of its channels."""
    if name in WORDS:
        return [WORDS[name][1]]
    if isinstance(number, tuple):
        return [tuple(c + 0.1 * (i == k) for k, c in enumerate(number)) for i in range(3)]
    return [OTHER.get(name, number + 0.1)]


def counts(category, name, folder):
    """Whether an input matters, or is told where it is not neutral."""
    defaults = SHADERS[category]
    for kind in KINDS:
        inputs = lively(defaults)
        inputs |= {key: number for key, number in kind.items() if key in inputs and key != name}
        base = outcome(category, inputs, folder)
        found = [outcome(category, inputs | {name: o}, folder) for o in others(name, inputs[name])]
        if len({base, *found}) == 1 + len(found):
            return True
        neutral = (defaults[name], 0.0) if name not in WORDS else ()
        if any(outcome(category, inputs | {name: n}, folder)[1] != base[1] for n in neutral):
            return True
    return False


@pytest.mark.parametrize("category", SHADERS)
def test_every_input_of_a_shader_counts(category, tmp_path):
    silent = {name for name in SHADERS[category] if not counts(category, name, tmp_path)}
    assert silent <= PARTS
