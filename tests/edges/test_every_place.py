"""Every material in every other one, and every field with a named texture, wherever it is read."""

from __future__ import annotations

import pytest

from alight.bsdfs import MODELS
from alight.bsdfs.nesting import Nested, scatters_inside
from alight.cameras.pinhole import Pinhole
from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.core.field_types import texture_interval
from alight.core.registry import type_name_of
from alight.formats import dumps, loads
from alight.formats.gltf.write import write
from alight.lab.info import facts, tree_lines
from alight.lights.constant import Constant as Surroundings
from alight.rendering.schedules.sample_bound import largest_sample
from alight.scene import Node, Scene, content_hash, flatten
from alight.scene.transform import translate
from alight.shapes.sphere import Sphere
from alight.textures.checkerboard import Checkerboard
from tests.edges.specs import changed

EXAMPLES = [model.EXAMPLES[0] for model in MODELS]
NESTING = [example for example in EXAMPLES if isinstance(example, Nested)]
BOARD = Checkerboard(color0=0.25, color1=0.3)


def scene_of(*bsdfs):
    """A sphere of each material."""
    nodes = {f"s{i}": Node(shape=Sphere(), bsdf=bsdf) for i, bsdf in enumerate(bsdfs)}
    camera = Node(camera=Pinhole(), transform=translate(0, 0, 5))
    return Scene(nodes=nodes, camera=camera, textures={"board": BOARD}, environment=Surroundings())


def read_everywhere(scene, folder):
    """All that reads a description, but for what makes tables of it; returns the flat scene."""
    text = dumps(scene)
    again = loads(text, "scene.yaml", folder)
    assert again == scene and content_hash(again) == content_hash(scene)
    flat = flatten(again)
    assert facts(again, flat) and list(tree_lines(again))
    largest_sample(flat, by_tree=False)
    write(flat, folder / "written.glb")
    return flat


def nested(outer, inner):
    """The outer material with others inside; None where they do not go together."""
    if scatters_inside(inner) and len(outer.parts) > 1:
        return None
    fields = {"bsdfs": (inner, outer.bsdfs[1])} if "bsdfs" in dict(outer) else {"bsdf": inner}
    try:
        return outer.replaced(**fields)
    except SceneError:
        return None


@pytest.mark.parametrize("outer", NESTING, ids=lambda spec: spec.type_name())
def test_materials_can_stand_in_others_wherever_descriptions_are_read(outer, tmp_path):
    pairs = [nested(outer, inner) for inner in EXAMPLES]
    compile_scene(read_everywhere(scene_of(*filter(None, pairs)), tmp_path), structure="list")


@pytest.mark.parametrize("model", MODELS, ids=type_name_of)
def test_each_field_that_takes_a_texture_takes_its_name(model, tmp_path):
    spec = model.EXAMPLES[0]
    fields = [name for name in type(spec).model_fields if texture_interval(type(spec), name)]
    # Two fields of which the light must be shared fit with the texture.
    plain = dict.fromkeys(spec.shares, 0.1)
    named = [changed(spec, plain | {name: "board"}) for name in fields]
    inside = [nested(outer, found) for found in named for outer in NESTING[:3]]
    read_everywhere(scene_of(spec, *named, *filter(None, inside)), tmp_path)
