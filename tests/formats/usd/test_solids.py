"""Solids of UsdGeom by their formulas: how large, along which axis, and the right way out."""

import numpy as np
import pytest

from alight.meshes.volume import enclosed_volume
from tests.formats.usd.stage import shapes, usd_loader, world_points

pytest.importorskip("pxr")

RADIUS, HEIGHT = 0.5, 3.0
#: Volume, and where along the axis it begins and ends.
SOLIDS = {
    "Cylinder": (np.pi * RADIUS**2 * HEIGHT, 0.5 * HEIGHT),
    "Cone": (np.pi * RADIUS**2 * HEIGHT / 3.0, 0.5 * HEIGHT),
    "Capsule": (np.pi * RADIUS**2 * (HEIGHT + 4.0 / 3.0 * RADIUS), 0.5 * HEIGHT + RADIUS),
}


@pytest.mark.parametrize("axis", "XYZ")
@pytest.mark.parametrize("kind", SOLIDS)
def test_solids_of_revolution(kind, axis, tmp_path):
    scene = usd_loader(tmp_path)(
        f'def {kind} "it" {{ double radius = {RADIUS}; double height = {HEIGHT}\n'
        f'    uniform token axis = "{axis}" }}'
    )
    [node] = shapes(scene).values()
    volume, end = SOLIDS[kind]
    # A polygon of 64 sides, and an eighth of a turn in 8 steps, are a little smaller.
    assert 0.99 * volume < enclosed_volume(node.shape.vertices, node.shape.faces) < volume
    points, along = world_points(scene), "XYZ".index(axis)
    wanted = np.full(3, RADIUS)
    wanted[along] = end
    np.testing.assert_allclose(points.max(axis=0), wanted, atol=1e-5)
    np.testing.assert_allclose(points.min(axis=0), -wanted, atol=1e-5)
    # A cone's tip points to where its axis does.
    tip = points[np.argmax(points[:, along])]
    if kind != "Cylinder":
        np.testing.assert_allclose(np.delete(tip, along), 0.0, atol=1e-5)


@pytest.mark.parametrize("kind", ["Cylinder_1", "Capsule_1"])
@pytest.mark.parametrize(("bottom", "top"), [(0.6, 0.2), (0.25, 1.0), (0.5, 0.5)])
def test_solids_of_two_radii(kind, bottom, top, tmp_path):
    """Against OpenUSD's own extents, and the volumes of a frustum and of caps of balls."""
    from pxr import Usd, UsdGeom

    scene = usd_loader(tmp_path)(
        f'def {kind} "it" {{ double radiusBottom = {bottom}; double radiusTop = {top}\n'
        f'    double height = {HEIGHT}; uniform token axis = "Y" }}'
    )
    [node] = shapes(scene).values()
    volume = np.pi * HEIGHT * (bottom**2 + bottom * top + top**2) / 3.0
    if kind == "Capsule_1":
        sine = (bottom - top) / np.hypot(bottom - top, HEIGHT)
        for radius, depth in ((bottom, 1.0 + sine), (top, 1.0 - sine)):
            ball = radius / np.sqrt(1.0 - sine**2)
            volume += np.pi * ball**3 * depth**2 * (3.0 - depth) / 3.0
    found = enclosed_volume(node.shape.vertices, node.shape.faces)
    assert 0.99 * volume < found < volume
    stage = Usd.Stage.CreateInMemory()
    solid = getattr(UsdGeom, kind).Define(stage, "/it")
    solid.GetRadiusBottomAttr().Set(bottom)
    solid.GetRadiusTopAttr().Set(top)
    solid.GetHeightAttr().Set(HEIGHT)
    solid.GetAxisAttr().Set("Y")
    time, points = Usd.TimeCode.Default(), world_points(scene)
    low, high = UsdGeom.Boundable.ComputeExtentFromPlugins(solid, time)
    np.testing.assert_allclose(
        [points.min(axis=0)[1], points.max(axis=0)[1]], [low[1], high[1]], atol=1e-5
    )
    # Of 64 sides and some steps of a cap none need be the widest.
    np.testing.assert_allclose(np.ptp(points, axis=0)[[0, 2]], 2.0 * high[0], rtol=5e-3)


@pytest.mark.parametrize(("axis", "across"), [("X", (2, 1)), ("Y", (0, 2)), ("Z", (0, 1))])
def test_planes_are_as_wide_and_long_as_they_say(axis, across, tmp_path):
    """The width lies along x, or along z where the plane looks along x; the length across it."""
    scene = usd_loader(tmp_path)(
        f'def Plane "it" {{ double width = 3; double length = 5; uniform token axis = "{axis}" }}'
    )
    [node] = shapes(scene).values()
    wanted = np.zeros(3)
    wanted[list(across)] = 3.0, 5.0
    corners = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]], float)
    points = (corners @ node.transform.matrix.T)[:, :3]
    np.testing.assert_allclose(np.ptp(points, axis=0), wanted, atol=1e-6)
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    assert normal["XYZ".index(axis)] > 14.9
