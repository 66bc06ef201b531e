"""Every attribute of lights and cameras that OpenUSD's schemas declare (decision 38).

The schemas know their attributes and defaults: said, a default changes nothing; another value
changes the scene or brings a remark, or is one of those that `IGNORED` lists by name.
"""

import pytest

from alight.scene import content_hash
from tests.formats.usd.stage import SQUARE, usd_loader

pxr = pytest.importorskip("pxr")

from pxr import Gf, Sdf, Usd, UsdLux  # noqa: E402

LIGHTS = ("SphereLight", "RectLight", "DiskLight", "CylinderLight", "DistantLight", "DomeLight")
#: How others are linked to a light or computed; when the shutter is open; and what is said with
#: the attribute that it belongs to.
IGNORED = {
    "inputs:shaping:focusTint", "shutter:open", "shutter:close", "inputs:shaping:ies:angleScale",
    "inputs:shaping:ies:normalize",
}  # fmt: skip
#: Cones of surfaces are left out as a whole, and a dome has no size.
OF_ONE = {"inputs:shaping:cone:softness": "SphereLight"}
SIZELESS = {("DomeLight", "inputs:normalize")}
#: What some attributes need beside them.
CONE = {"inputs:shaping:cone:angle": 40.0}
NEEDS = {
    "inputs:colorTemperature": {"inputs:enableColorTemperature": True},
    "inputs:enableColorTemperature": {"inputs:colorTemperature": 3000.0},
    "inputs:shaping:cone:softness": CONE,
    "inputs:width": {"inputs:height": 2.0},
    "fStop": {"focusDistance": 3.0},
    "focusDistance": {"fStop": 2.0},
}
LARGE = {"RectLight": {"inputs:width": 3.0}}
CAMERA = ("Camera",)


def other(value):
    """Another value of the same type, one that is allowed."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, float):
        return 0.5 * value + 0.3
    return type(value)(*(0.3, 0.5, 0.7)[: len(value)]) if isinstance(value, Gf.Vec3f) else None


def attributes(kind):
    """(name, default) of what a light or camera may be given, shaping included."""
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/l", kind)
    if kind in LIGHTS and kind not in ("DomeLight", "DistantLight"):
        UsdLux.ShapingAPI.Apply(prim)
    for attribute in prim.GetAttributes():
        default, name = attribute.Get(), attribute.GetName()
        if kind != "Camera" and not name.startswith("inputs:") and name != "treatAsPoint":
            continue
        if default is not None and other(default) is not None:
            yield name, default


def outcome(load, kind, values):
    """What a stage with one such prim becomes, and what is said."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    stage.DefinePrim("/l", kind)
    if any("shaping" in name for name in values):
        UsdLux.ShapingAPI.Apply(stage.GetPrimAtPath("/l"))
    for name, value in values.items():
        stage.GetPrimAtPath("/l").GetAttribute(name).Set(value)
    text = layer.ExportToString().partition("\n")[2]
    scene = load(f'def Mesh "m" {{{SQUARE}}}\n{text}')
    return content_hash(scene), repr(scene.warnings), repr(scene.source.remarks)


@pytest.mark.parametrize("kind", (*LIGHTS, *CAMERA))
def test_attributes_have_their_defaults_and_matter(kind, tmp_path):
    load, judged = usd_loader(tmp_path), 0
    for name, default in attributes(kind):
        if name in IGNORED or (kind, name) in SIZELESS or OF_ONE.get(name, kind) != kind:
            continue
        needs = {**NEEDS.get(name, {}), **(LARGE.get(kind, {}) if "normalize" in name else {})}
        silent = outcome(load, kind, needs)
        assert outcome(load, kind, {**needs, name: default})[0] == silent[0], name
        assert outcome(load, kind, {**needs, name: other(default)}) != silent, name
        judged += 1
    assert judged > 3


@pytest.mark.parametrize("values", [CONE, {"treatAsPoint": True}], ids=["cone", "point"])
@pytest.mark.parametrize(
    "shaping",
    [{"inputs:shaping:focus": 2.0}, {"inputs:shaping:ies:file": Sdf.AssetPath("a.ies")}],
    ids=["focus", "profile"],
)
def test_what_shapes_the_light_of_points_and_cones_is_told(values, shaping, tmp_path):
    load = usd_loader(tmp_path)
    silent, said = (outcome(load, "SphereLight", {**values, **more}) for more in ({}, shaping))
    assert said != silent


@pytest.mark.parametrize("softness", [0.0, 0.3, 1.0])
def test_a_soft_cone_is_even_up_to_where_it_begins_to_fade(softness, tmp_path):
    text = f"""def SphereLight "l" (prepend apiSchemas = ["ShapingAPI"])
{{
    float inputs:shaping:cone:angle = 40
    float inputs:shaping:cone:softness = {softness}
}}"""
    scene = usd_loader(tmp_path)(f'def Mesh "m" {{{SQUARE}}}\n{text}')
    light = next(node.light for _, _, node in scene.walk() if node.light is not None)
    assert light.cutoff_angle == pytest.approx(40.0)
    assert light.beam_width == pytest.approx(40.0 * (1.0 - softness), abs=1e-6)


def test_temperatures_count_where_they_are_enabled(tmp_path):
    load = usd_loader(tmp_path)
    silent = outcome(load, "SphereLight", {})
    assert outcome(load, "SphereLight", {"inputs:colorTemperature": 3000.0}) == silent
