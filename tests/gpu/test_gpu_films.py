"""A GPU's executor adds the sums that threads would add: here its threads are the processor's."""

import numpy as np
import pytest

import alight
from alight.core.errors import DeviceError, FilmError, OptionError
from tests.gpu.processor import ProcessorGpu, render_on_the_processor

WORDS = {"size": (20, 13), "crop": (3, 2, 15, 10), "replicates": 2, "threads": 1}


def same(a, b):
    """Whether two films hold the same samples with the same sums."""
    return np.array_equal(a.sums, b.sums) and np.array_equal(a.cells, b.cells)


@pytest.fixture
def on_the_processor(monkeypatch):
    render_on_the_processor(monkeypatch)


@pytest.fixture(scope="module")
def ours():
    return alight.render("cornell-box", spp=7, spp_per_pass=3, **WORDS)


def test_a_film_has_the_same_sums(on_the_processor, ours):
    film = alight.render("cornell-box", spp=7, spp_per_pass=5, device="gpu", **WORDS)
    assert same(film, ours)
    assert film.stats["rays"] == ours.stats["rays"]
    assert film.stats["gpu"]["launches"] == 2


def test_layers_of_direct_and_indirect_light_have_the_same_sums(on_the_processor):
    words = {"spp": 3, "aovs": ("direct", "indirect"), **WORDS}
    film, ours = (alight.render("cornell-box", device=on, **words) for on in ("gpu", "cpu"))
    assert same(film, ours)
    for name in words["aovs"]:
        assert ours.aov(name).any()
        assert np.array_equal(film.aov(name), ours.aov(name))


def test_films_of_both_are_not_added(on_the_processor, ours):
    film = alight.render("cornell-box", spp=2, device="gpu", **WORDS)
    assert film.fingerprint != ours.fingerprint
    with pytest.raises(FilmError, match="kernel fingerprint"):
        alight.Film.merge(film, ours)


def test_a_lost_gpu_leaves_a_checkpoint_that_goes_on(on_the_processor, ours, monkeypatch, tmp_path):
    path = tmp_path / "a.alight"
    launch = ProcessorGpu.launch

    def lost(gpu, *given):
        if len(gpu.launches) == 2:
            raise DeviceError("the GPU is lost", 719)
        launch(gpu, *given)

    with monkeypatch.context() as patch:
        patch.setattr(ProcessorGpu, "launch", lost)
        words = {"device": "gpu", "spp_per_pass": 2, "checkpoint": path, **WORDS}
        with pytest.raises(DeviceError, match="is lost"):
            alight.render("cornell-box", spp=7, **words)
    # It goes on where it was begun, without being told.
    film = alight.resume(path)
    assert same(film, ours)
    assert film.stats["gpu"]["launches"] >= 1


def test_a_gpus_checkpoint_needs_one(on_the_processor, monkeypatch, tmp_path):
    path = tmp_path / "a.alight"
    alight.render("cornell-box", spp=1, device="gpu", checkpoint=path, **WORDS)
    with pytest.raises(OptionError, match="a GPU renders on this machine, cluster on others"):
        alight.resume(path, spp=2, cluster="tls://10.0.0.1:8786")
    monkeypatch.setattr(ProcessorGpu, "description", {"gpu": "another one"})
    with pytest.raises(FilmError, match="gpu"):
        alight.resume(path, spp=2)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ({"aovs": ("albedo",)}, "layers other than direct and indirect"),
        ({"cluster": "local:1"}, "a GPU renders on this machine, cluster on others"),
    ],
)
def test_what_it_cannot_do_is_said_at_once(on_the_processor, monkeypatch, words, text):
    monkeypatch.setattr("alight.rendering.job.Job.start", None)
    with pytest.raises(OptionError, match=text):
        alight.render("cornell-box", spp=1, device="gpu", **words, **WORDS)
