"""A glTF file -> a description in the native format."""

from __future__ import annotations

from typing import Any

from alight.core.errors import SceneError
from alight.formats.gltf.accessors import COMPRESSED
from alight.formats.gltf.container import Document, open_document
from alight.formats.gltf.keys import left_out, say_what_is_unknown
from alight.formats.gltf.materials import COVERED as MATERIALS
from alight.formats.gltf.materials import Materials
from alight.formats.gltf.nodes import Graph
from alight.formats.parsed import Parsed
from alight.formats.reach import Reach
from alight.formats.report import Report, did_you_mean
from alight.formats.surroundings import SIZE, add_camera, add_light, say_if_empty, use_first_camera
from alight.scene.build import FORMAT_VERSION

#: Extensions that are read.
COVERED = (
    *MATERIALS, "KHR_lights_punctual", "KHR_mesh_quantization", "KHR_texture_transform",
)  # fmt: skip
_HEIGHT = 600


def parse(data: bytes, name: str, reach: Reach | None = None) -> Parsed:
    """Read a scene file.

    Parameters
    ----------
    data, name : bytes and str
        Content of the file (.gltf or .glb), and its name for messages.
    reach : Reach, optional
        Where the files that it names may lie; the current folder by default.

    Raises
    ------
    SceneError
        If the file is no scene at all.
    """
    report = Report()
    document = open_document(data, name, reach or Reach(), report)
    _check_extensions(document)
    say_what_is_unknown(document.root.value, report)
    graph = Graph(document, Materials(document))
    graph.build()
    _say_what_is_dropped(document)
    scene: dict[str, Any] = {
        "alight": FORMAT_VERSION,
        "bsdfs": graph.bsdfs,
        "prototypes": graph.prototypes,
        "nodes": graph.nodes,
    }
    say_if_empty(report, graph.bounds)
    if not graph.is_lit and not graph.glow.suffices(graph.bounds):
        add_light(scene, report, shines=graph.glow.total > 0.0, view=graph.view)
    if graph.cameras:
        _use_camera(document, graph, scene)
    else:
        add_camera(scene, report, graph.bounds)
    report.count("nodes", len(document.list("nodes")))
    framed = None if graph.cameras else graph.bounds
    return Parsed.of(scene, graph.places | {"": name}, report, framed=framed)


def _use_camera(document: Document, graph: Graph, scene: dict[str, Any]) -> None:
    """Show what the first camera sees."""
    use_first_camera(scene, document.report, [path for path, _ in graph.cameras])
    item = document.list("cameras")[graph.cameras[0][1]]
    perspective = item.object("perspective")
    orthographic = item.object("orthographic")
    aspect = SIZE[0] / SIZE[1]
    if perspective is not None and perspective.has("aspectRatio"):
        aspect = perspective.number("aspectRatio", aspect, 1e-3, 1e3)
    elif orthographic is not None:
        height = orthographic.number("ymag", 1.0, 1e-9)
        aspect = orthographic.number("xmag", height, 1e-9) / height
    scene["film"] = {"size": [max(1, min(round(_HEIGHT * aspect), 2**14)), _HEIGHT]}


def _check_extensions(document: Document) -> None:
    """Refuse what must be understood and is not; list the rest."""
    root = document.root
    required = root.value.get("extensionsRequired", [])
    used = root.value.get("extensionsUsed", [])
    for key, names in (("extensionsRequired", required), ("extensionsUsed", used)):
        if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
            raise root.fatal(key, "must be a list of names")
    for name in required:
        if name in COMPRESSED:
            root.wrong("extensionsRequired", COMPRESSED[name])
        elif name not in COVERED:
            text = f'requires "{name}", which is not covered{did_you_mean(name, COVERED)}'
            root.wrong("extensionsRequired", f"{text}  (covered: {', '.join(sorted(COVERED))})")
    for name in used:
        if name not in COVERED and name not in required:
            document.report.approximate(left_out(name))
    if document.report.issues:
        raise SceneError(document.report.issues)


def _say_what_is_dropped(document: Document) -> None:
    animations = document.list("animations")
    if animations:
        document.report.drop(f"animations ({len(animations)}): the scene is shown at rest")
    if document.list("samplers"):
        document.report.drop("minification filters: many samples do the same")
    asset = document.root.object("asset")
    if document.root.has("extras") or (asset is not None and asset.has("extras")):
        document.report.drop("extras: data of other programs")
