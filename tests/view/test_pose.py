"""The camera's moves, by what they leave alone and by going there and back."""

import math
from dataclasses import fields

import numpy as np
import pytest

import alight
from alight.cameras.basis import project_points
from alight.cameras.model import CAMERAS
from alight.cameras.orthographic import Orthographic
from alight.cameras.pinhole import Pinhole
from alight.cameras.thin_lens import ThinLens
from alight.scene import look_at, rotate, scale
from alight.scene.flatten import PlacedCamera, place_camera
from alight.view import protocol
from alight.view.pose import POLE, Pose

SIZE = (64, 36)
CAMERAS_OF_ALL_KINDS = [
    Pinhole(fov=35.0),
    ThinLens(fov=50.0, fov_axis="x"),
    Orthographic(height=3.0),
]


def pose_of(camera, seed=0):
    draw = np.random.default_rng(seed)
    origin = draw.uniform(2.0, 4.0, 3)
    placed = look_at(tuple(origin), tuple(draw.uniform(-0.5, 0.5, 3))) @ scale(1.5)
    pose = Pose.of(PlacedCamera(camera, placed.matrix))
    return Pose(pose.camera, pose.to_world, draw.uniform(-0.5, 0.5, 3), pose.up)


def on_film(pose, point):
    model = CAMERAS[pose.camera.type_name()]
    extents = model.half_extents(pose.camera, *SIZE)
    return project_points(point, extents, SIZE, pose.to_world, model.PERSPECTIVE)[:2]


@pytest.mark.parametrize("camera", CAMERAS_OF_ALL_KINDS, ids=lambda c: c.type)
@pytest.mark.parametrize("seed", range(3))
def test_an_orbit_keeps_the_pivot_in_its_place(camera, seed):
    before = pose_of(camera, seed)
    after = before.moved(protocol.Orbit(0.2, 0.05), SIZE)
    assert not np.allclose(after.origin, before.origin)
    assert math.isclose(
        np.linalg.norm(after.origin - before.pivot), np.linalg.norm(before.origin - before.pivot)
    )
    # Upright stays upright, and nothing is sheared.
    right = after.to_world[:3, 0]
    assert abs(right @ before.up) < 1e-9 * np.linalg.norm(right)
    np.testing.assert_allclose(
        after.to_world[:3, :3].T @ after.to_world[:3, :3],
        before.to_world[:3, :3].T @ before.to_world[:3, :3], atol=1e-12,
    )  # fmt: skip


def test_a_drag_to_the_right_turns_the_scene_to_the_right_and_down_looks_from_above():
    pose = Pose.of(PlacedCamera(Pinhole(), look_at((0, 0, 4), (0, 0, 0)).matrix))
    np.testing.assert_allclose(pose.pivot, 0.0, atol=1e-12)
    near = np.array([0.0, 0.0, 1.0])
    turned = pose.moved(protocol.Orbit(0.05, 0.0), SIZE)
    assert on_film(turned, near)[0] > SIZE[0] / 2
    assert pose.moved(protocol.Orbit(0.0, 0.1), SIZE).origin[1] > 0.1


def test_a_roll_turns_the_camera_with_the_clock_and_the_picture_against_it():
    """What was to the right of the middle is above it then."""
    pose = Pose.of(PlacedCamera(Pinhole(), look_at((0, 0, 4), (0, 0, 0)).matrix))
    middle, right = on_film(pose, np.zeros(3)), np.array([1.0, 0.0, 0.0])
    x, y = on_film(pose.moved(protocol.Roll(0.5 * np.pi), SIZE), right) - middle
    np.testing.assert_allclose([x, -y], [0.0, (on_film(pose, right) - middle)[0]], atol=1e-9)


def test_a_camera_that_moves_starts_where_it_is_when_its_shutter_opens():
    """Below a node that moves and turns."""
    turns = [
        {"time": time, "steps": [{"rotate": {"axis": "y", "angle": 120.0 * time}},
                                 {"translate": [4.0 * time, 0.0, 1.0]}]}
        for time in (0.0, 1.0)
    ]  # fmt: skip
    eye = {
        "camera": {"type": "pinhole", "shutter": [0.25, 1.0]},
        "transform": [{"rotate": {"axis": "x", "angle": 30.0}}, {"translate": [1.0, 2.0, 3.0]}],
    }
    arm = {"transform": {"keyframes": turns}, "children": {"eye": eye}}
    nodes = {"arm": arm, "ball": {"shape": "sphere"}}
    scene = alight.load({"alight": 1, "camera": "arm/eye", "nodes": nodes})
    turn, own = rotate("y", 30.0).matrix.copy(), rotate("x", 30.0).matrix.copy()
    turn[:3, 3], own[:3, 3] = (1.0, 0.0, 1.0), (1.0, 2.0, 3.0)
    np.testing.assert_allclose(Pose.of(place_camera(scene)).to_world, turn @ own, atol=1e-12)


