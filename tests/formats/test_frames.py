"""`--frames` of files that have an animation of their own: glTF and OpenUSD."""

import gc
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import alight
from alight.core.errors import SceneError
from alight.options.animation import AnimationOptions
from alight.outputs.image import read_picture
from alight.rendering.animation import Animation
from alight.scene.flatten import flatten, place_camera
from tests.formats.gltf.maker import Maker
from tests.formats.gltf.test_animations import animated

FPS = 4


@pytest.fixture
def sliding(tmp_path):
    """A square that slides by 4 m in 2 s, with neither a camera nor a light."""
    m = Maker()
    node = m.node(mesh=m.square(), translation=[9, 0, 0])
    path = tmp_path / "sliding.gltf"
    path.write_bytes(
        animated(m, (node, "translation", [0, 2], [[0, 1, 0], [4, 3, 0]], "LINEAR")).gltf()
    )
    return path


def frames(path, numbers, **words):
    options = {"size": (8, 8), "spp": 1, "fps": FPS, "output": "f_####.png"}
    return Animation(path, AnimationOptions(frames=numbers, **options | words))


def place_of(scene):
    [square] = [shape for shape in flatten(scene).shapes if shape.geometry >= 0]
    return square.to_world[:3, 3]


def test_frame_n_is_n_frames_after_the_time_that_is_given(sliding):
    for at, begin in ((None, 0.0), (0.5, 0.5)):
        made = frames(sliding, "0:12", at=at)
        assert made.prepared.useless == []
        for number in made.numbers:
            seconds = min(begin + number / FPS, 2.0)
            expected = [2.0 * seconds, 1.0 + seconds, 0.0]
            np.testing.assert_allclose(place_of(made.scene_of(number)), expected, atol=1e-6)


def test_one_of_several_animations_is_played(sliding):
    m = Maker()
    node = m.node(mesh=m.square())
    for name, far in (("walk", 4), ("run", 8)):
        animated(m, (node, "translation", [0, 2], [[0, 0, 0], [far, 0, 0]], "LINEAR"), name=name)
    sliding.write_bytes(m.gltf())
    places = [
        place_of(frames(sliding, "0:9", animation=name).scene_of(4))[0] for name in ("run", None)
    ]
    assert places == pytest.approx([4.0, 2.0])


def test_a_turntable_plays_nothing(sliding):
    with pytest.raises(SceneError, match="--at SECONDS is a time of; give it, too"):
        frames(sliding, "0:9", animation="0", turntable=True)


def test_what_was_made_up_stays_where_it_is(sliding):
    """A camera and a floor that are placed for each pose would jump with it."""
    made = frames(sliding, "0:9")
    first, last = made.scene_of(0), made.scene_of(8)
    assert place_of(last)[1] == pytest.approx(3.0)
    np.testing.assert_array_equal(place_camera(first).to_world, place_camera(last).to_world)
    assert first.nodes["studio floor"] == last.nodes["studio floor"]
    assert first.environment == last.environment
    # A part of the frames is seen as all of them are.
    assert frames(sliding, "8:9").scene.camera == first.camera
    # What the user has chosen is no longer made up, and holds in every frame.
    chosen = frames(sliding, "0:9", changes=["camera.fov=11", "environment=null"])
    assert chosen.scene_of(8).camera.camera.fov == 11
    assert chosen.scene_of(8).environment is None


def test_a_frame_is_the_picture_at_its_time(sliding, tmp_path):
    view = ["camera.transform={look_at: {origin: [2, 2, 9], target: [2, 2, 0]}}"]
    words = {"size": (8, 6), "spp": 4, "changes": [*view, "environment={type: constant}"]}
    alight.animate(sliding, frames="5:6", fps=FPS, output=tmp_path / "f_####.exr", **words)
    film = alight.render(sliding, at=5 / FPS, **words)
    shown = read_picture(tmp_path / "f_0005.exr").image
    np.testing.assert_array_equal(shown, film.picture().image.astype(shown.dtype))


def test_only_what_moves_is_told_to_move(sliding, tmp_path):
    still = tmp_path / "still.gltf"
    m = Maker()
    m.node(mesh=m.square())
    still.write_bytes(m.gltf())
    alike = "nothing in the scene has keyframes, so all frames are alike; "
    for scene, remedy in (
        (still, "{turntable} turns the camera"),
        (
            alight.load(sliding),
            "the animation of its file is played if the file's path is given",
        ),
    ):
        useless = frames(scene, "0:2").prepared.useless
        assert useless == [(alike + remedy, ("frames", "turntable"))]
    # A turntable turns about the scene at rest.
    assert place_of(frames(sliding, "0:2", turntable=True).scene)[0] == pytest.approx(9.0)


