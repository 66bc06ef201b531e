"""Stages of OpenUSD as text."""

import numpy as np

import alight
from alight.scene.flatten import flatten


def stage_text(text, up="Y", unit=1):
    """A stage: OpenUSD wants every statement on a line of its own."""
    lines = text.replace("; ", "\n").replace("{ ", "{\n").replace("}", "\n}")
    return HEAD.format(up=up, unit=unit) + lines


HEAD = '#usda 1.0\n(\n    upAxis = "{up}"\n    metersPerUnit = {unit}\n)\n'
SQUARE = """
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
"""


def shapes(scene):
    """Node path -> node of everything that has a shape."""
    return {path: node for path, _, node in scene.walk() if node.shape is not None}


def world_points(scene):
    """Vertices of all meshes in the world, in the order of the file."""
    found = [
        item.to_world[:3, :3] @ item.shape.vertices.T.astype(float) + item.to_world[:3, 3:]
        for item in flatten(scene).shapes
    ]
    return np.concatenate(found, axis=1).T


def usd_loader(folder):
    """A function that loads a stage given as text, from a file in `folder`."""

    def run(text, up="Y", unit=1, name="a.usda"):
        (folder / name).write_text(stage_text(text, up, unit))
        return alight.load(folder / name)

    return run
