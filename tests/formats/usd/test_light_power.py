"""OpenUSD: the power of lights of every shape, whatever transform stands above them.

A surface of radiance L sends out pi L from each of its square metres. A normalised light sends out
pi times its intensity, however large it is; a point sends as much as the sphere that it stands for.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from alight.compiled.shapes import compile_shapes
from alight.scene.flatten import flatten
from tests.formats.usd.stage import SQUARE, usd_loader

pytest.importorskip("pxr")

INTENSITY = 5.0
RADIUS, LENGTH, WIDTH, HEIGHT = 0.7, 3.0, 2.0, 1.5
#: What the file says about each light, and the part of the sphere that it shines into.
LIGHTS = {
    "sphere": f"SphereLight; float inputs:radius = {RADIUS}",
    "point": f"SphereLight; float inputs:radius = {RADIUS}; bool treatAsPoint = 1",
    "cone": f"SphereLight; float inputs:radius = {RADIUS}; float inputs:shaping:cone:angle = 40",
    "disk": f"DiskLight; float inputs:radius = {RADIUS}",
    "rectangle": f"RectLight; float inputs:width = {WIDTH}; float inputs:height = {HEIGHT}",
    "cylinder": f"CylinderLight; float inputs:radius = {RADIUS}; float inputs:length = {LENGTH}",
}
TURNED = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TRANSFORMS = {
    "at rest": np.eye(3),
    "larger": 3.0 * np.eye(3),
    "turned": TURNED,
    "stretched": TURNED @ np.diag([2.0, 0.5, 1.2]),
    "mirrored": np.diag([-1.5, 1.0, 0.4]) @ TURNED,
    "slanted": np.array([[1.0, 0.8, 0.0], [0.0, 1.0, 0.3], [0.5, 0.0, 0.7]]),
}


@pytest.fixture
def load(tmp_path):
    return usd_loader(tmp_path)


def area_of(name, a):
    """Area of the image of a light's surface, by summing up small pieces."""
    phi = (np.arange(4000) + 0.5) * (2.0 * np.pi / 4000)
    around = np.stack([np.cos(phi), np.sin(phi)])
    if name == "rectangle":
        return WIDTH * HEIGHT * np.linalg.norm(np.cross(a[:, 0], a[:, 1]))
    if name == "disk":
        return math.pi * RADIUS**2 * np.linalg.norm(np.cross(a[:, 0], a[:, 1]))
    if name == "cylinder":
        # The axis is x.
        along = a[:, 1:] @ np.stack([-around[1], around[0]])
        strips = np.linalg.norm(np.cross(along, a[:, :1], axis=0), axis=0)
        return 2.0 * math.pi * RADIUS * LENGTH * float(strips.mean())
    nodes, weights = np.polynomial.legendre.leggauss(200)
    r = np.sqrt(1.0 - nodes**2)
    q = np.stack([np.outer(r, around[0, ::20]), np.outer(r, around[1, ::20]),
                  np.outer(nodes, 1.0 + 0.0 * phi[::20])])  # fmt: skip
    cofactors = np.linalg.det(a) * np.linalg.inv(a).T
    stretch = np.linalg.norm(np.tensordot(cofactors, q, 1), axis=0).mean(axis=1)
    return 4.0 * math.pi * RADIUS**2 * float((0.5 * weights * stretch).sum())


def power_of(scene):
    """W that the only light sends out, as if its cone were open all around."""
    (node,) = [node for _, _, node in scene.walk() if node.light is not None]
    if node.shape is None:
        return 4.0 * math.pi * node.light.intensity[0]
    shapes = [item for item in flatten(scene).shapes if item.light is not None]
    (row,) = compile_shapes(SimpleNamespace(shapes=shapes, geometries=[])).rows
    return math.pi * node.light.radiance[0] * row.areas.sum()


@pytest.mark.parametrize("normalize", [0, 1])
@pytest.mark.parametrize("transform", TRANSFORMS)
@pytest.mark.parametrize("name", LIGHTS)
def test_the_power_is_pi_times_the_intensity_or_times_the_area(load, name, transform, normalize):
    kind, _, fields = LIGHTS[name].partition(";")
    a = TRANSFORMS[transform]
    matrix = np.eye(4)
    # Rows of OpenUSD's matrices are columns of ours.
    matrix[:3, :3] = a.T
    rows = ", ".join(f"({', '.join(map(repr, row))})" for row in matrix.tolist())
    scene = load(f"""def Mesh "m" {{{SQUARE}}}
def Xform "above" {{
    matrix4d xformOp:transform = ( {rows} )
    uniform token[] xformOpOrder = ["xformOp:transform"]
    def {kind} "light" {{ {fields}; float inputs:intensity = {INTENSITY}
        bool inputs:normalize = {normalize}
    }}
}}""")
    area = 1.0 if normalize else area_of(name, a)
    assert power_of(scene) == pytest.approx(math.pi * INTENSITY * area, rel=1e-4)


@pytest.mark.parametrize("name", LIGHTS)
def test_normalised_lights_are_as_bright_in_every_unit(load, name):
    """The area is one of world space, which is that of the stage: a stage is only relabelled."""
    kind, _, fields = LIGHTS[name].partition(";")
    text = f"""def Mesh "m" {{{SQUARE}}}
def {kind} "light" {{ {fields}; float inputs:intensity = {INTENSITY}
    bool inputs:normalize = 1
}}"""
    metres, inches = (power_of(load(text, unit=unit)) for unit in (1, 0.0254))
    assert inches == pytest.approx(0.0254**2 * metres, rel=1e-4)
