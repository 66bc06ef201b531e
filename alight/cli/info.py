"""``alight info``: what a scene holds, its memory, its tree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from alight.cli import arguments
from alight.cli.reporting import show_remarks

if TYPE_CHECKING:
    from alight.scene import FlatScene, Node, Scene


def info(
    scene: Annotated[str, typer.Argument(help="Scene file, or a built-in name.")],
    tree: Annotated[
        bool, typer.Option("--tree", help="Show the scene graph and the cost of the BVH.")
    ] = False,
    assignments: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Change a key first.")
    ] = None,
    camera: arguments.CameraName = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    root: arguments.Root = None,
) -> None:
    """Show a scene's contents without rendering it."""
    from alight.cli.loading import load_scene
    from alight.cli.options import changes_of
    from alight.scene import flatten

    changes = changes_of({"camera": camera}, assignments or [])
    description = load_scene(scene, changes, define=define, lenient=lenient, root=root)
    flat = flatten(description)
    for name, value in facts(description, flat):
        typer.echo(f"{name:<13}{value}")
    if tree:
        typer.echo(f"{'accelerator':<13}{accelerator_facts(flat)}")
        for line in tree_lines(description):
            typer.echo(line)
    show_remarks(description)
    for note in flat.notes:
        typer.echo(f"approximated: {note}", err=True)
    for note in energy_notes(flat):
        typer.echo(f"note: {note}", err=True)


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
    from alight.bsdfs.nesting import leaves
    from alight.core.registry import Models

    names = {leaf.bsdf.type_name() for bsdf in flat.bsdfs for leaf in leaves(bsdf)}
    most = {name: getattr(Models("bsdfs")[name], "MOST_SENT_OUT", 1.0) for name in sorted(names)}
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


def accelerator_facts(flat: FlatScene) -> str:
    """Build the acceleration structure and say its figures."""
    from alight.compiled.scene import compile_scene

    stats = compile_scene(flat).stats
    return ", ".join(f"{name.replace('_', ' ')} {_figure(value)}" for name, value in stats.items())


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
