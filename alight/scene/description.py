"""The scene as data: nodes in a tree, named materials, camera, film, sampler, integrator.

All of it is immutable. `alight.scene.manager.SceneManager` edits scenes, and
`alight.scene.flatten` resolves names and composes transforms for the compiler.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, PrivateAttr, model_validator
from pydantic_core import core_schema

from alight.core.errors import quote, show_value
from alight.core.field_types import NestedBsdf
from alight.core.fields import Interval, Model, Numbers, invalid
from alight.core.registry import default_of, specs_of
from alight.core.spec import (
    Bsdf,
    Camera,
    Filter,
    Integrator,
    Light,
    Medium,
    Sampler,
    Shape,
    Spec,
    Texture,
)
from alight.media.coefficients import shines
from alight.outputs import html
from alight.scene.files import Files
from alight.scene.source import Memory, Source
from alight.scene.transform import IDENTITY, Transform

MOST_PIXELS = 2**28


@dataclass(frozen=True)
class TransformField:
    """Metadata of a field that holds a `Transform`."""

    def check(self, value: object) -> Transform:
        """Accept transforms only."""
        if not isinstance(value, Transform):
            raise invalid(f"must be a transform, got {show_value(value)}")
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


@dataclass(frozen=True)
class Named:
    """Metadata of a field that maps names to descriptions.

    Parameters
    ----------
    kind : str
        What the values are, in messages.
    family : str
        Package of their models; empty for nodes.
    """

    kind: str
    family: str = ""

    def check(self, value: object) -> dict[str, Any]:
        """Copy a mapping whose names and values are right."""
        if not isinstance(value, Mapping):
            raise invalid(f"must map names to {self.kind}s, got {show_value(value)}")
        for name, item in value.items():
            problem = name_problem(name)
            if problem:
                raise invalid(problem)
            if not isinstance(item, Spec) or item.family != self.family:
                raise invalid(f"{name} must be a {self.kind}, got {show_value(item)}")
        return dict(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


def name_problem(name: object) -> str | None:
    """Say what is wrong with a name: it must fit into key paths and node paths."""
    if not isinstance(name, str):
        return f"names must be texts, got {show_value(name)}"
    if not 0 < len(name) <= 100 or name != name.strip() or not name.isprintable():
        return f"names must have 1 to 100 printable characters, got {quote(name)}"
    if set(name) & set("/.[]="):
        return f"names must not contain any of / . [ ] =, got {quote(name)}"
    return None


class FilmSettings(Spec):
    """What the picture is.

    Parameters
    ----------
    size : (2,) int, pixels, default (512, 512)
        Width and height; at most 2^28 pixels together.
    crop : (4,) int, pixels, optional
        x, y, width, height of the part that is rendered; y grows downwards from the top.
    filter : Filter, default Box()
        Pixel filter.
    replicates : int in [1, 64], default 4
        Independently scrambled parts of the samples, from which errors are estimated.
    """

    family: ClassVar[str] = "film"
    kind: ClassVar[str] = "film"

    size: Annotated[tuple[int, int], Numbers(2, Interval(1, MOST_PIXELS, integer=True))] = (
        512,
        512,
    )
    crop: (
        Annotated[tuple[int, int, int, int], Numbers(4, Interval(0, MOST_PIXELS, integer=True))]
        | None
    ) = None
    filter: Annotated[Filter, Model("filter", "filters")] = default_of(Filter)
    replicates: Annotated[int, Interval(1, 64, integer=True)] = 4

    @model_validator(mode="after")
    def _crop_lies_inside(self) -> Self:
        width, height = self.size
        if width * height > MOST_PIXELS:
            raise invalid(f"size must be at most {MOST_PIXELS} pixels, got {width} x {height}")
        if self.crop is not None:
            x, y, w, h = self.crop
            if w < 1 or h < 1 or x + w > width or y + h > height:
                raise invalid(
                    f"crop [x, y, width, height] must lie inside {width} x {height} "
                    f"and be at least 1 x 1, got {list(self.crop)}"
                )
        return self

    @classmethod
    def type_name(cls) -> str:
        """Name the key of scene files."""
        return "film"


NestedMedium = Annotated[Medium | str, Model("medium", "media", named=True)]

#: Name of the medium that is none.
VACUUM = "vacuum"


class Node(Spec):
    """A place in the scene graph, with its contents.

    Parameters
    ----------
    transform : Transform, default identity
        From this node's space to its parent's.
    shape : Shape, optional
        Surface.
    bsdf : Bsdf or str, optional
        Material, described or named; a node without one takes its parent's, at the top Diffuse().
    light : Light, optional
        Area light: the shape shines. Others sit at the node's origin.
    camera : Camera, optional
        Viewpoint, looking along -z.
    interior, exterior : Medium or str, optional
        Media on the inner and outer side of the shape, described or named, or "vacuum". A shape
        with either is a border; then the other one is vacuum inside, the scene's medium outside.
    instance : str, optional
        Name of a prototype to put here.
    children : dict of str to Node, optional
        Nodes that move along.
    """

    kind: ClassVar[str] = "node"

    transform: Annotated[Transform, TransformField()] = IDENTITY
    shape: Annotated[Shape, Model("shape", "shapes")] | None = None
    bsdf: NestedBsdf | None = None
    light: Annotated[Light, Model("light", "lights")] | None = None
    camera: Annotated[Camera, Model("camera", "cameras")] | None = None
    interior: NestedMedium | None = None
    exterior: NestedMedium | None = None
    instance: str | None = None
    children: Annotated[dict[str, Node], Named("node")] = {}

    def walk(self, path: str, keys: str) -> Iterator[tuple[str, str, Node]]:
        """Visit this node and all below: node path, key path, node."""
        stack = [(path, keys, self)]
        while stack:
            path, keys, node = stack.pop()
            yield path, keys, node
            if node.children:
                stack.extend(
                    (f"{path}/{name}", f"{keys}.children.{name}", child)
                    for name, child in reversed(node.children.items())
                )


NO_LIGHT = "the scene has no light: the picture will be black"


@dataclass(frozen=True)
class CameraField:
    """Metadata of the field that holds a placed camera or the path of a camera node."""

    def check(self, value: object) -> Node | str:
        """Accept a node with a camera, a camera, or a path."""
        if isinstance(value, Camera):
            return Node(camera=value)
        if isinstance(value, str) or (isinstance(value, Node) and value.camera is not None):
            return value
        raise invalid(f"must be a camera or the path of a node with one, got {show_value(value)}")

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


class Scene(Spec):
    """Everything that decides a picture.

    Parameters
    ----------
    camera : Node, Camera or str
        Viewpoint: a node with a camera, a camera at the origin, or the path of a node with one.
    film : FilmSettings, optional
        The picture's size and filter.
    sampler : Sampler, default Sobol()
        Source of random numbers.
    integrator : Integrator, optional
        Algorithm: by default volpath where the scene has media, path where not.
    environment : Light, optional
        Light from infinity.
    medium : Medium or str, optional
        What fills the space around all shapes, the camera included; empty by default.
    textures, bsdfs, media : dict, optional
        Textures, materials and media that others refer to by name.
    prototypes : dict of str to Node, optional
        Trees of nodes for instances; they are rendered only where a node instances them.
    nodes : dict of str to Node, optional
        Roots of the scene graph.
    """

    camera: Annotated[Node | str, CameraField()] | None = None
    film: Annotated[FilmSettings, Model("film", "film")] = FilmSettings()
    sampler: Annotated[Sampler, Model("sampler", "samplers")] = default_of(Sampler)
    integrator: Annotated[Integrator, Model("integrator", "integrators")] = Field(
        # Only when asked: integrators are above the scene in the order of imports.
        default_factory=lambda: default_of(Integrator)
    )
    environment: Annotated[Light, Model("light", "lights")] | None = None
    medium: NestedMedium | None = None
    textures: Annotated[dict[str, Texture], Named("texture", "textures")] = {}
    media: Annotated[dict[str, Medium], Named("medium", "media")] = {}
    bsdfs: Annotated[dict[str, Bsdf], Named("bsdf", "bsdfs")] = {}
    prototypes: Annotated[dict[str, Node], Named("node")] = {}
    nodes: Annotated[dict[str, Node], Named("node")] = {}
    _source: Source = PrivateAttr(default_factory=Source)
    _memory: Memory = PrivateAttr(default_factory=Memory)
    _checked: Files | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _default_sees_media(self) -> Self:
        if "integrator" not in self.model_fields_set and next(self.used_media(), None):
            # The description is new and frozen only for others.
            sees_media = next(spec for spec in specs_of(Integrator).values() if spec.sees_media)
            object.__setattr__(self, "integrator", sees_media())
        return self

    def used_media(self) -> Iterator[tuple[str, Medium | str]]:
        """Visit what shapes, the camera and the scene name as their media: key path and medium."""
        found = [("medium", self.medium)]
        camera = self.camera.camera if isinstance(self.camera, Node) else None
        found.append(("camera.medium", camera and camera.medium))
        roots = [(f"prototypes.{name}", node) for name, node in self.prototypes.items()]
        roots += [(f"nodes.{name}", node) for name, node in self.nodes.items()]
        for keys, root in roots:
            for _, path, node in root.walk("", keys):
                if node.camera is not None:
                    found.append((f"{path}.camera.medium", node.camera.medium))
                if node.interior is not None or node.exterior is not None:
                    found.append((f"{path}.interior", node.interior))
                    found.append((f"{path}.exterior", node.exterior))
        yield from ((path, medium) for path, medium in found if medium not in (None, VACUUM))

    @property
    def source(self) -> Source:
        """Where the scene came from."""
        return self._source

    @property
    def memory(self) -> Memory:
        """What the scenes share that were made from one another."""
        return self._memory

    def made_from(self, other: Scene) -> Scene:
        """Copy the scene, with the origin and the memory of another."""
        copy = self.from_source(other.source)
        copy._memory = other.memory
        return copy

    def replaced(self, **changes: Any) -> Self:
        """Make a checked copy with some fields changed; it has no origin."""
        copy = super().replaced(**changes)
        copy._memory = self._memory
        return copy

    def from_source(self, source: Source) -> Scene:
        """Copy the scene, with another origin."""
        copy = self.model_copy()
        copy._source, copy._checked = source, None
        return copy

    @property
    def checked(self) -> Files | None:
        """The files by which the scene was found to be right; None where nobody has looked yet."""
        return self._checked

    def mark_checked(self, files: Files) -> None:
        """Note that nothing is wrong with the scene, whose files are these: it never changes."""
        self._checked = files

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is legal but suspicious, in words."""
        return self.source.remarks.warnings + (() if self._is_lit() else (NO_LIGHT,))

    def _is_lit(self) -> bool:
        if not self.integrator.needs_light:
            return True
        nodes = [node for _, _, node in self.walk()]
        used = {node.instance for node in nodes}
        # Prototypes inside prototypes: follow names until no new one turns up.
        names = list(used)
        while names:
            prototype = self.prototypes.get(names.pop() or "")
            for _, _, node in prototype.walk("", "") if prototype else ():
                nodes.append(node)
                if node.instance not in used:
                    used.add(node.instance)
                    names.append(node.instance)
        lights = [self.environment, *(node.light for node in nodes)]
        return any(light is not None and not light.is_black for light in lights) or self._glows()

    def _glows(self) -> bool:
        """Whether one of the media adds light."""
        used = (self.media.get(m) if isinstance(m, str) else m for _, m in self.used_media())
        return any(medium is not None and shines(medium) for medium in used)

    def walk(self) -> Iterator[tuple[str, str, Node]]:
        """Visit all nodes of the graph, parents first: node path, key path, node."""
        for name, node in self.nodes.items():
            if node.children:
                yield from node.walk(name, f"nodes.{name}")
            else:  # as most of many instances
                yield name, f"nodes.{name}", node

    def _facts(self) -> list[tuple[str, str]]:
        width, height = self.film.size
        return [
            ("film", f"{width}x{height} pixels"),
            ("integrator", self.integrator.type_name()),
            ("nodes", f"{sum(1 for _ in self.walk())}"),
            ("materials", f"{len(self.bsdfs)} with a name"),
            ("surroundings", self.environment.type_name() if self.environment else "dark"),
        ]

    def __repr__(self) -> str:
        """Say in a line what it holds: meshes may have millions of numbers."""
        return f"<Scene: {', '.join(f'{name} {value}' for name, value in self._facts())}>"

    def _repr_html_(self) -> str:
        """Show in a notebook what it holds; `alight.info` tells more."""
        return html.division(html.table(self._facts()), html.preformatted(self.warnings))

    def __eq__(self, other: object) -> bool:
        """Compare what the scenes describe, not where they came from."""
        return isinstance(other, Scene) and dict(self) == dict(other)

    __hash__ = None  # pyright: ignore[reportAssignmentType]
