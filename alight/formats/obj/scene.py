"""OBJ files opened by themselves: groups, materials, with light and a camera around them.

A node is made for each group and material. Without vertex normals a surface is shaded flat, unless
a smoothing group is on; then the normals of the faces around a vertex are averaged.

Source: Wavefront Technologies, Object files (.obj), appendix B1 of the Advanced Visualizer manual.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from alight.core.errors import Issue, SceneError, quote, unknown_name
from alight.formats.materials.surfaces import Surface, plain_surface, tinted
from alight.formats.obj import mtl
from alight.formats.obj.maps import find
from alight.formats.reading.names import free_name
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.formats.scenes.model_scene import ModelScene
from alight.formats.scenes.parsed import Parsed
from alight.meshes import obj
from alight.meshes.normals import vertex_normals
from alight.scene.meshes import mesh_of
from alight.shapes.arrays import TriangleShape

MOST_LIBRARY_BYTES = 16 * 2**20
#: Of free-form curves and surfaces.
_FREE_FORM = dict.fromkeys(
    (
        "bmat", "bsp", "bzp", "cdc", "cdp", "con", "cstype", "curv", "curv2", "deg", "end", "hole",
        "parm", "res", "scrv", "sp", "step", "surf", "trim", "vp",
    ),
    "curves and free-form surfaces are not covered",
)  # fmt: skip
#: About how other programs draw.
_OF_DRAWING = dict.fromkeys(
    (
        "bevel", "c_interp", "ctech", "d_interp", "lod", "maplib", "mg", "shadow_obj", "stech",
        "trace_obj", "usemap",
    ),
    "plays no part",
)  # fmt: skip
#: What becomes of a group in which only some faces have something.
_LACKING = {"texture coordinates": "the others take (0, 0)", "normals": "none is used"}
_KNOWN = ("f", "g", "l", "mtllib", "o", "p", "s", "usemtl", "v", "vn", "vt")


@dataclass
class _Part:
    """Faces that share a group, a material and a way of shading."""

    group: str
    material: str
    smooth: bool
    faces: list[tuple[int, int]] = field(default_factory=list)


def parse(data: bytes, name: str, reach: Reach | None = None, lenient: bool = False) -> Parsed:
    """Read an OBJ file as a scene.

    Parameters
    ----------
    data, name : bytes and str
        Content of the file, and its name for messages.
    reach : Reach, optional
        Where material libraries and pictures may lie; the current folder by default.
    lenient : bool, default False
        Whether something stands for pictures that are missing.

    Raises
    ------
    SceneError
        If the file is broken; messages name the line.
    """
    report, reach = Report(lenient), reach or Reach()
    try:
        content = obj.parse(data)
    except SceneError as error:
        raise SceneError([_with_line(issue.message, name) for issue in error.issues]) from None
    for kind, (text, line) in content.absent.items():
        report.approximate(f"{name}:{line}:1: {text}: its faces have no {kind}")
    if content.colors is not None and np.isnan(content.colors).any():
        report.approximate(f"{name}: only some vertices have colours: the others are white")
    materials: dict[str, Surface] = {}
    parts = _parts(content, name, reach, report, materials)
    if report.issues:
        raise SceneError(report.issues)
    model = ModelScene(report, reach, {"": name})
    for part in parts:
        mesh = _mesh(content, part, name, report)
        if mesh is None:
            continue
        assert mesh.vertices is not None
        model.bounds.add(mesh.vertices, np.eye(4))
        surface, wanted = materials.get(part.material), part.material
        key = wanted
        if surface is None:
            has_colors = mesh.colors is not None
            surface, wanted, key = plain_surface(has_colors), "grey", f"grey {has_colors}"
        elif mesh.colors is not None and mesh.colors.min() < 1.0:
            report.approximate(f"{name}: the colours of its vertices tint its materials")
            surface, key = tinted(surface), f"tinted {wanted}"
        model.shine(mesh, surface, np.eye(4))
        bsdf = model.name_of(key, surface, wanted, surface.place)
        group = free_name(part.group, model.nodes, "mesh")
        model.nodes[group] = {"shape": mesh, "bsdf": bsdf, **surface.light}
        report.count("meshes")
    if not model.nodes:
        points = len(content.tables[b"v"])
        found = f"{points} points without a face" if points else "an empty mesh"
        raise SceneError([Issue("", f"must hold at least one triangle, got {found}", name)])
    report.count("materials", len(materials))
    return model.finish()


def _with_line(message: str, name: str) -> Issue:
    """A problem of the file, with the line that its message begins with as its place."""
    found = re.fullmatch(r"line (\d+): (.*)", message, re.DOTALL)
    return Issue("", found[2], f"{name}:{found[1]}:1") if found else Issue("", message, name)


def _parts(
    content: obj.Content,
    name: str,
    reach: Reach,
    report: Report,
    materials: dict[str, Surface],
) -> list[_Part]:
    """Ranges of faces by group and material, in the order of their first face."""
    parts: dict[tuple[str, str, bool], _Part] = {}
    group, material, smooth, start = "", "", False, 0
    used: dict[str, str] = {}
    end = obj.Statement([b""], 0, len(content.sizes))
    for words, line, faces in [*content.statements, end]:
        if faces > start:
            part = parts.setdefault((group, material, smooth), _Part(group, material, smooth))
            part.faces.append((start, faces))
            start = faces
        texts = [obj.decoded(word) for word in words]
        rest = " ".join(texts[1:])
        if words[0] in (b"g", b"o"):
            group = rest
        elif words[0] == b"usemtl":
            material = rest
            used.setdefault(material, f"{name}:{line}:1")
        elif words[0] == b"s":
            smooth = rest not in ("off", "0", "")
        elif words[0] == b"mtllib":
            _library(rest, f"{name}:{line}:1", reach, report, materials)
        elif words[0] in (b"l", b"p"):
            report.drop("points and lines have no surface")
        elif texts[0]:
            report.leave_out(
                f"{name}:{line}:1", texts[0], "statement",
                dropped=_OF_DRAWING, approximated=_FREE_FORM, known=_KNOWN,
            )  # fmt: skip
    if (content.sizes < 3).any():
        report.drop("faces of fewer than 3 corners have no surface")
    if used and not any(words[0] == b"mtllib" for words, _, _ in content.statements):
        report.approximate(f"{name}: names materials but no library (mtllib): all is grey")
    for material, place in used.items():
        if material not in materials and materials:
            known = unknown_name("material", material, materials).partition("  (")[0]
            report.approximate(f"{place}: {known}; its faces are grey")
    return list(parts.values())


def _library(
    text: str, place: str, reach: Reach, report: Report, materials: dict[str, Surface]
) -> None:
    """Read the libraries of a statement: one name with spaces, or several names."""
    is_one = text.lower().rstrip('"').endswith(".mtl") and ".mtl " not in text.lower()
    for name in [text] if is_one else text.split():
        try:
            path = find(name, place, reach, report)
        except OutOfReachError as error:
            report.approximate(f"{place}: its materials are grey: {error}")
            continue
        try:
            content = obj.decoded(content_of(path, MOST_LIBRARY_BYTES))
        except OutOfReachError as error:
            raise mtl.broken(place, str(error)) from None
        materials.update(mtl.read(content, path.name, reach.from_folder(path.parent), report))


def _mesh(content: obj.Content, part: _Part, name: str, report: Report) -> TriangleShape | None:
    """The mesh of a part; None if it has no triangle."""
    arrays = content.mesh(part.faces)
    if len(arrays.faces) == 0:
        return None
    for kind in content.partly(part.faces):
        group = f"{quote(part.group)}: " if part.group else ""
        report.approximate(f"{name}: {group}only some faces have {kind}: {_LACKING[kind]}")
    try:
        mesh = mesh_of(arrays)
    except SceneError as error:
        raise SceneError([Issue("", issue.sentence, name) for issue in error.issues]) from None
    if arrays.normals is None and part.smooth:
        return mesh.replaced(normals=vertex_normals(arrays.vertices, arrays.faces))
    return mesh
