"""Cameras, films and filters of pbrt, at random, by the formulas of its documentation.

Source: pbrt 3 and 4, "file formats"; PBR4 sections 5.2, 5.4.3 and 8.8.
"""

import math

import numpy as np
import pytest

from alight.cameras.rays import unproject
from alight.filters.model import FILTERS
from tests.formats.pbrt.reading import node, read

BALL = 'Shape "sphere"'


def listed(numbers):
    """Numbers as pbrt reads them."""
    return " ".join(f"{x:.9g}" for x in np.ravel(numbers))


def normalized(v):
    return v / np.linalg.norm(v)


def looking(rng):
    """A random LookAt, mirrored, and the matrix from the camera of pbrt to the world."""
    eye, target, up = rng.normal(size=(3, 3))
    ahead = normalized(target - eye)
    right = normalized(np.cross(normalized(up), ahead))
    made = np.eye(4)
    made[:3] = np.stack([right, np.cross(ahead, right), ahead, eye], axis=1)
    # What comes first acts on the world last.
    text = f"Scale -1 1 1 LookAt {listed([eye, target, up])}\n"
    return text, made @ np.diag([-1.0, 1.0, 1.0, 1.0])


def seen_at(scene, places):
    """Points at depth 1 and 2 that pixels show, both (n, 3)."""
    return [
        unproject(
            scene.camera.camera, scene.camera.transform.matrix, scene.film.size,
            np.column_stack([places, np.full(len(places), depth)]),
        )
        for depth in (1.0, 2.0)
    ]  # fmt: skip


