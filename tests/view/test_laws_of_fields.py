"""Laws of the parts that the page shows, for every registered model: paths lead to the values."""

import re

import pytest

from alight.core.registry import modules, type_name_of
from alight.laws.bodies import scene_of
from alight.lights.model import LIGHTS
from alight.scene import Node, Scene, rotate, scale, translate
from alight.scene.dump import dump_scene
from alight.view.tree import fields_of, items_of

#: Tables of a scene, and the key of a node for what stands in none.
TABLES, KEYS = ("bsdfs", "textures", "media"), {"shapes": "shape", "lights": "light"}


def scene_with(family: str, specs: list) -> Scene:
    """A scene of all these models."""
    whole = scene_of({})
    named = {f"m{i}": spec for i, spec in enumerate(specs)}
    if family in TABLES:
        return Scene(nodes={}, camera=whole.camera, **{family: named})
    place = translate(1, 2, 3) @ rotate("y", 30) @ scale(2.0)
    nodes = {
        name: Node(transform=place, **{KEYS[family]: spec})
        for name, spec in named.items()
        if family != "lights" or spec.placement != "environment"
    }
    return Scene(nodes=nodes, camera=whole.camera)


def at(data, path: str):
    """What stands at a key path of a scene as plain data."""
    for word in re.findall(r"[^.\[\]]+", path):
        if isinstance(data, list):
            data = data[int(word)]
        elif isinstance(data, dict):
            data = data[word]
        else:
            raise KeyError(word)
    return data


@pytest.mark.parametrize("family", [*TABLES, *KEYS])
def test_every_field_has_the_value_at_its_path(family):
    shown = 0
    for module in modules(family):
        scene = scene_with(family, list(module.EXAMPLES))
        data = dump_scene(scene, full=True)
        for item in items_of(scene):
            for field in fields_of(scene, item.path):
                if field.kind == "told":
                    continue
                found = at(data, field.path)
                if isinstance(field.value, list) and not isinstance(found, list):
                    found = [found] * len(field.value)
                assert found == field.value, (type_name_of(module), field.path)
                shown += 1
    assert shown > 20


def test_a_light_may_become_any_that_stands_in_the_same_way():
    placed = {name: model.EXAMPLES[0].placement for name, model in LIGHTS.items()}
    for name, model in LIGHTS.items():
        if placed[name] == "environment":
            continue
        scene = scene_with("lights", [model.EXAMPLES[0]])
        alike = sorted(other for other, where in placed.items() if where == placed[name])
        types = [f for f in fields_of(scene, "nodes.m0.light") if f.path.endswith("light.type")]
        assert [f.choices for f in types] == ([alike] if len(alike) > 1 else []), name
