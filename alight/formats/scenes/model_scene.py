"""The scene of a file that shows a model: light around it and a camera, where it has none."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

from alight.core.errors import quote
from alight.formats.geometry.bounds import Bounds
from alight.formats.geometry.displacement import Lifting
from alight.formats.materials.steepness import told
from alight.formats.materials.surfaces import Surface
from alight.formats.reading.names import free_name
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.formats.scenes.emission import Glow
from alight.formats.scenes.parsed import Parsed
from alight.formats.scenes.surroundings import (
    add_camera,
    add_floor,
    add_light,
    say_if_empty,
    use_first_camera,
)
from alight.scene.build import FORMAT_VERSION
from alight.scene.transform import Matrix
from alight.shapes.mesh import Mesh

Data = dict[str, Any]
#: Pixels, of pictures whose shape a file's camera decides.
HEIGHT, MOST_WIDTH = 600, 2**14


@dataclass
class ModelScene:
    """A scene in the making.

    Attributes
    ----------
    report : Report
    reach : Reach
        Finds the files that it names.
    places : dict of str to str
        Key path -> place in the file.
    nodes, prototypes, bsdfs : dict
        Descriptions of the native format.
    environment : dict or None
        Light from around.
    cameras : list of (str, float)
        Of each camera the path of its node, and width by height of its picture; the first is shown.
    view : (4, 4) float64 or None
        Camera to world of the first camera.
    bounds : Bounds
        Of all that is seen, in the world.
    glow : Glow
        Of the meshes that shine, but for unlit ones.
    is_lit : bool
        Whether the file has lights.
    lifting : Lifting
        Of the meshes that are displaced.
    """

    report: Report
    reach: Reach
    places: dict[str, str]
    nodes: dict[str, Data] = field(default_factory=dict)
    prototypes: dict[str, Data] = field(default_factory=dict)
    bsdfs: dict[str, Data] = field(default_factory=dict)
    environment: Data | None = None
    cameras: list[tuple[str, float]] = field(default_factory=list)
    view: Matrix | None = None
    bounds: Bounds = field(default_factory=Bounds)
    is_lit: bool = False
    glow: Glow = field(init=False)
    lifting: Lifting = field(init=False)
    _names: dict[Hashable, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Nothing shines yet."""
        self.glow = Glow(self.reach.files)
        self.lifting = Lifting(self.report, {})

    def name_of(self, key: Hashable, surface: Surface, wanted: str, place: str = "") -> str:
        """The name of a material, which is entered at its first use.

        Parameters
        ----------
        key : hashable
            The same for the same material.
        surface : Surface
        wanted : str
            What the file calls it.
        place : str, optional
            Where the file defines it.
        """
        if key not in self._names:
            name = self._names[key] = free_name(wanted, self.bsdfs, "material")
            self.bsdfs[name] = surface.bsdf
            steep = told(surface, self.reach.files)
            if steep:
                self.report.approximate(f"material {quote(wanted)}: {steep}")
            if place:
                self.places[f"bsdfs.{name}"] = place
        return self._names[key]

    def has_named(self, key: Hashable) -> bool:
        """Whether a material has been entered."""
        return key in self._names

    def shine(self, mesh: Mesh, surface: Surface, to_world: Matrix) -> None:
        """Count the light of a mesh, if it shines."""
        if surface.emission is not None and not surface.is_unlit:
            self.glow.add(mesh, to_world, surface.emission)

    def add_camera(self, path: str, aspect: float, view: Matrix) -> None:
        """Note a camera: the path of its node, the shape of its picture, camera to world."""
        self.cameras.append((path, aspect))
        self.view = view if self.view is None else self.view

    def finish(self) -> Parsed:
        """Put the description together, and say what was made up."""
        scene: Data = {"alight": FORMAT_VERSION, "bsdfs": self.bsdfs}
        scene |= {"prototypes": self.prototypes, "nodes": self.nodes}
        if self.lifting.textures:
            scene["textures"] = self.lifting.textures
        if self.environment is not None:
            scene["environment"] = self.environment
        say_if_empty(self.report, self.bounds)
        if not self.is_lit and not self.glow.suffices(self.bounds):
            add_light(scene, self.report, shines=self.glow.total > 0.0, view=self.view)
            if not self.cameras:
                add_floor(self.nodes, self.bounds)
        if not self.cameras:
            add_camera(scene, self.report, self.bounds)
            return Parsed.of(scene, self.places, self.report, framed=self.bounds)
        use_first_camera(scene, self.report, [path for path, _ in self.cameras])
        width = max(1, min(round(HEIGHT * self.cameras[0][1]), MOST_WIDTH))
        scene["film"] = {"size": [width, HEIGHT]}
        return Parsed.of(scene, self.places, self.report)
