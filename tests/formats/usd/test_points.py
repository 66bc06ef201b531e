"""Points: one mesh of balls with widths and colours of each."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats.usd import points as usd_points
from tests.formats.usd.stage import shapes, usd_loader, world_points

pytest.importorskip("pxr")

TWO = "point3f[] points = [(0, 0, 0), (4, 1, 2)]"


@pytest.fixture
def load(tmp_path):
    return usd_loader(tmp_path)


def dots(text: str) -> str:
    return f'def Points "dots" {{ {text} }}'


def only(scene):
    [node] = shapes(scene).values()
    return node


def radii(scene):
    """Distances of all vertices from the nearer of two points."""
    vertices = world_points(scene)
    apart = [np.linalg.norm(vertices - at, axis=1) for at in ((0, 0, 0), (4, 1, 2))]
    near = apart[0] < apart[1]
    return apart[0][near], apart[1][~near]


def test_points_are_balls_with_the_diameters_of_their_widths(load):
    first, second = radii(load(dots(f"{TWO}; float[] widths = [1, 2]")))
    np.testing.assert_allclose(first, 0.5, rtol=1e-6)
    np.testing.assert_allclose(second, 1.0, rtol=1e-6)
    for one in ("float[] widths = [1]", 'float[] primvars:widths = [1] (interpolation="constant")'):
        first, second = radii(load(dots(f"{TWO}; {one}")))
        np.testing.assert_allclose([*first, *second], 0.5, rtol=1e-6)


def test_their_normals_point_outwards(load):
    mesh = only(load(dots("point3f[] points = [(0, 0, 0)]; float[] widths = [2]"))).shape
    np.testing.assert_allclose(mesh.normals, mesh.vertices, atol=1e-6)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert ((np.cross(b - a, c - a) * a).sum(axis=1) > 0.0).all()


def test_each_has_its_color(load):
    colors = 'color3f[] primvars:displayColor = [(1, 0, 0), (0, 0, 1)] (interpolation = "vertex")'
    mesh = only(load(dots(f"{TWO}; float[] widths = [1]; {colors}"))).shape
    half = len(mesh.vertices) // 2
    np.testing.assert_array_equal(mesh.colors[:half], np.tile([1, 0, 0], (half, 1)))
    np.testing.assert_array_equal(mesh.colors[half:], np.tile([0, 0, 1], (half, 1)))


def test_points_without_widths_nearly_touch(load):
    scene = load(dots(TWO))
    first, _ = radii(scene)
    np.testing.assert_allclose(first.max(), 0.6 * np.sqrt(21), rtol=1e-6)
    assert any("nearly touch" in text for text in scene.source.remarks.warnings)


def test_of_very_many_points_some_are_shown(load, monkeypatch):
    monkeypatch.setattr(usd_points, "MOST_POINTS", 1)
    scene = load(dots(f"{TWO}; float[] widths = [1]"))
    first, second = radii(scene)
    assert len(first) == 642
    assert len(second) == 0
    assert any("of 2 points one in 2 is shown" in text for text in scene.source.remarks.warnings)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{TWO}; float[] widths = [1, 2, 3]", "its widths must be 1 or 2, got 3"),
        (f"{TWO}; float[] widths = [-1]", "its widths must be in"),
        ("point3f[] points = [(0, 0, nan)]", "must be finite .* at place 0"),
    ],
)
def test_what_does_not_fit_is_refused(load, text, message):
    with pytest.raises(SceneError, match=message):
        load(dots(text))
