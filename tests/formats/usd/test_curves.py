"""BasisCurves: bases, wrapping, widths and colours."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.scene.flatten import flatten
from alight.shapes.strands import segments
from tests.formats.usd.stage import shapes, usd_loader

pytest.importorskip("pxr")

FOUR = "point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 2, 0), (2, 2, 0)]"


@pytest.fixture
def load(tmp_path):
    return usd_loader(tmp_path)


def curves(text: str) -> str:
    return f'def BasisCurves "hair" {{ {text} }}'


def cubic(basis: str, more: str, counts: str = "[4]") -> str:
    kind = f'uniform token type = "cubic"; uniform token basis = "{basis}"'
    return curves(f"{kind}; int[] curveVertexCounts = {counts}; {more}")


def only(scene):
    [node] = shapes(scene).values()
    return node


@pytest.mark.parametrize(
    ("basis", "ours"),
    [("bezier", "bezier"), ("bspline", "b_spline"), ("catmullRom", "catmull_rom")],
)
def test_bases_have_their_names(load, basis, ours):
    found = only(load(cubic(basis, f"{FOUR}; float[] widths = [0.2]"))).shape
    assert (found.basis, found.counts.tolist()) == (ours, [4])
    np.testing.assert_allclose(found.radii, 0.1)
    # Where the curve begins and ends, by the definition of each basis.
    ends = {"bezier": (0, 0, 2, 2), "b_spline": (1 / 6, 1, 1, 11 / 6), "catmull_rom": (0, 1, 1, 2)}
    parts = segments(found, np.eye(4)).points
    np.testing.assert_allclose([*parts[0, 0, :2], *parts[-1, 3, :2]], ends[ours], atol=1e-6)


def test_pinned_ends_are_met_and_periodic_ones_meet(load):
    pinned = cubic("bspline", f'{FOUR}; float[] widths = [0.2]; uniform token wrap = "pinned"')
    parts = segments(only(load(pinned)).shape, np.eye(4)).points
    np.testing.assert_allclose(parts[0, 0, :3], [0.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(parts[-1, 3, :3], [2.0, 2.0, 0.0], atol=1e-6)
    for basis in ("bspline", "catmullRom"):
        closed = f'{FOUR}; float[] widths = [0.2]; uniform token wrap = "periodic"'
        parts = segments(only(load(cubic(basis, closed))).shape, np.eye(4)).points
        assert len(parts) == 4
        np.testing.assert_allclose(parts[0, 0], parts[-1, 3], atol=1e-6)


def test_widths_belong_to_curves_segments_or_points(load):
    two = "point3f[] points = [(0, 0, 0), (0, 1, 0), (0, 2, 0), (1, 0, 0), (1, 1, 0)]"
    kind = f'uniform token type = "linear"; int[] curveVertexCounts = [3, 2]; {two}'

    def radii(widths, how):
        text = f'{kind}; float[] widths = {widths} (interpolation = "{how}")'
        return only(load(curves(text))).shape.radii.tolist()

    assert radii("[2, 4]", "uniform") == [1.0, 1.0, 1.0, 2.0, 2.0]
    assert radii("[2, 4, 6, 8, 10]", "varying") == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert radii("[2, 4, 6, 8, 10]", "vertex") == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert radii("[3]", "constant") == [1.5] * 5
    varying = f'{FOUR}; float[] widths = [0, 3] (interpolation = "varying")'
    np.testing.assert_allclose(only(load(cubic("bezier", varying))).shape.radii, [0, 0.5, 1, 1.5])
    wrong = f'{FOUR}; float[] widths = [1, 2, 3] (interpolation = "vertex")'
    with pytest.raises(SceneError, match=r"its widths \(vertex\) must be 1, 1, 2 or 4, got 3"):
        load(cubic("bezier", wrong))


@pytest.mark.parametrize("basis", ["bspline", "catmullRom"])
@pytest.mark.parametrize(
    ("wrap", "widths", "radii"),
    [
        ("nonperiodic", "[0, 4]", [0, 2]),
        ("pinned", "[0, 2, 4, 0]", [0, 1, 2, 0]),
        ("periodic", "[0, 2, 4, 6]", [0, 1, 2, 3, 0]),
    ],
)
def test_varying_widths_are_those_at_the_ends_of_segments(load, basis, wrap, widths, radii):
    more = f'float[] widths = {widths} (interpolation = "varying"); uniform token wrap = "{wrap}"'
    parts = segments(only(load(cubic(basis, f"{FOUR}; {more}"))).shape, np.eye(4)).points
    np.testing.assert_allclose(parts[:, 0, 3], radii[:-1], atol=1e-6)
    np.testing.assert_allclose(parts[:, 3, 3], radii[1:], atol=1e-6)
    if wrap == "periodic":
        # The first segment begins near the second point.
        near = np.linalg.norm(parts[0, 0, :3] - [[0, 0, 0], [0, 1, 0], [1, 2, 0]], axis=1)
        assert near.argmin() == 1


def test_pinned_curves_have_their_widths_at_their_ends(load):
    more = 'float[] widths = [0, 2, 2, 1] (interpolation = "vertex")'
    pinned = cubic("bspline", f'{FOUR}; {more}; uniform token wrap = "pinned"')
    parts = segments(only(load(pinned)).shape, np.eye(4)).points
    np.testing.assert_allclose([parts[0, 0, 3], parts[-1, 3, 3]], [0.0, 0.5], atol=1e-6)


def test_a_primvar_of_widths_counts_more(load):
    both = f"{FOUR}; float[] widths = [0.2]; float[] primvars:widths = [0.6]"
    np.testing.assert_allclose(only(load(cubic("bezier", both))).shape.radii, 0.3, rtol=1e-6)


def test_points_must_be_finite(load):
    text = FOUR.replace("(1, 2, 0)", "(1, nan, 0)")
    with pytest.raises(SceneError, match=r"its points must be finite .* at place 2"):
        load(cubic("bezier", f"{text}; float[] widths = [0.2]"))


def test_counts_must_fit(load):
    with pytest.raises(SceneError, match="curveVertexCounts must fit its points, and bezier"):
        load(cubic("bezier", FOUR, "[3]"))
    scene = load(curves("int[] curveVertexCounts = []"))
    assert "/hair: curves without points" in "\n".join(scene.source.remarks.notes)


def test_what_is_approximated_is_said(load):
    scene = load(cubic("bezier", f"{FOUR}; normal3f[] normals = [(0, 0, 1)]"))
    assert "/hair: ribbons with normals are shown round" in scene.warnings
    assert "/hair: without widths, its curves are thin" in scene.warnings


def test_colors_that_vary_become_their_mean(load):
    values = "[(1, 0, 0), (0, 0.5, 0)]"
    colors = f'color3f[] primvars:displayColor = {values} (interpolation = "varying")'
    scene = load(cubic("bezier", f"{FOUR}; float[] widths = [0.2]; {colors}"))
    [bsdf] = flatten(scene).bsdfs
    np.testing.assert_allclose(bsdf.bsdf.reflectance, [0.5, 0.25, 0.0])
    assert any("mean of their displayColor" in text for text in scene.warnings)
