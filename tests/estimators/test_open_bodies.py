"""Walks that leave an open body end by chance, by what they still may bring, and lose nothing."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.vec import Vec3
from alight.integrators.interiors import body_walk
from alight.integrators.interiors.endless import chance_of_return
from alight.integrators.walk import PathState
from alight.laws.statistics import LARGEST_Z
from alight.samplers.state import sampler_state
from alight.scene.flatten import flatten
from lanewise.jit import instantiate

WHITE = {"type": "subsurface", "ior": 1, "color": 1, "radius": 0.1}
TUBE = {"shape": "cylinder", "bsdf": WHITE}
LID = {"shape": "disk", "bsdf": WHITE, "transform": {"translate": [0, 0, 1]}}
BOTTOM = {"shape": {"type": "disk", "flip_normals": True}, "bsdf": WHITE}
#: Radius of the ball around the tube, and its middle, metres.
R, MIDDLE = 1.5, np.array([0.0, 0.0, 0.5])
N = 2**14


def scene(**nodes):
    look = {"look_at": {"origin": [0, -4, 3], "target": [0, 0, 0.5]}}
    return alight.load({
        "alight": 1, "camera": {"fov": 40, "transform": look},
        "film": {"size": [32, 32], "filter": {"type": "box"}},
        "sampler": {"type": "independent"},
        "environment": {"type": "constant", "radiance": 1}, "nodes": nodes,
    })  # fmt: skip


def compiled(**nodes):
    return compile_scene(flatten(scene(**nodes)), structure="list")


def at_distance(distance, n=N, seed=1):
    """Places so far from the middle, in all directions, as rows."""
    d = np.random.default_rng(seed).normal(size=(n, 3))
    return MIDDLE + distance * d / np.linalg.norm(d, axis=1)[:, None]


def chance(made, p):
    twin = instantiate(chance_of_return, made.program, compiled=False)
    return np.broadcast_to(twin(made.tables, Vec3(*p.astype(np.float32).T)), len(p))


def test_the_chance_to_come_back_is_harmonic_outside_of_all_shapes():
    """1 on the ball, 0 at infinity, and its own mean over every sphere that stays outside."""
    tube = compiled(tube=TUBE)
    assert chance(tube, at_distance(0.999 * R)) == pytest.approx(1.0)
    assert chance(tube, at_distance(1e6 * R, n=8)) == pytest.approx(1e-6, rel=1e-3)
    for distance, radius in ((2.0 * R, 0.9 * R), (5.0 * R, 3.0 * R)):
        middle = at_distance(distance, n=1)
        around = chance(tube, middle + at_distance(radius) - MIDDLE)
        error = around.std() / np.sqrt(N)
        assert abs(around.mean() - chance(tube, middle)[0]) < LARGEST_Z * error


@pytest.mark.parametrize(
    "nodes",
    [
        {"ball": {"shape": "sphere", "bsdf": WHITE}},
        {"tube": TUBE, "floor": {"shape": "plane"}},
        {"tube": {"shape": "cylinder"}},
    ],
    ids=["closed", "plane", "matte"],
)
def test_walks_go_on_where_bodies_end_or_planes_bring_them_back(nodes):
    made = compiled(**nodes)
    assert (chance(made, at_distance(9.0 * R)) == 1.0).all()
    assert not hasattr(made.tables.materials, "ball")


@pytest.mark.parametrize("distance", [0.3 * R, 4.0 * R, 40.0 * R])
def test_walks_that_survive_outside_stand_for_those_that_do_not(distance):
    """One scattering of walks that weigh 1: R / D of those below the bound go on."""
    made, at = compiled(tube=TUBE), at_distance(distance)
    index = np.arange(N, dtype=np.uint32)
    zero, one = np.zeros(N, np.float32), np.ones(N, np.float32)
    white, up = Vec3(one, one, one), Vec3(zero, zero, one)
    away = at - MIDDLE
    d = Vec3(*(away / np.linalg.norm(away, axis=1)[:, None]).astype(np.float32).T)
    going = np.full(N, True)
    path = PathState(*[()] * len(PathState._fields))._replace(
        o=Vec3(*at.astype(np.float32).T), d=d, beta=white, pdf=one, delta=~going, depth=index * 0,
        sampler=sampler_state(0 * index, 0 * index, index, 0 * index, 0 * index), active=going,
        rays=index * 0,
    )  # fmt: skip
    ten = np.full(N, 10.0, np.float32)
    extinction, none = Vec3(ten, ten, ten), Vec3(zero, zero, zero)
    nu = Vec3(*[np.full(N, 1e6, np.float32)] * 3)
    share = Vec3(one / 3.0, one / 3.0, one / 3.0)
    body = body_walk.Body(
        extinction=extinction, albedo=none, rarity=none, led=none, nu=nu, share=share, n=up,
        margin=zero,
    )  # fmt: skip
    way = body_walk.Way(~going, ten, nu.x, one)
    walk = body_walk.Walk(
        going=going, body=body, way=way, u=0.5 * one, step=index * 0, length=zero, height=zero,
        first=zero, factor=one,
    )  # fmt: skip
    with np.errstate(all="ignore"):
        _, on = instantiate(body_walk.scatter, made.program, compiled=False, lanes=N)(
            made.tables, path, walk
        )
    scattered = distance + np.log(2.0) / 10.0
    expected = min(1.0, R / scattered / body_walk.DIM)
    went = np.asarray(on.going).mean()
    assert went == pytest.approx(expected, abs=LARGEST_Z * np.sqrt(0.25 / N) + 1e-3)
    total = np.where(on.going, on.factor, 0.0)
    assert abs(total.mean() - 1.0) <= LARGEST_Z * total.std() / np.sqrt(N) + 1e-6


@pytest.mark.proofs
def test_an_open_tube_looks_the_same_with_far_fewer_steps(monkeypatch):
    """As with walks that end by their length alone."""
    films = [alight.render(scene(tube=TUBE), spp=64, seed=1, replicates=16)]
    monkeypatch.setattr("alight.compiled.scene.may_be_endless", lambda flat, shapes: False)
    films.append(alight.render(scene(tube=TUBE), spp=64, seed=2, replicates=16))
    means = [np.asarray(film.mean, float).mean() for film in films]
    errors = [
        np.sqrt((np.asarray(film.standard_error, float).mean(axis=2) ** 2).sum()) / 32**2
        for film in films
    ]
    assert abs(means[0] - means[1]) < LARGEST_Z * np.hypot(*errors)
    assert max(errors) < 0.002 < 1.0 - means[0]
    few, many = (film.stats["rays"] for film in films)
    assert few < 0.5 * many
