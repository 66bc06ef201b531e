"""Keyframes in files and in Python: reading, writing, hashing, and what other formats say."""

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.formats import dumps, loads
from alight.lab.info import facts
from alight.scene import content_hash, flatten, keyframes, rotate, scale, translate
from alight.scene.keyframes import Keyframes, rotation, take_apart
from alight.scene.transform import matrix
from tests.formats.mitsuba import reading as mitsuba
from tests.formats.pbrt import reading as pbrt
from tests.fuzz.in_the_twin import picture as in_twin

HEAD = (
    "alight: 1\nenvironment: constant\ncamera: {type: pinhole%s}\nnodes: {a: {transform: %s, %s}}\n"
)
MOVES = "{keyframes: [{time: 0}, {time: 1, scale: 2, rotate: {axis: y, angle: 90}}]}"


def scene(transform=MOVES, shutter="", rest="shape: sphere"):
    """A scene with one node."""
    return loads(HEAD % (shutter, transform, rest), "scene.yaml")


# ---------------------------------------------------------------- keyframes


def test_a_keyframe_scales_then_turns_then_shifts_whatever_the_order():
    """M = T R S, as everywhere."""
    frame = "{time: 1, translate: [1, 2, 3], scale: [1, 2, 3], rotate: {axis: y, angle: 90}}"
    found = scene(f"{{keyframes: [{{time: -1.5}}, {frame}]}}").nodes["a"].transform
    (begin, first), (end, second) = found.frames
    assert (begin, end) == (-1.5, 1.0)
    np.testing.assert_array_equal(first.matrix, np.eye(4))
    expected = translate(1, 2, 3) @ rotate("y", 90) @ scale(1, 2, 3)
    np.testing.assert_array_equal(second.matrix, expected.matrix)


@pytest.mark.parametrize(
    "transform",
    [
        MOVES,
        """{keyframes: [{time: 0.25, steps: [{translate: [1, 2, 3]}, {scale: 3}, {scale: 2}]},
         {time: 0.5, look_at: {origin: [0, 0, 1], target: [1, 0, 0]}}]}""",
        """{keyframes: [{time: 0, matrix: [[1, 0.5, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3],
         [0, 0, 0, 1]]}]}""",
    ],
)
def test_what_is_written_reads_back_as_it_was(transform):
    """Files keep the steps, and every bit of the matrices."""
    first = scene(transform, ", shutter: [0.1, 0.4]")
    text = dumps(first)
    again = loads(text, "again.yaml")
    assert again == first
    assert "keyframes" in text
    assert "shutter" in text
    assert dumps(again) == text


def test_in_python_keyframes_are_a_transform():
    """They compose with what rests, keyframe by keyframe, and can be inverted."""
    moving = keyframes({0: translate(1, 0, 0), 2: rotate("z", 90)})
    assert isinstance(moving, Keyframes)
    both = scale(2) @ moving @ translate(0, 1, 0)
    for time, frame in ((0, translate(1, 0, 0)), (1, rotate("z", 90))):
        expected = scale(2) @ frame @ translate(0, 1, 0)
        assert both.frames[time][1] == expected
    np.testing.assert_allclose(moving.inverse().frames[1][1].matrix, rotate("z", -90).matrix)
    assert moving != keyframes({0: translate(1, 0, 0), 1: rotate("z", 90)})
    assert hash(moving) == hash(keyframes([(0, translate(1, 0, 0)), (2, rotate("z", 90))]))
    with pytest.raises(SceneError, match="must be later than the one before"):
        keyframes([(1, translate(1, 0, 0)), (1, translate(2, 0, 0))])


