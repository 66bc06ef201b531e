"""Textured lamps: points chosen by their light, whichever shape it is spread over."""

import numpy as np
import pytest

from alight.accel import intersect_closest
from alight.compiled.scene import compile_scene
from alight.core.distributions import UNIT
from alight.formats import loads
from alight.lights.area_map import share_of, square_density, square_of
from alight.lights.hits import emitted, light_pdf
from alight.lights.sampling import sample_light
from alight.lights.tables import MAP_START, MAPPED, STRIDE, TEXTURED
from alight.scene.flatten import flatten
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square, z_of_mean
from tests.shapes.tracing import directions, finite, rows, vec

N = 16_000
#: One texel shines a thousand times as bright as the others.
TEXEL = [[1.0 if (x, y) != (6, 2) else 1000.0 for x in range(8)] for y in range(8)]
SHAPES = {
    "rectangle": "rectangle",
    "disk": "disk",
    "sphere": "sphere",
    "ellipsoid": "sphere, transform: {scale: [1, 0.8, 0.9]}",
    "room": "{type: sphere, radius: 9, flip_normals: true}",
    "cylinder": "cylinder, transform: {rotate: {axis: x, angle: 70}}",
    "mesh": "{type: mesh, vertices: [[-1, -1, 0], [1, -1, 0.2], [1, 1, 0], [-0.3, 0.6, 0.3]], "
    "faces: [[0, 1, 2], [0, 2, 3]], uvs: [[0, 0], [1, 0], [1, 1], [0.1, 1]]}",
}
#: Seen from near and from far.
VIEWS = {"near": (0.3, -0.25, 1.4), "far": (1.0, 0.5, 7.0)}
each_shape = pytest.mark.parametrize("shape", SHAPES)
each_view = pytest.mark.parametrize("view", VIEWS)


def lamp(shape, pixels=TEXEL, more=""):
    """The scene of one lamp with a picture."""
    radiance = f"{{type: bitmap, pixels: {pixels}, {more}}}"
    light = f"light: {{type: area, radiance: {radiance}}}"
    text = f"alight: 1\ncamera: {{}}\nnodes: {{a: {{shape: {SHAPES[shape]}, {light}}}}}\n"
    return compile_scene(flatten(loads(text)), structure="list")


def run(scene, kernel, *arguments):
    with np.errstate(all="ignore"):
        return instantiate(kernel, scene.program, compiled=False)(scene.tables, *arguments)


def place(view, shape, n=N):
    z = 0.2 if shape == "room" else 1.0
    return np.tile(np.reshape(VIEWS[view], (3, 1)) * [[1.0], [1.0], [z]], n)


def samples(scene, p, seed):
    """(unit directions, radiance of one channel, density, distance) of samples at p (3, n)."""
    n = p.shape[1]
    u = np.random.default_rng(seed).random((3, n), np.float32)
    s = run(scene, sample_light, vec(p), vec(p), u[0], (u[1], u[2]), np.ones(n, bool))
    columns = s.radiance.x, s.pdf, s.distance, s.cosine
    return rows(s.wi), *(np.broadcast_to(a, n).astype(float) for a in columns)


def hits(scene, p, d):
    """(radiance of one channel, density, distance) along directions (3, n) from p; 0 for misses."""
    n = d.shape[1]
    o, d = vec(p), vec(d)
    active = np.ones(n, bool)
    hit = run(scene, intersect_closest, o, d, np.full(n, np.inf, np.float32), active)
    found = np.isfinite(hit.t)
    surface = run(scene, make_surface, finite(hit), o, d, found)
    distance = np.where(found, hit.t, 1.0).astype(np.float32)
    light = np.where(found, surface.light, 0).astype(np.uint32)
    pdf = run(scene, light_pdf, light, o, d, distance, surface)
    radiance = run(scene, emitted, surface, -d).x
    return np.where(found, radiance, 0.0), np.where(found, pdf, 0.0), distance


TURNED = "wrap: mirror, to_uv: [{scale: [2.3, 0.7]}, {rotate: 20}]"


