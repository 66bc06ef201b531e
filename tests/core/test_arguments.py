"""What a function is about is checked by its name, whatever is given in its place."""

import inspect
import math
from pathlib import Path

import numpy as np
import pytest

import alight
from alight.core.arguments import known_words
from alight.core.errors import AlightError, OptionError
from alight.films import Film
from alight.outputs.image import read_image, write_image

#: What slips into the wrong place.
VALUES = {
    "nothing": None, "text": "95%", "nan": math.nan, "inf": math.inf, "negative": -1, "list": [],
    "dict": {}, "bytes": b"x", "path": Path("nowhere") / "x", "scalar": np.float32(0.5),
    "truth": True,
}  # fmt: skip


def manager():
    return alight.SceneManager(alight.load("cornell-box"))


def film():
    return Film(8, 8, aovs={"depth": ("Z",)})


#: Function and argument, or words for it -> the call with a value. Nothing is rendered.
CALLS = {
    "load scene": lambda value: alight.load(value),
    "load changes": lambda value: alight.load("cornell-box", value),
    "load definitions": lambda value: alight.load("cornell-box", definitions=value),
    "load root": lambda value: alight.load("cornell-box", root=value),
    "render scene": lambda value: alight.render(value, spp=1),
    "resume path": lambda value: alight.resume(value),
    "merge source|film": lambda value: alight.merge(value),
    "trace scene": lambda value: alight.trace(value, (0, 0)),
    "trace pixel": lambda value: alight.trace("cornell-box", value),
    "guide scene": lambda value: alight.guide(value, (0, 0)),
    "check scene": lambda value: alight.check(value),
    "info scene": lambda value: alight.info(value),
    "why scene": lambda value: alight.why(value),
    "plan scene": lambda value: alight.plan(value),
    "animate scene": lambda value: alight.animate(value, frames="0:1", output="a.gif"),
    "study name": lambda value: alight.study(value),
    "denoise film": lambda value: alight.denoise(value),
    "compare a": lambda value: alight.compare(value, film()),
    "compare b": lambda value: alight.compare(film(), value),
    "save scene": lambda value: alight.save(value, "a.yaml"),
    "save path": lambda value: alight.save(alight.load("cornell-box"), value),
    "changed scene": lambda value: alight.changed(value, {}),
    "changed changes": lambda value: alight.changed(alight.load("cornell-box"), value),
    "register model": lambda value: alight.register(value),
    "check_laws model": lambda value: alight.check_laws(value, compiled=False),
    "SceneManager scene": lambda value: alight.SceneManager(value),
    "SceneManager.get path": lambda value: manager().get(value),
    "SceneManager.add path": lambda value: manager().add(value, None),
    "SceneManager.remove path": lambda value: manager().remove(value),
    "SceneManager.move path": lambda value: manager().move(value, "elsewhere"),
    "SceneManager.move to": lambda value: manager().move("floor", value),
    "SceneManager.set_value path.to": lambda value: manager().set_value(value),
    "SceneManager.set_at path": lambda value: manager().set_at(value, 1),
    "SceneManager.add_bsdf name": lambda value: manager().add_bsdf(value, None),
    "SceneManager.add_texture name": lambda value: manager().add_texture(value, None),
    "SceneManager.add_prototype name": lambda value: manager().add_prototype(value, None),
    "Film width|size": lambda value: Film(value, 8),
    "Film height|size": lambda value: Film(8, value),
    "Film crop": lambda value: Film(8, 8, crop=value),
    "Film replicates": lambda value: Film(8, 8, replicates=value),
    "Film channels": lambda value: Film(8, 8, channels=value),
    "Film aovs": lambda value: Film(8, 8, aovs=value),
    "Film.interval confidence": lambda value: film().interval(value),
    "Film.aov name": lambda value: film().aov(value),
    "Film.mask name|mattes": lambda value: film().mask(value),
    "Film.merge films": lambda value: Film.merge(value),
    "Film.save path": lambda value: film().save(value),
    "Film.load path": lambda value: Film.load(value),
    **{
        f"Film.save {word}": lambda value, word=word: film().save("a.png", **{word: value})
        for word in ("exposure", "tone_map", "bits", "white_balance", "dpi")
    },
    "write_image path": lambda value: write_image(value, np.zeros((2, 2, 3))),
    "read_image path": lambda value: read_image(value),
}
#: Texts and paths are names: what they do not lead to is told by the name that was given.
NAMES = ("text", "path")


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_argument_is_told_by_its_name(call):
    """Or it works; no other error says that something inside has met it."""
    words = call.split()[1].replace("_", " ").split("|")
    for kind, value in VALUES.items():
        told = ""
        try:
            CALLS[call](value)
        except AlightError as error:
            told = str(error)
        shown = kind in NAMES and str(value) in told
        # A dictionary is a scene, without a camera.
        named = any(word in told.replace("_", " ") for word in (*words, "camera"))
        assert named or shown or not told, (kind, told)


def test_windows_may_be_arrays():
    assert Film(8, 8, crop=np.array([1, 2, 3, 4])).crop == (1, 2, 3, 4)


def test_a_pixel_of_uneven_parts_is_told_by_its_name():
    with pytest.raises(OptionError, match=r"pixel: must be x,y .* got \[1, 2\],3"):
        alight.trace("cornell-box", ([1, 2], 3))


def test_values_by_key_paths_are_for_another_function():
    with pytest.raises(OptionError, match=r"changes: must list .*; alight\.changed takes"):
        alight.load("cornell-box", {"film.size": (8, 8)})


@pytest.mark.parametrize(
    "call",
    [
        lambda: alight.load("cornell-box", roots="."),
        lambda: alight.save(alight.load("cornell-box"), path="a.yaml", sceene=1),
        lambda: alight.merge(film(), output="a.png"),
        lambda: alight.changed(alight.load("cornell-box"), {}, change={}),
        lambda: film().save("a.png", exposre=1.0),
        lambda: write_image("a.png", np.zeros((2, 2, 3)), exposre=1.0),
    ],
)
def test_an_unknown_word_is_told_with_the_nearest_one(call):
    with pytest.raises(OptionError, match=r"unknown argument .*(did you mean|film\.save)"):
        call()


def test_words_that_are_known_go_through_and_the_signature_stays():
    @known_words()
    def function(a, *, b=2):
        return a, b

    assert function(1, b=3) == function(a=1, b=3) == (1, 3)
    assert str(inspect.signature(function)) == "(a, *, b=2)"
