"""`--frames` of files that have an animation of their own: glTF and OpenUSD."""

import numpy as np
import pytest

import alight
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


def test_stages_play_from_their_first_time(tmp_path):
    pytest.importorskip("pxr")
    path = tmp_path / "rolling.usda"
    path.write_text("""#usda 1.0
(
    startTimeCode = 10
    endTimeCode = 58
    timeCodesPerSecond = 24
    metersPerUnit = 1
)
def Mesh "square"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    double3 xformOp:translate.timeSamples = {10: (0, 0, 0), 58: (4, 0, 0)}
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
""")
    made = frames(path, "0:9")
    assert made.prepared.useless == []
    places = [place_of(made.scene_of(number))[0] for number in (0, 3, 8)]
    np.testing.assert_allclose(places, [0.0, 1.5, 4.0], atol=1e-6)