def test_an_orbit_ends_at_the_poles():
    pose = pose_of(Pinhole())
    for _ in range(20):
        pose = pose.moved(protocol.Orbit(0.03, 0.3), SIZE)
    back = pose.to_world[:3, 2] / np.linalg.norm(pose.to_world[:3, 2])
    assert math.isclose(math.degrees(math.asin(back @ pose.up)), 90.0 - POLE, abs_tol=1e-6)
    assert pose.is_usable


@pytest.mark.parametrize("camera", CAMERAS_OF_ALL_KINDS, ids=lambda c: c.type)
def test_a_pan_moves_what_is_at_the_pivot_with_the_pointer(camera):
    before = pose_of(camera, 1)
    after = before.moved(protocol.Pan(0.25, -0.125), SIZE)
    moved = on_film(after, before.pivot) - on_film(before, before.pivot)
    np.testing.assert_allclose(moved, [0.25 * SIZE[1], -0.125 * SIZE[1]], atol=1e-9)
    np.testing.assert_allclose(on_film(after, after.pivot), on_film(before, before.pivot))


def test_the_depth_of_a_point_is_that_of_its_plane_of_focus():
    pose = pose_of(ThinLens())
    for across in ([0.0, 0.0], [0.7, -0.4]):
        point = (pose.to_world @ [*across, -2.5, 1.0])[:3]
        assert math.isclose(pose.depth_of(point), 2.5)
    assert pose.has_focus
    assert pose.sharp.camera == ThinLens(aperture_radius=0.0)
    plain = pose_of(Pinhole())
    assert not plain.has_focus
    assert plain.sharp == plain


@pytest.mark.parametrize("camera", CAMERAS_OF_ALL_KINDS, ids=lambda c: c.type)
@pytest.mark.parametrize(
    "there", [protocol.Dolly(0.3), protocol.Roll(0.3), protocol.Widen(0.2), protocol.Pan(0.1, 0.2),
              protocol.Fly(0.1, 0.2, 0.3)], ids=lambda e: e.word,
)  # fmt: skip
def test_what_is_done_can_be_undone(camera, there):
    before = pose_of(camera, 2)
    values = {name: -value for name, value in vars(there).items()}
    after = before.moved(there, SIZE)
    assert not np.allclose(on_film(after, np.ones(3)), on_film(before, np.ones(3)))
    back = after.moved(type(there)(**values), SIZE)
    np.testing.assert_allclose(back.to_world, before.to_world, atol=1e-12)
    assert back.camera.replaced() == before.camera or math.isclose(
        *(dict(c).get("fov", dict(c).get("height")) for c in (back.camera, before.camera))
    )


@pytest.mark.parametrize("kind", [protocol.Dolly, protocol.Widen])
def test_one_event_changes_sizes_by_e_to_the_third_at_most(kind):
    for sign in (-1.0, 1.0):
        pose = pose_of(Orthographic(height=3.0))
        height = pose.moved(kind(sign * 50.0), SIZE).camera.height
        smaller = sign if kind is protocol.Dolly else -sign
        assert height == pytest.approx(3.0 * math.exp(-3.0 * smaller), rel=1e-9)


def test_moves_without_bounds_are_usable_or_told():
    pose, draw = pose_of(Pinhole()), np.random.default_rng(5)
    moves = [
        protocol.Orbit,
        protocol.Pan,
        protocol.Dolly,
        protocol.Fly,
        protocol.Roll,
        protocol.Widen,
    ]
    for _ in range(500):
        kind = moves[draw.integers(len(moves))]
        count = len(fields(kind))
        moved = pose.moved(kind(*draw.uniform(-protocol.LARGEST, protocol.LARGEST, count)), SIZE)
        pose = moved if moved.is_usable else pose
    assert np.isfinite(pose.to_world).all()
    assert 0.0 < pose.camera.fov < 180.0
