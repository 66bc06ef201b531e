"""Curves as descriptions: what is refused, files, and the boxes and coordinates of strands."""

import itertools
import zipfile

import numpy as np
import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.native import save
from alight.scene.flatten import flatten
from alight.scene.hashing import content_hash
from alight.shapes import curves
from alight.shapes.strand_rows import AFTER, BEFORE, IS_BALL, TEXTURE
from alight.shapes.strands import segments

POINTS = [[0, 0, 0], [0, 1, 0], [1, 2, 0], [2, 2, 1], [3, 2, 1]]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "needs a file, or points and radii"),
        ({"points": POINTS}, "needs a file, or points and radii"),
        ({"file": "a.npz", "radii": 1}, "takes either file or arrays, got file and radii"),
        ({"points": POINTS, "radii": -1}, r"must be in \[0, 1e\+15\], got -1 at place 0"),
        ({"points": POINTS, "radii": [1, 2]}, r"one number or one a point \(5\), got 2"),
        ({"points": POINTS, "radii": "thin"}, "must be a number or a list of numbers, got str"),
        ({"points": POINTS, "radii": 1, "counts": [4]}, "sum up to the number of points, 5, got 4"),
        (
            {"points": POINTS, "radii": 1, "basis": "bezier"},
            "strands of basis bezier have 4, 7, 10, ... points, got 5 in strand 0",
        ),
        ({"points": POINTS, "radii": 1, "basis": "bspline"}, "b_spline"),
        ({"points": POINTS, "radii": 1, "flip_normals": True}, "met from outside only"),
        ({"points": [[0, 0]], "radii": 1}, r"shape \(n, 3\)"),
    ],
)
def test_what_makes_no_curves_is_refused(keys, message):
    with pytest.raises(SceneError, match=message):
        curves.Curves(**keys)


@pytest.mark.parametrize("basis", ["b_spline", "catmull_rom"])
def test_segments_join_smoothly(basis):
    parts = segments(curves.Curves(points=POINTS, radii=(1, 2, 3, 2, 1), basis=basis), np.eye(4))
    assert len(parts.points) == 2
    ends, starts = parts.points[:-1], parts.points[1:]
    np.testing.assert_allclose(ends[:, 3], starts[:, 0])
    np.testing.assert_allclose(ends[:, 3] - ends[:, 2], starts[:, 1] - starts[:, 0])
    np.testing.assert_allclose(parts.first, [0.0, 0.5])


#: Basis -> where a segment of the control points a, b, c, d begins, and its derivative there.
BEGINNINGS = {
    "bezier": lambda a, b, c, d: (a, 3.0 * (b - a)),
    "b_spline": lambda a, b, c, d: ((a + 4.0 * b + c) / 6.0, 0.5 * (c - a)),
    "catmull_rom": lambda a, b, c, d: (b, 0.5 * (c - a)),
}


