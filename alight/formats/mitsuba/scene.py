"""A scene file of Mitsuba -> a description in the native format, with the place of every value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from alight.core.errors import join_path, unknown_name
from alight.formats.geometry.bounds import Bounds
from alight.formats.mitsuba import (
    bsdfs,
    emitters,
    integrators,
    interiors,
    sensors,
    shapes,
    stand_ins,
    textures,
)
from alight.formats.mitsuba.context import Context
from alight.formats.mitsuba.document import Document, read_document
from alight.formats.mitsuba.framing import surround
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.formats.reading.xml import Element
from alight.formats.scenes.parsed import Parsed
from alight.scene.build import FORMAT_VERSION

#: What converts materials, those that are approximated included.
MATERIALS = bsdfs.COVERED | stand_ins.STAND_INS
#: Kinds of objects at the top level, in the order in which they are converted.
TOP = ("sensor", "integrator", "texture", "bsdf", "medium", "shape", "emitter")


def parse(
    text: str,
    name: str,
    reach: Reach | None = None,
    definitions: Mapping[str, str] | None = None,
    lenient: bool = False,
) -> Parsed:
    """Read a scene file.

    Parameters
    ----------
    text, name : str
        Content of the file, and its name for messages.
    reach : Reach, optional
        Where the files that it names may lie; the current folder by default.
    definitions : mapping of str to str, optional
        Values of ``$names``.
    lenient : bool, default False
        Whether what is not covered is replaced instead of refused.

    Raises
    ------
    SceneError
        If the file is no scene at all.
    """
    report = Report(lenient)
    objects, document = read_document(text, name, reach or Reach(), definitions or {}, report)
    context = Context(report, document.reach, materials=MATERIALS)
    _collect_ids(context, objects, document)
    data, spp, framed = _convert(context, objects)
    places = context.places | {"": f"{name}:1:1"}
    report.sort()
    return Parsed.of(data, places, report, spp, framed)


def _collect_ids(context: Context, objects: list[Element], document: Document) -> None:
    ids, stack = context.ids, list(reversed(objects))
    while stack:
        element = stack.pop()
        stack.extend(reversed(element.children))
        context.moves = context.moves or element.tag == "animation"
        context.has_panes = context.has_panes or element.type == "thindielectric"
        name = element.attributes.get("id")
        if name is None or element.tag == "ref":
            continue
        if name in ids:
            context.report.error(element, f"this id was given before, at {ids[name].place}")
            # Two objects must not share a name.
            del element.attributes["id"]
        else:
            ids[name] = element
    for alias in document.aliases:
        name, new = alias.attributes.get("id", ""), alias.attributes.get("as", "")
        if name not in ids:
            context.report.error(alias, unknown_name("id", name, ids, listed_as="ids"))
        elif not new or new in ids:
            context.report.error(alias, f'needs a new id in the attribute as, got "{new}"')
        else:
            ids[new] = ids[name]


def _convert(
    context: Context, objects: list[Element]
) -> tuple[dict[str, Any], int | None, Bounds | None]:
    by_kind: dict[str, list[Element]] = {kind: [] for kind in TOP}
    for element in objects:
        if element.tag in by_kind:
            by_kind[element.tag].append(element)
            context.report.count(f"{element.tag}s")
        else:
            text = unknown_name("element", element.tag, TOP, listed_as="covered")
            context.report.not_covered(element, text, "left out")
    data: dict[str, Any] = {"alight": FORMAT_VERSION}
    spp = None
    context.sees_media = integrators.sees_media(by_kind["integrator"])
    for surplus in by_kind["sensor"][1:]:
        context.report.warn(surplus, "is not used: the picture is that of the first sensor")
    for sensor in by_kind["sensor"][:1]:
        spp = sensors.convert(context, sensor, data)
    for surplus in by_kind["integrator"][1:]:
        context.report.error(surplus, "a scene has one integrator at most")
    for integrator in by_kind["integrator"][:1]:
        data["integrator"] = integrators.convert(context, integrator)
    for texture in by_kind["texture"]:
        textures.texture_value(context, texture, "textures")
    for bsdf in by_kind["bsdf"]:
        bsdfs.convert(context, bsdf, "bsdfs")
    for medium in by_kind["medium"]:
        interiors.medium(context, medium, "media")
    nodes = shapes.convert_all(context, by_kind["shape"], "nodes")
    _emitters(context, by_kind["emitter"], data, nodes)
    if context.uses_media:
        data["integrator"] = integrators.for_media(data.get("integrator"))
        _say_how_panes_count(context, by_kind["integrator"], data["integrator"])
    framed = None
    if nodes and not by_kind["sensor"]:
        framed = surround(context, data, nodes)
    return {**data, **context.tables, "nodes": nodes}, spp, framed


def _say_how_panes_count(
    context: Context, integrators_of_file: list[Element], integrator: dict[str, Any]
) -> None:
    """Tell of what makes a picture with media darker than Mitsuba's at the same depth."""
    if context.has_panes and context.sees_media and integrator.get("max_depth") is not None:
        text = "volpath does not count passing thindielectric in Mitsuba, max_depth does so here"
        for element in integrators_of_file[:1]:
            context.report.warn(element, f"{text}: raise it for the same light")


def _emitters(
    context: Context, elements: list[Element], data: dict[str, Any], nodes: dict[str, Any]
) -> None:
    for element in elements:
        if element.type == "constant" and "environment" not in data:
            data["environment"] = emitters.constant(context, element)
        elif element.type == "constant":
            name = context.name("nodes", f"constant {len(nodes) + 1}")
            nodes[name] = {"light": emitters.constant(context, element)}
        elif element.type in emitters.NODES:
            name = element.attributes.get("id") or f"{element.type} {len(nodes) + 1}"
            name = context.name("nodes", name)
            node = emitters.node_light(context, element, join_path("nodes", name))
            if node is not None:
                nodes[name] = node
        else:
            emitters.unknown(context, element)
