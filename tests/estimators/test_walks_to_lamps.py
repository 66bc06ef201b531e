"""Steps of walks that look for caustics, where they end, and how often their ends count."""

from unittest import mock

import numpy as np
import pytest

from alight.accel import intersect_closest
from alight.core.constants import INFINITY
from alight.core.frame import frame_from_normal
from alight.core.vec import Vec3
from alight.integrators import walk
from alight.integrators.caustics.chain_types import Type
from alight.integrators.caustics.manifold_sampling import _is_kept
from alight.integrators.caustics.manifold_search import Begin, Search, _towards, search_lamps
from alight.integrators.caustics.manifold_walk import (
    ASIDE,
    LONGEST,
    MARGIN,
    Solution,
    axes_of,
    bent_by,
    draw_near,
    no_walker,
    place_near,
    solution_at,
    step_from,
    straight,
    updated,
)
from alight.integrators.caustics.specular_chain import MOST_EDGES
from alight.integrators.walk import to_local
from alight.laws.statistics import LARGEST_Z
from alight.lights.targets import target_at
from alight.media.tables import Stream
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate, kernel
from lanewise.simd import lanes
from tests.rendering.many_paths import compiled

N = 256


def vec3(rows):
    """Rows (n, 3) as a vector of lanes."""
    return Vec3(*np.asarray(rows, np.float32).T)


def rows_of(v, n=N):
    """A vector of lanes as rows."""
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)], axis=-1).astype(np.float64)


def walkers(rng, size, scale):
    """Walkers of random linear maps (n, 3, 2), at places (n, 2) from where the map is 0."""
    maps, place = rng.normal(size=(N, 3, 2)), rng.normal(size=(N, 2))
    place *= (size / np.linalg.norm(place, axis=1))[:, None]
    # Columns that lean on each other, by a half at most.
    maps *= scale * rng.uniform(0.5, 1.0, (N, 1, 2))
    miss = np.einsum("nij,nj->ni", maps, place)
    walker = no_walker()._replace(
        by_u=vec3(maps[..., 0]),
        by_v=vec3(maps[..., 1]),
        miss=vec3(miss),
        middle=vec3(miss * 0 + 3**-0.5),
    )
    return maps, place, walker


def form_of(end):
    """The form of a straight ellipse about a solution in the frame of its direction (n, 2, 2)."""
    s, t = (rows_of(v) for v in instantiate(frame_from_normal, compiled=False)(end.w))
    axis = rows_of(end.axis)
    longer = np.stack([(axis * s).sum(axis=1), (axis * t).sum(axis=1)], axis=1)
    shorter = longer[:, ::-1] * [-1.0, 1.0]
    return sum(
        np.asarray(square, float)[..., None, None] * v[:, :, None] * v[:, None, :]
        for square, v in ((end.along, longer), (end.across, shorter))
    )


@pytest.mark.parametrize("size", [0.01, 3.0])
def test_a_step_leads_to_where_a_linear_map_is_nought(size):
    maps, place, walker = walkers(np.random.default_rng(1), size, 500.0)
    step = np.stack(instantiate(step_from, compiled=False)(walker), axis=-1)
    wanted = -place * min(1.0, LONGEST / size)
    # As exact as the damping lets it: by its share of the mean square over the least one.
    sizes = np.linalg.svd(maps, compute_uv=False)
    fine = sizes[:, 1] > 0.2 * sizes[:, 0]
    assert fine.sum() > N // 2
    np.testing.assert_allclose(step[fine], wanted[fine], atol=2e-3 * np.abs(wanted).max())


def test_an_update_has_the_step_lead_where_it_led_and_changes_nothing_across():
    rng = np.random.default_rng(2)
    maps, _, walker = walkers(rng, 1.0, 1.0)
    step, miss = rng.normal(size=(N, 2)), rng.normal(size=(N, 3))
    by = instantiate(updated, compiled=False)(walker, *step.astype(np.float32).T, vec3(miss))
    new = np.stack([rows_of(column) for column in by], axis=-1)
    led = np.einsum("nij,nj->ni", new, step)
    np.testing.assert_allclose(led, miss - rows_of(walker.miss), atol=1e-4)
    across = step[:, ::-1] * [1.0, -1.0]
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", new - maps, across), 0.0, atol=1e-4 * np.abs(step).max() ** 2
    )


def test_the_ellipse_of_a_solution_has_the_area_that_its_density_says():
    maps, _, walker = walkers(np.random.default_rng(3), 1e-4, 500.0)
    axes, bent = (instantiate(text, compiled=False) for text in (axes_of, straight))
    end = instantiate(solution_at, compiled=False)(walker, axes(walker), bent())
    form = np.einsum("nij,nik->njk", maps, maps)
    area = np.pi * MARGIN**2 / np.sqrt(np.linalg.det(form))
    density, sizes = np.asarray(end.density, float), np.linalg.svd(maps, compute_uv=False)
    # Those that are longer than a radian end there.
    fine = (density > 0.0) & (sizes[:, 1] > 30.0)
    assert fine.sum() > N // 2
    np.testing.assert_allclose(density[fine] * area[fine], 1.0, rtol=2e-3)
    np.testing.assert_allclose(form_of(end), form, atol=1e-3 * np.abs(form).max())


