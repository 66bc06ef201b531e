"""A scene in the making: where things are, and what all kinds of scenes contain."""

from __future__ import annotations

from typing import Any

from alight.bsdfs.nesting import scatters_inside
from alight.core.field_types import texture_interval
from alight.core.registry import Models as Registry
from alight.core.spec import Bsdf, Light, Medium, Texture
from alight.lab.random_scenes import bodies, fogs, materials, views
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.views import Point
from alight.scene.description import Node, Scene
from alight.scene.dispersion import disperses_light
from alight.scene.keyframes import keyframes
from alight.scene.transform import IDENTITY, Transform, matrix, rotate, scale, translate
from alight.shapes.rectangle import Rectangle

#: Materials that are drawn for each purpose; then they are used again. Each model of a scene takes
#: its time to compile, so these are few; walls are mostly of one model.
MOST_MATERIALS = {"any_material": 3, "wall": 3}

#: Among things of any material, the share of bodies that scatter light inside, and of strands.
TRANSLUCENT, STRANDS = 0.07, 0.07


class Draft:
    """What a scene has so far.

    Parameters
    ----------
    chance : Chance
        Of which each part takes a source of its own.
    size : (2,) int, pixels, optional
        Of the film; drawn by default.

    Attributes
    ----------
    found_by_chance, closed, edges : bool, bool and (int, int)
        What `views.any_integrator` wants to know of the scene.
    moving : float
        Probability that a thing moves.
    cloudy : bool
        Whether things may have a medium inside.
    walked : bool
        Whether there may be bodies that scatter light inside.
    """

    def __init__(self, chance: Chance, size: tuple[int, int] | None = None) -> None:
        self.chance = chance
        self.size = size
        self.found_by_chance, self.closed, self.edges = True, False, (2, 9)
        self.moving = 0.3 if chance.named("does it move").happens(0.15) else 0.0
        self.cloudy = chance.named("is it cloudy").happens(0.15)
        self.walked = True
        self.camera: Node | None = None
        self.environment: Light | None = None
        self.medium: Medium | str | None = None
        self.nodes: dict[str, Node] = {}
        self.prototypes: dict[str, Node] = {}
        self.bsdfs: dict[str, Bsdf] = {}
        self.media: dict[str, Medium] = {}
        self._pools: dict[str, list[str]] = {}

    def add(self, name: str, **fields: Any) -> None:
        """Put a node into the scene; a number is added to a name that is there already."""
        count = sum(other.partition("-")[0] == name for other in self.nodes)
        self.nodes[f"{name}-{count}" if count else name] = Node(**fields)

    def material(self, role: str) -> str:
        """The name of a material for a purpose: a function of `alight.lab.random_scenes.materials`.

        Some are drawn for each purpose; later ones are among those.
        """
        pool = self._pools.setdefault(role, [])
        chance = self.chance.named(f"{role} {len(self.nodes)}")
        if len(pool) < MOST_MATERIALS.get(role, 1) and (not pool or chance.happens(0.7)):
            name = f"{role.replace('_', '-')}-{len(pool)}"
            self.bsdfs[name] = getattr(materials, role)(chance)
            pool.append(name)
            return name
        return chance.choose(pool)

    def look(self, origin: Point, target: Point, half: float, *, indoors: bool = False) -> None:
        """Place the camera, see `views.any_view`."""
        chance = self.chance.named("camera")
        self.camera = views.any_view(chance, origin, target, half, indoors=indoors)

    def ground(self, role: str = "wall", half: float = 0.0) -> None:
        """Put a plane at y = 0, or a square of a size."""
        up = rotate("x", -90.0)
        if half > 0.0:
            turned = rotate("y", self.chance.named("ground").within(0.0, 90.0))
            where = turned @ up @ scale(half)
            self.add("ground", shape=Rectangle(), bsdf=self.material(role), transform=where)
        else:
            plane = Registry("shapes")["plane"].EXAMPLES[0]
            self.add("ground", shape=plane, bsdf=self.material(role), transform=up)

    def rectangle(
        self, name: str, center: Point, x: Point, y: Point, role: str = "wall", **fields: Any
    ) -> None:
        """Put a rectangle by its centre and half its sides; it faces along x cross y."""
        normal = (
            x[1] * y[2] - x[2] * y[1],
            x[2] * y[0] - x[0] * y[2],
            x[0] * y[1] - x[1] * y[0],
        )
        length = sum(part * part for part in normal) ** 0.5
        rows = [[x[i], y[i], normal[i] / length, center[i]] for i in range(3)]
        where = matrix([*rows, [0.0, 0.0, 0.0, 1.0]])
        fields.setdefault("bsdf", self.material(role))
        self.add(name, shape=Rectangle(), transform=where, **fields)

    def thing(
        self, name: str, at: Point, radius: float, role: str = "any_material", **fields: Any
    ) -> None:
        """Put a body of any shape into a cube, of a material for some purpose.

        Some of those of any material scatter light inside, and some are strands.
        """
        chance = self.chance.named(f"{name} {len(self.nodes)}")
        sort = chance.named("sort").number() if role == "any_material" else 1.0
        if self.walked and sort < TRANSLUCENT:
            role, (shape, fitted) = "translucent", bodies.closed_body(chance)
        elif not self.moving and TRANSLUCENT <= sort < TRANSLUCENT + STRANDS:
            # They bound no media, and stand still.
            role, (shape, fitted) = "fibre", bodies.strands(chance)
        else:
            shape, fitted = bodies.any_body(chance, fields.pop("shapes", None))
        where = self.placed(chance, at, radius, fitted)
        bsdf = self.material(role)
        if self.cloudy and role in ("clear", "any_material") and chance.happens(0.5):
            fields.setdefault("interior", self.inside(chance, radius))
        self.add(name, shape=shape, bsdf=bsdf, transform=where, **fields)

    def placed(
        self, chance: Chance, at: Point, radius: float, first: Transform = IDENTITY
    ) -> Transform:
        """Bring the cube from -1 to 1 to a place: turned, perhaps moving; after `first`."""
        stretch = [radius] * 3
        if chance.happens(0.3):
            stretch = [radius * chance.within(0.5, 1.0) for _ in range(3)]
        if chance.happens(0.1):
            stretch[0] = -stretch[0]
        axis = [chance.within(-1.0, 1.0), chance.within(0.5, 1.0), chance.within(-1.0, 1.0)]
        # From the right to the left, as files do: so their steps give the same bits.
        turned = rotate(axis, chance.within(-180.0, 180.0)) @ (scale(*stretch) @ first)
        if not chance.happens(self.moving):
            return translate(*at) @ turned
        x, y, z = (radius * chance.within(-1.5, 1.5) for _ in range(3))
        end = rotate(axis, chance.within(-120.0, 120.0)) @ turned if chance.happens(0.5) else turned
        there = translate(at[0] + x, at[1] + abs(y), at[2] + z)
        return keyframes({0.0: translate(*at) @ turned, 1.0: there @ end})

    def inside(self, chance: Chance, radius: float) -> str:
        """The name of a medium for the inside of a body."""
        name = f"inside-{len(self.media)}"
        self.media[name] = fogs.any_medium(chance, chance.scaled(0.3, 10.0), 2.0 * radius)
        return name

    def finish(self) -> Scene:
        """The scene, with a film, a sampler and an integrator."""
        textures = self._name_textures()
        used = [node.interior for node in self.nodes.values()] + [self.medium]
        integrator = views.any_integrator(
            self.chance.named("integrator"),
            media=any(medium is not None for medium in used),
            bodies=any(map(scatters_inside, self.bsdfs.values())),
            spreads=any(disperses_light(bsdf, self.bsdfs) for bsdf in self.bsdfs.values()),
            found_by_chance=self.found_by_chance,
            closed=self.closed,
            edges=self.edges,
        )
        assert self.camera is not None
        return Scene(
            camera=self.camera,
            film=views.any_film(self.chance.named("film"), self.size),
            sampler=views.any_sampler(self.chance.named("sampler")),
            integrator=integrator,
            environment=self.environment,
            medium=self.medium,
            textures=textures,
            media=self.media,
            bsdfs=self.bsdfs,
            prototypes=self.prototypes,
            nodes=self.nodes,
        )

    def _name_textures(self) -> dict[str, Texture]:
        """Take some of the materials' textures out and leave their names there."""
        textures: dict[str, Texture] = {}
        for name, bsdf in self.bsdfs.items():
            chance = self.chance.named(f"textures of {name}")
            changes = {}
            for key, value in bsdf:
                takes = texture_interval(type(bsdf), key) is not None
                if takes and isinstance(value, Texture) and chance.happens(0.5):
                    changes[key] = f"{name}-{key.replace('_', '-')}"
                    textures[changes[key]] = value
            self.bsdfs[name] = bsdf.replaced(**changes)
        return textures