@each_shape
@each_view
@pytest.mark.parametrize("more", ["interpolation: nearest", TURNED], ids=["nearest", "turned"])
def test_samples_have_the_density_of_hits_and_bring_the_same_light(shape, view, more):
    scene = lamp(shape, more=more)
    p = place(view, shape)
    wi, light, pdf, distance, cosine = samples(scene, p, 1)
    _, found, met = hits(scene, p, wi)
    clear = (pdf > 0.0) & (found > 0.0) & (cosine > 0.05) & (np.abs(met - distance) < 1e-3)
    assert clear.sum() > 100
    same = np.isclose(found[clear], pdf[clear], rtol=5e-3)
    # Next to the edge of a cell rounding tells.
    assert same.mean() > 0.998
    d = directions(60_000, np.random.default_rng(2))
    by_chance, density, _ = hits(scene, place(view, shape, 60_000), d)
    share = np.mean(pdf > 0.0)
    error = np.sqrt(share * (1.0 - share) / N)
    assert abs(z_of_mean(4.0 * np.pi * density, share, error)) < LARGEST_Z
    by_light = np.where(pdf > 0.0, light / np.where(pdf > 0.0, pdf, 1.0), 0.0)
    error = by_light.std() / np.sqrt(N)
    assert abs(z_of_mean(4.0 * np.pi * by_chance, by_light.mean(), error)) < LARGEST_Z


@pytest.mark.parametrize("shape", ["rectangle", "disk", "mesh"])
def test_bright_texels_are_drawn_by_their_light(shape):
    scene = lamp(shape, more="interpolation: nearest")
    _, light, _, _, _ = samples(scene, place("far", shape), 3)
    # One texel of 64 gives nine tenths of the light or more; cells at its rim count in part.
    assert np.mean(light > 500.0) > 0.8


@each_view
def test_places_are_chosen_as_the_density_says(view):
    scene = lamp("rectangle")
    p = place(view, "rectangle")
    wi, _, pdf, distance, _ = samples(scene, p, 4)
    word = np.zeros(N, np.uint32)
    x, y, _ = run(scene, square_of, word, word, word, vec(p + distance * wi))
    side, fine = 8, 24
    at = (np.mgrid[: side * fine, : side * fine] + 0.5) / (side * fine)
    q = np.stack([2.0 * at[1].ravel() - 1.0, 2.0 * at[0].ravel() - 1.0, 0.0 * at[0].ravel()])
    to = q - place(view, "rectangle", q.shape[1])
    length = np.linalg.norm(to, axis=0)
    _, density, _ = hits(scene, place(view, "rectangle", q.shape[1]), to / length)
    expected = density * -to[2] / length**3 * 4.0 / length.size
    expected = expected.reshape(side, fine, side, fine).sum((1, 3)).ravel()
    cell = [np.clip(side * np.broadcast_to(a, N), 0, side - 1).astype(int) for a in (y, x)]
    counts = np.bincount(side * cell[0] + cell[1], minlength=side * side)
    assert chi_square([*counts, 0], expected / expected.sum()) > SIGNIFICANCE
    assert expected.sum() == pytest.approx(1.0, abs=2e-3) and np.all(pdf > 0.0)


def test_far_rectangles_are_drawn_by_their_picture_and_near_ones_by_what_stands_out():
    scene = lamp("rectangle")
    at = scene.tables.lights.data.array.view(np.uint32)[MAP_START : MAP_START + 1]
    # The corners are the root of two away from the middle.
    for z, share in ((1.0, 0.5), (2.0, 0.75), (1e4, 1.0)):
        found = run(scene, share_of, at, vec([[0.0], [0.0], [z]]))
        np.testing.assert_allclose(found, share, atol=5e-3)


def test_the_last_cell_holds_the_edge_of_the_square():
    scene = lamp("rectangle", [[1.0, 50.0], [2.0, 90.0]], "interpolation: nearest")
    at = scene.tables.lights.data.array.view(np.uint32)[[MAP_START] * 3]
    edge, inside = (np.float32([[a, 0.3, a], [0.3, a, a]]) for a in (1.0, 0.9999))
    found, wanted = (run(scene, square_density, at, x, y) for x, y in (edge, inside))
    np.testing.assert_array_equal(found, wanted)


