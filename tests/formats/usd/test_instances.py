"""OpenUSD: instances look as what stands in their place would, and share what looks alike."""

import pytest

from alight.scene.flatten import flatten
from tests.formats.usd.stage import SQUARE, usd_loader

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


def material(name, color, path=""):
    return f"""
def Material "{name}" {{
    token outputs:surface.connect = <{path}/{name}/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = {color}
        token outputs:surface
    }}
}}
"""


def look_of(bsdf):
    """The colour of a two-sided material."""
    inner = bsdf.bsdf
    return tuple(inner.base_color if inner.type == "principled" else inner.reflectance)


def colors(scene):
    """Colour of every shape, in the order of the file."""
    flat = flatten(scene)
    return [look_of(flat.bsdfs[item.bsdf]) for item in flat.shapes]


RED, GREEN, BLUE, GREY = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.18,) * 3
BOUND = 'prepend apiSchemas = ["MaterialBindingAPI"]'
MATERIALS = material("red", RED) + material("green", GREEN)
ASSET = f'class "_a" {{ def Mesh "m" {{{SQUARE}}} }}\n'
INSTANCE = "instanceable = true; inherits = </_a>"


def test_a_material_bound_on_an_instance_is_shown(load):
    scene = load(f"""{MATERIALS}{ASSET}
def "one" ({BOUND}; {INSTANCE}) {{ rel material:binding = </red> }}
def "two" ({BOUND}; {INSTANCE}) {{ rel material:binding = </green> }}
def "above" ({BOUND}) {{ rel material:binding = </green>
    def "three" ({INSTANCE}) {{ }}
}}
def "four" ({INSTANCE}) {{ }}
""")
    assert colors(scene) == [RED, GREEN, GREEN, GREY]
    # The second and the third look alike.
    assert len(scene.prototypes) == 3


def test_a_weaker_binding_above_an_instance_does_not_count(load):
    strong = '(bindMaterialAs = "strongerThanDescendants")'
    inside = f'def Mesh "m" ({BOUND}) {{{SQUARE}\nrel material:binding = </_a/blue> }}'
    asset = f'class "_a" {{ {material("blue", BLUE, "/_a")} {inside} }}'
    scene = load(f"""{MATERIALS}{asset}
def "weak" ({BOUND}; {INSTANCE}) {{ rel material:binding = </red> }}
def "strong" ({BOUND}; {INSTANCE}) {{ rel material:binding = </red> {strong} }}
""")
    assert colors(scene) == [BLUE, RED]


def test_a_material_at_the_root_of_an_asset_is_shown_and_shared(load):
    scene = load(f"""
class "_a" ({BOUND}) {{ rel material:binding = </_a/red>
    {material("red", RED, "/_a")}
    def Mesh "m" {{{SQUARE}}}
}}
def "one" ({INSTANCE}) {{ }}
def "two" ({INSTANCE}) {{ }}
""")
    assert colors(scene) == [RED, RED]
    assert len(scene.prototypes) == 1


def test_a_collection_above_instances_binds_its_members_only(load):
    both = 'prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:some"]'
    scene = load(f"""{MATERIALS}{ASSET}
def "world" ({both}) {{
    rel material:binding:collection:some = [</world.collection:some>, </red>]
    rel collection:some:includes = </world/two>
    def "one" ({INSTANCE}) {{ }}
    def "two" ({INSTANCE}) {{ }}
}}
""")
    assert colors(scene) == [GREY, RED]


def test_instances_inherit_display_colors(load):
    def color(value):
        return f"color3f[] primvars:displayColor = [{value}]"

    scene = load(f"""{ASSET}
def "one" ({INSTANCE}) {{ {color(RED)} }}
def "two" ({INSTANCE}) {{ {color(GREEN)} }}
def "three" ({INSTANCE}) {{ {color(RED)} }}
def "above" {{ {color(BLUE)}
    def Mesh "m" {{{SQUARE}}}
}}
""")
    assert colors(scene) == [RED, GREEN, RED, BLUE]
    assert len(scene.prototypes) == 2


def test_instances_within_instances_inherit_from_the_outer_ones(load):
    scene = load(f"""{MATERIALS}{ASSET}
class "_b" {{ def "inner" ({INSTANCE}) {{ }}
}}
def "one" ({BOUND}; instanceable = true; inherits = </_b>) {{ rel material:binding = </red> }}
def "two" ({BOUND}; instanceable = true; inherits = </_b>) {{ rel material:binding = </green> }}
""")
    assert colors(scene) == [RED, GREEN]


def test_prototypes_of_a_point_instancer_may_be_instances(load):
    scene = load(f"""{MATERIALS}{ASSET}
def PointInstancer "p" {{
    rel prototypes = [</p/one>, </p/two>]
    int[] protoIndices = [0, 1, 0]
    point3f[] positions = [(0, 0, 1), (0, 0, 2), (0, 0, 3)]
    def "one" ({BOUND}; {INSTANCE}) {{ rel material:binding = </red> }}
    def "two" ({BOUND}; {INSTANCE}) {{ rel material:binding = </green> }}
}}""")
    assert colors(scene) == [RED, GREEN, RED]


def test_a_point_instancer_within_instances_inherits_from_them(load):
    scene = load(f"""{MATERIALS}
class "_a" {{
    def PointInstancer "p" {{
        rel prototypes = </_a/p/one>
        int[] protoIndices = [0]
        point3f[] positions = [(0, 0, 1)]
        def Mesh "one" {{{SQUARE}}}
    }}
}}
def "one" ({BOUND}; {INSTANCE}) {{ rel material:binding = </red> }}
def "two" ({BOUND}; {INSTANCE}) {{ rel material:binding = </green> }}
""")
    assert colors(scene) == [RED, GREEN]


def test_one_material_shows_the_primvars_of_each_prim(load):
    reader = """
def Material "m" {
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/r.outputs:result>
        token outputs:surface
    }
    def Shader "r" {
        uniform token info:id = "UsdPrimvarReader_float3"
        string inputs:varname = "tint"
        float3 outputs:result
    }
}
"""

    def mesh(name, tint):
        return f"""
def Mesh "{name}" ({BOUND}) {{{SQUARE}
    rel material:binding = </m>
    color3f[] primvars:tint = [{tint}]
}}
"""

    scene = load(reader + mesh("one", RED) + mesh("two", GREEN))
    assert colors(scene) == [RED, GREEN]
