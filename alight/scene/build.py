"""Plain data (dictionaries, lists, numbers, texts) -> `Scene`, collecting every problem.

A part that cannot be built is reported and replaced by a stand-in, so that the checks of the rest
(unknown names, for instance) still run and a user sees all problems of a file at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, get_args

from pydantic import ValidationError

from alight.core.errors import Issue, join_path, show_value, unknown_name
from alight.core.field_errors import translate
from alight.core.fields import Model, Models, NumberOrTexture, Numbers
from alight.core.registry import default_of, specs, specs_of
from alight.core.spec import Camera, Light, Spec, Texture
from alight.scene.description import (
    CameraField,
    FilmSettings,
    Named,
    Node,
    Scene,
    TransformField,
    name_problem,
)
from alight.scene.steps import parse_transform

FORMAT_VERSION = 1
Marker = Model | Numbers | NumberOrTexture | Named | TransformField | CameraField


@dataclass
class Builder:
    """Builds descriptions and keeps a list of what went wrong.

    Attributes
    ----------
    issues : list of Issue
        Problems found so far.
    """

    issues: list[Issue] = field(default_factory=list)

    def report(self, path: str, message: str, about_key: bool = False) -> None:
        """Note a problem."""
        self.issues.append(Issue(path, message, about_key=about_key))

    def scene(self, data: object) -> Scene:
        """Build a scene from the top level of a file."""
        if not isinstance(data, Mapping):
            self.report("", f"a scene must be a mapping of keys, got {show_value(data)}")
            return Scene()
        data = dict(data)
        version = data.pop("alight", None)
        if version != FORMAT_VERSION or isinstance(version, bool):
            text = (
                f"must be {FORMAT_VERSION} (the version of the format), got {show_value(version)}"
            )
            self.report("alight", text)
        try:
            scene = self.fields(Scene, data, "")
        except RecursionError:
            self.report("", "is nested too deeply, or holds itself")
            return Scene()
        return scene if isinstance(scene, Scene) else Scene()

    def fields(self, spec: type[Spec], data: Mapping[str, Any], path: str) -> Spec | None:
        """Build one description from its keys; None where not even the defaults help."""
        values = {}
        for name, value in data.items():
            try:
                marker = _marker(spec, name)
                values[name] = self.value(marker, value, join_path(path, name))
            except _Failed:
                continue
        try:
            return spec.__pydantic_validator__.validate_python(values)
        except ValidationError as error:
            self.issues.extend(issue.under(path) for issue in translate(spec, error))
            wrong = {detail["loc"][0] for detail in error.errors() if detail["loc"]}
        try:
            kept = {name: value for name, value in values.items() if name not in wrong}
            return spec.__pydantic_validator__.validate_python(kept)
        except ValidationError:
            return None

    def value(self, marker: Marker | None, value: object, path: str) -> object:
        """Build what a field holds; anything that is no description is passed on as it is."""
        if isinstance(marker, TransformField):
            return parse_transform(value, lambda issue: self.issues.append(issue.under(path)))
        if isinstance(marker, Named):
            return self.named(marker, value, path)
        if isinstance(marker, CameraField) and isinstance(value, Mapping):
            return self.placed_camera(value, path)
        if isinstance(marker, Models):
            return self.models(marker, value, path)
        if isinstance(marker, Model) and not (marker.named and isinstance(value, str)):
            return self.model(marker, value, path)
        if Texture in getattr(marker, "other", ()) and isinstance(value, Mapping):
            return self.model(Model("texture", "textures"), value, path)
        return value

    def model(self, marker: Model, value: object, path: str) -> Spec:
        """Build a model of a family from a mapping with its type, or from the type alone."""
        if isinstance(value, str):
            value = {"type": value}
        if value is None:
            raise _Failed
        if isinstance(value, Spec) and value.family == marker.family:
            return value
        if not isinstance(value, Mapping):
            self.report(path, f"must be a {marker.kind}, got {show_value(value)}")
            raise _Failed
        if marker.family == "film":
            return self.fields(FilmSettings, value, path) or FilmSettings()
        known = specs(marker.family)
        name = value.get("type")
        if not isinstance(name, str) or name not in known:
            if "type" in value and name is None and "null" in known:
                self.report(join_path(path, "type"), _NULL.format(kind=marker.kind))
            else:
                self.report(*_type_problem(marker, name, path))
            return _stand_in(marker.family, path)
        return self.fields(known[name], value, path) or _stand_in(marker.family, path)

    def models(self, marker: Models, value: object, path: str) -> tuple[object, ...]:
        """Build a list of models or of names of them."""
        if not isinstance(value, list | tuple) or len(value) != marker.count:
            self.report(path, marker.problem(value))
            raise _Failed
        built = []
        for i, item in enumerate(value):
            if isinstance(item, str) or getattr(item, "family", None) == marker.family:
                built.append(item)
            else:
                built.append(self._named_model(marker, item, f"{path}[{i}]"))
        return tuple(built)

    def named(self, marker: Named, value: object, path: str) -> dict[str, Spec]:
        """Build a mapping of names to descriptions."""
        if value is None:
            return {}
        if not isinstance(value, Mapping):
            self.report(path, f"must map names to {marker.kind}s, got {show_value(value)}")
            return {}
        result: dict[str, Spec] = {}
        for name, item in value.items():
            here = join_path(path, name)
            problem = name_problem(name)
            if problem:
                self.report(path, problem)
            elif marker.family:
                model = Model(marker.kind, marker.family)
                # A name must not become a type here, or a misspelt reference would look right.
                if isinstance(item, str):
                    self.report(here, f"must be a {marker.kind}, got {show_value(item)}")
                    result[name] = _stand_in(marker.family, here)
                else:
                    result[name] = self._named_model(model, item, here)
            else:
                result[name] = self.node(item, here)
        return result

    def _named_model(self, marker: Model, item: object, path: str) -> Spec:
        try:
            return self.model(marker, {} if item is None else item, path)
        except _Failed:
            return _stand_in(marker.family, path)

    def node(self, value: object, path: str) -> Node:
        """Build a node with all of its children."""
        if value is None:
            return Node()
        if isinstance(value, Node):
            return value
        if not isinstance(value, Mapping):
            self.report(path, f"must be a node, got {show_value(value)}")
            return Node()
        node = self.fields(Node, value, path)
        return node if isinstance(node, Node) else Node()

    def placed_camera(self, value: Mapping[str, Any], path: str) -> Node:
        """Build the scene's own camera: a camera's keys and `transform` side by side."""
        keys = dict(value)
        steps = keys.pop("transform", [])
        moved = parse_transform(
            steps, lambda issue: self.issues.append(issue.under(join_path(path, "transform")))
        )
        keys.setdefault("type", default_of(Camera).type_name())
        return Node(transform=moved, camera=self.model(Model("camera", "cameras"), keys, path))


class _Failed(Exception):
    """A value was reported and has no stand-in: leave its field at the default."""


#: A word of YAML's own is the name of a model.
_NULL = 'a bare null means nothing in YAML; write "null", quoted, for the {kind} of that name'


def _type_problem(marker: Model, name: object, path: str) -> tuple[str, str]:
    known = sorted(specs(marker.family))
    if name is None:
        return path, f"needs a type  (types: {', '.join(known)})"
    if not isinstance(name, str):
        return join_path(path, "type"), f"must be a text, got {show_value(name)}"
    text = unknown_name(marker.kind, name, known, listed_as="types")
    # What is like no name may be a model of somebody's own.
    hint = (
        "" if "did you mean" in text else "; a script of yours that registers it: --plugin FILE.py"
    )
    return join_path(path, "type"), text + hint


def _stand_in(family: str, path: str) -> Spec:
    if family == Light.family:
        place = "environment" if path == "environment" else "shape"
        return next(light for light in specs_of(Light).values() if light.placement == place)()
    return next(iter(specs(family).values()))()


@cache
def _marker(spec: type[Spec], name: str) -> Marker | None:
    """Find what kind of description a field holds, also inside ``... | None``."""
    info = spec.model_fields.get(name)
    if info is None:
        return None
    found = [*info.metadata]
    for part in get_args(info.annotation):
        found.extend(getattr(part, "__metadata__", ()))
    return next((item for item in found if isinstance(item, Marker)), None)