@pytest.mark.parametrize("size", [(8, 4), (4, 8), (5, 5), (3, 7)])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("window", ["", "screenwindow", "frameaspectratio"])
def test_each_place_of_the_film_shows_what_it_does_in_pbrt(size, kind, window):
    rng = np.random.default_rng([*size, len(kind), len(window)])
    text, to_world = looking(rng)
    (width, height), aspect = size, size[0] / size[1]
    x, y = max(aspect, 1.0), max(1.0 / aspect, 1.0)
    given = ""
    if window == "screenwindow":
        y = rng.uniform(0.3, 3.0)
        x = y * aspect
        given = f'"float screenwindow" [{listed([-x, x, -y, y])}]'
    elif window:
        given = f'"float frameaspectratio" {aspect:.9g}'
    angle, scale = rng.uniform(20.0, 120.0), rng.uniform(0.3, 3.0)
    half = math.tan(math.radians(0.5 * angle)) if kind == "perspective" else scale
    names = [f'"float fov" {angle:.9g}', f'"float halffov" {0.5 * angle:.9g}']
    given += rng.choice(names) if kind == "perspective" else f'"float screenscale" {scale:.9g}'
    film = f'Film "rgb" "integer xresolution" {width} "integer yresolution" {height}\n'
    scene = read(BALL, f'{text}Camera "{kind}" {given}\n{film}')
    places = rng.uniform(0.0, 1.0, (20, 2)) * size
    sx, sy = (
        half * x * (2.0 * places[:, 0] / width - 1.0),
        half * y * (1.0 - 2.0 * places[:, 1] / height),
    )
    for depth, found in zip((1.0, 2.0), seen_at(scene, places), strict=True):
        spread = depth if kind == "perspective" else 1.0
        local = np.stack([sx * spread, sy * spread, np.full(20, depth), np.ones(20)])
        np.testing.assert_allclose(found, (to_world @ local)[:3].T, atol=1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_crops_hold_the_pixels_that_pbrt_renders(seed):
    rng = np.random.default_rng(seed)
    width, height = rng.integers(5, 40, 2)
    size = f'"integer xresolution" {width} "integer yresolution" {height}'
    (x0, x1), (y0, y1) = np.sort(rng.uniform(-0.1, 1.1, (2, 2)), axis=1)
    scene = read(BALL, f'Film "rgb" {size} "float cropwindow" [{x0} {x1} {y0} {y1}]')
    x, y, w, h = scene.film.crop
    columns = [i for i in range(width) if x0 * width <= i < x1 * width]
    rows = [j for j in range(height) if y0 * height <= j < y1 * height]
    assert (list(range(x, x + w)), list(range(y, y + h))) == (columns, rows)
    # The same by whole numbers.
    bounds = f"[{columns[0]} {columns[-1] + 1} {rows[0]} {rows[-1] + 1}]"
    other = read(BALL, f'Film "rgb" {size} "integer pixelbounds" {bounds}')
    assert other.film.crop == scene.film.crop


def bell(x, alpha, radius):
    return np.maximum(np.exp(-alpha * x * x) - np.exp(-alpha * radius * radius), 0.0)


def cubic(x, b, c, radius):
    t = np.abs(2.0 * x / radius)
    near = (12 - 9 * b - 6 * c) * t**3 + (-18 + 12 * b + 6 * c) * t**2 + 6 - 2 * b
    far = (-b - 6 * c) * t**3 + (6 * b + 30 * c) * t**2 + (-12 * b - 48 * c) * t + 8 * b + 24 * c
    return np.where(t < 1.0, near, far)


#: pbrt's words for a filter at a radius r and with two more numbers, and its formula.
CURVES = {
    "box": ("", lambda x, r, a, b: np.ones_like(x)),
    "triangle": ("", lambda x, r, a, b: np.maximum(r - np.abs(x), 0.0)),
    "mitchell": ('"float B" {a} "float C" {b}', lambda x, r, a, b: cubic(x, a, b, r)),
    "gaussian": ('"float alpha" {a}', lambda x, r, a, b: bell(x, a, r)),
    "gaussian of 4": ('"float sigma" {a}', lambda x, r, a, b: bell(x, 0.5 / (a * a), r)),
}
#: Radius and numbers where a file gives none; of 3 and of 4.
USUAL = {
    "box": ((0.5, 0, 0), (0.5, 0, 0)),
    "triangle": ((2.0, 0, 0), (2.0, 0, 0)),
    "mitchell": ((2.0, 1 / 3, 1 / 3), (2.0, 1 / 3, 1 / 3)),
    "gaussian": ((2.0, 2.0, 0), (1.5, 2.0, 0)),
    "gaussian of 4": (None, (1.5, 0.5, 0)),
}


def agrees(head, name, numbers):
    """Whether the filter of a film has the formula of pbrt's, but for a factor."""
    spec = read(BALL, head).film.filter
    radius = numbers[0]
    x = np.linspace(-0.99, 0.99, 23) * radius
    x, y = np.meshgrid(x, 0.7 * x)
    curve = CURVES[name][1]
    found = FILTERS[spec.type_name()].value(spec, x, y)
    wanted = curve(x, *numbers) * curve(y, *numbers)
    assert spec.radius == pytest.approx(radius)
    np.testing.assert_allclose(found / found[11, 11], wanted / wanted[11, 11], atol=1e-6)


@pytest.mark.parametrize("old", [False, True])
@pytest.mark.parametrize("name", CURVES)
def test_filters_are_those_of_pbrt(name, old):
    rng = np.random.default_rng(len(name))
    words, _ = CURVES[name]
    kind, film = name.partition(" ")[0], "image" if old else "rgb"
    numbers = (rng.uniform(1.0, 3.0), *rng.uniform(0.3, 0.9, 2))
    size = "width" if old else "radius"
    given = " ".join(f'"float {axis}{size}" {numbers[0]}' for axis in "xy")
    given += words.format(a=numbers[1], b=numbers[2])
    agrees(f'PixelFilter "{kind}" {given}\nFilm "{film}"\n', name, numbers)
    usual = USUAL[name][0 if old else 1]
    if usual is None or (kind == "gaussian" and "alpha" in words and not old):
        return
    agrees(f'PixelFilter "{kind}"\nFilm "{film}"\n', name, usual)


def test_what_moves_is_where_pbrt_has_it_at_its_times():
    rng = np.random.default_rng(9)
    times = np.sort(rng.uniform(0.0, 2.0, 2))
    places = rng.normal(size=(2, 3))
    moving = "".join(
        f"ActiveTransform {when} Translate {listed(place)}\n"
        for when, place in zip(("StartTime", "EndTime"), places, strict=True)
    )
    moving += "ActiveTransform All\n"
    timed = f"TransformTimes {listed(times)}\n"
    ball = node(read(moving + BALL, timed)).transform
    camera = read(BALL, f'{timed}{moving}Camera "perspective"\n').camera.transform
    # What moves the world one way moves the camera the other way.
    for motion, sign in ((ball, 1.0), (camera, -1.0)):
        assert [time for time, _ in motion.frames] == pytest.approx(times.tolist())
        found = [frame.matrix[:3, 3] for _, frame in motion.frames]
        np.testing.assert_allclose(found, sign * places, atol=1e-6)


def test_strata_along_both_sides_are_multiplied():
    scene = read(BALL, 'Sampler "stratified" "integer xsamples" 3 "integer ysamples" 5\n')
    assert scene.source.remarks.spp == 15
    assert scene.sampler.strata == 4
