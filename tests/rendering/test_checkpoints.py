"""Renders that were stopped go on to the same bits, or say by name why they cannot."""

import errno
import json
import logging
import os
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest

import alight
from alight.bsdfs.matte.diffuse import Diffuse
from alight.core.errors import FilmError, OptionError, OutputError
from alight.films import Film
from alight.rendering.checkpoints import checkpoint_writer
from alight.rendering.checkpoints.checkpoint import read_checkpoint
from alight.rendering.executors import blocks
from alight.rendering.schedules import selection as schedules
from alight.rendering.schedules.schedule import Goal, Schedule, Verdict
from alight.rendering.summary import summary_lines
from alight.scene import SceneManager
from alight.scene.content import describe_content, differences
from tests.rendering.interrupted import assert_same, cancelled_after

SPP = 24
CHANGES = ("film.size=[72, 40]", "film.crop=[3, 2, 60, 37]")


def scene():
    return alight.load("cornell-box", CHANGES)


@pytest.fixture(scope="module")
def reference():
    return alight.render(scene(), spp=SPP)


def stopped_after(tiles, path, monkeypatch, spp=SPP, **options):
    """Render with a checkpoint, cancelled when so many tiles are in the film."""
    with cancelled_after(tiles, monkeypatch) as cancel:
        return alight.render(
            scene(), spp=spp, checkpoint=path, cancel=cancel, threads=1, spp_per_pass=5, **options
        )


@pytest.mark.parametrize("tiles", [1, 6, 8, 19])
def test_a_stopped_render_goes_on_to_the_same_bits(tmp_path, monkeypatch, reference, tiles):
    path = tmp_path / "a.alight"
    film = stopped_after(tiles, path, monkeypatch)
    assert film.stats["verdict"]["word"] == "cancelled"
    # Most of these moments lie within a pass: some cells hold more samples than others.
    assert 0 < film.spp < SPP
    assert_same(Film.load(path), film)
    assert_same(alight.resume(path, threads=2, spp_per_pass=3), reference)
    # The whole render is in the checkpoint now, and there is nothing left to do.
    again = alight.resume(path)
    assert_same(again, reference)
    assert again.stats["verdict"]["word"] == "done"


def test_a_render_is_not_begun_over_one_that_was_stopped(tmp_path, monkeypatch, reference):
    path = tmp_path / "a b.alight"
    stopped_after(3, path, monkeypatch)
    before = path.read_bytes()
    told = ""
    try:
        alight.render(scene(), spp=SPP, checkpoint=path)
    except OutputError as error:
        told = str(error)
    assert f"to go on: alight resume '{path}', in Python alight.resume({str(path)!r});" in told
    assert path.read_bytes() == before
    assert_same(alight.resume(path), reference)
    # One that has ended is written over, and so is one without a sample.
    for limit in ({"spp": SPP}, {"time_limit": 1e-6}, {"spp": 1}):
        alight.render(scene(), checkpoint=path, threads=1, **limit)


def test_more_samples_are_those_of_a_longer_render(tmp_path, monkeypatch, reference):
    path = tmp_path / "a.alight"
    alight.render(scene(), spp=9, checkpoint=path)
    assert_same(alight.resume(path, spp=SPP), reference)
    stopped_after(3, path, monkeypatch, spp=100)
    assert_same(alight.resume(path, spp=SPP), reference)


def test_a_render_that_fails_has_kept_its_samples(tmp_path, monkeypatch, reference):
    path, add_tile = tmp_path / "a.alight", Film.add_tile

    def fail_late(film, *tile):
        if film.counts.max() >= 12:
            raise MemoryError("no memory")
        add_tile(film, *tile)

    with monkeypatch.context() as patch:
        patch.setattr(Film, "add_tile", fail_late)
        with pytest.raises(MemoryError):
            alight.render(scene(), spp=SPP, replicates=1, checkpoint=path, spp_per_pass=4)
    assert Film.load(path).spp >= 8
    whole = alight.resume(path)
    assert_same(whole, alight.render(scene(), spp=SPP, replicates=1))


