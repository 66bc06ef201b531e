"""What a session renders is what `alight render` renders, wherever the camera has been."""

import threading
from contextlib import suppress

import numpy as np
import pytest

import alight
from alight.core.errors import AlightError, OutputError
from alight.options.view import ViewOptions
from alight.view import editing, protocol
from alight.view.layers import FileLayers, read_layers
from alight.view.live import LiveScene, Wish
from alight.view.movable import Movable
from alight.view.opening import session_of
from alight.view.protocol import RefusedError
from alight.view.saving import save
from alight.view.session import Session
from tests.view.looking import OPTIONS, cornell, settled, wait_for


@pytest.fixture
def session():
    found = cornell()
    yield found
    found.close()


def content(film, path):
    """All that the file of a film holds."""
    return film.save(path).read_bytes()


@pytest.mark.parametrize(
    "words",
    [{}, {"crop": (3, 5, 13, 9), "seed": 3, "replicates": 2, "aovs": ("direct", "depth")},
     {"spp": None, "error": 0.6, "max_spp": 48}, {"spp": 16, "adaptive": True}],
    ids=["plain", "crop and layers", "an error", "adaptive"],
)  # fmt: skip
def test_the_settled_film_is_that_of_a_render(words, tmp_path):
    options = OPTIONS.changed(**words)
    session = session_of("cornell-box", options)
    try:
        film = settled(session)
        same = alight.render("cornell-box", size=(24, 16), **{"spp": 4, "threads": 1, **words})
        assert content(film, tmp_path / "a.alight") == content(same, tmp_path / "b.alight")
        assert session.live.job.verdict.word == same.stats["verdict"]["word"]
        # And wherever it has been moved to.
        session.apply(protocol.Orbit(0.05, 0.02))
        session.apply(protocol.Dolly(0.1))
        film = settled(session)
        moved = alight.render(session.live.scene, options.of_render)
        assert not np.array_equal(film.image, same.image)
        assert content(film, tmp_path / "a.alight") == content(moved, tmp_path / "b.alight")
    finally:
        session.close()


def test_the_saved_scene_gives_the_same_picture(session, tmp_path):
    session.apply(protocol.Orbit(-0.04, 0.01))
    film = settled(session)
    save(session, tmp_path / "scene.yaml")
    again = alight.render(tmp_path / "scene.yaml", spp=4, threads=1)
    assert content(film, tmp_path / "a.alight") == content(again, tmp_path / "b.alight")


def test_more_samples_go_on_from_those_that_are_there(session, tmp_path):
    settled(session)
    session.apply(protocol.More())
    wait_for(lambda: session.film.spp == 8)
    film = settled(session)
    whole = alight.render("cornell-box", size=(24, 16), spp=8, threads=1)
    assert content(film, tmp_path / "a.alight") == content(whole, tmp_path / "b.alight")


def test_a_camera_that_moves_after_more_samples_gives_its_own_picture(session, tmp_path):
    """The render that went on is not that of the next view, which has as many samples."""
    settled(session)
    session.apply(protocol.More())
    wait_for(lambda: session.film.spp == 8)
    settled(session)
    session.apply(protocol.Orbit(0.05, 0.02))
    film = settled(session)
    same = alight.render(session.live.scene, spp=8, threads=1)
    assert content(film, tmp_path / "a.alight") == content(same, tmp_path / "b.alight")


def test_nothing_is_done_before_the_loop_has_heard_of_it(session):
    settled(session)
    # The loop waits.
    with session.live._news:
        session.apply(protocol.Orbit(0.05, 0.02))
        assert session.state(None, None)["phase"] == "moving"
        session.apply(protocol.Rest())
        assert session.state(None, None)["phase"] == "rendering"
    settled(session)
    assert session.state(None, None)["phase"] == "done"


@pytest.mark.parametrize(("before", "after"), [("done", "failed"), ("failed", "done")])
def test_a_view_that_ends_never_has_the_phase_of_the_one_before(before, after):
    seen = []

    class Watched(LiveScene):
        def __init__(self):
            self._phase, self._wish, self._done = before, Wish(number=2), Wish(number=1)

        def __setattr__(self, name, value):
            super().__setattr__(name, value)
            if {"_phase", "_wish", "_done"} <= self.__dict__.keys():
                seen.append(self.phase)

        def _changed(self):
            """Nobody looks."""

    live = Watched()
    live._tell(after, live._wish)
    assert seen == ["rendering", "rendering", after]


def test_what_is_stopped_is_the_picture_of_this_view(session, tmp_path):
    """A key that is pressed before the loop has heard of the move stops nothing."""
    settled(session)
    with session.live._news:
        session.live._phase = "rendering"
        session.apply(protocol.Orbit(0.05, 0.02))
        session.apply(protocol.Stop())
    wait_for(lambda: session.live.phase in ("done", "stopped"))
    assert session.live.phase == "done"
    film = settled(session)
    same = alight.render(session.live.scene, spp=4, threads=1)
    assert content(film, tmp_path / "a.alight") == content(same, tmp_path / "b.alight")