@pytest.mark.parametrize("basis", BEGINNINGS)
def test_segments_begin_and_end_as_their_basis_says(basis):
    rng = np.random.default_rng(2)
    spec = curves.Curves(points=rng.normal(size=(4, 3)), radii=rng.uniform(1, 2, 4), basis=basis)
    given = np.concatenate([spec.points, spec.radii[:, None]], axis=1, dtype=np.float64)
    [found] = segments(spec, np.eye(4)).points
    for rows, points in ((given, found), (given[::-1], found[::-1])):
        place, slope = BEGINNINGS[basis](*rows)
        np.testing.assert_allclose(points[0], place, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(3.0 * (points[1] - points[0]), slope, rtol=1e-6, atol=1e-9)


def test_radii_grow_as_the_third_root_of_the_volume():
    spec = curves.Curves(points=POINTS[:4], radii=(1, 2, 3, 4), basis="bezier")
    [found] = segments(spec, np.diag([2.0, -3.0, 4.5, 1.0])).points
    np.testing.assert_allclose(found[:, 3], [3.0, 6.0, 9.0, 12.0])


def test_balls_at_joints_know_the_lines_on_both_sides():
    # Two strands, of three lines and of one.
    points = np.array([*POINTS[:4], [9, 9, 9], [9, 9, 8]], float)
    rows = curves.pack(
        curves.Curves(points=points, radii=0.1, counts=[4, 2], basis="linear"), np.eye(4)
    )
    balls = rows[rows[:, IS_BALL] > 0.0]
    along = [(b - a) / np.linalg.norm(b - a) for a, b in itertools.pairwise(points)]
    none = np.zeros(3)
    lines = {
        tuple(points[0]): (none, along[0]), tuple(points[1]): (along[0], along[1]),
        tuple(points[2]): (along[1], along[2]), tuple(points[3]): (along[2], none),
        tuple(points[4]): (none, along[4]), tuple(points[5]): (along[4], none),
    }  # fmt: skip
    assert len(balls) == len(lines)
    # u runs from 0 to 1 along each strand: at joints it is that of the line that begins there.
    tubes = rows[rows[:, IS_BALL] == 0.0]
    begins = {tuple(tube[:3]): tube[TEXTURE] for tube in tubes}
    assert begins[tuple(points[0])] == begins[tuple(points[4])] == 0.0
    for ball in balls:
        assert ball[TEXTURE] == begins.get(tuple(ball[:3]), 1.0)
        before, after = lines[tuple(ball[:3])]
        np.testing.assert_allclose(ball[BEFORE : BEFORE + 3], before, atol=1e-6)
        np.testing.assert_allclose(ball[AFTER : AFTER + 3], after, atol=1e-6)


def test_slender_segments_are_divided_and_stay_where_they_are():
    spec = curves.Curves(points=POINTS[:4], radii=(0.01, 0.02, 0.03, 0.04), basis="bezier")
    whole, rows = segments(spec, np.eye(4)).points[0], curves.pack(spec, np.eye(4))
    assert len(rows) == 4
    u = np.linspace(0.0, 1.0, 9)
    bernstein = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3], axis=1)
    for number, row in enumerate(rows):
        # Texture coordinates say which part of the strand it is.
        first, span = row[18:20]
        assert (first, span) == (0.25 * number, 0.25)
        local = ((u[2 * number : 2 * number + 3] - first) / span)[:, None] ** np.arange(4)
        found = local @ row[:16].reshape(4, 4)
        np.testing.assert_allclose(
            found, (bernstein @ whole)[2 * number : 2 * number + 3], atol=1e-6
        )


def test_radii_that_swing_below_0_are_0():
    # Catmull-Rom's curve through 1, 0, 0, 1 dips to -1/8.
    points = [[x, 0, 0] for x in range(4)]
    spec = curves.Curves(points=points, radii=(1, 0, 0, 1), basis="catmull_rom")
    rows = curves.pack(spec, np.eye(4))
    assert curves.area(rows) == 0.0
    low, high = curves.extremes(rows, np.eye(3))
    assert (low <= high).all()


SCENE = """
alight: 1
camera: {type: pinhole}
environment: {type: constant}
nodes:
  hair: {shape: {type: curves, %s}%s}
"""


def scene(tmp_path, keys, more=""):
    (tmp_path / "scene.yaml").write_text(SCENE % (keys, more))
    return alight.load(tmp_path / "scene.yaml")


def test_a_file_holds_the_same_as_the_keys(tmp_path):
    inline = scene(tmp_path, f"points: {POINTS}, radii: 0.1, counts: [5]")
    np.savez(tmp_path / "hair.npz", points=np.array(POINTS), radii=0.1, counts=[5])
    read = scene(tmp_path, "file: hair.npz")
    assert content_hash(read) == content_hash(inline)
    np.savez(tmp_path / "hair.npz", points=np.array(POINTS), radii=0.2, counts=[5])
    assert content_hash(scene(tmp_path, "file: hair.npz")) != content_hash(inline)


