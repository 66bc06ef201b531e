"""Every input of UsdPreviewSurface, by double entry (decision 38), and of which workflow it is.

Source: Pixar, "UsdPreviewSurface specification", version 2.6.
"""

import pytest

from alight.core.spec import Spec
from alight.formats.usd.materials import INPUTS
from tests.formats.usd.stage import SQUARE, usd_loader

pytest.importorskip("pxr")

#: Type, default and another value of each input, as the specification has them.
SPECIFICATION = {
    "diffuseColor": ("color3f", "(0.18, 0.18, 0.18)", "(0.3, 0.5, 0.7)"),
    "emissiveColor": ("color3f", "(0, 0, 0)", "(0.3, 0.5, 0.7)"),
    "useSpecularWorkflow": ("int", "0", "1"),
    "specularColor": ("color3f", "(0, 0, 0)", "(0.3, 0.5, 0.7)"),
    "metallic": ("float", "0", "0.3"),
    "roughness": ("float", "0.5", "0.3"),
    "clearcoat": ("float", "0", "0.3"),
    "clearcoatRoughness": ("float", "0.01", "0.3"),
    "opacity": ("float", "1", "0.3"),
    "opacityMode": ("token", '"transparent"', '"presence"'),
    "opacityThreshold": ("float", "0", "0.3"),
    "ior": ("float", "1.5", "1.3"),
    "normal": ("normal3f", "(0, 0, 1)", "(0.3, 0, 0.9)"),
    "displacement": ("float", "0", "0.3"),
    "occlusion": ("float", "1", "0.3"),
}
SPECULAR = {"useSpecularWorkflow": "1"}
#: What some need beside them; and those without an effect of their own.
NEEDS = {
    "clearcoatRoughness": {"clearcoat": "0.5"}, "opacityMode": {"opacity": "0.5"},
    "opacityThreshold": {"opacity": "0.5"}, "specularColor": SPECULAR,
}  # fmt: skip
WITHOUT = {"occlusion"}
#: What plays no part in the workflow of metals, and in that of specular colours.
OF_THE_OTHER = [("specularColor", {}), ("metallic", SPECULAR), ("ior", SPECULAR)]


def rounded(value):
    """All fields of descriptions, numbers to six digits."""
    if isinstance(value, Spec):
        return [type(value).__name__, *([name, rounded(item)] for name, item in value)]
    if isinstance(value, list | tuple):
        return [rounded(item) for item in value]
    return f"{value:.6g}" if isinstance(value, float) else str(value)


@pytest.fixture
def outcome(tmp_path):
    load = usd_loader(tmp_path)

    def run(values):
        lines = "\n".join(
            f"        {SPECIFICATION[name][0]} inputs:{name} = {value}"
            for name, value in values.items()
        )
        scene = load(f"""
def Material "m" {{
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
{lines}
        token outputs:surface
    }}
}}
def Mesh "mesh" (prepend apiSchemas = ["MaterialBindingAPI"]) {{{SQUARE}
    rel material:binding = </m>
}}
""")
        # OpenUSD has single precision.
        lights = [node.light for _, _, node in scene.walk()]
        return (
            rounded([*scene.bsdfs.values(), *lights]),
            repr(scene.warnings),
            repr(scene.source.remarks),
            [node.shape.displacement_scale for _, _, node in scene.walk() if node.shape],
        )

    return run


def test_inputs_have_their_defaults_and_matter(outcome):
    assert set(SPECIFICATION) == set(INPUTS)
    for name, (_, default, other) in SPECIFICATION.items():
        needs = NEEDS.get(name, {})
        silent = outcome(needs)
        assert outcome({**needs, name: default}) == silent, name
        if name not in WITHOUT:
            assert outcome({**needs, name: other}) != silent, name


@pytest.mark.parametrize(("name", "needs"), OF_THE_OTHER, ids=[name for name, _ in OF_THE_OTHER])
def test_inputs_of_the_other_workflow_play_no_part(name, needs, outcome):
    color = {"specularColor": "(0.2, 0.2, 0.2)"} if needs else {}
    other = SPECIFICATION[name][2]
    assert outcome({**needs, **color, name: other})[0] == outcome({**needs, **color})[0]


def test_what_is_only_present_in_part_is_no_approximation(outcome):
    """Of `presence` reflections go with the surface, as ours do."""
    faint = {"opacity": "0.5"}
    assert "opacity: rays pass" in str(outcome(faint))
    assert "opacity: rays pass" not in str(outcome({**faint, "opacityMode": '"presence"'}))
