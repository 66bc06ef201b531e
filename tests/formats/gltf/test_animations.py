"""Animations at a time: nodes, joints of skins and morph targets, against closed forms."""

import numpy as np
import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.gltf.scene import parse
from alight.formats.reading.shown import Shown
from alight.scene.flatten import flatten
from tests.formats import bare
from tests.formats.gltf.maker import POINTS, Maker
from tests.formats.gltf.test_skins import with_skin

HALF = np.sqrt(0.5)


def animated(m, *channels, name=None):
    """Append an animation of (node, path, times, values, interpolation)."""
    made = {"samplers": [], "channels": []} | ({} if name is None else {"name": name})
    for node, path, times, values, way in channels:
        sampler = {
            "input": m.accessor(np.array(times, "<f4")),
            "output": m.accessor(np.array(values, "<f4")),
            "interpolation": way,
        }
        target = {"node": node, "path": path}
        made["channels"].append({"sampler": len(made["samplers"]), "target": target})
        made["samplers"].append(sampler)
    m.json.setdefault("animations", []).append(made)
    return m


def moving(path, times, values, way="LINEAR", **node):
    m = Maker()
    return animated(m, (m.node(mesh=m.square(), **node), path, times, values, way))


def points_at(m, at, tmp_path, **more):
    """World-space vertices of the only mesh."""
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    [placed] = flatten(bare.load(tmp_path / "a.gltf", at=at, **more)).shapes
    matrix = placed.to_world
    return placed.shape.vertices @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize(
    ("at", "x"), [(None, 9.0), (0.0, 1.0), (1.0, 1.0), (2.0, 3.0), (3.5, 9.0), (8.0, 13.0)]
)
def test_positions_run_evenly_between_keys(at, x, tmp_path):
    # At rest the node is elsewhere; before the first key and after the last one it stays.
    m = moving("translation", [1, 3, 4], [[1, 0, 0], [5, 0, 0], [13, 0, 0]], translation=[9, 0, 0])
    np.testing.assert_allclose(points_at(m, at, tmp_path), np.add(POINTS, [x, 0, 0]), atol=1e-5)


@pytest.mark.parametrize(("at", "x"), [(1.0, 1.0), (2.999, 1.0), (3.0, 5.0), (9.0, 5.0)])
def test_steps_jump_at_their_keys(at, x, tmp_path):
    m = moving("translation", [1, 3], [[1, 0, 0], [5, 0, 0]], "STEP")
    np.testing.assert_allclose(points_at(m, at, tmp_path), np.add(POINTS, [x, 0, 0]), atol=1e-5)


@pytest.mark.parametrize("frame", [1, 3, 7])
def test_steps_at_their_keys_are_those_of_the_keys_as_they_are_written(frame, tmp_path):
    # Single precision puts 1 / 30 s a trifle later.
    times = np.arange(8) / 30.0
    m = moving("translation", times, [[n, 0, 0] for n in range(8)], "STEP")
    found = points_at(m, frame / 30.0, tmp_path)
    np.testing.assert_allclose(found, np.add(POINTS, [frame, 0, 0]), atol=1e-5)


def test_splines_are_the_cubics_of_their_tangents(tmp_path):
    # x = t^3 - 2t, y = 1, z = t^2 between 1 and 3: a cubic of Hermite gives them back.
    rows = []
    for t in (1.0, 3.0):
        slope = [3 * t**2 - 2, 0, 2 * t]
        # How the first key is reached, and the last one left, plays no part.
        reached, left = (slope, [9, 9, 9]) if rows else ([9, 9, 9], slope)
        rows += [reached, [t**3 - 2 * t, 1, t**2], left]
    m = moving("translation", [1, 3], rows, "CUBICSPLINE")
    for t in (1.0, 1.3, 2.6, 3.0):
        meant = np.add(POINTS, [t**3 - 2 * t, 1, t**2])
        np.testing.assert_allclose(points_at(m, t, tmp_path), meant, atol=1e-4)


def test_rotations_turn_evenly_the_shorter_way(tmp_path):
    # A quarter turn about z; its end is written as the quaternion of the other sign.
    m = moving("rotation", [0, 3], [[0, 0, 0, 1], [0, 0, -HALF, -HALF]])
    angle = np.radians(30.0)
    turn = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    meant = POINTS @ np.transpose(turn)
    np.testing.assert_allclose(points_at(m, 1.0, tmp_path), meant, atol=1e-5)