def test_a_matrix_is_taken_apart_into_shift_turn_and_stretch():
    """The parts are what they should be, and make the matrix; mirrors are a negative stretch."""
    rng = np.random.default_rng(4)
    for i in range(200):
        linear = rng.normal(size=(3, 3)) + (0.0 if i % 2 else 2.0) * np.eye(3)
        whole = np.eye(4)
        whole[:3, :3], whole[:3, 3] = linear, rng.normal(size=3)
        parts = take_apart(whole)
        np.testing.assert_allclose(parts.matrix, whole, atol=1e-12)
        turn = rotation(parts.turn)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) > 0.0
        np.testing.assert_allclose(parts.stretch, parts.stretch.T, atol=1e-12)
        sizes = np.linalg.eigvalsh(parts.stretch)
        assert (sizes * np.sign(np.linalg.det(linear)) > 0.0).all()


def test_half_way_is_half_the_turn():
    """Shoemake's slerp: evenly about one axis; shift and stretch evenly."""
    [placed] = flatten(scene("{keyframes: [{time: 0, scale: [1, 1, 2]}, {time: 2, scale: [3, 1, 2],"
                             " rotate: {axis: [1, 1, 0], angle: 100}, translate: [4, 0, 0]}]}",
                             ", shutter: [0, 2]")).shapes  # fmt: skip
    found = placed.motion.at(0.25) @ placed.to_world
    expected = translate(1, 0, 0) @ rotate((1, 1, 0), 25) @ scale(1.5, 1, 2)
    np.testing.assert_allclose(found, expected.matrix, atol=1e-12)


def test_turns_take_the_shorter_way_whatever_the_signs_of_quaternions():
    """By 160 degrees through -20, where the quaternions of the ends point away from each other."""
    frames = "{keyframes: [{time: 0, %s}, {time: 1, %s}]}"
    ends = (f"rotate: {{axis: x, angle: {angle}}}" for angle in (60, -100))
    [placed] = flatten(scene(frames % tuple(ends))).shapes
    middle = placed.motion.at(0.5) @ placed.to_world
    np.testing.assert_allclose(middle, rotate("x", -20).matrix, atol=1e-12)


def test_the_whole_graph_around_what_moves_counts():
    """Above, the frame it moves in; below, what it carries. Exactly, whatever is simplified."""
    text = """
alight: 1
environment: constant
camera: {type: pinhole}
nodes:
  a:
    transform: [{scale: 2}, {rotate: {axis: x, angle: 30}}, {translate: [0, 1, 0]}]
    children:
      b:
        transform: {keyframes: [{time: 0, translate: [1, 0, 0]},
                                {time: 1, rotate: {axis: y, angle: 80}, scale: [1, 2, 1]}]}
        children: {c: {transform: {translate: [0, 0, 3]}, shape: sphere}}
"""
    [placed] = flatten(loads(text, "scene.yaml")).shapes
    above = translate(0, 1, 0) @ rotate("x", 30) @ scale(2)
    for time in (0.0, 0.3, 1.0):
        own = translate(1 - time, 0, 0) @ rotate("y", 80 * time) @ scale(1, 1 + time, 1)
        expected = (above @ own @ translate(0, 0, 3)).matrix
        np.testing.assert_allclose(placed.motion.at(time) @ placed.to_world, expected, atol=1e-12)


# ---------------------------------------------------------------- what a picture depends on


def test_the_content_hash_is_about_what_is_seen():
    """Keyframes and the shutter count where something moves then, and nowhere else."""
    assert content_hash(scene(MOVES)) != content_hash(scene("{translate: [0, 0, 0]}"))
    assert content_hash(scene(MOVES)) != content_hash(scene(MOVES.replace("90", "80")))
    assert content_hash(scene(MOVES)) != content_hash(scene(MOVES, ", shutter: [0, 0.5]"))
    still = content_hash(scene("{translate: [1, 0, 0]}"))
    frames = "{keyframes: [{time: 0, translate: [1, 0, 0]}, {time: 1, translate: [1, 0, 0]}]}"
    assert content_hash(scene("{translate: [1, 0, 0]}", ", shutter: [0, 0.5]")) == still
    assert content_hash(scene(frames)) == still


def test_info_says_what_moves():
    """Shapes, lights and the camera; nothing about scenes that rest."""
    moving = scene(MOVES)
    assert dict(facts(moving, flatten(moving)))["moving"] == "1 shapes; shutter 0 to 1"
    still = scene("{translate: [1, 0, 0]}")
    assert "moving" not in dict(facts(still, flatten(still)))


