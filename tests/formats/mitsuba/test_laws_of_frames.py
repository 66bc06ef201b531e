"""Cameras, films, filters and transforms of Mitsuba, at random, by its documentation's formulas.

Source: Mitsuba 3, documentation of its plug-ins: a sensor looks along +z of its own space, with +x
to the left; `to_world` applies the first transform first; rows of a bitmap run down with v.
"""

import math

import numpy as np
import pytest

from alight.cameras.rays import unproject
from alight.filters.model import FILTERS
from alight.formats.mitsuba.transforms import _any_up
from tests.formats.mitsuba.reading import FILES, read, read_bsdf

BALL = '<shape type="sphere" id="it">{}</shape>'


def listed(numbers):
    """Numbers as Mitsuba reads them."""
    return " ".join(f"{x:.9g}" for x in np.ravel(numbers))


def moved(x):
    made = np.eye(4)
    made[:3, 3] = x
    return made


def turned(axis, degrees):
    """Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    k, angle = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), math.radians(degrees)
    made = np.eye(4)
    made[:3, :3] += math.sin(angle) * k + (1.0 - math.cos(angle)) * (k @ k)
    return made


def looking(origin, target, up):
    """The columns are left, up, ahead and where it stands."""
    ahead = (target - origin) / np.linalg.norm(target - origin)
    left = np.cross(up, ahead)
    left /= np.linalg.norm(left)
    made = np.eye(4)
    made[:3] = np.stack([left, np.cross(ahead, left), ahead, origin], axis=1)
    return made


def step(kind, rng):
    """One random transform as text, and its matrix."""
    x = rng.uniform(0.5, 2.0, 3)
    named = " ".join(f'{name}="{c:.9g}"' for name, c in zip("xyz", x, strict=True))
    if kind == "translate":
        return f"<translate {named}/>", moved(x)
    if kind == "scale":
        return f"<scale {named}/>", np.diag([*x, 1.0])
    if kind == "rotate":
        x /= np.linalg.norm(x)
        named = " ".join(f'{name}="{c:.9g}"' for name, c in zip("xyz", x, strict=True))
        angle = rng.uniform(-180.0, 180.0)
        return f'<rotate {named} angle="{angle:.9g}"/>', turned(x, angle)
    if kind == "lookat":
        points = rng.normal(size=(3, 3))
        words = " ".join(
            f'{name}="{listed(p)}"'
            for name, p in zip(("origin", "target", "up"), points, strict=True)
        )
        return f"<lookat {words}/>", looking(*points)
    matrix = np.eye(4)
    size = 3 if kind == "small matrix" else 4
    matrix[:3, :size] = rng.normal(size=(3, size))
    return f'<matrix value="{listed(matrix[:size, :size])}"/>', matrix


KINDS = ("translate", "scale", "rotate", "lookat", "matrix", "small matrix")


@pytest.mark.parametrize("kind", KINDS)
def test_transforms_apply_one_after_the_other(kind):
    rng = np.random.default_rng(len(kind))
    first, a = step(kind, rng)
    second, b = step(KINDS[KINDS.index(kind) - 1], rng)
    body = BALL.format(f'<transform name="to_world">{first}{second}</transform>')
    found = read(body).nodes["it"].transform.matrix
    np.testing.assert_allclose(found, b @ a, atol=1e-6)


@pytest.mark.parametrize("size", [(8, 4), (4, 8)])
@pytest.mark.parametrize("axis", ["x", "y", "diagonal", "smaller", "larger", "focal", "parallel"])
def test_each_place_of_the_film_shows_what_it_does_in_mitsuba(size, axis):
    rng = np.random.default_rng([*size, len(axis)])
    (width, height), (text, matrix) = size, step("lookat", rng)
    stretch = rng.uniform(0.5, 2.0)
    text = f'<transform name="to_world"><scale value="{stretch:.9g}"/>{text}</transform>'
    angle = rng.uniform(20.0, 100.0)
    given = f'<float name="fov" value="{angle:.9g}"/><string name="fov_axis" value="{axis}"/>'
    if axis == "focal":
        focal = rng.uniform(20.0, 90.0)
        given = f'<string name="focal_length" value="{focal:.9g}mm"/>'
        # Of a film of 36 by 24 mm, from corner to corner.
        angle = 2.0 * math.degrees(math.atan(0.5 * math.hypot(36.0, 24.0) / focal))
    side = {
        "x": width, "y": height, "smaller": min(size), "larger": max(size), "parallel": width,
    }.get(axis, math.hypot(width, height))  # fmt: skip
    half = 1.0 if axis == "parallel" else math.tan(math.radians(0.5 * angle))
    kind = "orthographic" if axis == "parallel" else "perspective"
    given = "" if axis == "parallel" else given
    film = "".join(
        f'<integer name="{n}" value="{v}"/>' for n, v in (("width", width), ("height", height))
    )
    scene = read(f'<sensor type="{kind}">{given}{text}<film type="hdrfilm">{film}</film></sensor>')
    places = rng.uniform(0.0, 1.0, (20, 2)) * size
    left = half * (width - 2.0 * places[:, 0]) / side
    up = half * (height - 2.0 * places[:, 1]) / side
    to_world = matrix @ np.diag([stretch, stretch, stretch, 1.0])
    for depth in (1.0, 2.0):
        found = unproject(
            scene.camera.camera, scene.camera.transform.matrix, scene.film.size,
            np.column_stack([places, np.full(20, depth)]),
        )  # fmt: skip
        spread = 1.0 if axis == "parallel" else depth
        local = np.stack([left * spread, up * spread, np.full(20, depth), np.ones(20)])
        np.testing.assert_allclose(found, (to_world @ local)[:3].T, atol=1e-5)


def test_crops_are_told_by_their_corner_and_size():
    rng = np.random.default_rng(4)
    names = ("crop_offset_x", "crop_offset_y", "crop_width", "crop_height")
    crop = rng.integers(1, 20, 4).tolist()
    words = [*zip(names, crop, strict=True), ("width", 60), ("height", 50)]
    film = "".join(f'<integer name="{n}" value="{v}"/>' for n, v in words)
    scene = read(f'<sensor type="perspective"><film type="hdrfilm">{film}</film></sensor>')
    assert (scene.film.size, list(scene.film.crop)) == ((60, 50), crop)


def cubic(x, b, c):
    t = np.abs(x)
    near = (12 - 9 * b - 6 * c) * t**3 + (-18 + 12 * b + 6 * c) * t**2 + 6 - 2 * b
    far = (-b - 6 * c) * t**3 + (6 * b + 30 * c) * t**2 + (-12 * b - 48 * c) * t + 8 * b + 24 * c
    return np.where(t < 1.0, near, far)


def bell(x, sigma):
    """Cut off at four standard deviations."""
    return np.exp(-0.5 * (x / sigma) ** 2) - np.exp(-8.0)


#: Filter -> its parameters with defaults, radius, formula.
CURVES = {
    "box": ({}, lambda n: 0.5, lambda x, n: np.ones_like(x)),
    "tent": ({"radius": 1.0}, lambda n: n["radius"], lambda x, n: 1.0 - np.abs(x / n["radius"])),
    "gaussian": ({"stddev": 0.5}, lambda n: 4.0 * n["stddev"], lambda x, n: bell(x, n["stddev"])),
    "mitchell": ({"B": 1 / 3, "C": 1 / 3}, lambda n: 2.0, lambda x, n: cubic(x, n["B"], n["C"])),
    "catmullrom": ({}, lambda n: 2.0, lambda x, n: cubic(x, 0.0, 0.5)),
}


@pytest.mark.parametrize("given", [False, True])
@pytest.mark.parametrize("name", CURVES)
def test_filters_are_those_of_mitsuba(name, given):
    numbers, radius, curve = CURVES[name]
    words = ""
    if given:
        drawn = np.random.default_rng(len(name)).uniform(0.3, 0.9, len(numbers))
        numbers = dict(zip(numbers, drawn, strict=True))
        words = "".join(f'<float name="{n}" value="{v}"/>' for n, v in numbers.items())
    film = f'<film type="hdrfilm"><rfilter type="{name}">{words}</rfilter></film>'
    spec = read(f'<sensor type="perspective">{film}</sensor>').film.filter
    assert spec.radius == pytest.approx(radius(numbers))
    x, y = np.meshgrid(*[np.linspace(-0.99, 0.99, 23) * spec.radius] * 2)
    found = FILTERS[spec.type_name()].value(spec, x, y)
    wanted = curve(x, numbers) * curve(y, numbers)
    np.testing.assert_allclose(found / found[11, 11], wanted / wanted[11, 11], atol=1e-6)


@pytest.mark.parametrize("old", [False, True])
def test_bitmaps_are_looked_up_row_by_row_from_their_top(old):
    rng = np.random.default_rng(8)
    if old:
        scale, offset = rng.uniform(0.5, 3.0, (2, 2))
        words = [*zip(("uscale", "vscale", "uoffset", "voffset"), [*scale, *offset], strict=True)]
        text = "".join(f'<float name="{n}" value="{v:.9g}"/>' for n, v in words)
        # As Mitsuba 3 reads such files.
        place = np.array([[scale[0], 0, scale[0] * offset[0]], [0, scale[1], scale[1] * offset[1]]])
    else:
        first, a = step("rotate", rng)
        angle = rng.uniform(-90.0, 90.0)
        first, a = f'<rotate z="1" angle="{angle:.9g}"/>', turned(np.array([0, 0, 1.0]), angle)
        second, b = step("scale", rng)
        third, c = step("translate", rng)
        text = f'<transform name="to_uv">{first}{second}{third}</transform>'
        place = (c @ b @ a)[:2][:, [0, 1, 3]]
    picture = next(path.name for path in sorted(FILES.iterdir()) if path.suffix == ".png")
    texture = (
        f'<texture type="bitmap" name="reflectance">'
        f'<string name="filename" value="{picture}"/>{text}</texture>'
    )
    found = read_bsdf(texture, 'type="diffuse"', "0.6.0" if old else "3.0.0")
    s, t, one = found.reflectance.lookup()[0], found.reflectance.lookup()[1], np.array([0, 0, 1.0])
    np.testing.assert_allclose([s, one - t], place, atol=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_what_stands_in_for_up_is_at_right_angles_to_the_view(seed):
    """The first axis of a frame about the view, of any length and in all octants."""
    rng = np.random.default_rng([109, seed])
    view = rng.uniform(0.1, 3.0, 3) * [1 - 2 * (seed >> bit & 1) for bit in range(3)]
    up = np.array(_any_up(view))
    assert abs(up @ view) < 1e-9 * np.linalg.norm(view)
    assert np.linalg.norm(up) == pytest.approx(1.0)