def test_points_are_weighed_in_the_cell_that_they_were_drawn_in():
    # From afar rounding leads over the sharp edges of a texel, into cells of hardly any density.
    dark = [[1000.0 if (x, y) == (20, 33) else 0.0 for x in range(64)] for y in range(64)]
    scene = lamp("rectangle", dark, "interpolation: nearest, color_space: linear")
    p = np.tile(np.float32([[80.0], [-70.0], [100.0]]), N)
    _, radiance, pdf, distance, cosine = samples(scene, p, 11)
    per_area = (pdf * cosine / distance**2)[radiance > 0.0]
    assert per_area.min() > 0.5 * np.median(per_area)


def test_lamps_whose_light_the_map_misses_are_chosen_too():
    strip = [[9.0 if x == 400 else 0.0 for x in range(8192)]] * 2
    picture = f"{{type: bitmap, pixels: {strip}, interpolation: nearest, color_space: linear}}"
    text = "alight: 1\ncamera: {}\nnodes:\n"
    for name, radiance in (("strip", picture), ("other", "2")):
        text += f"  {name}: {{shape: rectangle, light: {{type: area, radiance: {radiance}}}}}\n"
    pmf = compile_scene(flatten(loads(text))).tables.lights.data.array.reshape(-1, STRIDE)[:, 3]
    assert pmf.min() > 0.0


@pytest.mark.parametrize("shape", ["rectangle", "mesh"])
def test_even_pictures_have_no_map(shape):
    scene = lamp(shape, pixels=[[2.0, 2.0], [2.0, 2.0]])
    assert scene.program.lights == ("area", TEXTURED)


@pytest.mark.parametrize(("bright", "is_mapped"), [(5.0, False), (7.0, True)])
def test_a_map_gains_half_of_the_mean_square_or_there_is_none(bright, is_mapped):
    # Two halves, 1 and b: even points gain 2 (1 + b^2) / (1 + b)^2, which is 1.44 and 1.56.
    scene = lamp("rectangle", pixels=[[1.0, bright]], more="interpolation: nearest")
    assert (MAPPED in scene.program.lights) == is_mapped


def test_lamps_are_known_by_the_part_of_the_picture_that_they_show():
    half = "to_uv: {scale: [0.5, 1]}, interpolation: nearest"
    text = "alight: 1\ncamera: {}\nnodes:\n"
    for name, pixels in (("left", "[[3, 100]]"), ("right", "[[1, 0]]")):
        light = f"{{type: area, radiance: {{type: bitmap, pixels: {pixels}, {half}}}}}"
        text += f"  {name}: {{shape: rectangle, light: {light}}}\n"
    pmf = compile_scene(flatten(loads(text))).tables.lights.data.array.reshape(-1, STRIDE)[:, 3]
    assert pmf[0] / pmf[1] == pytest.approx(3.0, rel=1e-5)


def test_triangles_are_chosen_by_their_light():
    scene = lamp("mesh", pixels=[[8.0, 8.0], [8.0, 0.0]], more="interpolation: nearest")
    cdf = scene.tables.lights.cdf.array[2:5]
    v = np.array([[-1, -1, 0], [1, -1, 0.2], [1, 1, 0], [-0.3, 0.6, 0.3]])
    areas = [0.5 * np.linalg.norm(np.cross(v[b] - v[0], v[b + 1] - v[0])) for b in (1, 2)]
    # A quarter of the picture is dark, below on the right: as barycentrics tell, by a fine grid.
    b1, b2 = np.mgrid[:400, :400] / 400.0 + 1.0 / 1200.0
    inside = b1 + b2 < 1.0
    uv = np.array([[0, 0], [1, 0], [1, 1], [0.1, 1]])
    powers = []
    for area, a in zip(areas, (1, 2), strict=True):
        s, t = (b1 * uv[a, i] + b2 * uv[a + 1, i] for i in (0, 1))
        powers.append(area * np.mean(((s < 0.5) | (t > 0.5))[inside]))
    assert np.diff(cdf)[0] == pytest.approx(powers[0] / sum(powers), abs=5e-3)
    assert np.diff(cdf)[1] > UNIT