def test_an_ellipse_bends_with_a_ring_of_solutions():
    """Directions that pass the lamp's middle are a circle about the axis of a ball."""
    radius, width = 0.25, 2e-4
    rng = np.random.default_rng(7)
    turn, off = rng.uniform(0.0, 2.0 * np.pi, N), width * rng.uniform(-0.9, 0.9, N)

    def directions(angle, turn):
        across = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
        return np.sin(angle)[:, None] * across + np.cos(angle)[:, None] * np.array([0.0, 0.0, 1.0])

    def miss(w):
        w = w / np.linalg.norm(w, axis=-1, keepdims=True)
        across = w[:, :2] / np.linalg.norm(w[:, :2], axis=1, keepdims=True)
        angle = np.arctan2(np.linalg.norm(w[:, :2], axis=1), w[:, 2])
        return np.column_stack([across * ((angle - radius) / width)[:, None], 0.0 * angle])

    middle = directions(radius + off, turn)
    run = {text: instantiate(text, compiled=False) for text in (axes_of, bent_by, solution_at)}
    s, t = (rows_of(v) for v in instantiate(frame_from_normal, compiled=False)(vec3(middle)))
    by = [(miss(middle + 1e-4 * e) - miss(middle - 1e-4 * e)) / 2e-4 for e in (s, t)]
    walker = no_walker()._replace(
        middle=vec3(middle), miss=vec3(miss(middle)), by_u=vec3(by[0]), by_v=vec3(by[1])
    )
    axes = run[axes_of](walker)
    assert np.all(axes.slender)
    step = np.asarray(axes.look * axes.x)[:, None] * s + np.asarray(axes.look * axes.y)[:, None] * t
    walker = walker._replace(ahead=vec3(miss(middle + step)))
    bent = run[bent_by](walker, axes, vec3(miss(middle - step)), np.ones(N, bool))
    end = run[solution_at](walker, axes, bent)
    # As a circle of this radius in the plane that touches the sphere there.
    np.testing.assert_allclose(np.abs(bent.bend), 0.5 / np.tan(radius), rtol=0.05)
    u2 = tuple(rng.random(N, np.float32) for _ in range(2))
    drawn = rows_of(instantiate(draw_near, compiled=False)(end, u2))
    passed = np.linalg.norm(miss(drawn), axis=1)
    assert (passed < MARGIN + ASIDE).mean() > 0.99
    # They are far apart: a straight ellipse that keeps to the ring is a tenth as long.
    lengths = 1.0 / np.sqrt(np.asarray(end.along, float))
    assert np.median(lengths) > 6.0 * np.sqrt(2.0 * radius * ASIDE * width)
    # The place from which the walk has come is in the ellipse about its end.
    q, _ = instantiate(place_near, compiled=False)(end, vec3(middle))
    assert (np.asarray(q) <= 1.0).mean() > 0.99


WATER = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: manifold}
camera: {type: pinhole, transform: {translate: [0, 0, 9]}}
nodes:
  floor: {shape: rectangle, transform: [{scale: 9}, {translate: [0, 0, -1]}]}
  water: {shape: rectangle, bsdf: {type: dielectric, int_ior: 1.33}, transform: [{scale: 9}]}
  lamp:
    shape: {type: sphere, center: [-1, 0.2, 0.6], radius: 0.004}
    light: {type: area, radiance: 5}