def test_a_time_limit_is_that_of_the_whole_render(tmp_path):
    path = tmp_path / "a.alight"
    film = alight.render(scene(), time_limit=0.01, checkpoint=path)
    assert film.stats["verdict"]["word"] == "time"
    assert_same(alight.resume(path), film)
    more = alight.resume(path, time_limit=0.2)
    assert more.spp > film.spp
    assert more.stats["samples"] == more.counts.sum()
    before, after = film.stats["seconds"], more.stats["seconds"]
    assert after["render"] > before["render"]
    assert "resumed_at" not in before
    assert after["resumed_at"] == pytest.approx(before["render"], abs=0.05)


def test_the_time_in_all_is_that_of_every_process(tmp_path):
    path = tmp_path / "a.alight"
    alight.render(scene(), spp=8, checkpoint=path)
    film = alight.resume(path, spp=16)
    film.stats["seconds"] |= {"render": 7.0, "resumed_at": 5.0}
    first = summary_lines(film, film.relmse_estimate(), 0.0, seconds=2.5)[0]
    assert "16 spp in 7.00 s" in first
    assert first.endswith("(7.50 s in all)")


# ---------------------------------------------------------------------------- rules


@dataclass
class TwoRounds(Schedule):
    """Uneven samples in a first film; in a second one as many as the first asks for."""

    asked: int = 0
    pilot: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    name: ClassVar[str] = "two-rounds"

    def next(self, rounds):
        self.asked += 1
        shape = rounds[0].cells.shape
        if self.asked == 1:
            self.pilot = np.arange(shape[0] * shape[1]).reshape(shape) % 7
            return Goal(np.full(shape, 3), self.pilot + 2)
        if self.asked == 2:
            brightness = rounds[0].image.mean()
            counts = (1 + self.pilot * 10 * brightness).astype(np.int64)
            return Goal(np.zeros(shape, np.int64), counts, round=1)
        return Verdict("met", "it is enough", {"asked": self.asked})

    def picture(self, rounds):
        return rounds[-1]

    def state(self):
        return {"asked": self.asked, "pilot": self.pilot.copy()}

    @classmethod
    def restored(cls, state):
        return cls(**state)


def test_decisions_of_a_rule_are_those_of_the_uninterrupted_render(tmp_path, monkeypatch):
    monkeypatch.setattr(schedules, "SCHEDULES", (*schedules.SCHEDULES, TwoRounds))
    whole = alight.render(scene(), schedule=TwoRounds())
    assert whole.stats["verdict"] == {"word": "met", "line": "it is enough", "asked": 3}
    path = tmp_path / "a.alight"
    for tiles in (3, 9, 12, 15):
        stopped_after(tiles, path, monkeypatch, schedule=TwoRounds())
        film = alight.resume(path)
        assert_same(film, whole)
        assert (film.cells == whole.cells).all()
        assert film.stats["verdict"] == whole.stats["verdict"]
        assert film.stats["samples"] == whole.stats["samples"]
    assert_same(alight.merge(path), whole)
    with pytest.raises(FilmError, match="holds 2 films, the rounds of one render"):
        Film.load(path)
    with pytest.raises(OptionError, match="the schedule two-rounds has no fixed number"):
        alight.resume(path, spp=100)


# ---------------------------------------------------------------------------- refusals


def test_a_changed_scene_is_refused_by_key(tmp_path, monkeypatch):
    path, file = tmp_path / "a.alight", tmp_path / "scene.yaml"
    alight.save(scene(), file)
    alight.render(alight.load(file), spp=1, checkpoint=path)
    text = file.read_text()
    file.write_text(text.replace("fov: 39.3077", "fov: 40").replace("[72, 40]", "[80, 40]"))
    with pytest.raises(FilmError) as refused:
        alight.resume(path)
    message, *changed = str(refused.value).splitlines()
    assert message == f"cannot resume {path}: the scene has changed since"
    assert sorted(changed) == [
        "  camera.fov: was 39.3077, is 40.0",
        "  film.size: was [72, 40], is [80, 40]",
    ]
    file.unlink()
    with pytest.raises(FilmError, match="its scene cannot be loaded"):
        alight.resume(path)
    moved = tmp_path / "moved.yaml"
    moved.write_text(text)
    assert alight.resume(path, scene=moved, spp=2).spp == 2


