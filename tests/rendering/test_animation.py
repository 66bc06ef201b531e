"""Animations: each frame at its time, none rendered twice, all in a moving picture."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.options.animation import AnimationOptions
from alight.rendering import animation
from alight.rendering.animation import Animation, numbered
from alight.rendering.executors import blocks
from alight.rendering.schedules.passes import PASS_SECONDS
from alight.scene import keyframes, translate
from alight.scene.flatten import flatten, place_camera

SMALL = {"size": (8, 8), "spp": 1, "threads": 1}


def frames_of(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def renders(monkeypatch):
    """The hash of every film that is rendered."""
    made, render = [], animation.main_loop.render_film

    def counted(scene, options, executor):
        film = render(scene, options, executor)
        made.append(film.scene_hash)
        return film

    monkeypatch.setattr(animation.main_loop, "render_film", counted)
    return made


def animate(folder, frames="0:3", **words):
    return alight.animate(
        "cornell-box", frames=frames, output=folder / "f_####.png", **{**SMALL, **words}
    )


def test_only_frames_that_are_whole_and_of_these_settings_are_kept(tmp_path, renders):
    animate(tmp_path, turntable=True)
    assert frames_of(tmp_path) == ["f_0000.png", "f_0001.png", "f_0002.png"]
    assert len(set(renders)) == 3
    before = [(tmp_path / name).read_bytes() for name in frames_of(tmp_path)]
    # Killed: one is lacking, one is half, one is another program's of the same name.
    (tmp_path / "f_0000.png").unlink()
    (tmp_path / "f_0001.png").write_bytes(before[1][: len(before[1]) // 2])
    Image.new("RGB", (8, 8)).save(tmp_path / "f_0002.png")
    animate(tmp_path, turntable=True)
    assert len(renders) == 6
    assert [(tmp_path / name).read_bytes() for name in frames_of(tmp_path)] == before
    animate(tmp_path, turntable=True, threads=2)
    assert len(renders) == 6
    for words in ({"spp": 2}, {"seed": 1}, {"exposure": 1.0}, {"max_depth": 3}):
        animate(tmp_path, turntable=True, **words)
    assert len(renders) == 18


def test_frames_lie_between_the_frames_before_and_after():
    moving = alight.changed(alight.load("cornell-box"), {"camera.shutter": (0.0, 0.5)})
    made = Animation(moving, AnimationOptions(frames="3:5", fps=10, output="f_#.png"))
    for number in made.numbers:
        camera = place_camera(made.scene_of(number)).camera
        assert camera.shutter == pytest.approx((number / 10, (number + 0.5) / 10))


def test_frames_of_which_none_differs_are_told_of():
    rests = alight.load("cornell-box")
    moves = keyframes({0.0: translate(0, 0, 0), 1.0: translate(1, 0, 0)})
    floor = rests.nodes["floor"].replaced(transform=moves)
    camera = rests.camera.replaced(transform=moves)
    for scene, words, told in (
        (rests, {"frames": "0:3"}, True),
        (rests, {"frames": "2:3"}, False),
        (rests, {"frames": "0:3", "turntable": True}, False),
        (rests.replaced(nodes={**rests.nodes, "floor": floor}), {"frames": "0:3"}, False),
        (rests.replaced(camera=camera), {"frames": "0:3"}, False),
    ):
        made = Animation(scene, AnimationOptions(output="f_#.png", **words))
        texts = made.prepared.warnings(lambda name: f"--{name}")
        found = [text for text in texts if "keyframes" in text]
        assert [text.split(":")[0] for text in found] == ["--frames"] * told
        same = [alight.scene.content_hash(made.scene_of(n)) for n in made.numbers]
        assert told == (len(same) > 1 and len(set(same)) == 1)


@pytest.mark.parametrize("frames", ["0:4", "3:7"])
def test_a_turntable_goes_once_around_the_middle_of_the_scene(frames):
    scene = alight.load(([[9, 0, 0], [11, 0, 0], [10, 2, 0], [10, 0, 1]], [[0, 1, 2], [0, 1, 3]]))
    made = Animation(scene, AnimationOptions(frames=frames, turntable=True, output="f.gif"))
    seen = np.array([place_camera(made.scene_of(n)).to_world for n in made.numbers])
    assert np.allclose(seen[0], place_camera(scene).to_world)
    around = seen[:, :3, 3] - [10.0, 1.0, 0.5]
    assert np.allclose(around[:, 1], around[0, 1])
    flat = around[:, [0, 2]]
    assert np.allclose(np.roll(flat, -1, axis=0), np.stack([-flat[:, 1], flat[:, 0]], axis=1))
    # It looks at the same place from everywhere.
    local = np.linalg.inv(seen) @ [10.0, 1.0, 0.5, 1.0]
    assert np.allclose(local, local[0], atol=1e-5)


def test_frames_after_the_first_have_passes_as_long_as_they_should_be():
    """Four times those of a picture alone."""
    made = Animation(alight.load("cornell-box"), AnimationOptions(frames="0:2", output="f.gif"))
    # 5 million samples a second for pictures of 20 000 pixels.
    film = SimpleNamespace(crop=(7, 9, 200, 100), stats={"msamples_per_s": 5.0})
    made._note_pace(film)
    [(name, spp)] = made._pace.items()
    assert name == "spp_per_pass" and spp == pytest.approx(1000 * PASS_SECONDS, abs=0.5)


def test_lamps_are_not_what_a_turntable_turns_about():
    ball = {"shape": {"type": "sphere", "center": [3, 0, 0]}}
    lamp = {"shape": {"type": "sphere", "center": [0, 9, 0]}, "light": {"type": "area"}}
    scene = {"alight": 1, "camera": {"type": "pinhole"}, "nodes": {"lamp": lamp, "ball": ball}}
    np.testing.assert_allclose(animation.middle(flatten(alight.load(scene)))[0], 3.0)
    del scene["nodes"]["ball"]
    assert animation.middle(flatten(alight.load(scene)))[1] > 0.0


@pytest.mark.parametrize("suffix", ["gif", "apng"])
def test_moving_pictures_take_the_time_of_all_frames(suffix, tmp_path):
    path = tmp_path / f"turn.{suffix}"
    words = {**SMALL, "frames": "0:4", "turntable": True, "fps": 25}
    assert alight.animate("cornell-box", output=path, **words) == [path]
    with Image.open(path) as image:
        # GIF: frames that are alike are one, for as long as all of them.
        assert image.n_frames == 4 if suffix == "apng" else 1 < image.n_frames <= 4
        total = 0.0
        for number in range(image.n_frames):
            image.seek(number)
            total += image.info["duration"]
        assert total == pytest.approx(4 * 40)


def test_two_frames_in_work_give_what_one_gives(tmp_path):
    files = {}
    for threads in (1, 2):
        folder = tmp_path / str(threads)
        folder.mkdir()
        output = [folder / "f_####.png", folder / "f.apng"]
        words = {**SMALL, "threads": threads, "frames": "0:5", "turntable": True}
        alight.animate("cornell-box", **words, output=output)
        files[threads] = [(folder / name).read_bytes() for name in frames_of(folder)]
        with Image.open(output[1]) as film:
            for number in range(5):
                film.seek(number)
                with Image.open(numbered(output[0], number)) as frame:
                    assert np.array_equal(np.asarray(film.convert("RGB")), np.asarray(frame))
    assert files[1] == files[2]


@pytest.mark.parametrize("at_once", [1, 2])
def test_no_frame_is_begun_after_one_that_fails(tmp_path, monkeypatch, at_once):
    begun, render, failed = [], animation.main_loop.render_film, threading.Event()

    def failing(scene, options, executor):
        begun.append(scene)
        if len(begun) == 2:
            failed.set()
            raise alight.OutputError("broken")
        if at_once == 2:
            # The first is in work until the other has failed, and is done after it.
            assert failed.wait(60.0)
            time.sleep(0.2)
        return render(scene, options, executor)

    monkeypatch.setattr(animation.main_loop, "render_film", failing)
    kept = tmp_path / "f.apng"
    kept.write_bytes(b"what was there before")
    with pytest.raises(alight.OutputError, match="broken"):
        words = {**SMALL, "threads": at_once, "turntable": True}
        alight.animate("cornell-box", **words, frames="0:9", output=kept)
    assert len(begun) == 2
    assert kept.read_bytes() == b"what was there before"
    assert frames_of(tmp_path) == ["f.apng"]


def test_an_error_leaves_the_event_of_the_caller_alone(tmp_path, monkeypatch):
    cancel = threading.Event()

    def failing(*arguments, **display):
        raise alight.OutputError("broken")

    with monkeypatch.context() as patch:
        patch.setattr(animation, "write_image", failing)
        with pytest.raises(alight.OutputError, match="broken"):
            animate(tmp_path, turntable=True, cancel=cancel)
    assert not cancel.is_set()
    animate(tmp_path, turntable=True, cancel=cancel)
    assert len(frames_of(tmp_path)) == 3
    cancel.set()
    assert animate(tmp_path, turntable=True, cancel=cancel, seed=1) == []


def test_an_error_in_a_tile_leaves_the_event_of_the_caller_alone(monkeypatch):
    cancel = threading.Event()

    def failing(*arguments):
        raise alight.OutputError("broken")

    monkeypatch.setattr(blocks, "render_tile", failing)
    with pytest.raises(alight.OutputError, match="broken"):
        alight.render("cornell-box", cancel=cancel, **SMALL)
    assert not cancel.is_set()


def test_kept_files_are_in_the_order_of_the_frames(tmp_path, monkeypatch):
    animate(tmp_path, turntable=True)
    words = {**SMALL, "threads": 2, "output": tmp_path / "f_####.png"}
    made = Animation("cornell-box", AnimationOptions(frames="0:3", turntable=True, **words))
    second, read = threading.Event(), animation.label_in

    def late(path):
        # The first frame is done after the second.
        if path.name == "f_0000.png":
            second.wait(1.0)
            time.sleep(0.02)
        elif path.name == "f_0001.png":
            second.set()
        return read(path)

    monkeypatch.setattr(animation, "label_in", late)
    assert made.render() == made.kept


def test_names_of_frames():
    assert numbered(animation.Path("a#/f_###.exr"), 7).as_posix() == "a#/f_007.exr"
    assert numbered(animation.Path("f#_##.exr"), 123).name == "f#_123.exr"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"output": "f_#.png"}, r"give frames, as 0:120, or turntable"),
        ({"output": "f.png", "frames": "0:2"}, r"output: must hold ####"),
        ({"output": "f.avi", "frames": "0:2"}, r"output: .*avi"),
        ({"output": "f_####.alight", "frames": "0:2"}, r"output: films are of single pictures"),
        ({"output": "f_#.png", "frames": "2:2"}, r"frames: must be FIRST:END"),
        ({"frames": "0:2"}, r"give output frame_####"),
        ({"output": "f_#.png", "frames": "0:2", "part": "1/2"}, r"part: is for a single picture"),
        ({"output": "f_#.png", "frames": "0:2", "fpss": 2}, r"did you mean \"fps\""),
    ],
)
def test_mistakes_are_told(words, message):
    with pytest.raises(alight.OptionError, match=message):
        alight.animate("cornell-box", **words)


COMMAND = ["render", "cornell-box", "--size", "8", "--spp", "1", "--threads", "1"]


def command(*words):
    return CliRunner().invoke(app, [*COMMAND, *map(str, words)])


def test_the_command_says_what_it_kept(tmp_path):
    words = ["--frames", "0:2", "--fps", "24", "-o", tmp_path / "f_####.exr"]
    for said in ("2 frames: 2 files\n", "2 frames: 2 files, 2 of them kept\n"):
        done = command(*words)
        assert done.exit_code == 0, done.output
        assert done.output.endswith(said)
    assert frames_of(tmp_path) == ["f_0000.exr", "f_0001.exr"]


def test_the_command_says_how_fast_a_gif_plays(tmp_path):
    done = command("--frames", "0:2", "-o", tmp_path / "a.gif", "-o", tmp_path / "a.apng")
    assert "a.gif: plays 25 frames per second, not 24: GIF counts" in done.output
    assert "a.apng: plays" not in done.output


def test_an_older_name_of_the_command_is_told():
    done = CliRunner().invoke(app, ["animate", "scene.yaml"])
    assert done.exit_code == 2
    assert "--turntable" in done.output
    assert "--frames" in done.output


def test_a_frame_of_the_command_is_that_of_python(tmp_path, renders):
    done = command("--turntable", "--frames", "0:3", "-o", tmp_path / "f_####.png")
    assert done.exit_code == 0, done.output
    animate(tmp_path, turntable=True)
    assert len(renders) == 3


def test_a_stopped_command_says_where_it_goes_on(tmp_path, monkeypatch):
    render = animation.main_loop.render_film
    left = [None, None]

    def stopped(scene, options, executor):
        if not left:
            raise KeyboardInterrupt
        left.pop()
        return render(scene, options, executor)

    words = ["--turntable", "--frames", "5:9", "-o", tmp_path / "f_####.png"]
    monkeypatch.setattr(animation.main_loop, "render_film", stopped)
    done = command(*words)
    assert done.exit_code == 130
    assert "stopped at frame 7; the same command goes on there" in done.output
    assert frames_of(tmp_path) == ["f_0005.png", "f_0006.png"]
    monkeypatch.undo()
    assert command(*words).output.endswith("4 frames: 4 files, 2 of them kept\n")


@pytest.mark.parametrize(
    ("names", "goes_on"),
    [
        (["f_####.png"], True), (["f_####.exr", "f.gif"], True),
        (["f_####.exr", "f_####.png", "f.gif"], True),
        (["f.gif"], False), (["f_####.png", "f.gif"], False), (["f_####.jpg"], False),
    ],
)  # fmt: skip
def test_an_animation_goes_on_where_its_frames_are_kept(tmp_path, renders, names, goes_on):
    output = [tmp_path / name for name in names]
    options = AnimationOptions(frames="0:2", output=output, **SMALL)
    first = Animation("cornell-box", options)
    first.render()
    assert first.goes_on == goes_on
    renders.clear()
    Animation("cornell-box", options).render()
    assert (not renders) == goes_on


@pytest.mark.parametrize("moves", [False, True])
def test_a_turntable_says_that_it_leaves_out_the_cameras_own_motion(moves):
    frames = [{"time": 0}, {"time": 1, "translate": [1 if moves else 0, 0, 0]}]
    scene = alight.load({
        "camera": {"transform": {"keyframes": frames}}, "nodes": {"ball": {"shape": "sphere"}}
    })  # fmt: skip
    made = Animation(scene, AnimationOptions(turntable=True, output="f_#.png"))
    told = [text for text in made.prepared.warnings() if "without its motion" in text]
    assert len(told) == moves


def test_layers_that_no_file_of_a_frame_keeps_are_told(tmp_path):
    words = ["--frames", "0:1", "--aov", "albedo", "-o"]
    assert "only EXR keeps layers" in command(*words, tmp_path / "f_####.png").output
    assert "only EXR keeps layers" not in command(*words, tmp_path / "f_####.exr").output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--fps", "8"], "--fps: is for an animation: give --frames, as 0:120, or --turntable"),
        (["-o", "a.mp4"], "--output: a.mp4 holds an animation: give --frames, as 0:120, or --turn"),
        (
            ["--frames", "3"],
            "--frames: must be FIRST:END with 0 <= FIRST < END <= 10000000, as 0:120, got",
        ),
        (["--frames", "0:2", "-o", "a.exr"], "--output: must hold #### for the number of the"),
        (["--turntable", "--stats", "a.json", "-o", "a_#.png"], "--stats: is for a single picture"),
    ],
)
def test_mistakes_of_the_command_are_told(words, message):
    done = command(*words)
    assert done.exit_code == 2
    assert f"error: {message}" in done.output