# ---------------------------------------------------------------- other formats


def frames_of(found):
    """Times and matrices."""
    return [(time, frame.matrix) for time, frame in found.frames]


def test_pbrt_active_transforms_are_keyframes():
    """StartTime and EndTime change one end each, All both; TransformTimes says when."""
    found = pbrt.read(
        "AttributeBegin Translate 1 0 0 ActiveTransform EndTime Rotate 30 0 1 0\n"
        'ActiveTransform All Scale 2 2 2 Shape "sphere" AttributeEnd Shape "sphere"',
        head='TransformTimes 0.5 1.5\nCamera "perspective" "float shutteropen" 0.25\n',
    )
    moving, still = found.nodes.values()
    (begin, first), (end, second) = frames_of(moving.transform)
    assert (begin, end) == (0.5, 1.5)
    np.testing.assert_allclose(first, (translate(1, 0, 0) @ scale(2)).matrix)
    np.testing.assert_allclose(second, (translate(1, 0, 0) @ rotate("y", 30) @ scale(2)).matrix)
    assert not isinstance(still.transform, Keyframes)
    assert found.camera.camera.shutter == (0.25, 1.0)


def test_pbrt_cameras_and_instances_move():
    """The camera's matrix is inverted at both ends; an instance carries its object."""
    found = pbrt.read(
        'ObjectBegin "it" Shape "sphere" ObjectEnd\n'
        'ActiveTransform StartTime Translate 0 3 0 ActiveTransform All ObjectInstance "it"',
        head='ActiveTransform EndTime Translate 1 0 0 ActiveTransform All Camera "perspective"\n',
    )
    [(_, first), (_, second)] = frames_of(found.camera.transform)
    np.testing.assert_allclose(second[:3, 3] - first[:3, 3], [-1, 0, 0])
    [node] = found.nodes.values()
    assert node.instance == "it"
    [(_, first), (_, second)] = frames_of(node.transform)
    np.testing.assert_allclose(first[:3, 3], [0, 3, 0])
    np.testing.assert_allclose(second[:3, 3], [0, 0, 0])


def test_pbrt_shapes_that_are_laid_out_anew_move_as_pbrt_moves_them():
    """A disk at a height is a child of what moves, which turns about the object's own origin."""
    found = pbrt.read('ActiveTransform EndTime Rotate 90 1 0 0 ActiveTransform All\n'
                      'Shape "disk" "float height" 2')  # fmt: skip
    [placed] = flatten(found).shapes
    middle = placed.motion.at(0.5) @ placed.to_world
    np.testing.assert_allclose(middle[:3, 3], 2.0 * np.array([0, -np.sqrt(0.5), np.sqrt(0.5)]))


def test_pbrt_lights_that_would_change_their_size_stay_and_it_is_said():
    """One that only turns moves; the other stands where it is at the start."""
    body = 'AreaLightSource "diffuse" ActiveTransform EndTime %s ActiveTransform All Shape "sphere"'
    turning = pbrt.read(body % "Rotate 20 1 0 0")
    assert isinstance(next(iter(turning.nodes.values())).transform, Keyframes)
    assert flatten(turning).shapes[0].motion.is_rigid
    growing = pbrt.read(body % "Scale 2 2 2")
    assert not isinstance(next(iter(growing.nodes.values())).transform, Keyframes)
    assert any("stands where it is" in text for text in growing.source.remarks.warnings)


