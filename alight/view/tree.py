"""The scene as a page shows it: its parts in groups, and of each part the values that can change.

What a field takes is read off the description's own field types, so that models of every family,
users' models too, are shown without a word about them here. What a file holds, and the arrays of
meshes, are not offered.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, get_args, get_origin

from alight.core.errors import join_path
from alight.core.fields import Interval, Model, Models, NumberOrTexture, Numbers
from alight.core.registry import specs
from alight.core.spec import Light, Spec, Texture
from alight.scene.description import Node, Scene
from alight.scene.keyframes import Keyframes
from alight.scene.nodes import all_nodes
from alight.scene.steps import dump_transform
from alight.shapes.arrays import TriangleShape

#: Parts that are listed at most; a scene of more is edited as a file.
MOST_ITEMS = 4000

#: Fields of nodes that are shown, in this order; the children are parts of their own.
_OF_NODES = ("bsdf", "light", "shape", "interior", "exterior", "camera")

#: What a step of a transform is before it is changed.
NEUTRAL: dict[str, Any] = {
    "translate": [0.0, 0.0, 0.0],
    "rotate": {"axis": [0.0, 1.0, 0.0], "angle": 0.0},
    "scale": [1.0, 1.0, 1.0],
}


@dataclass(frozen=True)
class Item:
    """A part of a scene: key path, what it is called, its group and the type of its model."""

    path: str
    name: str
    group: str
    type: str


@dataclass(frozen=True)
class Field:
    """A value that can be changed.

    Attributes
    ----------
    path : str
        Key path, as for ``--set``.
    label : str
        Names from the item down.
    kind : {"number", "whole", "color", "vector", "choice", "truth", "told"}
        "told" is shown only.
    value : number, list of number, text or bool
    low, high : float or None
        Bounds of numbers.
    choices : list of str
    """

    path: str
    label: str
    kind: str
    value: Any
    low: float | None = None
    high: float | None = None
    choices: list[str] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """As plain JSON."""
        return asdict(self)


def items_of(scene: Scene) -> list[Item]:
    """List the parts of a scene, at most `MOST_ITEMS`."""
    found = [_item("camera", "camera", "Camera", _camera_of(scene))]
    for group, known in (("Materials", "bsdfs"), ("Textures", "textures"), ("Media", "media")):
        found += [
            _item(join_path(known, name), name, group, spec)
            for name, spec in getattr(scene, known).items()
        ]
    if scene.environment is not None:
        found.append(_item("environment", "environment", "Lights", scene.environment))
    nodes = list(all_nodes(scene))
    for path, node in nodes:
        if node.light is not None:
            found.append(_item(f"{path}.light", _name(path), "Lights", node.light))
    found += [_item(path, _name(path), "Objects", node.shape) for path, node in nodes]
    render = [
        _item(name, name, "Render", getattr(scene, name)) for name in ("integrator", "sampler")
    ]
    return [*found[: MOST_ITEMS - len(render)], *render]


def _item(path: str, name: str, group: str, spec: Spec | None) -> Item:
    return Item(path, name, group, "" if spec is None else spec.type_name())


def _name(path: str) -> str:
    """A key path of a node as people call it: ``nodes.a.children.b`` is a/b."""
    return path.partition(".")[2].replace(".children.", "/")


def _camera_of(scene: Scene) -> Spec | None:
    return scene.camera.camera if isinstance(scene.camera, Node) else None


def fields_of(scene: Scene, path: str) -> list[Field]:
    """List what can be changed of a part.

    Parameters
    ----------
    scene : Scene
    path : str
        Of an `Item`; of any other there are no fields.
    """
    found = _part(scene, path)
    if isinstance(found, Node):
        return list(_of_node(scene, found, path))
    return list(_of_spec(scene, found, path, "")) if isinstance(found, Spec) else []


def _part(scene: Scene, path: str) -> Any:
    """The description at a key path; None if there is none."""
    found: Any = scene
    for key in path.split("."):
        if isinstance(found, Spec):
            found = getattr(found, key, None) if key in type(found).model_fields else None
        else:
            found = found.get(key) if isinstance(found, dict) else None
    return found


def _of_node(scene: Scene, node: Node, path: str) -> Iterator[Field]:
    yield from _of_transform(node, f"{path}.transform")
    for name in _OF_NODES:
        value = getattr(node, name)
        if isinstance(value, str):
            yield _named(scene, Model(name, _family(name)), f"{path}.{name}", name, value)
        elif isinstance(value, Spec):
            # The camera of a scene is a node with its keys side by side.
            here = path if path == "camera" else f"{path}.{name}"
            yield from _of_spec(scene, value, here, "" if path == "camera" else name)


def _family(name: str) -> str:
    return "bsdfs" if name == "bsdf" else "media"


def _of_spec(scene: Scene, spec: Spec, path: str, label: str) -> Iterator[Field]:
    """The type of a model and its values, those of what it is made of too."""
    kinds = _types_like(spec)
    if len(kinds) > 1:
        yield Field(f"{path}.type", label or "type", "choice", spec.type_name(), choices=kinds)
    for name, value in spec:
        if name != "type":
            inside = f"{label} · {name}" if label else name
            yield from _of_value(scene, spec, name, value, f"{path}.{name}", inside)


def _types_like(spec: Spec) -> list[str]:
    """The types that may take its place."""
    if isinstance(spec, TriangleShape) or not spec.family or "type" not in type(spec).model_fields:
        return []
    known = specs(spec.family)
    if isinstance(spec, Light):
        known = {n: s for n, s in known.items() if _placement(s) == spec.placement}
    return sorted(known)


def _placement(light: type[Spec]) -> str:
    return light.placement if issubclass(light, Light) else ""


def _of_value(
    scene: Scene, spec: Spec, name: str, value: Any, path: str, label: str
) -> Iterator[Field]:
    marks = _metadata(type(spec), name)
    if isinstance(value, bool):
        yield Field(path, label, "truth", value)
    elif isinstance(value, Spec):
        yield from _of_spec(scene, value, path, label)
    elif isinstance(value, str):
        model = next((mark for mark in marks if isinstance(mark, Model)), None)
        takes_texture = any(Texture in getattr(mark, "other", ()) for mark in marks)
        if takes_texture or model is not None:
            yield _named(scene, model or Model("texture", "textures"), path, label, value)
        elif choices := _choices(type(spec), name):
            yield Field(path, label, "choice", value, choices=choices)
        else:
            yield Field(path, label, "told", value)
    elif any(isinstance(mark, Models) for mark in marks):
        for i, one in enumerate(value):
            if isinstance(one, Spec):
                yield from _of_spec(scene, one, f"{path}[{i}]", f"{label} {i + 1}")
            else:
                yield _named(scene, Model("bsdf", "bsdfs"), f"{path}[{i}]", f"{label} {i + 1}", one)
    elif isinstance(value, int | float | tuple):
        yield from _of_numbers(marks, value, path, label)


def _of_numbers(marks: list[Any], value: Any, path: str, label: str) -> Iterator[Field]:
    """A number or a list of them, by the metadata of their field."""
    for mark in marks:
        if isinstance(mark, Interval | NumberOrTexture) and not isinstance(value, tuple):
            interval = mark if isinstance(mark, Interval) else mark.interval
            kind = "whole" if interval.integer else "number"
            yield Field(path, label, kind, value, *_ends(interval))
            return
        if isinstance(mark, Numbers) and isinstance(value, tuple):
            is_color = mark.count == 3 and mark.interval.low == 0.0
            kind = "color" if is_color else "vector"
            yield Field(path, label, kind, list(value), *_ends(mark.interval))
            return


def _ends(interval: Interval) -> tuple[float | None, float | None]:
    low, high = (None if math.isinf(end) else end for end in (interval.low, interval.high))
    return low, high


def _named(scene: Scene, model: Model, path: str, label: str, value: str) -> Field:
    known = sorted({value, *getattr(scene, model.family, {})})
    return Field(path, label, "choice", value, choices=known)


def _metadata(spec: type[Spec], name: str) -> list[Any]:
    """What the annotation of a field says, also inside ``... | None``."""
    info = spec.model_fields[name]
    parts = get_args(info.annotation)
    return [*info.metadata, *(m for part in parts for m in getattr(part, "__metadata__", ()))]


def _choices(spec: type[Spec], name: str) -> list[str]:
    """The texts that a field may have."""
    kind = spec.model_fields[name].annotation
    kinds = [kind, *get_args(kind)]
    found = next((one for one in kinds if get_origin(one) is Literal), None)
    return [str(choice) for choice in get_args(found)]


def _of_transform(node: Node, path: str) -> Iterator[Field]:
    if isinstance(node.transform, Keyframes):
        count = len(node.transform.frames)
        yield Field(path, "transform", "told", f"{count} keyframes")
        return
    data = dump_transform(node.transform)
    steps = data if isinstance(data, list) else [data]
    for i, step in enumerate(steps):
        here = f"{path}[{i}]" if isinstance(data, list) else path
        ((name, value),) = step.items()
        if name == "matrix":
            for row in range(3):
                yield Field(f"{here}.matrix[{row}]", f"matrix row {row + 1}", "vector", value[row])
        elif isinstance(value, dict):
            for key, part in value.items():
                kind = "vector" if isinstance(part, list) else "number"
                yield Field(f"{here}.{name}.{key}", f"{name} {key}", kind, part)
        else:
            value = value if isinstance(value, list) else [value] * 3
            yield Field(f"{here}.{name}", name, "vector", value)
