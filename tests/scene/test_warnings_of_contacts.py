"""Boundaries of bodies in one place: what is said, and that it is said of them alone."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.options.animation import AnimationOptions
from alight.rendering.animation import Animation
from alight.scene.flatten import flatten

FOG = {"type": "homogeneous", "sigma_a": 0.3, "sigma_s": 0}
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
SIDES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip


def warnings_of(**nodes):
    scene = alight.load({"camera": {}, "environment": {"type": "constant"}, "nodes": nodes})
    return [w for w in compile_scene(flatten(scene)).warnings if "in one place" in w]


def node(place, shape="cube", **keys):
    keys = keys or {"bsdf": {"type": "null"}, "interior": FOG}
    return {"shape": shape, "transform": {"translate": place}, **keys}


GLASS = {"bsdf": {"type": "dielectric"}}
MESH = {"type": "mesh", "vertices": CUBE.tolist(), "faces": SIDES}


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("other", [{}, GLASS, {"shape": MESH}], ids=["fog", "glass", "mesh"])
def test_faces_in_one_place_are_told(axis, other):
    away = [0.5, 0.5, 0.5]
    away[axis] = 2.0
    (text,) = warnings_of(a=node([0, 0, 0]), b=node(away, **other))
    assert "a and b have faces in one place" in text or "b and a have" in text
    assert f"{'xyz'[axis]} = 1:" in text


@pytest.mark.parametrize(
    "other",
    [
        node([2.001, 0, 0]),
        node([1.5, 0.5, 0.5]),
        node([2, 2, 0.5]),
        node([2, 0, 0], bsdf={"type": "diffuse"}),
        node([2, 0, 0], "sphere"),
        {**node([2, 0, 0]), "transform": [{"rotate": {"axis": [1, 2, 3], "angle": 40}}]},
    ],
    ids=["a gap", "an overlap", "along an edge", "a wall", "a ball", "a turned box"],
)
def test_others_are_not(other):
    assert warnings_of(a=node([0, 0, 0]), b=other) == []


def test_a_pane_in_a_frame_of_its_height_touches_nothing():
    """The box around a plane of the frame would hold the pane."""
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    corners = [corner * [r, r, 1] + [0, 0, z] for z in (0, 1) for r in (2, 1) for corner in square]
    rim = [[i, (i + 1) % 4, 4 + i] for i in range(4)]
    rim += [[(i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    faces = rim + [[8 + a, 8 + c, 8 + b] for a, b, c in rim]
    frame = {"type": "mesh", "vertices": np.array(corners, float).tolist(), "faces": faces}
    pane = {"shape": "cube", "transform": [{"scale": [0.8, 0.8, 0.5]}, {"translate": [0, 0, 0.5]}]}
    assert warnings_of(frame={"shape": frame, **GLASS}, pane={**pane, **GLASS}) == []
    wide = {**pane, "transform": [{"scale": [1.2, 0.8, 0.5]}, {"translate": [0, 0, 0.5]}]}
    assert len(warnings_of(frame={"shape": frame, **GLASS}, pane={**wide, **GLASS})) == 1


def test_no_faces_at_all():
    assert warnings_of(a=node([0, 0, 0], "sphere"), b=node([2, 0, 0], "sphere")) == []


def test_far_away_a_gap_is_one_and_places_are_told_in_the_world():
    def world(gap):
        a, b = node([0, 0, 0]), node([2.0 + gap, 0, 0])
        eye = {"camera": {"type": "pinhole"}, "transform": {"translate": [0, 0, 9]}}
        children = {"a": a, "b": b, "eye": eye}
        return {
            "camera": "world/eye",
            "environment": {"type": "constant"},
            "nodes": {"world": {"transform": {"translate": [1e6, 0, 0]}, "children": children}},
        }

    apart, touching = (
        compile_scene(flatten(alight.load(world(gap)))).warnings for gap in (0.05, 0)
    )
    assert apart == ()
    assert "x = 1e+06" in touching[0]


def test_a_body_within_another_may_share_its_bottom():
    assert warnings_of(a=node([0, 0, 0]), b=node([0, 0, 0], MESH, **GLASS))


def test_renders_say_so():
    cubes = {"a": node([0, 0, 0]), "b": node([2, 0, 0])}
    environment, film = {"type": "constant"}, {"size": [2, 2]}
    scene = alight.load({"camera": {}, "environment": environment, "film": film, "nodes": cubes})
    (text,) = alight.render(scene, spp=1).warnings
    assert "have faces in one place" in text


def test_animations_say_so_once(tmp_path):
    cubes = {"a": node([0, 0, 0]), "b": node([2, 0, 0])}
    environment, film = {"type": "constant"}, {"size": [2, 2]}
    scene = alight.load({"camera": {}, "environment": environment, "film": film, "nodes": cubes})
    asked = {"output": str(tmp_path / "a####.png"), "frames": "0:2", "turntable": True, "spp": 1}
    made = Animation(scene, AnimationOptions(**asked))
    made.render()
    (text,) = made.warnings
    assert "have faces in one place" in text
