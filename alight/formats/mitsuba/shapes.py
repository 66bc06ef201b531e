"""``<shape>`` -> nodes with a shape, a material and perhaps an area light."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from alight.core.errors import SceneError, join_path
from alight.formats.mitsuba import bsdfs, interiors
from alight.formats.mitsuba.below import scattering
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.emitters import area_light
from alight.formats.mitsuba.meshes import load_mesh
from alight.formats.mitsuba.strands import load_strands
from alight.formats.mitsuba.transforms import Step, is_mirrored, matrix_of, motion_of
from alight.formats.reading.context import sees_coordinates
from alight.formats.reading.xml import Element
from alight.shapes.mesh import Mesh
from alight.shapes.strands import StrandShape

#: Parameters that no shape needs.
_UNUSED = ("optimize",)

# Mitsuba's cube has texture coordinates of its own: corners of its six sides, four each.
_CUBE = """
+-- +-+ --+ ---  ++- -+- -++ +++  +-- ++- +++ +-+
+-+ +++ -++ --+  --+ -++ -+- ---  ++- +-- --- -+-
"""


def convert(context: Context, element: Element, path: str) -> Data | None:
    """Convert a ``<shape>`` to a node; None where there is nothing to show."""
    kind = element.type
    if kind == "shapegroup":
        if "id" not in element:
            context.report.error(element, "needs an id, by which instances refer to it")
            return None
        context.named("prototypes", element, lambda path: _group(context, element, path))
        return None
    if kind == "instance":
        return _instance(context, element, path)
    if kind not in COVERED:
        known = (*COVERED, "shapegroup", "instance")
        context.report.unknown(element, "shape", element.type, known, "left out")
        return None
    return _shape(context, element, path)


def _shape(context: Context, element: Element, path: str) -> Data | None:
    draft = Draft(context, element, path)
    p = draft.properties
    steps, transform = motion_of(p)
    draft.put("transform", transform or None, "to_world")
    if COVERED[element.type] is not _mesh:
        p.ignore("the shape has a formula", "face_normals", "flip_tex_coords", "max_smooth_angle")
    shape = COVERED[element.type](draft, steps)
    context.places[join_path(path, "shape")] = element.place
    bounds_media = interiors.of_shape(draft)
    if bounds_media and isinstance(shape, StrandShape):
        context.report.warn(element, "bounds no media: curves are met from outside only")
        for side in interiors.SIDES:
            draft.data.pop(side, None)
    lights, materials = p.take("emitter"), []
    for part in p.take("bsdf", "ref"):
        # Lamps may stand elsewhere, too.
        target = context.ids.get(part.attributes.get("id", "")) if part.tag == "ref" else None
        is_lamp = target is not None and target.tag == "emitter"
        (lights if is_lamp else materials).append(target if is_lamp and target else part)
    if lights:
        draft.put("light", area_light(context, lights[0], join_path(path, "light")))
    below = p.take("subsurface")
    for surplus in (*lights[1:], *materials[1:]):
        context.report.error(surplus, "a shape has one bsdf and one emitter at most")
    if materials:
        draft.put("bsdf", bsdfs.convert(context, materials[0], join_path(path, "bsdf")))
    elif "light" in draft.data:
        # A lamp without a material is black.
        draft.put("bsdf", {"type": "diffuse", "reflectance": [0.0, 0.0, 0.0]})
    elif bounds_media and element.old:
        # In version 0.6 the border of a medium is seen only if it says of what it is.
        draft.put("bsdf", {"type": "null"})
    for element_below in below[:1]:
        draft.put("bsdf", scattering(context, element_below))
    p.finish()
    if shape is None:
        return None
    if isinstance(shape, dict) and shape["type"] == "cube":
        shape = _cube_for(context, draft, shape)
    _check_colors(draft, shape)
    return {"shape": shape, **draft.data}


def _flipped(draft: Draft, mirrored: bool = False) -> Data:
    """The key `flip_normals`, if it is true."""
    return {"flip_normals": True} if draft.properties.flag("flip_normals") != mirrored else {}


def _mesh(draft: Draft, steps: list[Step]) -> Mesh | None:
    draft.properties.ignore("meshes are taken as they are", *_UNUSED)
    smooth = draft.properties.find("max_smooth_angle")
    if smooth is not None:
        text = "is left out: normals are smooth, or those of the file"
        draft.context.report.warn(smooth, text)
    return load_mesh(draft, is_mirrored(steps))


def _rectangle(draft: Draft, steps: list[Step]) -> Data:
    return {"type": "rectangle", **_flipped(draft)}


def _cube(draft: Draft, steps: list[Step]) -> Data:
    return {"type": "cube", **_flipped(draft)}


def _disk(draft: Draft, steps: list[Step]) -> Data:
    return {"type": "disk", **_flipped(draft)}


def _sphere(draft: Draft, steps: list[Step]) -> Data:
    p = draft.properties
    data: Data = {"type": "sphere", "center": p.triple("center"), "radius": p.number("radius")}
    _place(draft, data)
    linear = matrix_of(steps)[:3, :3]
    metric = linear.T @ linear
    if np.abs(metric - metric[0, 0] * np.eye(3)).max() > 1e-4 * abs(metric[0, 0]):
        text = "is scaled to an ellipsoid, which Mitsuba does not show as one"
        draft.context.report.warn(draft.element, text)
    # Of Mitsuba's shapes with a formula this one alone is turned inside out by a mirror.
    return _without_none(data) | _flipped(draft, is_mirrored(steps))


def _cylinder(draft: Draft, steps: list[Step]) -> Data:
    p = draft.properties
    data = {"type": "cylinder", "p0": p.triple("p0"), "p1": p.triple("p1")}
    data["radius"] = p.number("radius")
    _place(draft, data)
    return _without_none(data) | _flipped(draft)


def _place(draft: Draft, data: Data) -> None:
    """Note where the keys of a shape stand."""
    for key in data:
        if draft.properties.has(key):
            path = f"{draft.path}.shape.{key}"
            draft.context.places[path] = draft.properties.named[key].place


def _without_none(data: Data) -> Data:
    return {key: value for key, value in data.items() if value is not None}


def _cube_for(context: Context, draft: Draft, shape: Data) -> Data | Mesh:
    """A mesh in place of a cube where the texture coordinates or tangents can be seen."""
    used = [draft.data.get("bsdf"), draft.data.get("light")]
    if not context.holds(used, sees_coordinates):
        return shape
    words = _CUBE.split()
    corners = np.array([[1.0 if sign == "+" else -1.0 for sign in word] for word in words])
    sides = np.array([[0, 1, 2], [3, 0, 2]])
    faces = (4 * np.arange(6)[:, None, None] + sides).reshape(-1, 3)
    uvs = np.tile([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], (6, 1))
    return Mesh(
        vertices=corners, faces=faces, uvs=uvs, flip_normals=shape.get("flip_normals", False)
    )


def _sees_colors(value: Data) -> bool:
    return value.get("type") == "vertex_color"


def _check_colors(draft: Draft, shape: Data | Mesh | StrandShape) -> None:
    """Refuse a material that shows the vertex colours of a shape without."""
    if isinstance(shape, Mesh) and shape.colors is not None:
        return
    if draft.context.holds([draft.data.get("bsdf"), draft.data.get("light")], _sees_colors):
        text = "has no vertex colours (r, g, b of a PLY file) in [0, 1], which its material shows"
        draft.context.report.not_covered(draft.element, text, "grey 0.5 is taken")


def _group(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path)
    children = convert_all(context, draft.properties.take("shape", "ref"), f"{path}.children")
    draft.properties.finish()
    return {"children": children}


def _instance(context: Context, element: Element, path: str) -> Data | None:
    draft = Draft(context, element, path)
    p = draft.properties
    draft.put("transform", motion_of(p)[1] or None, "to_world")
    groups = p.take("shape", "ref")
    p.finish()
    if len(groups) != 1:
        text = f"must refer to one shapegroup, got {len(groups)}"
        context.report.error(element, text)
        return None
    target = context.target(groups[0], "shape")
    if target is None:
        return None
    if target.type != "shapegroup" or "id" not in target:
        text = f"must refer to a shapegroup with an id, got {target.label}"
        context.report.error(groups[0], text)
        return None
    name = context.named("prototypes", target, lambda path: _group(context, target, path))
    draft.put("instance", name)
    return draft.data


def convert_all(context: Context, elements: Iterable[Element], path: str) -> dict[str, Data]:
    """Convert shapes to nodes, each with a name of its own.

    Parameters
    ----------
    path : str
        Key path of the nodes.
    """
    nodes: dict[str, Data] = {}
    for element in elements:
        target = context.target(element, "shape")
        if target is None:
            continue
        name = context.name(path, target.attributes.get("id") or f"{target.type} {len(nodes) + 1}")
        try:
            node = convert(context, target, join_path(path, name))
        except SceneError as error:
            context.report.errors_of(target, error)
            continue
        if node is not None:
            nodes[name] = node
    return nodes


#: Shapes of Mitsuba that alight has models for.
COVERED: dict[str, Callable[[Draft, list[Step]], Data | Mesh | StrandShape | None]] = {
    "bsplinecurve": load_strands,
    "cube": _cube,
    "cylinder": _cylinder,
    "disk": _disk,
    "linearcurve": load_strands,
    "obj": _mesh,
    "ply": _mesh,
    "rectangle": _rectangle,
    "serialized": _mesh,
    "sphere": _sphere,
}
