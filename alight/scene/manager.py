"""The scene manager: named nodes and materials that can be added, found, moved and changed.

Scenes are immutable; the manager holds the newest one and makes the next from it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Self

from alight.core.arguments import expect
from alight.core.errors import Issue, SceneError, join_path, quote, show_value, unknown_name
from alight.core.registry import FAMILIES_OF_SCENES, specs
from alight.core.spec import Bsdf, Texture
from alight.scene import plain_yaml
from alight.scene.build import Builder
from alight.scene.description import Node, Scene
from alight.scene.dump import dump_scene

_PATH = 'the path of a node, as "table/leg"'
_KEY = re.compile(r"([^.\[\]]+)|\[(\d{1,9})\]")


class SceneManager:
    """Edits a scene.

    Parameters
    ----------
    scene : Scene, optional
        Where to start; an empty scene by default.

    Examples
    --------
    >>> from alight.shapes.sphere import Sphere
    >>> manager = SceneManager()
    >>> manager.add("balls", Node()).add("balls/red", Node(shape=Sphere()))
    SceneManager(2 nodes)
    >>> manager.get("balls/red").shape.radius
    1.0
    """

    def __init__(self, scene: Scene | None = None) -> None:
        expect(scene, (Scene, type(None)), "scene", "a scene; alight.load(path) reads one")
        self.scene = scene if scene is not None else Scene()

    def __repr__(self) -> str:
        """Say how many nodes there are."""
        return f"SceneManager({sum(1 for _ in self.nodes())} nodes)"

    def nodes(self) -> Iterator[tuple[str, Node]]:
        """Visit all nodes, parents first: path and node."""
        for path, _, node in self.scene.walk():
            yield path, node

    def get(self, path: str) -> Node:
        """Find a node.

        Parameters
        ----------
        path : str
            Names from the root down, joined with ``/``.

        Raises
        ------
        SceneError
            If there is no such node; names the nearest one.
        """
        expect(path, str, "path", _PATH)
        children, node = self.scene.nodes, None
        for name in path.split("/"):
            if name not in children:
                raise _error(path, unknown_name("node", path, (p for p, _ in self.nodes())))
            node = children[name]
            children = node.children
        assert node is not None
        return node

    def add(self, path: str, node: Node) -> Self:
        """Add a node below an existing one, or at the top.

        Raises
        ------
        SceneError
            If the parent does not exist or the name is taken.
        """
        parent, _, name = expect(path, str, "path", _PATH).rpartition("/")
        siblings = self.get(parent).children if parent else self.scene.nodes
        if name in siblings:
            raise _error(path, f"a node named {quote(name)} exists already")
        return self._put(parent, {**siblings, name: node})

    def replace(self, path: str, node: Node) -> Self:
        """Replace an existing node."""
        self.get(path)
        parent, _, name = path.rpartition("/")
        siblings = self.get(parent).children if parent else self.scene.nodes
        return self._put(parent, {**siblings, name: node})

    def remove(self, path: str) -> Self:
        """Remove a node with everything below it."""
        self.get(path)
        parent, _, name = path.rpartition("/")
        siblings = dict(self.get(parent).children if parent else self.scene.nodes)
        del siblings[name]
        return self._put(parent, siblings)

    def move(self, path: str, to: str) -> Self:
        """Hang a node, with everything below it, under another path; its transform stays.

        Raises
        ------
        SceneError
            If it does not exist, or would become its own descendant.
        """
        node = self.get(path)
        expect(path, str, "path", _PATH)
        if expect(to, str, "to", _PATH) == path or to.startswith(path + "/"):
            raise _error(path, f"cannot move below itself, to {quote(to)}")
        before = self.scene
        try:
            return self.remove(path).add(to, node)
        except SceneError:
            self.scene = before
            raise

    def add_bsdf(self, name: str, bsdf: Bsdf) -> Self:
        """Add or replace a named material."""
        expect(name, str, "name", "a name")
        return self._change(bsdfs={**self.scene.bsdfs, name: bsdf})

    def add_texture(self, name: str, texture: Texture) -> Self:
        """Add or replace a named texture."""
        expect(name, str, "name", "a name")
        return self._change(textures={**self.scene.textures, name: texture})

    def add_prototype(self, name: str, node: Node) -> Self:
        """Add or replace a node tree for instances."""
        expect(name, str, "name", "a name")
        return self._change(prototypes={**self.scene.prototypes, name: node})

    def set(self, **settings: Any) -> Self:
        """Change fields of the scene: camera, film, sampler, integrator, environment."""
        return self._change(**settings)

    def set_value(self, assignment: str) -> Self:
        """Change one value as ``--set`` of the command line does.

        Parameters
        ----------
        assignment : str
            ``path.to.key=value`` with the key path of the scene file and a YAML value, for
            instance ``bsdfs.white.reflectance[0]=0.5`` or ``integrator.max_depth=3``.

        Raises
        ------
        SceneError
            If there is no such key, or the value does not fit.
        """
        if not isinstance(assignment, str):
            raise _error("--set", f"must be path.to.key=value, got {show_value(assignment)}")
        path, equals, text = assignment.partition("=")
        if not equals or not path.strip():
            raise _error("--set", f"must be path.to.key=value, got {quote(assignment)}")
        try:
            value = plain_yaml.parse_value(text)
        except SceneError as error:
            raise _error(path, error.issues[0].message) from None
        return self._edit(path.strip(), value)

    def set_at(self, path: str, value: Any) -> Self:
        """Change one value by its key path.

        Parameters
        ----------
        path : str
            As of the scene file, for instance ``bsdfs.ball.roughness``.
        value : object
            What the file would hold there, as Python data, or a description.

        Raises
        ------
        SceneError
            If there is no such key, with the nearest one, or the value does not fit.
        """
        if not isinstance(path, str):
            raise _error("scene", f"key paths are texts, got {show_value(path)}")
        return self._edit(path.strip(), value)

    def _edit(self, path: str, value: Any) -> Self:
        keys = [int(index) if index else name for name, index in _KEY.findall(path)]
        data = dump_scene(self.scene, full=True, edited=join_path(*keys))
        _assign(data, keys, value)
        builder = Builder()
        scene = builder.scene(data)
        if builder.issues:
            raise SceneError(builder.issues)
        self.scene = scene.made_from(self.scene)
        return self

    def _put(self, parent: str, children: dict[str, Node]) -> Self:
        """Replace the children of a node, and with it all of its ancestors."""
        while parent:
            node = self.get(parent).replaced(children=children)
            parent, _, name = parent.rpartition("/")
            siblings = self.get(parent).children if parent else self.scene.nodes
            children = {**siblings, name: node}
        return self._change(nodes=children)

    def _change(self, **changes: Any) -> Self:
        self.scene = self.scene.replaced(**changes).from_source(self.scene.source)
        return self


def _assign(data: Any, keys: list[str | int], value: Any) -> None:
    """Set one value in plain data; numbers are indices of lists."""
    done = ""
    for key in keys[:-1]:
        data = _step(data, key, done)
        done = join_path(done, key)
    last = keys[-1] if keys else ""
    if isinstance(data, dict) and isinstance(last, str):
        if last == "type" and isinstance(value, str):
            _drop_other_keys(data, value)
        data[last] = value
    else:
        _step(data, last, done)
        data[last] = value


def _step(data: Any, key: str | int, path: str) -> Any:
    if isinstance(data, dict) and isinstance(key, str):
        if key in data and data[key] is None:
            data[key] = {}
        if key not in data:
            text = unknown_name("key", key, data, listed_as="keys")
            raise _error(join_path(path, key), text)
        return data[key]
    if isinstance(data, list) and isinstance(key, int):
        if key >= len(data):
            text = f"index must be in [0, {len(data) - 1}], got {key}"
            raise _error(join_path(path, key), text)
        return data[key]
    found = {dict: "named keys", list: "an index"}.get(type(data), "no keys below it")
    raise _error(join_path(path, key), f"{path} has {found}")


def _drop_other_keys(data: dict[str, Any], type_name: str) -> None:
    """Forget the settings of the type before, which the new one need not know."""
    for family in FAMILIES_OF_SCENES:
        known = specs(family)
        if data.get("type") in known and type_name in known:
            for key in set(data) - set(known[type_name].model_fields):
                del data[key]


def _error(path: str, message: str) -> SceneError:
    return SceneError([Issue(path, message)])
