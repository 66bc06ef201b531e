"""The content of a scene, key by key, to report what changed since a render began."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.errors import join_path
from alight.core.registry import versions
from alight.core.spec import Spec
from alight.scene.description import Scene
from alight.scene.dump import dump_scene

#: Longer values are kept as digests.
_MOST_CHARACTERS = 120

#: Prefix of the names of files and of registered models, which no key begins with.
_FILE, _MODEL = "file ", "registered "


def describe_content(scene: Scene) -> dict[str, str]:
    """Key path -> value as text, of everything in a scene; files by digest.

    Names of nodes and materials are part of the keys, so scenes with the same
    `alight.scene.content_hash` may differ here; those with the same content are the same picture.
    """
    data = dump_scene(scene, full=True)
    content = dict(_leaves(data, ""))
    folder = scene.source.folder or Path()
    for name in sorted(_files(data)):
        path = folder / name
        if path.is_file():
            content[_FILE + name] = _file_digest(path)
    for family, name, version in versions(_specs(scene)):
        content[f"{_MODEL}{family} {name}"] = version
    return content


def differences(before: Mapping[str, str], after: Mapping[str, str]) -> list[str]:
    """Say in words what differs between two contents, one line each.

    Examples
    --------
    >>> differences({"film.size": "[8, 8]"}, {"film.size": "[9, 8]"})
    ['film.size: was [8, 8], is [9, 8]']
    """
    return [
        _difference(key, before.get(key), after.get(key))
        for key in dict.fromkeys((*before, *after))
        if before.get(key) != after.get(key)
    ]


def _difference(key: str, before: str | None, after: str | None) -> str:
    if key.startswith((_FILE, _MODEL)) and before and after:
        return f"{key}: its content has changed"
    if before is None:
        return f"{key}: is new" + ("" if key.startswith((_FILE, _MODEL)) else f" ({after})")
    if after is None:
        return f"{key}: is gone" + ("" if key.startswith((_FILE, _MODEL)) else f" (was {before})")
    return f"{key}: was {before}, is {after}"


def _leaves(value: Any, path: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict) and value:
        for name, item in value.items():
            yield from _leaves(item, join_path(path, str(name)))
    elif isinstance(value, list | tuple) and any(isinstance(i, dict | list) for i in value):
        for index, item in enumerate(value):
            yield from _leaves(item, join_path(path, index))
    else:
        yield path, _text(value)


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{value.shape} {_digest(np.ascontiguousarray(value).tobytes())}"
    try:
        text = json.dumps(value)
    except TypeError:
        text = repr(value)
    return text if len(text) <= _MOST_CHARACTERS else f"{text[:40]}... {_digest(text.encode())}"


def _files(value: Any) -> Iterator[str]:
    """Names under a key ``file``, anywhere."""
    if isinstance(value, dict):
        for name, item in value.items():
            if name == "file" and isinstance(item, str):
                yield item
            else:
                yield from _files(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _files(item)


def _specs(value: Any) -> Iterator[Spec]:
    """Every description in a scene, nested ones too."""
    if isinstance(value, Spec):
        yield value
        for _, item in value:
            yield from _specs(item)
    elif isinstance(value, dict):
        for item in value.values():
            yield from _specs(item)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def _file_digest(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()[:16]
    except OSError:
        # Loading has reported it already, or will when it gets there.
        return "unreadable"