def test_more_samples_can_be_stopped_before_the_loop_begins_them(session, tmp_path):
    settled(session)
    # The loop waits.
    with session.live._news:
        session.apply(protocol.More())
        session.apply(protocol.Stop())
    wait_for(lambda: session.live.phase in ("done", "stopped"))
    assert (session.live.phase, session.film.spp) == ("stopped", 4)
    # And they can be asked for again.
    session.apply(protocol.More())
    wait_for(lambda: session.film.spp == 8)
    film = settled(session)
    same = alight.render("cornell-box", size=(24, 16), spp=8, threads=1)
    assert content(film, tmp_path / "a.alight") == content(same, tmp_path / "b.alight")


def test_a_thousand_moves_end_with_the_picture_of_the_last(session, tmp_path):
    settled(session)
    draw = np.random.default_rng(3)
    for _ in range(1000):
        session.apply(protocol.Orbit(*draw.uniform(-0.05, 0.05, 2)))
        if draw.random() < 0.05:
            session.apply(protocol.Rest())
    film = settled(session)
    assert session.number == 1000
    same = alight.render(session.live.scene, spp=4, threads=1)
    assert content(film, tmp_path / "a.alight") == content(same, tmp_path / "b.alight")


def test_a_thousand_random_events_leave_nothing_behind(session, tmp_path):
    settled(session)
    threads, draw = threading.active_count(), np.random.default_rng(7)
    events = [
        *(protocol.Orbit(x, 0.01) for x in (-0.03, 0.02)), protocol.Pan(0.01, 0.0),
        protocol.Dolly(0.01), protocol.Roll(0.02), protocol.Widen(-0.01), protocol.Rest(),
        protocol.Show("error"), protocol.Show("picture"), protocol.Develop(1.0, "aces", "auto"),
        protocol.AskPixel(3, 3), protocol.Keep(), protocol.Drop(), protocol.More(),
        protocol.Stop(), protocol.Undo(), protocol.Redo(), protocol.AskTree(),
        protocol.Edit("bsdfs.white", "bsdfs.white.reflectance", "[0.3, 0.3, 0.3]"),
        protocol.Edit("bsdfs.white", "bsdfs.white.reflectance", "[3, 0, 0]"),
        protocol.Region(2, 2, 8, 8), protocol.Whole(), protocol.ChooseCamera(""),
    ]  # fmt: skip
    for number in draw.integers(len(events), size=1000):
        with suppress(RefusedError):
            session.apply(events[number])
        assert len(session.editor.history.done) <= editing.MOST_UNDONE
    session.apply(protocol.Whole())
    session.apply(protocol.ChooseCamera(""))
    wait_for(lambda: session.live.phase in ("done", "stopped"))
    film = settled(session)
    save(session, tmp_path / "scene.yaml")
    same = alight.render(tmp_path / "scene.yaml", spp=round(film.spp), threads=1)
    np.testing.assert_array_equal(film.sums, same.sums)
    # Each render has threads of its own, which have ended with it.
    wait_for(lambda: threading.active_count() <= threads, 20)