def test_light_that_fades_brings_no_studio(tmp_path):
    """Whether a file has light enough is decided once, not for each pose."""
    m = Maker()
    lamp = m.node(mesh=m.square(m.material(emissiveFactor=[1, 1, 1])))
    m.node(mesh=m.square(), translation=[1, 0, 0])
    path, least = tmp_path / "fades.gltf", [0.001] * 3
    path.write_bytes(animated(m, (lamp, "scale", [0, 2], [[1, 1, 1], least], "LINEAR")).gltf())
    assert alight.load(path, at=2.0).environment is not None
    made = frames(path, "0:9")
    first, last = made.scene_of(0), made.scene_of(8)
    assert first.environment is None
    assert last.environment is None
    assert first.nodes.keys() == last.nodes.keys()
    assert last.source.remarks.warnings == first.source.remarks.warnings
    # The other way round, the studio stays where the lamp grows.
    path.write_bytes(animated(m, (lamp, "scale", [0, 2], [least, [1, 1, 1]], "LINEAR")).gltf())
    made = frames(path, "0:9", animation="1")
    assert made.scene_of(8).environment == made.scene_of(0).environment is not None
    assert "studio floor" in made.scene_of(8).nodes


def test_an_animation_that_is_not_there_is_named(sliding):
    m = Maker()
    m.node(mesh=m.square())
    sliding.write_bytes(m.gltf())
    with pytest.raises(SceneError, match=r"--animation\s+the file has no animations"):
        frames(sliding, "0:9", animation="walk")


STAGE = """#usda 1.0
(
    metersPerUnit = 1
    timeCodesPerSecond = 24
    {times}
)
{more}
def Mesh "square"
{{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    double3 xformOp:translate.timeSamples = {{10: (0, 0, 0), 58: (4, 0, 0)}}
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""


def stage(folder, times="startTimeCode = 10\n    endTimeCode = 58", more=""):
    path = folder / "rolling.usda"
    path.write_text(STAGE.format(times=times, more=more))
    return path


def test_stages_play_from_their_first_time(tmp_path):
    pytest.importorskip("pxr")
    made = frames(stage(tmp_path), "0:9")
    assert made.prepared.useless == []
    places = [place_of(made.scene_of(number))[0] for number in (0, 3, 8)]
    np.testing.assert_allclose(places, [0.0, 1.5, 4.0], atol=1e-6)
    # One that does not say when it ends plays from the time that is asked for.
    made = frames(stage(tmp_path, times=""), "0:9", at=10 / 24)
    places = [place_of(made.scene_of(number))[0] for number in (0, 3, 8)]
    np.testing.assert_allclose(places, [0.0, 1.5, 4.0], atol=1e-6)


#: A material of another file: what evaluates its network is part of a cycle that holds the stage.
MATERIAL = """<?xml version="1.0"?>
<materialx version="1.38">
  <standard_surface name="SR" type="surfaceshader">
    <input name="base_color" type="color3" value="0.8, 0.2, 0.1" />
  </standard_surface>
  <surfacematerial name="Mat" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="SR" />
  </surfacematerial>
</materialx>
"""
REFERENCE = """def "L" ( references = @m.mtlx@</MaterialX> ) {}
def Mesh "bound" ( prepend apiSchemas = ["MaterialBindingAPI"] )
{
    rel material:binding = </L/Materials/Mat>
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
}
"""


def test_no_stage_is_left_when_its_layers_are_opened_again(tmp_path):
    """It would be composed anew, without files that are being read, and warn of them."""
    pytest.importorskip("pxr")
    (tmp_path / "m.mtlx").write_text(MATERIAL)
    path = stage(tmp_path, more=REFERENCE)
    was_on = gc.isenabled()
    gc.disable()
    try:
        said = {alight.load(path, at=0.1 * n).source.remarks.warnings for n in range(4)}
    finally:
        if was_on:
            gc.enable()
    assert len(said) == 1


def test_stages_are_read_one_at_a_time(tmp_path, monkeypatch):
    """OpenUSD keeps layers for the whole process: two frames in work would share them."""
    pytest.importorskip("pxr")
    from alight.formats.usd import scene

    inside, most, open_stage = [], [], scene.open_stage

    def opened(*given):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0.05)
        try:
            return open_stage(*given)
        finally:
            inside.pop()

    monkeypatch.setattr(scene, "open_stage", opened)
    path = stage(tmp_path)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(alight.load, [path] * 4))
    assert most == [1, 1, 1, 1]
