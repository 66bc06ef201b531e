"""OpenUSD: arcs within a layer, and what else other programs write into one."""

import base64
import zlib

import numpy as np
import pytest

import alight
from alight.scene.flatten import flatten
from tests.formats import bare
from tests.formats.usd.stage import SQUARE, shapes, stage_text, usd_loader, world_points

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


ARCS = {
    "reference": "prepend references = </A>",
    "payload": "prepend payload = </A>",
    "inherit": "prepend inherits = </A>",
    "specialise": "prepend specializes = </A>",
}


@pytest.mark.parametrize("arc", ARCS)
def test_an_arc_to_another_prim_of_the_layer_brings_its_shapes(load, arc):
    scene = load(f'def "A" {{ def Mesh "m" {{{SQUARE}}} }}\ndef "B" ({ARCS[arc]}) {{\n}}')
    assert list(shapes(scene)) == ["A/m", "B/m"]


def test_a_flattened_stage_keeps_its_prototypes(tmp_path, load):
    """`Usd.Stage.Flatten` writes prototypes as prims of the layer and references to them."""
    from pxr import Usd

    load(f"""
class "_thing" {{ def Mesh "m" {{{SQUARE}}} }}
def Xform "a" (instanceable = true; inherits = </_thing>) {{
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def Xform "b" (instanceable = true; inherits = </_thing>) {{ }}
""")
    flat = Usd.Stage.Open(str(tmp_path / "a.usda")).Flatten()
    flat.Export(str(tmp_path / "flat.usda"))
    assert "Flattened_Prototype_1" in (tmp_path / "flat.usda").read_text()
    scene = bare.load(tmp_path / "flat.usda")
    assert len(scene.prototypes) == 1
    assert sorted(item.to_world[0, 3] for item in flatten(scene).shapes) == [0.0, 10.0]


def test_backslashes_in_paths_of_layers_are_slashes(tmp_path, load):
    (tmp_path / "parts").mkdir()
    below = stage_text(f'def "A" {{ def Mesh "m" {{{SQUARE}}} }}')
    (tmp_path / "parts" / "b.usda").write_text(below)
    scene = load('def "B" (references = @.\\parts\\b.usda@</A>) {\n}')
    assert list(shapes(scene)) == ["B/m"]


def test_backslashes_lead_no_further_than_slashes(tmp_path, load):
    (tmp_path.parent / "outside.usda").write_text(stage_text('def "A" {\n}'))
    with pytest.raises(alight.SceneError, match="leads out of the folder"):
        load('def "B" (references = @..\\outside.usda@</A>) {\n}')


#: A sphere in a binary layer whose metersPerUnit, 0.5, is stored in single precision.
SINGLE = (
    r"c-jky2+|D=c5!ClU;u-uj0{u(Fk_g27-}?w4V1QrDf*ymt*gnvP|Q$Jl$q<Ck(rZHl$yton_7}uR2-066q=V=!cbh0"
    r"nw*)InOejUT#%7kl*&+2S&-_Nn41c>iUmq@!UPIHmOC;t$-@K`B7p7@&}3x@09wuAz{zlcfkDfG4J^kEr5PA_V9FPO"
    r"^arvq{A2#ZgyandB(E?eFoHeF4&w)aJ&fS~2LhbB5PW7dKF9!;|1cMY_<Oth1tS7A1xklQ>EMtcPd|5rg57BLxp}(!"
    r"xFG3245b}V<XuBxN|>RsCIj<@V~7Wmb_RK<ydBK`09R*Z`B<pD1(Xi}KQA_h"
)


def test_lengths_may_be_stored_in_single_precision(tmp_path):
    (tmp_path / "a.usdc").write_bytes(zlib.decompress(base64.b85decode(SINGLE)))
    (item,) = flatten(bare.load(tmp_path / "a.usdc")).shapes
    np.testing.assert_allclose(item.to_world[:3, :3], 0.5 * np.eye(3))


def test_an_instance_may_be_a_mesh_itself(load):
    scene = load(f"""
class Mesh "A" {{{SQUARE}}}
def "B" (instanceable = true; inherits = </A>) {{
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}""")
    np.testing.assert_allclose(world_points(scene).min(axis=0), [10, 0, 0])