def test_a_render_with_a_root_goes_on_from_anywhere(tmp_path, monkeypatch):
    project, path = tmp_path / "project", tmp_path / "a.alight"
    for name in ("scenes", "textures", "elsewhere"):
        (project / name).mkdir(parents=True)
    np.save(project / "textures" / "sky.npy", np.ones((2, 4)))
    (project / "scenes" / "a.yaml").write_text(
        "alight: 1\ncamera: {type: pinhole}\nfilm: {size: [8, 8]}\n"
        "environment: {type: environment, file: ../textures/sky.npy}\n"
    )
    monkeypatch.chdir(project)
    whole = alight.render(alight.load("scenes/a.yaml", root="."), spp=4)
    alight.render(alight.load("scenes/a.yaml", root="."), spp=2, checkpoint=path)
    monkeypatch.chdir(project / "elsewhere")
    assert_same(alight.resume(path, spp=4, checkpoint=tmp_path / "b.alight"), whole)
    assert read_checkpoint(tmp_path / "b.alight").origin.recipe.root == str(project)
    moved = tmp_path / "moved"
    project.rename(moved)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FilmError, match=r"--root\n  must be a folder.*\n.*--scene, and --root"):
        alight.resume(path, scene=moved / "scenes" / "a.yaml", spp=4)
    found = alight.resume(path, scene=moved / "scenes" / "a.yaml", root="moved", spp=4)
    assert_same(found, whole)


def test_a_changed_file_of_a_scene_is_named(tmp_path):
    (tmp_path / "scene.yaml").write_text(
        "alight: 1\ncamera: {type: pinhole}\nfilm: {size: [8, 8]}\n"
        "environment: {type: constant}\n"
        "nodes: {ball: {shape: {type: mesh, file: ball.obj}}}\n"
    )

    def content(height):
        (tmp_path / "ball.obj").write_text(f"v -1 -1 -3\nv 1 -1 -3\nv 0 {height} -3\nf 1 2 3\n")
        return describe_content(alight.load(tmp_path / "scene.yaml"))

    before = content(1)
    assert differences(before, content(1)) == []
    assert differences(before, content(1.5)) == ["file ball.obj: its content has changed"]


def test_another_machine_is_refused_by_what_differs(tmp_path, monkeypatch):
    path = tmp_path / "a.alight"
    alight.render(scene(), spp=1, checkpoint=path)
    other = {**blocks.describe_machine(), "lanes": "4"}
    monkeypatch.setattr(blocks, "describe_machine", lambda: other)
    with pytest.raises(
        FilmError, match=r"other bits\n  lanes: was \d+, is 4\nits picture is whole"
    ):
        alight.resume(path)


def test_a_scene_made_in_python_must_be_given(tmp_path):
    path = tmp_path / "a.alight"
    made = alight.Scene(**dict(scene()))
    whole = alight.render(made, spp=5)
    alight.render(made, spp=2, checkpoint=path)
    with pytest.raises(FilmError, match=r"made in Python; give it as well: .*scene=scene"):
        alight.resume(path)
    assert_same(alight.resume(path, scene=made, spp=5), whole)


def test_a_scene_changed_in_python_is_found_out(tmp_path):
    path, manager = tmp_path / "a.alight", SceneManager(scene())
    manager.set_value("bsdfs.white.reflectance=[0.5, 0.5, 0.5]")
    alight.render(manager.scene, spp=1, checkpoint=path)
    with pytest.raises(FilmError, match=r"bsdfs\.white\.reflectance: was \[0\.5, 0\.5, 0\.5\], is"):
        alight.resume(path)


def test_a_film_is_no_checkpoint(tmp_path, reference):
    reference.save(tmp_path / "a.alight")
    with pytest.raises(FilmError, match="is a film, not a checkpoint"):
        alight.resume(tmp_path / "a.alight")


# ---------------------------------------------------------------------------- writing


def test_a_disk_that_fills_up_does_not_stop_the_render(tmp_path, monkeypatch, caplog, reference):
    path, count = tmp_path / "a.alight", 0
    fsync = os.fsync

    def full_later(handle):
        nonlocal count
        count += 1
        # A file and its folder are forced to the disk each time.
        if count > 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        fsync(handle)

    monkeypatch.setattr(os, "fsync", full_later)
    with caplog.at_level(logging.WARNING):
        film = alight.render(scene(), spp=SPP, checkpoint=path, every=0, spp_per_pass=4)
    monkeypatch.undo()
    assert_same(film, reference)
    assert film.stats["checkpoint"]["failure"] == f"cannot write {path}: the disk is full"
    assert len(caplog.records) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["a.alight"]
    assert_same(alight.resume(path), reference)


