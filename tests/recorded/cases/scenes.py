"""Scenes: built-in and random ones, edited ones, transforms, what files of scenes say wrongly."""

from __future__ import annotations

from typing import Any

import numpy as np

import alight
from alight.formats import builtin_names, dumps, loads
from alight.lab.random_scenes import KINDS, random_scene
from alight.rendering import animation
from alight.scene import Node, SceneManager, flatten, look_at, matrix, rotate, scale, translate
from alight.scene.dump import dump_scene
from alight.scene.plain_yaml import parse_value, write
from alight.shapes.sphere import Sphere
from tests.recorded.cases.renders import SCENE
from tests.recorded.making import briefly, command, described, outcome, rows


def flat() -> dict[str, Any]:
    """Built-in scenes, flattened: places of shapes, lights and cameras."""
    found = {}
    for name in builtin_names():
        made = flatten(alight.load(name))
        places = np.array([s.to_world for s in made.shapes] or [np.eye(4)])
        found[name] = {
            "shapes": len(made.shapes),
            "places": described(places, 16),
            "lights": len(made.lights),
            "camera": described(made.camera.to_world),
            "notes": list(made.notes),
            "bsdfs": len(made.bsdfs),
            "middle": described(animation.middle(made)),
        }
    return found


def random() -> dict[str, Any]:
    """Random scenes, by kind."""
    found: dict[str, Any] = {}
    for kind in KINDS:
        for seed in (1, 27):
            data = dump_scene(random_scene(seed, kind))
            numbers = list(_numbers(data))
            found[f"{kind} {seed}"] = [
                sorted(_types(data)),
                len(numbers),
                described(np.array(numbers), 0),
            ]
    found["wrong"] = outcome(random_scene, 3, "rom")
    found["list"] = command("scene", "random", "--kind", "list")
    return found


def _numbers(data: Any) -> Any:
    if isinstance(data, dict):
        data = list(data.values())
    if isinstance(data, (list, tuple)):
        for one in data:
            yield from _numbers(one)
    elif isinstance(data, (int, float)) and not isinstance(data, bool):
        yield float(data)


def _types(data: Any) -> set[str]:
    if isinstance(data, dict):
        own = {data["type"]} if isinstance(data.get("type"), str) else set()
        return own.union(*map(_types, data.values()))
    return set().union(*map(_types, data)) if isinstance(data, (list, tuple)) else set()


def edited() -> dict[str, Any]:
    """Scenes changed by a manager and by assignments."""
    made = loads(SCENE, "scene.yaml")
    node = Node(shape=Sphere(radius=2.0), transform=translate(1, 2, 3))
    edits: dict[str, Any] = {
        "add": lambda m: m.add("new", node),
        "add inside": lambda m: m.add("group/new", node),
        "add twice": lambda m: m.add("lamp", node),
        "replace": lambda m: m.replace("lamp", node),
        "replace none": lambda m: m.replace("lmp", node),
        "remove": lambda m: m.remove("group/ball"),
        "remove none": lambda m: m.remove("group/bal"),
        "move": lambda m: m.move("group/ball", "ball"),
        "move inside": lambda m: m.move("lamp", "group/lamp"),
        "move into itself": lambda m: m.move("group", "group/ball/x"),
        "move onto": lambda m: m.move("lamp", "floor"),
        "set value": lambda m: m.set_value("bsdfs.ball.alpha=0.9"),
        "set at": lambda m: m.set_at("film.size", [3, 4]),
        "set none": lambda m: m.set_value("bsdfs.bal.alpha=1"),
        "set": lambda m: m.set(environment=None),
        "bsdf": lambda m: m.add_bsdf("x", made.bsdfs["ball"]),
        "bsdf twice": lambda m: m.add_bsdf("ball", made.bsdfs["ball"]),
        "prototype": lambda m: m.add_prototype("p", node),
        "get": lambda m: m.get("group/ball") and m,
        "get none": lambda m: m.get("x/y"),
    }
    found = {
        name: outcome(lambda e=edit: briefly(dump_scene(e(SceneManager(made)).scene))["nodes"])
        for name, edit in edits.items()
    }
    found["nodes"] = [path for path, _ in SceneManager(made).nodes()]
    sets = (
        "film.size=[3, 4]",
        "nodes.lamp.light.radiance=4",
        "bsdfs.ball=floor",
        "x=1",
        "nodes.floor.transform[1].scale=2",
        "nodes.floor.transform[7].scale=2",
        "film.size",
        "camera.fov=",
        "integrator=direct",
        "integrator.type=direct",
        "sampler={type: sobol}",
        "nodes.group.children.ball.shape=disk",
        "environment=null",
    )
    found["changed"] = rows(lambda s: briefly(dump_scene(alight.changed(made, [s]))), list(sets))
    return found


def transforms() -> dict[str, Any]:
    """Steps and what they multiply out to."""
    steps = {
        "translate": translate(1, -2, 3),
        "rotate": rotate("y", 33),
        "rotate about": rotate((1, 2, 3), -70),
        "scale": scale(2),
        "scale uneven": scale(1, -2, 0.5),
        "look at": look_at((1, 2, 3), (0, 0.5, 0)),
        "look up": look_at((0, 1, 0), (0, 4, 0), (0, 0, 1)),
        "matrix": matrix([[1, 2, 0, 3], [0, 1, 0, 2], [0, 0, 3, 1], [0, 0, 0, 1]]),
    }
    found: dict[str, Any] = {n: [described(s.matrix), repr(s)] for n, s in steps.items()}
    found["product"] = described(
        (steps["translate"] @ steps["rotate about"] @ steps["scale uneven"]).matrix
    )
    found["wrong"] = [
        outcome(lambda f=f: f())
        for f in (
            lambda: look_at((1, 1, 1), (1, 1, 1)),
            lambda: scale(0),
            lambda: rotate("w", 3),
            lambda: matrix([[1, 2], [3, 4]]),
        )
    ]
    texts = (
        "1",
        "1e3",
        "0x10",
        "1_000",
        "true",
        "yes",
        "null",
        "~",
        "[1, 2.5, -3]",
        "{a: 1, b: [x, y]}",
        '"a b"',
        "'it''s'",
        "a: b",
        ".inf",
        ".nan",
        "-.5",
        "2026-11-27",
        "",
        "*x",
        "!x y",
        "[1, 2",
        "1:2",
    )
    found["values"] = rows(parse_value, list(texts))
    found["written"] = [
        write({"a": v})
        for v in (
            1,
            1.0,
            1e-9,
            0.1,
            True,
            None,
            "",
            "yes",
            "1",
            "a: b",
            "x\ny",
            [1, 2],
            [[1, 2], [3]],
            {"b": {}},
            [],
        )
    ]
    return found


def texts() -> dict[str, Any]:
    """Text of scenes with everything, and frames of animations."""
    made = loads(SCENE, "scene.yaml")
    again = loads(dumps(made), "again.yaml")
    names = [
        animation.numbered(animation.Path(p), n).name
        for p in ("a_####.png", "#.exr", "a#b##.png")
        for n in (0, 7, 12345)
    ]
    return {
        "text": dumps(made),
        "same": dumps(again) == dumps(made),
        "names": names,
        "motion": described(flatten(alight.load("motion-blur")).shapes[0].motion),
    }


CASES = {"flat": flat, "random": random, "edited": edited, "transforms": transforms, "texts": texts}
