"""What a scene, a film or a picture holds, and what the reader of a scene had to say."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from alight.core.errors import OptionError
from alight.options.entry import takes
from alight.options.laboratory import InfoOptions
from alight.outputs import html

if TYPE_CHECKING:
    from alight.scene import FlatScene, Node, Scene


@dataclass(frozen=True)
class SceneInfo:
    """What a scene holds; of a film or a picture only the facts.

    Attributes
    ----------
    facts : list of (str, str)
        Counts and settings by name; the cost of the tree of boxes, if requested.
    tree : list of str
        The scene graph, a line for each node, if requested.
    dropped : list of str
        What of a foreign file plays no part in the picture.
    approximated : list of str
        What took the place of something else.
    warnings : list of str
        What is legal but suspicious.
    notes : list of str
        What one should know of the models.
    """

    facts: list[tuple[str, str]]
    tree: list[str]
    dropped: list[str]
    approximated: list[str]
    warnings: list[str]
    notes: list[str]

    def __str__(self) -> str:
        """What ``alight info`` prints."""
        return "\n".join([*(f"{name:<13}{value}" for name, value in self.facts), *self.tree])

    def remarks(self) -> list[str]:
        """What the command says on stderr."""
        kinds = {
            "dropped": self.dropped, "approximated": self.approximated,
            "warning": self.warnings, "note": self.notes,
        }  # fmt: skip
        return [f"{kind}: {text}" for kind, texts in kinds.items() for text in texts]

    def _repr_html_(self) -> str:
        """Show the facts as a table in a notebook."""
        return html.division(
            html.table(self.facts), html.preformatted(self.tree), html.preformatted(self.remarks())
        )


@takes(InfoOptions)
def info(scene: Scene | str | os.PathLike[str], options: InfoOptions) -> SceneInfo:
    """Say what a scene holds, without rendering it, or what is in a film or a picture.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
        Or the path of a film or a picture.
    {options}

    Returns
    -------
    SceneInfo

    Raises
    ------
    AlightError
        For a scene or an option that is wrong.

    Examples
    --------
    >>> dict(alight.info("cornell-box").facts)["lights"]
    '1 (1 area)'
    """
    from alight.compiled.scene import compile_scene
    from alight.lab.picture_info import is_film_or_picture, picture_facts
    from alight.options.loading import scene_of
    from alight.scene import flatten

    if is_film_or_picture(scene):
        for name in options.given():
            raise OptionError(f"{scene} is no scene", name)
        found, warnings = picture_facts(str(scene))
        return SceneInfo(found, [], [], [], warnings, [])
    description = scene_of(scene, options)
    flat = flatten(description)
    compiled = compile_scene(flat, structure="auto" if options.tree else "none")
    found, tree = facts(description, flat), []
    if options.tree:
        found += accelerator_facts(compiled.stats)
        tree = list(tree_lines(description))
    remarks = description.source.remarks
    return SceneInfo(
        found,
        tree,
        dropped=list(remarks.notes),
        approximated=[*remarks.warnings, *flat.notes],
        warnings=[
            text
            for text in compiled.warnings
            if text not in remarks.warnings and text not in flat.notes
        ],
        notes=energy_notes(flat),
    )


def facts(scene: Scene, flat: FlatScene) -> list[tuple[str, str]]:
    """Gather the counts and settings of a scene, as (name, text)."""
    width, height = scene.film.size
    crop = f", crop {','.join(map(str, scene.film.crop))}" if scene.film.crop else ""
    nodes = sum(1 for _ in scene.walk())
    triangles = sum(len(flat.geometries[s.geometry].faces) for s in flat.shapes if s.geometry >= 0)
    stored = sum(len(geometry.faces) for geometry in flat.geometries)
    shapes = Counter(placed.shape.type_name() for placed in flat.shapes)
    lights = Counter(light.light.type_name() for light in flat.lights)
    lights.update(p.light.type_name() for p in flat.shapes if p.light is not None)
    lights.update(f"environment {light.light.type_name()}" for light in flat.environments)
    bsdfs = Counter(bsdf.type_name() for bsdf in flat.bsdfs)
    read = ", ".join(f"{number} {kind}" for kind, number in scene.source.remarks.read)
    return [
        *([("read", read)] if read else []),
        ("film", f"{width}x{height} pixels{crop}, {scene.film.filter.type_name()} filter"),
        ("camera", flat.camera.camera.type_name()),
        ("integrator", scene.integrator.type_name()),
        ("sampler", scene.sampler.type_name()),
        ("nodes", str(nodes)),
        ("shapes", _counted(shapes)),
        ("triangles", f"{triangles} ({stored} stored)"),
        ("bsdfs", _counted(bsdfs)),
        ("lights", _counted(lights)),
        ("meshes", f"{len(flat.geometries)} of {_megabytes(mesh_bytes(flat))}"),
        *moving_facts(flat),
    ]


def energy_notes(flat: FlatScene) -> list[str]:
    """Say which models send out more light than they get, whatever they are part of."""
    from alight.bsdfs.model import BSDFS
    from alight.bsdfs.nesting import leaves

    names = {leaf.bsdf.type_name() for bsdf in flat.bsdfs for leaf in leaves(bsdf)}
    most = {name: BSDFS[name].MOST_SENT_OUT for name in sorted(names)}
    return [
        f"{name} makes light: a white one sends out up to {factor:g} times what it gets"
        for name, factor in most.items()
        if factor > 1.0
    ]


def moving_facts(flat: FlatScene) -> list[tuple[str, str]]:
    """Say what moves while the shutter is open, if anything does."""
    counts = {
        "shapes": sum(placed.motion is not None for placed in flat.shapes),
        "lights": sum(placed.motion is not None for placed in flat.lights),
    }
    found = [f"{count} {name}" for name, count in counts.items() if count]
    found += ["camera"] * (flat.camera.motion is not None)
    begin, end = flat.camera.camera.shutter
    return [("moving", f"{', '.join(found)}; shutter {begin:g} to {end:g}")] if found else []


def mesh_bytes(flat: FlatScene) -> int:
    """Add up the bytes of all mesh arrays."""
    arrays = (
        array
        for g in flat.geometries
        for array in (g.vertices, g.faces, g.normals, g.uvs, g.colors, g.more_uvs)
    )
    return sum(array.nbytes for array in arrays if array is not None)


def accelerator_facts(stats: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Say the figures of displaced meshes and of the acceleration structure."""
    stats = dict(stats)
    displaced = stats.pop("displaced", {})
    figures = (f"{name.replace('_', ' ')} {_figure(value)}" for name, value in stats.items())
    meshes = (
        f"{name}: {n['triangles']} triangles of {n['before']}" for name, n in displaced.items()
    )
    found = [("accelerator", ", ".join(figures)), ("displaced", ", ".join(meshes))]
    return found if displaced else found[:1]