def test_a_checkpoint_that_cannot_be_written_is_said_before_rendering(tmp_path):
    with pytest.raises(OutputError, match=r"the folder .* does not exist"):
        alight.render(scene(), spp=SPP, checkpoint=tmp_path / "no" / "a.alight")


def test_rendering_does_not_wait_for_the_disk(tmp_path, monkeypatch):
    write, add_tile = checkpoint_writer.write_checkpoint, Film.add_tile
    begun, went_on, all_rendered = [], [], threading.Event()

    def slow(*arguments):
        begun.append(True)
        if len(begun) == 2:
            went_on.append(all_rendered.wait(30))
        return write(*arguments)

    def add_and_tell(film, *tile):
        add_tile(film, *tile)
        if film.counts.sum() == 60 * 37 * SPP:
            all_rendered.set()

    monkeypatch.setattr(checkpoint_writer, "write_checkpoint", slow)
    monkeypatch.setattr(Film, "add_tile", add_and_tell)
    alight.render(scene(), spp=SPP, checkpoint=tmp_path / "a.alight", every=0, spp_per_pass=2)
    # The second one hung until the last sample was there; the third is the last.
    assert went_on == [True]
    assert len(begun) == 3


LEAVE_A_FILE = """
import sys
from pathlib import Path
from alight.outputs import atomic
atomic._name_beside(Path(sys.argv[1])).touch()
"""


def test_what_a_killed_writer_left_is_removed(tmp_path):
    child = subprocess.run(
        [
            sys.executable, "-c",
            LEAVE_A_FILE,
            str(tmp_path / "a.alight"),
        ],
        check=False,
    )  # fmt: skip
    assert child.returncode == 0
    (tmp_path / ".alight-other.tmp").touch()
    assert len(list(tmp_path.iterdir())) == 2
    alight.render(scene(), spp=1, checkpoint=tmp_path / "a.alight")
    assert {p.name for p in tmp_path.iterdir()} == {"a.alight", ".alight-other.tmp"}


# ---------------------------------------------------------------------------- merging


def test_parts_merge_in_any_order_from_files_and_memory(tmp_path, reference):
    parts = [(0, 7), (7, 9), (16, 8)]
    for first, count in parts:
        alight.render(
            scene(), spp=count, first_sample=first, checkpoint=tmp_path / f"{first}.alight"
        )
    files = [tmp_path / f"{first}.alight" for first, _ in parts]
    assert_same(alight.merge(*files), reference)
    alight.merge(files[2], files[0]).save(tmp_path / "two.alight")
    assert_same(alight.merge(Film.load(files[1]), tmp_path / "two.alight"), reference)
    with pytest.raises(FilmError, match=r"7\.alight: samples 7 to 15 are in .*7\.alight too"):
        alight.merge(*files, files[1])


def test_films_of_other_scenes_are_refused_by_key_and_file(tmp_path):
    a, b = tmp_path / "a.alight", tmp_path / "b.alight"
    alight.render(scene(), spp=1, checkpoint=a)
    manager = SceneManager(scene())
    manager.set_value("bsdfs.white=" + json.dumps({"type": "diffuse", "reflectance": 0.5}))
    assert isinstance(manager.scene.bsdfs["white"], Diffuse)
    alight.render(manager.scene, spp=1, first_sample=1, checkpoint=b)
    with pytest.raises(FilmError) as refused:
        alight.merge(a, b)
    assert f"cannot merge {b} with {a}: their scenes differ\n  bsdfs.white.reflectance: was" in str(
        refused.value
    )


def test_notes_and_recipe_are_kept_over_a_resume(tmp_path):
    path = tmp_path / "a.alight"
    alight.render(scene(), spp=1, checkpoint=path, notes={"outputs": ["x.png"]})
    alight.resume(path, spp=2)
    origin = read_checkpoint(path).origin
    assert origin.notes == {"outputs": ["x.png"]}
    assert (origin.recipe.path, origin.recipe.changes) == ("cornell-box", CHANGES)