def test_the_pivot_is_what_a_pixel_shows(session):
    settled(session)
    live = session.live
    wait_for(lambda: live.aim(12, 8) or live._looks.is_set())
    session.apply(protocol.Pivot(12, 8))
    seen = alight.render("cornell-box", size=(24, 16), spp=1, aovs=("position",), threads=1)
    # Anywhere within the pixel: the point lies in the box of those around it.
    around = seen.aov("position")[6:11, 10:15].reshape(-1, 3)
    assert (live.pose.pivot >= around.min(axis=0) - 0.05).all()
    assert (live.pose.pivot <= around.max(axis=0) + 0.05).all()
    assert live.layers.number == 0
    # At the corners of cells, too.
    places = seen.aov("position")
    for x, y in ((8, 8), (16, 8), (7, 7), (15, 3), (8, 1)):
        point = live.movable.hit(live.pose, x, y)
        around = places[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
        assert point is not None
        assert (point >= around.min(axis=0) - 0.05).all()
        assert (point <= around.max(axis=0) + 0.05).all()


def test_a_pixel_is_told_with_its_error(session):
    film = settled(session)
    found = session.apply(protocol.AskPixel(12, 10))
    values = found["values"]
    np.testing.assert_allclose(values["picture"], film.image[10, 12], rtol=1e-6)
    np.testing.assert_allclose(values["standard error"], film.standard_error[10, 12], rtol=1e-6)
    assert values["95 % from"] < values["picture"] < values["95 % to"]
    assert values["samples"] == [4.0]


def test_the_state_tells_the_promise_and_the_error():
    session = session_of("cornell-box", OPTIONS.changed(spp=None, error=0.6, max_spp=48))
    try:
        film = settled(session)
        state = session.state(film.error, (0.0, 1.0))
        assert state["word"] in ("met", "not met", "not certifiable")
        assert state["error"][1] <= state["error"][0] <= state["error"][2]
        assert state["layers"][:3] == ["picture", "error", "samples"]
        assert (state["kind"], state["size"]) == ("scene", [24, 16])
    finally:
        session.close()


@pytest.mark.parametrize("suffix", ["alight", "exr", "png"])
def test_files_are_viewed_as_films_are(suffix, tmp_path):
    film = alight.render("cornell-box", size=(24, 16), spp=4, aovs=("normal",), threads=1)
    path = film.save(tmp_path / f"a.{suffix}")
    session = session_of(str(path), ViewOptions())
    layers = session.layers
    assert layers.size == (24, 16)
    if suffix != "png":
        np.testing.assert_array_equal(layers.plane("picture"), film.image)
        np.testing.assert_array_equal(layers.plane("normal"), film.aov("normal"))
        np.testing.assert_array_equal(layers.plane("samples")[..., 0], film.sample_count)
        np.testing.assert_allclose(
            layers.plane("error"), read_layers(film.save(tmp_path / "b.alight")).plane("error")
        )
    with pytest.raises(RefusedError, match="only scenes are rendered"):
        session.apply(protocol.Orbit(0.1, 0.1))
    with pytest.raises(OutputError, match="only scenes"):
        save(session, tmp_path / "scene.yaml")
    save(session, tmp_path / "picture.exr")
    np.testing.assert_array_equal(
        read_layers(tmp_path / "picture.exr").plane("picture"), layers.plane("picture")
    )


def test_a_file_takes_no_options_of_a_render(tmp_path):
    film = alight.render("cornell-box", size=(24, 16), spp=1, threads=1)
    path = film.save(tmp_path / "a.alight")
    with pytest.raises(alight.OptionError, match=r"spp: .* is no scene"):
        session_of(str(path), ViewOptions(spp=3))


def test_what_makes_no_sense_is_refused_and_changes_nothing():
    session = Session("a", FileLayers(read_picture()))
    for event in (
        protocol.Show("albedo"), protocol.AskPixel(5, 0), protocol.Denoise(True), protocol.More(),
        protocol.Develop(200.0, "none", "none"), protocol.Develop(0.0, "asces", "none"),
        protocol.Develop(0.0, "none", "hot"), protocol.Contrast("blink"),
    ):  # fmt: skip
        before = session.look
        with pytest.raises(RefusedError):
            session.apply(event)
        assert session.look == before
    session.apply(protocol.Develop(1.0, "aces", "3200K"))
    assert session.look.display.exposure == 1.0
    session.rival = "other.png"
    session.apply(protocol.Keep())
    assert session.against is session.layers
    assert session.state(None, None)["rival"] == "kept"
    session.apply(protocol.Drop())
    assert session.against is None


def read_picture():
    from alight.outputs.picture import as_picture

    return as_picture(np.full((4, 5, 3), 0.5, np.float32))


def test_of_scenes_that_wait_for_the_compiler_only_the_newest_is_compiled(session, monkeypatch):
    begun, may_end = [], threading.Event()

    def prepare(movable):
        begun.append(movable.scene.bsdfs["white"].type)
        may_end.wait(20.0)
        raise AlightError("cannot be compiled")

    settled(session)
    monkeypatch.setattr(Movable, "prepare", prepare)
    for name in ("mirror", "plastic", "conductor", "phong"):
        session.live.change(alight.changed(session.live.scene, {"bsdfs.white": {"type": name}}))
        wait_for(lambda: begun)
    may_end.set()
    wait_for(lambda: not session.live.prepares)
    assert begun == ["mirror", "phong"]
    assert session.live.problem == "cannot be compiled"


def test_layers_are_there_to_choose_while_the_camera_moves(session):
    """Only the coarse picture is there then, which has no others: it is shown in their place."""
    settled(session)
    session.live.layers = FileLayers(read_picture())
    assert session.film is None
    assert session.state(None, None)["layers"] == ["picture", "error", "samples"]
    session.apply(protocol.Show("error"))
    assert session.state(None, None)["layer"] == "error"
    with pytest.raises(RefusedError, match="none of this name"):
        session.apply(protocol.Show("albedo"))


def test_named_cameras_are_looked_through():
    session = session_of("transform-tree", ViewOptions(size=(16, 16), spp=1, threads=1))
    try:
        assert session.editor.cameras[0] == ""
        with pytest.raises(RefusedError, match="none of this name"):
            session.apply(protocol.ChooseCamera("nowhere"))
    finally:
        session.close()


def test_every_picture_bears_the_number_of_its_view_from_the_moment_it_is_there(monkeypatch):
    """A page that paints it then would take it for that of another place of the camera."""
    shown = []

    def keep(live, layers):
        shown.append(layers and layers.number)
        live.__dict__["kept"] = layers

    kept = property(lambda live: live.__dict__["kept"], keep)
    monkeypatch.setattr(LiveScene, "layers", kept, raising=False)
    session = cornell()
    try:
        settled(session)
        first = len(shown)
        session.apply(protocol.Orbit(0.05, 0.02))
        settled(session)
    finally:
        session.close()
    assert shown[0] is None and set(shown[1:first]) == {0}
    # The coarse picture of the second view, and the settled one.
    assert set(shown[first:]) == {1} and len(shown) >= first + 2
