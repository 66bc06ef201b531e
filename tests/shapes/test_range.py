"""Shapes that float32 cannot hold are refused in words, all at once."""

from __future__ import annotations

import pytest

from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.formats import loads
from alight.scene import flatten

SHAPES = ("sphere", "rectangle", "disk", "cube", "cylinder")

SCENE = """
alight: 1
camera: {type: pinhole}
prototypes:
  part: {children: {PARTS}}
nodes:
  small: {instance: part, transform: {scale: 1e-25}}
  fine: {instance: part, transform: {scale: 1e10}}
"""


def test_shapes_too_small_for_float32_are_named():
    # Each step is allowed; only together they leave the range.
    parts = ", ".join(f"{n}: {{shape: {n}, transform: {{scale: 1e-15}}}}" for n in SHAPES)
    flat = flatten(loads(SCENE.replace("PARTS", parts), "scene.yaml"))
    with pytest.raises(SceneError) as caught:
        compile_scene(flat)
    message = str(caught.value)
    for name in SHAPES:
        assert f"small/part/{name}" in message
    assert "fine/" not in message
    assert "transforms scale by 1e-40 to 1e-40" in message
