"""The live view: messages in, answers out, what is shown of layers, where cameras go."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import alight
from alight.options.view import ViewOptions
from alight.outputs.display import Display
from alight.scene import flatten
from alight.view import contrast, editing, protocol
from alight.view.frames import frame
from alight.view.layers import FilmLayers, read_layers, relative_error
from alight.view.opening import session_of
from alight.view.painter import Painter
from alight.view.pose import Pose
from alight.view.shades import shaded
from alight.view.tree import fields_of, items_of
from tests.recorded.cases.films import with_everything
from tests.recorded.cases.renders import FILES
from tests.recorded.making import by_twin, described, film_of, in_folder, outcome

GOOD: tuple[dict[str, Any], ...] = (
    {"do": "orbit", "x": 0.1, "y": -0.05},
    {"do": "pan", "x": 0.1, "y": 0.2},
    {"do": "dolly", "by": 0.2},
    {"do": "fly", "right": 0.1, "up": -0.2, "ahead": 0.3},
    {"do": "roll", "by": 0.3},
    {"do": "widen", "by": -0.1},
    {"do": "orbit", "x": 0, "y": 5},
    {"do": "widen", "by": 9},
    {"do": "dolly", "by": 2},
)

WRONG = (
    "",
    "x",
    "[]",
    "{}",
    '{"do": "orbit"}',
    '{"do": "orbit", "x": 1, "y": "a"}',
    '{"do": "orbit", "x": 1, "y": 2000}',
    '{"do": "orbit", "x": NaN, "y": 0}',
    '{"do": "pixel", "x": -1, "y": 0}',
    '{"do": "pixel", "x": 1.5, "y": 0}',
    '{"do": "denoise", "on": 1}',
    '{"do": "show", "layer": 3}',
    '{"do": "orbitt"}',
    '{"do": "rest", "x": 1}',
    '{"do": 3}',
    "{" + " " * 5000 + "}",
)


def messages() -> dict[str, Any]:
    """What messages become, and which are refused."""
    good = [protocol.parse(json.dumps(one)) for one in GOOD]
    words = {
        word: [event.__name__, sorted(getattr(event, "__dataclass_fields__", {}))]
        for word, event in protocol.EVENTS.items()
    }
    return {
        "good": [repr(one) for one in good],
        "words": words,
        "wrong": {text[:50]: outcome(protocol.parse, text) for text in WRONG},
        "frame": frame(1, 7, np.arange(24, dtype=np.uint8).reshape(2, 3, 4)).hex(),
    }


def poses() -> dict[str, Any]:
    """Where the camera of each scene goes."""
    found: dict[str, Any] = {}
    for name in ("cornell-box", "depth-of-field", "motion-blur"):
        pose = Pose.of(flatten(alight.load(name)).camera)
        told = [described([pose.pivot, pose.up, pose.distance, pose.origin, pose.has_focus])]
        for one in GOOD:
            pose = pose.moved(protocol.parse(json.dumps(one)), (64, 48))
            told.append(described([pose.to_world, pose.pivot, pose.distance, dict(pose.camera)]))
        told.append(
            described(
                [
                    pose.depth_of(np.array([0.1, 0.2, 0.3])),
                    dict(pose.sharp.camera),
                    pose.node.transform.matrix,
                ]
            )
        )
        found[name] = told
    return found


def layers() -> dict[str, Any]:
    """Layers of films and files, and how they are coloured."""
    found: dict[str, Any] = {}
    film = with_everything()
    of_film = FilmLayers(film)
    display = Display(0.5, "aces")
    found["names"] = of_film.names
    for name in of_film.names:
        plane = of_film.plane(name)
        done = shaded(name, plane, display)
        found[name] = [described(plane), described(done.rgba), done.low, done.high]
    found["values"] = [described(of_film.values(*p)) for p in ((0, 0), (21, 12), (3, 2))]
    for name in ("normal", "position", "uv", "albedo", "alpha", "direct", "samples"):
        plane = film_of((7, 5)).image[..., : {"uv": 2, "alpha": 1, "samples": 1}.get(name, 3)] - 0.2
        found[f"shaded {name}"] = described(shaded(name, plane, display))
    found["unknown"] = described(shaded("error", np.full((2, 2, 1), np.nan), display))
    found["even"] = described(shaded("error", np.full((2, 2, 1), 3.0), display))
    one, other = film_of((14, 12), seed=1).image, film_of((14, 12), seed=2).image
    found["contrast"] = {
        way: [
            contrast.label_of_way(way),
            contrast.waits(way),
            outcome(contrast.contrast, way, one, other),
        ]
        for way in contrast.ways()
        if way != contrast.DIVIDER and way != "flip"
    }
    found["error"] = described(relative_error(one, 0.1 * other))
    with in_folder():
        film.save("a.exr")
        film_of((5, 4)).save("b.alight")
        np.save("c.npy", one)
        for path in ("a.exr", "b.alight", "c.npy", "none.exr", "x.txt"):
            made = outcome(lambda p=path: _of_file(p))
            found[path] = made
    return found


def _of_file(path: str) -> Any:
    read = read_layers(Path(path))
    return [
        read.names,
        read.size,
        described(read.values(1, 2)),
        {n: described(read.plane(n), 9) for n in read.names[:4]},
    ]


def edits() -> dict[str, Any]:
    """What can be changed of scenes, and what becomes of changes."""
    found: dict[str, Any] = {}
    with in_folder(FILES):
        scenes = {
            n: alight.load(n)
            for n in ("scene.yaml", "fog", "coated-plastics", "motion-blur", "cornell-box")
        }
        for name, scene in scenes.items():
            items = items_of(scene)
            found[name] = {
                item.path: [
                    item.name,
                    item.group,
                    item.type,
                    [_field(f) for f in fields_of(scene, item.path)][:30],
                ]
                for item in items[:14]
            }
        scene = scenes["scene.yaml"]
        tries = (
            ("bsdfs.ball", "bsdfs.ball.alpha", "0.2"),
            ("bsdfs.ball", "bsdfs.ball.alpha", "7"),
            ("bsdfs.ball", "bsdfs.ball.alpha", '"x"'),
            ("bsdfs.floor", "bsdfs.floor.reflectance", "[0.1, 0.2, 0.3]"),
            ("camera", "camera.fov", "20"),
            ("nodes.lamp.light", "nodes.lamp.light.radiance", "[1, 2, 3]"),
            ("bsdfs.ball", "bsdfs.floor.reflectance", "0.5"),
            ("bsdfs.none", "bsdfs.none.x", "1"),
            ("bsdfs.ball", "bsdfs.ball.alpha", "{"),
            ("nodes.floor", "nodes.floor.transform[1].scale", "4"),
            ("integrator", "integrator.max_depth", "9"),
        )
        found["edited"] = {
            f"{p}={v}": outcome(
                lambda i=i, p=p, v=v: _changes(scene, editing.edited(scene, i, p, v))
            )
            for i, p, v in tries
        }
        found["steps"] = {
            f"{i} {s}": outcome(
                lambda i=i, s=s: editing.transform_of(editing.with_step(scene, i, s), i)
            )
            for i in ("nodes.lamp", "nodes.group.children.ball", "bsdfs.ball", "camera")
            for s in ("translate", "rotate", "scale", "x")
        }
        found["focus"] = outcome(lambda: _changes(scene, editing.focused(scene, 2.5)))
        found["of camera"] = [
            editing.is_of_camera(p) for p in ("camera", "camera.fov", "cameras", "nodes.camera")
        ]
    return found


def _field(field: Any) -> str:
    plain = field.plain()
    return " · ".join(
        f"{described(plain[k])}"
        for k in ("path", "label", "kind", "value", "low", "high", "choices")
    )


def _changes(before: Any, after: Any) -> Any:
    from alight.scene.dump import dump_scene

    a, b = (
        json.dumps(described(dump_scene(s)), sort_keys=True, indent=0).splitlines()
        for s in (before, after)
    )
    return [sorted(set(b) - set(a)), sorted(set(a) - set(b))]


def sessions() -> dict[str, Any]:
    """A session from its first picture to its last answer, by the NumPy reading of kernels."""
    found: dict[str, Any] = {}
    with in_folder(FILES) as folder, by_twin():
        options = ViewOptions(size=(8, 6), spp=4, threads=1, aovs="albedo", replicates=4)
        session = session_of("scene.yaml", options)
        try:
            found["first"] = _settled(session)
            asked = (
                '{"do": "pixel", "x": 3, "y": 2}',
                '{"do": "pixel", "x": 8, "y": 2}',
                '{"do": "trace", "x": 4, "y": 3, "sample": 1}',
                '{"do": "focus", "x": 4, "y": 3}',
                '{"do": "tree"}',
                '{"do": "fields", "item": "bsdfs.ball"}',
                '{"do": "show", "layer": "albedo"}',
                '{"do": "show", "layer": "none"}',
                '{"do": "develop", "exposure": 1, "tone_map": "aces", "white_balance": "none"}',
                '{"do": "develop", "exposure": 1, "tone_map": "x", "white_balance": "none"}',
                '{"do": "contrast", "way": "x"}',
                '{"do": "keep"}',
                '{"do": "contrast", "way": "difference"}',
                '{"do": "orbit", "x": 0.1, "y": 0.05}',
                '{"do": "rest"}',
                '{"do": "edit", "item": "bsdfs.ball", "path": "bsdfs.ball.alpha", "value": "0.1"}',
                '{"do": "edit", "item": "bsdfs.ball", "path": "bsdfs.ball.alpha", "value": "9"}',
                '{"do": "undo"}',
                '{"do": "redo"}',
                '{"do": "add step", "item": "nodes.lamp", "step": "translate"}',
                '{"do": "command"}',
                '{"do": "camera", "name": "none"}',
                '{"do": "region", "x": 1, "y": 1, "width": 4, "height": 3}',
                '{"do": "more"}',
                '{"do": "whole"}',
                '{"do": "drop"}',
            )
            for text in asked:
                event = protocol.parse(text)
                found[text] = outcome(session.apply, event)
                if event.word in (
                    "orbit",
                    "edit",
                    "more",
                    "region",
                    "whole",
                    "undo",
                    "focus",
                    "redo",
                    "add step",
                ):
                    found[f"{text}, then"] = _settled(session)
        finally:
            session.close()
        film_of((9, 7)).save("f.alight")
        still = session_of("f.alight", ViewOptions(against="f.alight"))
        found["film"] = described(still.state(None, (0.0, float("inf"))))
        found["film, refused"] = [
            outcome(still.apply, protocol.parse(t))
            for t in (
                '{"do": "more"}',
                '{"do": "tree"}',
                '{"do": "pixel", "x": 1, "y": 1}',
                '{"do": "keep"}',
            )
        ]
        found["painted"] = _painted(still)
        found["wrong"] = [
            outcome(lambda w=w: session_of(*w))
            for w in (
                ("f.alight", ViewOptions(spp=3)),
                ("none.yaml", ViewOptions()),
                ("f.alight", ViewOptions(against="none.exr")),
            )
        ]
        found["left"] = sorted(p.name for p in folder.iterdir())
    return found


def _settled(session: Any) -> Any:
    """The state once the picture rests, without what depends on the clock."""
    end = time.monotonic() + 120.0
    while True:
        live = session.live
        assert live.phase != "failed", live.problem
        assert time.monotonic() < end, "it does not settle"
        if (
            live.phase == "done"
            and not live.wish.moves
            and live.layers
            and live.layers.number == live.wish.number
            # Just asked for more, it has not begun.
            and session.film.spp >= (live.wish.spp or 0)
        ):
            break
        time.sleep(0.005)
    state = session.state(None, (0.25, 4.0))
    left_out = {"seconds", "rate", "can_denoise", "number"}
    return {
        **{k: described(v) for k, v in state.items() if k not in left_out},
        "picture": described(session.film.image, 9),
    }


def _painted(session: Any) -> Any:
    """What a browser is sent."""
    sent: dict[str, Any] = {}

    class Browser:
        def post(self, kind: str, message: Any) -> None:
            sent[kind] = message

    with mock.patch.object(Painter, "_run", lambda self: None):
        painter = Painter(session)
        painter.join(Browser())
        painter._paint()
        told = [
            {
                k: described(np.frombuffer(m, np.uint8)) if isinstance(m, bytes) else _parsed(m)
                for k, m in sent.items()
            }
        ]
        session.apply(protocol.parse('{"do": "contrast", "way": "difference"}'))
        painter._paint()
        told.append(
            {
                k: described(np.frombuffer(m, np.uint8)) if isinstance(m, bytes) else _parsed(m)
                for k, m in sent.items()
            }
        )
        painter.close()
    return told


def _parsed(message: str) -> Any:
    state = json.loads(message)
    return {
        k: described(v) for k, v in state.items() if k not in ("can_denoise", "seconds", "rate")
    }


CASES = {
    "messages": messages,
    "poses": poses,
    "layers": layers,
    "edits": edits,
    "sessions": sessions,
}
