"""Shapes that numbers of float32 cannot hold: what is said, and that it is said of them alone."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.scene.flatten import flatten

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
FACES = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]]


def warnings_of(**nodes):
    scene = alight.load({"camera": {}, "environment": {"type": "constant"}, "nodes": nodes})
    return compile_scene(flatten(scene)).warnings


def cube(place, size=1.0, axis=0):
    where = np.roll([place, 0.0, 0.0], axis).tolist()
    return {"shape": "cube", "transform": [{"scale": size}, {"translate": where}]}


def mesh(size, place=0.0):
    vertices = (CORNERS * size + place).tolist()
    return {"shape": {"type": "mesh", "vertices": vertices, "faces": FACES}}


@pytest.mark.parametrize(
    "node",
    [cube(1e5), cube(-1e5), cube(1e5, axis=1), cube(-1e5, axis=2), mesh(1.0, 1e5), cube(1e2, 1e-3)],
)
def test_what_is_far_away_for_its_size_is_rounded(node):
    texts = warnings_of(near=cube(10.0), far=node)
    assert len(texts) == 1, texts
    text = texts[0]
    assert text.startswith(("far: 1", "far: its vertices lie 1e+05 m"))
    assert "m from the origin" in text


def test_the_share_is_what_float32_does_to_it():
    (text,) = warnings_of(far=mesh(1.0, 1e6))
    told = float(text.split("numbers of float32 are ")[1].split(" %")[0]) / 100.0
    places = 1e6 + np.random.default_rng(0).uniform(0.0, 1.0, 20000)
    worst = np.abs(places.astype(np.float32).astype(float) - places).max()
    assert told == pytest.approx(2.0 * worst, rel=0.02)


@pytest.mark.parametrize("axis", range(3))
def test_the_longest_side_is_the_size_of_a_shape(axis):
    """A long and thin rod is told where one as long as it is thick would be, and no earlier."""
    sides = np.roll([1e3, 1.0, 1.0], axis)
    assert not warnings_of(rod=mesh(sides, 1e6))
    assert warnings_of(rod=mesh(1.0, 1e6))


def test_several_are_told_in_one_line():
    (text,) = warnings_of(a=cube(1e6), b=cube(2e6), c=cube(3e6))
    assert text.startswith("a (and 2 more): ")


@pytest.mark.parametrize("size", [1e-10, 1e10])
def test_meshes_outside_of_exact_normals_are_told(size):
    (text,) = warnings_of(m=mesh(size))
    assert " m across: normals of triangles" in text


def test_others_are_not():
    assert not warnings_of(
        a=cube(5e3), b=mesh(1e-7), c=cube(0.0, 1e-10), d=mesh(1e8), e=cube(0.0, 1e11)
    )
