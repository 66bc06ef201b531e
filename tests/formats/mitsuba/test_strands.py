"""Curves of Mitsuba: text files of control points and radii."""

import numpy as np
import pytest

from tests.formats.mitsuba.reading import messages, node, read

FIRST = "0 0 0 0.1\n0 0 1 0.2\n0 0 2 0.1\n0 1 2 0.05\n"
TWO = f"{FIRST}\n\n1 0 0 0.1\n1 0 1 .1\n1 0 2 .1\n1 0 3 0\n1 1 3 0\n"


def shape(kind: str, more: str = "") -> str:
    name = '<string name="filename" value="hair.txt"/>'
    return f'<shape type="{kind}">{name}{more}</shape>'


def test_strands_are_divided_by_empty_lines(tmp_path):
    (tmp_path / "hair.txt").write_text(TWO)
    found = node(read(shape("bsplinecurve"), folder=tmp_path)).shape
    assert (found.type_name(), found.basis) == ("curves", "b_spline")
    assert found.counts.tolist() == [4, 5]
    np.testing.assert_allclose(found.points[3], [0.0, 1.0, 2.0])
    np.testing.assert_allclose(found.radii[:4], [0.1, 0.2, 0.1, 0.05])
    assert node(read(shape("linearcurve"), folder=tmp_path)).shape.basis == "linear"


def test_a_transform_leaves_the_radii_as_they_are(tmp_path):
    (tmp_path / "hair.txt").write_text(TWO)
    scaled = '<transform name="to_world"><scale value="2"/></transform>'
    found = node(read(shape("bsplinecurve", scaled), folder=tmp_path)).shape
    np.testing.assert_allclose(2.0 * found.radii[:4], [0.1, 0.2, 0.1, 0.05], rtol=1e-6)


def test_strands_bound_no_media(tmp_path):
    (tmp_path / "hair.txt").write_text(TWO)
    medium = '<medium type="homogeneous" name="exterior"/>'
    scene = read(shape("bsplinecurve", medium), folder=tmp_path)
    assert node(scene).exterior is None
    assert any("bounds no media" in text for text in scene.warnings)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("0 0 0 1\n0 0 1\n", 'line 2: must be four numbers, x y z and a radius >= 0, got "0 0 1"'),
        ("0 0 0 -1\n", "line 1: must be four numbers"),
        ("0 0 x 1\n", "line 1: must be four numbers"),
        ("0 0 0 1\n0 0 1 1\n\n", "line 2: a strand has at least 4 points, got 2"),
        ("\n\n", "must hold at least one strand"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path, content, message):
    (tmp_path / "hair.txt").write_text(content)
    assert message in messages(shape("bsplinecurve"), folder=tmp_path)[0]
