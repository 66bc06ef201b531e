"""Files may be named by paths wherever Python describes a scene."""

from pathlib import Path

import numpy as np
import pytest

import alight
from alight.core.registry import FAMILIES_OF_SCENES, specs
from alight.outputs.image import write_image

NAMED = [
    model
    for family in FAMILIES_OF_SCENES
    for model in specs(family).values()
    if "file" in model.model_fields
]


@pytest.mark.parametrize("model", NAMED, ids=lambda model: model.type_name())
def test_every_model_takes_a_path(model):
    described = model(file=Path("folder") / "a.png")
    assert described == model(file="folder/a.png")
    assert type(described.file) is str


def test_scenes_take_paths(tmp_path):
    path = write_image(tmp_path / "a.png", np.full((2, 2, 3), 0.25))
    sky = {"type": "environment", "file": path}
    scene = alight.load({"camera": {"type": "pinhole"}, "environment": sky})
    assert scene.environment.file == str(path)
    manager = alight.SceneManager(scene).set_at("environment.file", path)
    assert manager.scene.environment == scene.environment
    assert alight.changed(scene, {"environment.file": path}).environment == scene.environment
