"""A document of MaterialX by itself: a ball of each of its materials, side by side."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from alight.core.errors import Issue, SceneError, quote
from alight.formats.materials.surfaces import Surface, plain_surface
from alight.formats.materials.textures import CHECKERED, MISSING, WITHOUT
from alight.formats.materials.udim import find_tiles, is_tiled
from alight.formats.materialx.document import Document, Material
from alight.formats.materialx.nodes import Input, Node
from alight.formats.materialx.shaders import not_covered, read_shader, stand_in
from alight.formats.materialx.values import Value, spread, textured
from alight.formats.reading.names import free_name
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.formats.reading.shown import Shown
from alight.formats.reading.xml import MOST_BYTES, Element
from alight.formats.scenes.model_scene import ModelScene
from alight.formats.scenes.parsed import Parsed
from alight.scene.transform import translate
from alight.textures.images import Image

Data = dict[str, Any]
AS_IT_IS = Shown()
#: Balls that are shown, and from centre to centre of two of radius 1.
MOST_BALLS, APART = 64, 2.4
#: Of the format.
VERSIONS = ("1.36", "1.37", "1.38", "1.39")
SHADERBALL = {"type": "sphere"}
#: Its poles above and below, its seam where the automatic camera does not see it.
UPRIGHT = ({"rotate": {"axis": "x", "angle": -90.0}}, {"rotate": {"axis": "y", "angle": 120.0}})


class DocumentHost:
    """What an evaluator needs of a document.

    Parameters
    ----------
    report : Report
    reach : Reach
    """

    #: The specification converts nothing without a stated colour space.
    space = ""
    coordinates = "UV0"
    meters = 1.0

    def __init__(self, report: Report, reach: Reach) -> None:
        self.report, self.reach, self.files = report, reach, reach.files

    def set_name(self, index: int) -> str:
        """Name of a set of coordinates by its number."""
        return f"UV{index}"

    def primvar(self, node: Node, name: str, width: int) -> Value | None:
        """Colours of vertices; balls have no other property."""
        if name in ("displayColor", "Cd", "color") and width >= 3:
            return spread(textured({"type": "vertex_color", "fallback": 1.0}, 3), width)
        return None

    def picture(self, node: Node, entry: Input, is_color: bool) -> str | Image | None:
        """The picture of a file name, from the folder of the document that says it."""
        folder = entry.asset if isinstance(entry.asset, Path) else self.reach.folder
        try:
            if is_tiled(str(entry.value)):
                return find_tiles(str(entry.value), self.reach.from_folder(folder))
            path = self.reach.from_folder(folder).find(str(entry.value))
        except OutOfReachError as error:
            replacement = CHECKERED if is_color else WITHOUT
            self.report.lacks_at(node.place, node.name, error, replacement)
            return MISSING if is_color and self.report.can_do_without(error) else None
        return self.reach.name_of(path)


def parse(
    data: bytes, name: str, reach: Reach, shown: Shown = AS_IT_IS, lenient: bool = False
) -> Parsed:
    """Read a document as a scene.

    Parameters
    ----------
    data, name : bytes and str
        Its content, and its name for messages.
    reach : Reach
        Where the files that it names may lie.
    shown : Shown, optional
        `variant` is the name of the only material that is shown.
    lenient : bool, default False
        See `alight.load`.

    Raises
    ------
    SceneError
        If it is no document, or holds no material.
    """
    report = Report(lenient)
    document = Document(decoded(data, name), name, reach.folder, reach, report)
    materials = _chosen(document.materials(), shown, name)
    host = DocumentHost(report, reach)
    model = ModelScene(report, reach, {"": name})
    columns = math.ceil(math.sqrt(len(materials)))
    for number, material in enumerate(materials):
        surface = surface_of(material, host).on(closed=True)
        key = model.name_of(number, surface, material.name, material.place)
        report.count("materials")
        # From left to right, then from front to back: what is behind shows between.
        place = [APART * (number % columns), 0.0, -APART * (number // columns)]
        ball: Data = {"shape": dict(SHADERBALL), "bsdf": key, **surface.light}
        ball["transform"] = [*UPRIGHT, {"translate": place}]
        model.nodes[free_name(material.name, model.nodes, "ball")] = ball
        to_world = translate(*place).matrix
        model.bounds.add(SHADERBALL, to_world)
        if surface.emission is not None and not surface.is_unlit:
            model.glow.add_shape(SHADERBALL, to_world, surface.emission)
    if report.issues:
        raise SceneError(report.issues)
    report.drop("the file holds materials alone: a ball shows each")
    _say_what_is_not_read(document.root.element, report)
    return model.finish()


def _say_what_is_not_read(top: Element, report: Report) -> None:
    """Remark on looks, which say what wears a material, and on versions of the format to come."""
    version = top.attributes.get("version", "").strip()
    if version and version not in VERSIONS:
        text = f"version {quote(version)} is read as {VERSIONS[-1]}"
        report.approximate(f"{top.place}: {text}  (covered: {', '.join(VERSIONS)})")
    looks = [child.name or child.tag for child in top.children if child.tag == "look"]
    if looks:
        report.drop(f"looks ({', '.join(map(quote, looks[:20]))}): there is nothing to wear them")


def decoded(data: bytes, name: str) -> str:
    """The text of a document.

    Raises
    ------
    SceneError
        If it is too large or no UTF-8.
    """
    if len(data) > MOST_BYTES:
        text = f"must be at most {MOST_BYTES >> 20} MB, got {len(data) >> 20} MB"
        raise SceneError([Issue("", text, name)])
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text = f"must be UTF-8 text, got byte 0x{error.object[error.start]:02x} at {error.start}"
        raise SceneError([Issue("", text, name)]) from None


def surface_of(material: Material, host: DocumentHost) -> Surface:
    """What a material of a document looks like."""
    report = host.report
    if material.shader is None:
        report.approximate(f"{material.place}: {material.name}: it has no surface; grey is shown")
        return plain_surface(has_colors=False)
    if material.is_displaced:
        report.approximate(f"{material.place}: {material.name}: displacement is left out")
    found = read_shader(material.shader, host)
    if found is not None:
        return found
    text = not_covered(material.shader)
    if report.lenient:
        said = f"{text}: squares of magenta and black are shown"
        report.approximate(f"{material.shader.place}: {material.name}: {said}")
    else:
        report.problem(material.shader.place, material.name, text)
    return stand_in()


def _chosen(materials: list[Material], shown: Shown, name: str) -> list[Material]:
    if not materials:
        raise SceneError([Issue("", "holds no material", name)])
    if shown.variant is not None:
        found = [material for material in materials if material.name == shown.variant]
        if not found:
            known = ", ".join(material.name for material in materials[:50])
            text = f"there is no material {quote(shown.variant)}  (materials: {known})"
            raise SceneError([Issue("--variant", text, name)])
        return found
    if len(materials) > MOST_BALLS:
        text = f"holds {len(materials)} materials, of which {MOST_BALLS} can be shown at once"
        raise SceneError([Issue("", f"{text}: choose one with --variant NAME", name)])
    return materials
