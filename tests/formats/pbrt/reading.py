"""What the tests of the pbrt reader share: scenes from pieces of files, and rays through pixels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from alight.cameras.basis import perspective_half_extents
from alight.core.errors import Issue, SceneError
from alight.formats import loads
from tests.formats.mitsuba.reading import FILES, native

__all__ = [
    "FILES",
    "HEAD",
    "issues",
    "messages",
    "native",
    "node",
    "ray",
    "read",
    "read_bsdf",
    "world",
]

HEAD = 'Camera "perspective"\nFilm "rgb" "integer xresolution" 8 "integer yresolution" 4\n'


def read(body: str, head: str = HEAD, folder: Path | None = FILES, **options: Any) -> Any:
    """Load the world of a scene of pbrt 4; with `head` that of another."""
    return loads(f"{head}WorldBegin\n{body}\n", "scene.pbrt", folder, **options)


def read_old(body: str, **options: Any) -> Any:
    """Load the world of a scene of pbrt 3."""
    head = 'Camera "perspective"\nFilm "image" "integer xresolution" 8 "integer yresolution" 4\n'
    return read(body + "\nWorldEnd", head, **options)


def read_bsdf(material: str, old: bool = False, **options: Any) -> Any:
    """The only material of a scene, without the two sides of most."""
    body = f'Material {material}\nShape "sphere"'
    scene = read_old(body, **options) if old else read(body, **options)
    [found] = scene.bsdfs.values()
    return found


def two_sided(text: str, **tables: str) -> Any:
    """Build a material of the native format that has two sides: what was meant."""
    return native("bsdfs", f"{{type: two_sided, bsdf: {text}}}", **tables)


def node(scene: Any) -> Any:
    """The only node of a scene."""
    [found] = scene.nodes.values()
    return found


def world(scene: Any, point: tuple[float, float, float]) -> list[float]:
    """A point of the only node in the world, rounded."""
    return np.round(node(scene).transform.apply_point(point), 6).tolist()


def ray(scene: Any, x: float, y: float) -> np.ndarray:
    """Direction of the camera's ray through a place of the film, in pixels."""
    camera = scene.camera.camera
    width, height = scene.film.size
    wide, high = perspective_half_extents(camera.fov, camera.fov_axis, width, height)
    local = [(2 * x / width - 1) * wide, (1 - 2 * y / height) * high, -1.0]
    direction = scene.camera.transform.apply_vector(local)
    return direction / np.linalg.norm(direction)


def issues(body: str, head: str = HEAD, **options: Any) -> list[Issue]:
    """Load what must be refused; the problems, each with its place."""
    with pytest.raises(SceneError) as caught:
        read(body, head, **options)
    assert all(issue.message and issue.place for issue in caught.value.issues)
    return list(caught.value.issues)


def messages(body: str, head: str = HEAD, **options: Any) -> list[str]:
    """Load what must be refused; the messages."""
    return [issue.message for issue in issues(body, head, **options)]
