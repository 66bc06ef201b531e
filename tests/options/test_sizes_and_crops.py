"""A size and a crop that are asked for, over those of the scene: each pair that can be."""

import itertools

import numpy as np
import pytest

import alight
from alight.formats import loads
from alight.options.loading import scene_of
from alight.options.render import RenderOptions

SCENE = """
alight: 1
camera: {type: pinhole}
film: {size: [32, 24], crop: [20, 10, 8, 8]}
nodes: {ball: {shape: sphere}}
"""


@pytest.mark.parametrize(
    ("size", "crop"), [*itertools.product([None, "16", "48x36"], [None, "1,2,6,5"])]
)
def test_a_new_size_shows_all_of_the_picture_unless_a_crop_is_asked_for(size, crop):
    given = {name: text for name, text in (("size", size), ("crop", crop)) if text}
    film = scene_of(loads(SCENE), RenderOptions(**given)).film
    assert film.size == {None: (32, 24), "16": (16, 16), "48x36": (48, 36)}[size]
    own = (20, 10, 8, 8) if size is None else None
    assert film.crop == (own if crop is None else (1, 2, 6, 5))


@pytest.mark.parametrize(("dpi", "pixels"), [(None, (1050, 750)), (100, (350, 250))])
def test_paper_has_the_pixels_of_its_inches(dpi, pixels):
    options = RenderOptions(size="3.5x2.5in", dpi=dpi)
    assert scene_of(loads(SCENE), options).film.size == pixels


@pytest.mark.parametrize("size", [8, np.int64(8), (8, 8), np.array([8, 8])])
def test_sizes_and_crops_may_be_of_numpy(size):
    options = RenderOptions(size=size, crop=np.array([1, 2, 3, 4]))
    assert options.size == (8, 8) and options.crop == (1, 2, 3, 4)


@pytest.mark.parametrize("size", [8.0, np.float64(8), (8, 8, 8), np.array([8.0, 8.0]), "3cm"])
def test_what_is_no_size_is_refused(size):
    with pytest.raises(
        alight.OptionError, match=r"^size: must be WIDTHxHEIGHT in pixels or on pap"
    ):
        RenderOptions(size=size)


def test_changes_of_what_was_changed_before_are_kept_in_their_order(tmp_path):
    (tmp_path / "a.yaml").write_text(SCENE)
    first = alight.load(tmp_path / "a.yaml", ["film={size: [9, 5]}", "nodes.ball.shape.radius=2"])
    scene = scene_of(first, RenderOptions(changes=["film.size=[7, 6]"]))
    recipe = scene.source.recipe
    again = alight.load(recipe.path, recipe.changes)
    assert again.film.size == scene.film.size == (7, 6)
    assert again.nodes["ball"].shape.radius == scene.nodes["ball"].shape.radius == 2.0
