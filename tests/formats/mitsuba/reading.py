"""What the tests of the Mitsuba reader share: scenes from pieces of XML."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from alight.core.errors import Issue, SceneError
from alight.formats import loads
from alight.scene import Scene

PICTURE = Path(__file__).parent / "picture"
FILES = PICTURE / "files"


def read(body: str, version: str = "3.0.0", folder: Path | None = FILES, **options: Any) -> Scene:
    """Load the content of a ``<scene>``, with a camera if it has none."""
    if "<sensor" not in body:
        body += '<sensor type="perspective"/>'
    text = f'<scene version="{version}">\n{body}\n</scene>\n'
    return loads(text, "scene.xml", folder, **options)


def read_bsdf(body: str, attributes: str, version: str = "3.0.0", **options: Any) -> Any:
    """Load one material."""
    scene = read(f'<bsdf id="it" {attributes}>{body}</bsdf>', version, **options)
    return scene.bsdfs["it"]


def native(key: str, text: str, **tables: str) -> Any:
    """Build one entry of a table from the native format: what was meant."""
    parts = [f"{table}: {content}" for table, content in tables.items()]
    lines = ["alight: 1", "camera: {type: pinhole}", f"{key}: {{it: {text}}}", *parts]
    scene = loads("\n".join(lines), "meant.yaml", FILES)
    return getattr(scene, key)["it"]


def issues(body: str, version: str = "3.0.0", **options: Any) -> list[Issue]:
    """Load what must be refused; the problems."""
    with pytest.raises(SceneError) as caught:
        read(body, version, **options)
    assert all(issue.message and issue.place for issue in caught.value.issues)
    return list(caught.value.issues)


def messages(body: str, version: str = "3.0.0", **options: Any) -> list[str]:
    """Load what must be refused; the messages."""
    return [issue.message for issue in issues(body, version, **options)]


def node(scene: Scene) -> Any:
    """The only node of a scene."""
    [found] = scene.nodes.values()
    return found