def test_mitsuba_animations_are_keyframes():
    """Of shapes, instances and the sensor, in the files of Mitsuba 0.6, with its shutter."""
    body = """
<sensor type="perspective">
  <float name="shutterOpen" value="0.25"/><float name="shutterClose" value="0.5"/>
  <animation name="toWorld">
    <transform time="0"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <transform time="1"><lookat origin="1,0,5" target="1,0,0" up="0,1,0"/></transform>
  </animation>
</sensor>
<shape type="shapegroup" id="group"><shape type="sphere"/></shape>
<shape type="instance">
  <ref id="group"/>
  <animation name="toWorld">
    <transform time="0.5"><scale value="2"/></transform>
    <transform time="2"><scale value="2"/><translate x="3"/></transform>
  </animation>
</shape>
"""
    found = mitsuba.read(body, "0.6.0")
    assert found.camera.camera.shutter == (0.25, 0.5)
    [(_, first), (_, second)] = frames_of(found.camera.transform)
    np.testing.assert_allclose(first[:3, 3], [0, 0, 5])
    np.testing.assert_allclose(second[:3, 3], [1, 0, 5])
    [node] = found.nodes.values()
    (begin, first), (end, second) = frames_of(node.transform)
    assert (begin, end) == (0.5, 2.0)
    np.testing.assert_allclose(second, matrix((translate(3, 0, 0) @ scale(2)).matrix).matrix)


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ("", "has no keyframe"),
        (
            '<transform time="1"/><transform time="0"/>',
            "must be later than the one before, 1, got 0",
        ),
        ('<transform/><transform time="0"/>', "must be a <transform time=...>"),
        ('<transform time="x"/><transform time="0"/>', '"x"'),
    ],
)
def test_wrong_animations_are_refused_where_they_stand(inside, text):
    """One message each."""
    body = f'<shape type="sphere"><animation name="toWorld">{inside}</animation></shape>'
    found = mitsuba.issues(body, "0.6.0")
    assert text in found[0].message
    assert found[0].place.startswith("scene.xml:2:")


def test_a_shutter_of_mitsuba_that_closes_at_once_is_told_of():
    """Its default: what moves is sharp."""
    body = (
        '<shape type="sphere"><animation name="toWorld"><transform time="0"/><transform time="1">'
        '<translate x="1"/></transform></animation></shape>'
    )
    found = mitsuba.read(body, "0.6.0")
    assert found.camera.camera.shutter == (0.0, 0.0)
    assert any("closes as it opens" in text for text in found.source.remarks.warnings)


#: One thing that moves among others that rest: the table of motions has a single entry.
MOVING = "transform: {keyframes: [{time: 0}, {time: 1, translate: [0.1, 0, 0]}]}"
LONE = {
    "lamp": f"lamp: {{shape: sphere, light: area, {MOVING}}}",
    "bulb": f"bulb: {{light: point, {MOVING}}}",
    "ball": f"ball: {{shape: sphere, {MOVING}}}",
    "mesh": f"""mesh:
    {MOVING}
    shape: {{type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 2]]}}""",
}
RESTING = """
alight: 1
film: {size: [8, 8]}
camera: {type: pinhole, fov: 60, transform: {translate: [0, 0, 6]}}
bsdfs: {noise: {type: diffuse, reflectance: {type: noise}}}
nodes:
  floor: {shape: rectangle, bsdf: noise, transform: [{scale: 4}, {translate: [0, 0, -2]}]}
  other: {shape: sphere, light: area, transform: {translate: [2, 0, 0]}}
  spot: {light: {type: spot, intensity: 3}, transform: {translate: [0, 1, 4]}}
"""


@pytest.mark.parametrize("choice", ["power", "tree"])
@pytest.mark.parametrize("name", LONE)
def test_what_rests_asks_for_no_motion_beyond_the_table(name, choice):
    """In the twin, where an index outside of a table is an error; all lanes read, idle ones too."""
    text = f"{RESTING}  {LONE[name]}\nintegrator: {{type: path, light_choice: {choice}}}\n"
    flat = flatten(loads(text, "lone.yaml"))
    assert len(compile_scene(flat).program.motion) > 0
    assert in_twin(flat) == 0


def test_a_camera_that_moves_alone_finds_its_motion():
    text = RESTING.replace("transform: {translate: [0, 0, 6]}", MOVING)
    flat = flatten(loads(text, "lone.yaml"))
    assert "camera" in compile_scene(flat).program.motion
    assert in_twin(flat) == 0