def tree_lines(scene: Scene) -> Iterator[str]:
    """Draw the scene graph, a line for each node."""
    yield "scene"
    yield from _branches(scene.nodes)
    if scene.prototypes:
        yield "prototypes"
        yield from _branches(scene.prototypes)


def _branches(nodes: Mapping[str, Node]) -> Iterator[str]:
    # A stack, not recursion: files may nest deeper than Python may call.
    stack = _siblings("", nodes)
    while stack:
        indent, last, name, node = stack.pop()
        yield f"{indent}{'└── ' if last else '├── '}{name}  {_describe(node)}".rstrip()
        stack += _siblings(indent + ("    " if last else "│   "), node.children)


def _siblings(indent: str, nodes: Mapping[str, Node]) -> list[tuple[str, bool, str, Node]]:
    """Put nodes on a stack, the last one (which ends its branch) at the bottom."""
    last_first = reversed(list(nodes.items()))
    return [(indent, i == 0, name, node) for i, (name, node) in enumerate(last_first)]


def _describe(node: Node) -> str:
    from alight.scene.keyframes import Keyframes

    parts = []
    if node.shape is not None:
        parts.append(node.shape.type_name())
    if node.bsdf is not None:
        parts.append(f"bsdf {node.bsdf if isinstance(node.bsdf, str) else node.bsdf.type_name()}")
    if node.light is not None:
        parts.append(f"light {node.light.type_name()}")
    if node.camera is not None:
        parts.append(f"camera {node.camera.type_name()}")
    if node.instance is not None:
        parts.append(f"instance of {node.instance}")
    steps = [step.name for step in node.transform.steps]
    if isinstance(node.transform, Keyframes):
        parts.append(f"[{len(node.transform.frames)} keyframes]")
    elif steps:
        parts.append(f"[{', '.join(steps)}]")
    return ", ".join(parts)


def _counted(counter: Counter[str]) -> str:
    total = sum(counter.values())
    listed = ", ".join(f"{count} {name}" for name, count in sorted(counter.items()))
    return f"{total} ({listed})" if listed else "0"


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


def _figure(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
