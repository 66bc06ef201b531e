"""A glTF file -> a description in the native format."""

from __future__ import annotations

from alight.core.errors import SceneError
from alight.formats.gltf.accessors import COMPRESSED
from alight.formats.gltf.animations import pose
from alight.formats.gltf.container import Document, open_document
from alight.formats.gltf.draco import NAME as DRACO
from alight.formats.gltf.draco import unpack_draco
from alight.formats.gltf.instances import NAME as INSTANCES
from alight.formats.gltf.keys import left_out, say_what_is_unknown
from alight.formats.gltf.materials import COVERED as MATERIALS
from alight.formats.gltf.materials import Materials
from alight.formats.gltf.nodes import Graph
from alight.formats.gltf.scenes import choose_scene
from alight.formats.gltf.textures import WAYS_OUT, WEBP
from alight.formats.gltf.variants import NAME as VARIANTS
from alight.formats.gltf.variants import choose_variant
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report, did_you_mean
from alight.formats.reading.shown import Shown
from alight.formats.scenes.parsed import Parsed

#: Extensions that are read.
COVERED = (
    *MATERIALS, DRACO, INSTANCES, "KHR_lights_punctual", "KHR_mesh_quantization",
    "KHR_texture_transform", VARIANTS, WEBP,
)  # fmt: skip


def parse(
    data: bytes,
    name: str,
    reach: Reach | None = None,
    shown: Shown | None = None,
    lenient: bool = False,
) -> Parsed:
    """Read a scene file.

    Parameters
    ----------
    data, name : bytes and str
        Content of the file (.gltf or .glb), and its name for messages.
    reach : Reach, optional
        Where the files that it names may lie; the current folder by default.
    shown : Shown, optional
        Which variant of the materials, which scene, and at which time.
    lenient : bool, default False
        Whether something stands for pictures that are missing.

    Raises
    ------
    SceneError
        If the file is no scene at all.
    """
    report = Report(lenient)
    document = open_document(data, name, reach or Reach(), report)
    _check_extensions(document)
    say_what_is_unknown(document.root.value, report)
    unpack_draco(document)
    shown = shown or Shown()
    choose_variant(document, shown.variant)
    choose_scene(document, shown.scene_name)
    pose(document, shown)
    graph = Graph(document, Materials(document))
    graph.build()
    _say_what_is_dropped(document)
    report.count("nodes", len(document.list("nodes")))
    return graph.finish()


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
        elif name in WAYS_OUT:
            root.wrong("extensionsRequired", f"{name} is not covered; {WAYS_OUT[name]}")
        elif name not in COVERED:
            text = f'requires "{name}", which is not covered{did_you_mean(name, COVERED)}'
            root.wrong("extensionsRequired", f"{text}  (covered: {', '.join(sorted(COVERED))})")
    for name in used:
        if name not in (*COVERED, *COMPRESSED, *required):
            document.report.approximate(left_out(name))
    if document.report.issues:
        raise SceneError(document.report.issues)


def _say_what_is_dropped(document: Document) -> None:
    if document.list("samplers"):
        document.report.drop("minification filters: many samples do the same")
    asset = document.root.object("asset")
    if document.root.has("extras") or (asset is not None and asset.has("extras")):
        document.report.drop("extras: data of other programs")
