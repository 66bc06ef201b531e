"""Photometric files, and projected pictures."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.lights.ies import LUMENS, Ies, intensity, profile, table
from alight.lights.photometry import (
    HORIZONTAL_STEP,
    VERTICAL_STEP,
    Profile,
    folded,
    grid,
    parse_profile,
    read_profile,
)
from alight.lights.projector import Projector
from alight.lights.tables import INFO
from alight.scene.flatten import PlacedLight
from tests.lights.test_light_sampling import run, sample
from tests.shapes.tracing import PROGRAM, World, vec

#: A lamp of 1995: multiplier 2, ballast 0.5, its lamp 0.9.
TEXT = """IESNA:LM-63-1995
[TEST] none
TILT=NONE
1 -1 2.0 3 2 1 2 -0.08 0 0
0.5 0.9 9
0 45 90
0 90
100 200, 0
100 400 30
"""


def test_a_file_is_read_with_its_factors():
    found = parse_profile(TEXT)
    np.testing.assert_array_equal(found.vertical, [0, 45, 90])
    np.testing.assert_array_equal(found.horizontal, [0, 90])
    np.testing.assert_allclose(found.candela, 0.9 * np.array([[100, 200, 0], [100, 400, 30]]))


def test_tilt_inside_the_file_is_skipped():
    inside = TEXT.replace("TILT=NONE", "TILT=INCLUDE\n1\n2\n0 90\n1.0 0.9")
    np.testing.assert_array_equal(parse_profile(inside).candela, parse_profile(TEXT).candela)
    # The standard of 1986 has no first line.
    old = TEXT.split("\n", 2)[2]
    np.testing.assert_array_equal(parse_profile(old).candela, parse_profile(TEXT).candela)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("TILT=NONE", "", "TILT= is missing"),
        ("TILT=NONE", "TILT=lamp.tlt", "another file is not read"),
        ("3 2 1 2", "3 2 2 2", "type B"),
        ("3 2 1 2", "3 2 3 2", "type A"),
        ("100 400 30", "100 400", "6 numbers, got 5"),
        ("100 400 30", "100 400 x", "must be numbers, got 'x'"),
        ("100 400 30", "100 400 -1", "not negative"),
        ("0 45 90\n", "0 90 45\n", "must ascend"),
        ("0 45 90\n", "0 45 190\n", "lie in"),
        ("0 90\n100", "0 70\n100", "0 to 70"),
        ("3 2 1 2", "0 2 1 2", "whole number"),
        ("3 2 1 2", "99999 99999 1 2", "at most"),
        ("-1 2.0 3", "-1 inf 3", "candela must be finite"),
        ("0 45 90\n", "0 inf inf\n", "must ascend"),
    ],
)
def test_files_that_are_refused(tmp_path, old, new, words):
    assert old in TEXT
    path = tmp_path / "lamp.ies"
    path.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(SceneError, match=words):
        read_profile(path)


def test_files_that_are_missing(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        read_profile(tmp_path / "none.ies")
    with pytest.raises(SceneError, match=r"ending \.ies"):
        read_profile(tmp_path / "lamp.txt")


@pytest.mark.parametrize(
    ("horizontal", "around", "stands_for"),
    [
        ([0, 90], [0, 30, 90, 150, 210, 330], [0, 30, 90, 30, 30, 30]),
        ([0, 180], [0, 30, 150, 210, 330], [0, 30, 150, 150, 30]),
        ([0, 360], [0, 30, 150, 210, 330], [0, 30, 150, 210, 330]),
        ([90, 270], [90, 180, 270, 0, 30, 330], [90, 180, 270, 180, 150, 210]),
    ],
)
def test_symmetries(horizontal, around, stands_for):
    found = folded(np.array(around, float), np.array(horizontal, float))
    np.testing.assert_allclose(found, stands_for)


def test_intensity_is_interpolated_and_turned():
    spec = Ies(
        vertical_angles=(0, 60, 120),
        horizontal_angles=(0, 360),
        candela=((683, 683, 0), (683, 2049, 0)),
        scale=(1, 2, 3),
    )
    world = World(lights=[PlacedLight("lamp", spec, np.eye(4))])
    program = PROGRAM._replace(lights=("ies",), single_light=True)
    theta = np.radians([0, 30, 60, 60, 60, 90, 150])
    phi = np.radians([0, 180, 1, 90, 270, 180, 20])
    w = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    index = np.zeros(7, np.uint32)
    found = run(intensity, world.scene, index, vec(w), program=program)
    expected = [1, 1.5, 1 + 2 / 360, 1.5, 2.5, 1.0, 0]
    np.testing.assert_allclose(found, expected, atol=2e-4)
    # A point that lies that way is lit by it, in its colour.
    s = sample(world, (0, 3 * np.sin(np.pi / 3), 1.5), 4, program=program)
    np.testing.assert_allclose(s.radiance.y[:4] * np.ones(4), 2 * 1.5 / 9, rtol=1e-3)


@pytest.mark.parametrize("columns", [1, 13])
def test_intensity_is_that_of_the_four_angles_around_a_direction(columns):
    """A profile that jumps from degree to degree: between two angles of the grid too."""
    rng, n = np.random.default_rng(columns), 4000
    around = tuple(np.linspace(0.0, 360.0, columns)) if columns > 1 else (0.0,)
    candela = rng.uniform(1.0, 1e4, (columns, 181))
    spec = Ies(
        vertical_angles=tuple(range(181)),
        horizontal_angles=around,
        candela=tuple(map(tuple, candela)),
    )
    world = World(lights=[PlacedLight("lamp", spec, np.eye(4))])
    w = rng.standard_normal((3, n))
    w = (w / np.linalg.norm(w, axis=0)).astype(np.float32)
    program = PROGRAM._replace(lights=("ies",), single_light=True)
    found = run(intensity, world.scene, np.zeros(n, np.uint32), vec(w), program=program)
    values = grid(profile(spec)) / LUMENS
    x, y, z = w.astype(float)
    row = np.degrees(np.arctan2(np.hypot(x, y), z)) / VERTICAL_STEP
    column = np.degrees(np.arctan2(y, x)) % 360.0 / HORIZONTAL_STEP * (columns > 1)
    i, j = np.floor(row).astype(int), np.floor(column).astype(int)
    right = np.minimum(j + 1, values.shape[1] - 1)
    upper, lower = (
        values[k, j] + (column - j) * (values[k, right] - values[k, j]) for k in (i, i + 1)
    )
    # A ten-thousandth of a degree, of jumps from one degree to the next.
    np.testing.assert_allclose(found, upper + (row - i) * (lower - upper), atol=2e-4 * values.max())


def test_a_lamp_that_is_the_same_all_around_has_one_column():
    spec = Ies(vertical_angles=(0, 90), horizontal_angles=(0,), candela=((683, 0),))
    assert grid(Profile(np.array([0.0, 90]), np.zeros(1), np.array([[1.0, 0]]))).shape == (361, 1)
    assert table(spec)[0] == 0 and table(spec).size == 362


def projected(spec, points):
    """What points (3, n) get from a projector at the origin."""
    world = World(lights=[PlacedLight("p", spec, np.eye(4))])
    assert world.lights.tables.info.array.size == INFO
    program = PROGRAM._replace(lights=("projector",), single_light=True)
    return [
        float(np.ravel(sample(world, p, 1, program=program).radiance.x)[0])
        * max(0.0, p[2] / np.linalg.norm(p))
        for p in np.transpose(points)
    ]


def test_a_screen_shows_the_picture():
    # Left, as seen along +z, is towards +x.
    spec = Projector(pixels=((1, 2), (3, 4)), fov=90.0)
    x, y = np.array([1.8, -1.8, 1.8, -1.8, 2.2, 0.0]), np.array([1.8, 1.8, -1.8, -1.8, 0.0, 0.0])
    found = projected(spec, (x, y, np.full(6, 2.0)))
    np.testing.assert_allclose(found, np.array([1, 2, 3, 4, 0, 2.5]) / 4, rtol=1e-5)
    # Behind it is nothing.
    assert projected(spec, ([0.1], [0.1], [-1.0])) == [0.0]


def test_a_spot_with_a_texture_is_even_in_its_intensity():
    spec = Projector(
        pixels=((1.0,),), fov=90.0, evenness="intensity", cutoff_angle=40.0, beam_width=20.0
    )
    angle = np.radians([0.0, 15.0, 30.0, 39.0, 41.0])
    found = projected(spec, (np.sin(angle), 0 * angle, np.cos(angle)))
    expected = np.array([1, 1, 0.5, 0.05, 0]) * np.cos(angle)
    np.testing.assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize(
    ("model", "fields", "words"),
    [
        (Ies, {}, "needs a file"),
        (Ies, {"file": "a.ies", "candela": ((1,),)}, "either file or"),
        (
            Ies,
            {"vertical_angles": (0, 90), "horizontal_angles": (0,), "candela": ((1,),)},
            "1 rows of 2",
        ),
        (Projector, {}, "needs a file"),
        (Projector, {"pixels": ((1.0,),), "beam_width": 5.0}, "at most a cutoff_angle"),
    ],
)
def test_descriptions_that_are_refused(model, fields, words):
    with pytest.raises(SceneError, match=words):
        model(**fields)