"""
LAMP, RADIUS, INDEX = np.array([-1.0, 0.2, 0.6]), 0.004, 1.33
#: Of `Type`: transmitted once.
THROUGH = 2


@kernel
def searched(scene, o, d, w, given, type, stream):
    """Search from where rays meet the floor."""
    hit = intersect_closest(scene, o, d, lanes(INFINITY), given)
    surface = make_surface(scene, hit, o, d, given)
    search = Search(
        surface=surface, wo=to_local(surface, -d), d=d, bodies=(), monochromatic=(), sampler=(),
        target=target_at(scene, type.count - 1), stream=stream, first=stream.a,
        most=stream.a + MOST_EDGES,
    )  # fmt: skip
    begin = Begin(~given, given, ~given, surface.p, w, type)
    return search_lamps(scene, search, begin), surface.p


def passes(p, w):
    """By how many radii rays from p in the water along w, any length, miss the lamp (n, 3)."""
    w = w / np.linalg.norm(w, axis=-1, keepdims=True)
    at = p - w * (p[..., 2:] / w[..., 2:])
    side = INDEX * w[..., :2]
    up = np.sqrt(1.0 - (side**2).sum(axis=-1, keepdims=True))
    d = np.concatenate([side, up], axis=-1)
    to = LAMP - at
    return (to - (to * d).sum(axis=-1, keepdims=True) * d) / RADIUS


def test_walks_end_at_the_ray_through_water_with_the_slopes_that_it_has():
    rng, scene = np.random.default_rng(4), compiled(WATER)
    p = np.concatenate([rng.uniform([0.5, -0.3], [1.2, 0.3], (N, 2)), np.full((N, 1), -1.0)], 1)
    # Towards a place above the lamp, as if there was no water.
    w = LAMP + np.array([0.0, 0.0, 1.0]) - p
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    above = vec3(p + np.array([0.0, 0.0, 0.5]))
    one, none = np.ones(N, bool), np.zeros(N, np.uint32)
    run = np.errstate(all="ignore")(instantiate(searched, scene.program, compiled=False))
    # Rays are counted by the bits of a packet, of which there is none here.
    with mock.patch.object(walk, "mask_bits", lambda mask: 0):
        down = vec3(np.tile([0.0, 0.0, -1.0], (N, 1)))
        result, met = run(
            scene.tables, above, down, vec3(w), one, Type(none + THROUGH, none + 1),
            Stream(none, none, none),
        )  # fmt: skip
    np.testing.assert_allclose(rows_of(met), p, atol=1e-5)
    end = result.second
    assert np.all(np.asarray(end.density) > 0.0)
    found = rows_of(end.w)
    # The solution is one: the ray passes the lamp's middle.
    assert np.linalg.norm(passes(p, found), axis=1).max() < 0.5
    s, t = (rows_of(v) for v in instantiate(frame_from_normal, compiled=False)(end.w))
    h = 1e-6
    slopes = np.stack(
        [(passes(p, found + h * e) - passes(p, found - h * e)) / (2.0 * h) for e in (s, t)], axis=-1
    )
    form = np.einsum("nij,nik->njk", slopes, slopes)
    scale = np.trace(form, axis1=1, axis2=2)
    # Differences of directions half as long as the lamp is wide are that far from derivatives.
    assert np.abs((form_of(end) - form) / scale[:, None, None]).max() < 3e-3


@pytest.mark.parametrize("distance", [0.5, 2.0])
def test_seeds_go_from_the_edge_of_the_lamp_to_the_other_side_of_the_world(distance):
    scene, radius = compiled(WATER), 0.1
    place = LAMP - distance * np.array([0.6, 0.0, 0.8])
    u = np.linspace(0.0, 1.0, N, dtype=np.float32)
    one = np.ones(N, np.float32)

    @kernel
    def towards(scene, surface, u, v):
        target = target_at(scene, 0)._replace(radius=0.1 + 0.0 * u)
        search = Search(surface, *[()] * 5, target, *[()] * 3)
        return _towards(search, u, v)

    surface = mock.Mock(p=Vec3(*(np.float32(c) * one for c in place)))
    drawn = instantiate(towards, scene.program, compiled=False)(
        scene.tables, surface, u, np.float32(0.3) * one
    )
    versed = 1.0 - rows_of(drawn) @ ((LAMP - place) / distance)
    # Half the square of the lamp's radius as seen from there, up to its fourth power.
    edge = 1.0 - np.cos(np.arcsin(radius / distance))
    np.testing.assert_allclose(versed, edge ** (1.0 - u) * 2.0**u, rtol=0.02, atol=1e-6)


def test_what_is_drawn_and_refused_adds_up_to_the_solid_angle():
    """Two solutions, of which the narrow one is too dense for the largest density of the wide one.

    Directions are drawn from either, kept, and weighted by the mean number of searches until one
    is taken over the largest density: that is the solid angle of what is covered.
    """
    n, chances, slack = 1 << 16, (0.6, 0.4), 1.2
    rng = np.random.default_rng(6)
    axis = vec3([[0.0, 0.6, 0.8]])
    one = np.ones(1, np.float32)
    ends = []
    for size in (0.2, 0.05):
        square = np.float32(size**-2.0)
        density = np.float32(1.0 / (np.pi * (MARGIN * size) ** 2))
        across = vec3([[1.0, 0.0, 0.0]])
        ends.append(Solution(axis, across, square * one, square * one, 0.0 * one, density * one))
    near, at = (instantiate(text, compiled=False) for text in (place_near, draw_near))
    values = []
    for end, chance in zip(ends, chances, strict=True):
        drawn = at(end, tuple(rng.random(n, np.float32) for _ in range(2)))
        (q, wide), (_, narrow) = (near(other, drawn) for other in ends)
        most = np.float32(slack) * wide
        own = wide if end is ends[0] else narrow
        kept = instantiate(_is_kept, compiled=False)(rng.random(n, np.float32), own, most)
        with np.errstate(all="ignore"):
            taken = sum(
                c * np.minimum(p / most, 1.0) for c, p in zip(chances, (wide, narrow), strict=True)
            )
            value = np.where((q <= 1.0) & kept, 1.0 / (taken * most), 0.0)
        values.append((chance * value.mean(), chance**2 * value.var() / n))
        # A search that is drawn with too much is refused, not all of them.
        assert 0.0 < kept[q < 0.01].mean() <= 1.0
    total, variance = np.sum(values, axis=0)
    # Of the cone whose edge has the tangent 0.2.
    wanted = 2.0 * np.pi * (1.0 - 1.0 / np.hypot(1.0, 0.2))
    assert abs(total - wanted) < LARGEST_Z * np.sqrt(variance), (total, wanted)
    assert np.sqrt(variance) < 0.01 * wanted