def test_joints_move_what_they_hold(tmp_path):
    shift = np.eye(4)
    shift[:3, 3] = 0, 10, 0
    bind = np.stack([shift.T.ravel(), np.eye(4).ravel()])
    m = with_skin(bind=bind)
    moves = [[0, 0, 5], [0, 0, 9]]
    m = animated(
        m,
        (0, "translation", [0, 2], moves, "LINEAR"),
        (1, "scale", [0, 2], [[2, 2, 2], [6, 6, 6]], "LINEAR"),
    )
    # Joint 0 has gone to z = 7; joint 1 is 4 times as large, at z = 5, and turned: x becomes -z.
    meant = [[0, 10, 7], [0, 0, 1], [0, 4, 1], [0, 11, 7]]
    np.testing.assert_allclose(points_at(m, 1.0, tmp_path), meant, atol=2e-5)


def test_weights_of_morph_targets_are_sampled(tmp_path):
    m = Maker()
    index = m.square()
    up, right = np.zeros((2, 4, 3), "<f4")
    up[0, 2], right[2, 0] = 1.0, 1.0
    targets = [{"POSITION": m.accessor(table)} for table in (up, right)]
    m.json["meshes"][index]["primitives"][0]["targets"] = targets
    m.json["meshes"][index]["weights"] = [5.0, 5.0]
    node = m.node(mesh=index)
    m = animated(m, (node, "weights", [0, 2], [0.0, 1.0, 1.0, 3.0], "LINEAR"))
    np.testing.assert_allclose(points_at(m, 0.5, tmp_path), POINTS + 0.25 * up + 1.5 * right)
    # Of a node with a matrix, too, whose place cannot be animated.
    m.json["nodes"][node]["matrix"] = np.eye(4).ravel().tolist()
    np.testing.assert_allclose(points_at(m, 0.5, tmp_path), POINTS + 0.25 * up + 1.5 * right)
    np.testing.assert_allclose(points_at(m, None, tmp_path), POINTS + 5.0 * up + 5.0 * right)


def test_animations_are_chosen_by_name_or_number(tmp_path):
    m = moving("translation", [0], [[1, 0, 0]])
    m.json["animations"][0]["name"] = "walk"
    m = animated(m, (0, "translation", [0], [[2, 0, 0]], "LINEAR"), name="run")
    for chosen, x in ((None, 1), ("walk", 1), ("run", 2), ("1", 2)):
        found = points_at(m, 0.0, tmp_path, animation=chosen)
        np.testing.assert_allclose(found, np.add(POINTS, [x, 0, 0]))
    notes = parse(m.gltf(), "a.gltf", None, Shown(at=0.0)).notes
    assert 'other animations ("run"): --animation shows one of them' in notes
    scene = alight.load(tmp_path / "a.gltf", at=0.0, animation="run")
    assert (scene.source.recipe.at, scene.source.recipe.animation) == (0.0, "run")


def refused(m, **shown):
    with pytest.raises(SceneError) as caught:
        parse(m.gltf(), "a.gltf", None, Shown(**{"at": 0.0, **shown}))
    return str(caught.value)


def test_what_is_wrong_has_its_place():
    still = Maker()
    still.node(mesh=still.square())
    assert "--at\n  the file has no animations" in refused(still)
    m = moving("translation", [0, 1], [[1, 0, 0], [2, 0, 0]])
    assert "give it, too" in refused(m, at=None, animation="walk")
    assert "must be below the number of animations, 1, got 3" in refused(m, animation="3")
    late = moving("translation", [1, 1], [[1, 0, 0], [2, 0, 0]])
    assert "/animations/0/samplers/0/input\n  must hold times that grow" in refused(late)
    few = moving("translation", [0, 1], [[1, 0, 0]])
    assert "samplers/0/output\n  must hold 1 values for each of 2 times" in refused(few)
    flat = moving("rotation", [0], [[1, 0, 0]])
    assert "must have rows of 4 numbers, got 3" in refused(flat)
    wild = moving("translation", [0], [[np.nan, 0, 0]])
    assert "must hold finite numbers" in refused(wild)
    with pytest.raises(SceneError, match="only glTF and OpenUSD files"):
        alight.load("cornell-box", at=1.0)


def test_what_plays_no_part_is_told():
    m = moving("pointer", [0], [[1, 0, 0]])
    [line] = [w for w in parse(m.gltf(), "a.gltf", None, Shown(at=0.0)).warnings if "/anim" in w]
    assert 'an animation of "pointer" is left out' in line
    m = moving("scale", [0], [[2, 2, 2]], matrix=np.eye(4).ravel().tolist())
    found = parse(m.gltf(), "a.gltf", None, Shown(at=0.0))
    assert any("it has a matrix" in line for line in found.warnings)
