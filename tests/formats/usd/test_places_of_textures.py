"""UsdTransform2d: coordinates are scaled, turned counter-clockwise and moved, node by node."""

import numpy as np
import pytest
from PIL import Image

from tests.formats.usd.stage import TEXTURED, usd_loader

pytest.importorskip("pxr")

PLACE = """
    def Shader "place {i}" {{
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = <{source}>
        float2 inputs:scale = ({scale[0]}, {scale[1]})
        float inputs:rotation = {angle}
        float2 inputs:translation = ({shift[0]}, {shift[1]})
        float2 outputs:result
    }}
"""
READER = """
    def Shader "reader" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
"""


@pytest.mark.parametrize("count", [1, 2, 3])
def test_each_transform_scales_turns_and_moves_what_the_one_before_it_gives(count, tmp_path):
    rng = np.random.default_rng(count)
    Image.fromarray(np.full((2, 2, 3), 90, np.uint8)).save(tmp_path / "p.png")
    uv = rng.uniform(-2.0, 2.0, (5, 2))
    expected, source, places = uv, "/m/reader.outputs:result", ""
    for i in range(count):
        scale, shift = rng.uniform(0.5, 2.0, 2), rng.uniform(-1.0, 1.0, 2)
        angle = rng.uniform(-180.0, 180.0)
        places += PLACE.format(i=i, source=source, scale=scale, shift=shift, angle=angle)
        source = f"/m/place {i}.outputs:result"
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        x, y = (expected * scale).T
        expected = np.stack([c * x - s * y, s * x + c * y], axis=1) + shift
    inputs, nodes = f"float2 inputs:st.connect = <{source}>", READER + places
    text = TEXTURED.format(file="p.png", inputs=inputs, nodes=nodes, u=1, v=1)
    text = text.replace("place ", "place")
    scene = usd_loader(tmp_path)(text)
    texture = next(iter(scene.bsdfs.values())).bsdf.base_color
    matrix = texture.lookup()
    np.testing.assert_allclose(uv @ matrix[:, :2].T + matrix[:, 2], expected, atol=1e-5)


def test_transforms_that_come_from_themselves_are_left_out(tmp_path):
    Image.fromarray(np.full((2, 2, 3), 90, np.uint8)).save(tmp_path / "p.png")
    numbers = {"scale": (2, 3), "shift": (0.5, 0.25), "angle": 30}
    place = PLACE.format(i=0, source="/m/place 0.outputs:result", **numbers)
    inputs = "float2 inputs:st.connect = </m/place 0.outputs:result>"
    text = TEXTURED.format(file="p.png", inputs=inputs, nodes=place, u=1, v=1)
    scene = usd_loader(tmp_path)(text.replace("place ", "place"))
    assert any("come from itself" in said for said in scene.warnings)
    texture = next(iter(scene.bsdfs.values())).bsdf.base_color
    np.testing.assert_allclose(texture.lookup(), np.eye(3)[: len(texture.lookup())])