def test_many_points_are_saved_beside_the_scene(tmp_path):
    rng = np.random.default_rng(1)
    shape = curves.Curves(points=rng.normal(size=(4000, 3)), radii=0.1, counts=[4] * 1000)
    made = scene(tmp_path, f"points: {POINTS}, radii: 0.1")
    made = alight.changed(made, {"nodes.hair.shape": shape})
    save(made, tmp_path / "saved.yaml")
    again = alight.load(tmp_path / "saved.yaml")
    assert again.nodes["hair"].shape.file.endswith(".npz")
    assert content_hash(again) == content_hash(made)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        (None, 'no such file: "hair.npz"'),
        ({"point": POINTS, "radii": 1.0}, 'lacks points; is it "point"'),
        ({"points": POINTS}, "lacks radii"),
        ({"points": POINTS, "radii": [1.0, 2.0]}, "radii must be one number or one a point"),
        ({"points": POINTS, "radii": "x"}, "must be a number or a list of numbers"),
        ({"points": POINTS, "radii": np.float16(np.inf)}, "radii must be in [0, 1e+15], got inf"),
        ({"points": np.full((5, 3), np.inf, np.float16), "radii": 1.0}, "points must be finite"),
        (b"no archive", "is no NPZ file of numbers, or broken"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path, arrays, message):
    if isinstance(arrays, bytes):
        (tmp_path / "hair.npz").write_bytes(arrays)
    elif arrays is not None:
        np.savez(tmp_path / "hair.npz", **arrays)
    with pytest.raises(SceneError, match=r"nodes\.hair\.shape\.file") as caught:
        flatten(scene(tmp_path, "file: hair.npz"))
    assert message in str(caught.value)


def broken(kind: str, folder) -> bytes:
    """Bytes of a file that NumPy cannot read."""
    path = folder / "whole.npz"
    np.savez_compressed(path, points=np.zeros((4, 3)), radii=np.ones(4))
    data = bytearray(path.read_bytes())
    if kind == "an array alone":
        np.save(folder / "alone.npy", np.zeros((4, 3)))
        return (folder / "alone.npy").read_bytes()
    if kind == "a header that is cut":
        with zipfile.ZipFile(path, "w") as archive:
            head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3"
            archive.writestr("points.npy", b"\x93NUMPY\x01\x00" + bytes([len(head), 0]) + head)
        return path.read_bytes()
    central = data.find(b"PK\x01\x02")
    if kind == "encrypted":
        data[6] |= 1
        data[central + 8] |= 1
    elif kind == "packed in another way":
        data[8] = data[central + 10] = 99
    else:
        start = 30 + data[26] + 256 * data[27] + data[28] + 256 * data[29]
        data[start : start + 8] = b"\xff" * 8
    return bytes(data)


@pytest.mark.parametrize(
    "kind",
    ["an array alone", "a header that is cut", "encrypted", "packed in another way", "scrambled"],
)
def test_broken_archives_get_one_message(tmp_path, kind):
    (tmp_path / "hair.npz").write_bytes(broken(kind, tmp_path))
    with pytest.raises(SceneError, match="is no NPZ file of numbers, or broken") as caught:
        flatten(scene(tmp_path, "file: hair.npz"))
    assert len(caught.value.issues) == 1


@pytest.mark.parametrize("side", ["interior", "exterior"])
def test_curves_bound_no_media(tmp_path, side):
    medium = f", {side}: {{type: homogeneous, sigma_s: 1}}"
    with pytest.raises(SceneError, match=rf"{side}.*\n.*they bound no media"):
        flatten(scene(tmp_path, f"points: {POINTS}, radii: 0.1", medium))


def test_straight_lines_that_bend_do_not_shine(tmp_path):
    light = ", light: {type: area, radiance: 1}"
    with pytest.raises(SceneError, match="overlap at their joints and cannot shine"):
        flatten(scene(tmp_path, f"points: {POINTS}, radii: 0.1, basis: linear", light))
    straight = [[x, 0, 0] for x in range(5)]
    flatten(scene(tmp_path, f"points: {straight}, radii: 0.1, basis: linear", light))


@pytest.mark.parametrize("keys", [f"points: {POINTS}, radii: 0", "points: [[1, 1, 1], [1, 1, 1]]"])
def test_a_light_needs_an_area(tmp_path, keys):
    if "radii" not in keys:
        keys += ", radii: 0, basis: linear"
    with pytest.raises(SceneError, match="must have an area > 0"):
        flatten(scene(tmp_path, keys, ", light: {type: area, radiance: 1}"))


def test_curves_cannot_move(tmp_path):
    keys = "[{time: 0, translate: [0, 0, 0]}, {time: 1, translate: [1, 0, 0]}]"
    moving = f", transform: {{keyframes: {keys}}}"
    with pytest.raises(SceneError, match="curves cannot move while the shutter is open"):
        flatten(scene(tmp_path, f"points: {POINTS}, radii: 0.1", moving))
