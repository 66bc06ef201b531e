"""The directives of the world: where things stand, what they are made of, and the things."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.core.errors import join_path, quote, unknown_name
from alight.scene.formats.pbrt import lights, materials, textures
from alight.scene.formats.pbrt.colors import SPACES
from alight.scene.formats.pbrt.context import Context, Data
from alight.scene.formats.pbrt.directives import Directive, Parameter
from alight.scene.formats.pbrt.materials import MaterialItem
from alight.scene.formats.pbrt.media import Media
from alight.scene.formats.pbrt.parameters import Parameters
from alight.scene.formats.pbrt.shapes import Placed
from alight.scene.formats.pbrt.shapes import convert as convert_shape
from alight.scene.formats.pbrt.shining import GAP, area_of, back_of, has_one_side
from alight.scene.formats.pbrt.state import State
from alight.scene.formats.pbrt.textures import Source, TextureItem
from alight.scene.formats.pbrt.transforms import (
    look_at,
    moving,
    only_turns,
    rotation,
    scaling,
    steps,
    swaps_handedness,
    translation,
)

MOST_LEVELS, MOST_NAMED = 1000, 20
#: What `alight info` counts.
COUNTED = {
    "AreaLightSource": "area lights",
    "LightSource": "lights",
    "MakeNamedMaterial": "materials",
    "MakeNamedMedium": "media",
    "Material": "materials",
    "ObjectBegin": "objects",
    "ObjectInstance": "instances",
    "Shape": "shapes",
    "Texture": "textures",
}
_TIMES = {"StartTime": (True, False), "EndTime": (False, True), "All": (True, True)}
_TARGETS = ("shape", "light", "material", "medium", "texture")


class World:
    """Follows directives, and collects nodes.

    Attributes
    ----------
    nodes : dict of str to dict
        Of the native format.
    environment : dict or None
        The same light from everywhere.
    systems : dict of str to (4, 4) float64
        Named coordinate systems, to the world.
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self.state = State(materials.default_material())
        self.stack: list[tuple[str, State | tuple, Directive]] = []
        self.systems: dict[str, np.ndarray] = {}
        self.named: dict[str, MaterialItem] = {}
        self.textures: list[TextureItem] = []
        self.objects: dict[str, str] = {}
        self.nodes: dict[str, Data] = {}
        self.environment: Data | None = None
        self.media = Media(context)
        self.times = 0.0, 1.0
        self._target, self._path = self.nodes, "nodes"

    def begin(self) -> None:
        """Start the world: its space is that of the world."""
        self.state = State(
            materials.default_material(),
            space=self.state.space,
            media=self.state.media,
            textures=self.state.textures,
        )
        self.stack.clear()
        self.systems["world"] = np.eye(4)

    def close(self) -> None:
        """Report what was not closed."""
        for _, _, directive in self.stack:
            end = directive.name.replace("Begin", "End")
            self.context.report.error(directive, f"has no {end}")
        unused = {
            "textures": [item.directive for item in self.textures if item.value is None],
            "materials": [i.directive for i in self.named.values() if i.native is None],
        }
        for kind, directives in unused.items():
            names = [quote(directive.texts[0]) for directive in directives]
            if names:
                more = ", ..." if len(names) > MOST_NAMED else ""
                listed = ", ".join(names[:MOST_NAMED])
                self.context.report.drop(f"{kind} that nothing uses are not read: {listed}{more}")

    def follow(self, directive: Directive) -> None:
        """Do what a directive says."""
        self.context.colors.space = self.state.space
        if directive.name in COUNTED:
            self.context.report.count(COUNTED[directive.name])
        _FOLLOW[directive.name](self, directive)

    # ------------------------------------------------------------ transformations

    def append(self, directive: Directive) -> None:
        """Translate, Scale, Rotate, LookAt or ConcatTransform."""
        numbers, name = directive.numbers, directive.name
        matrix: np.ndarray | None
        if name == "Translate":
            matrix = translation(*numbers)
        elif name == "Scale":
            matrix = scaling(*numbers)
        elif name == "Rotate":
            matrix = rotation(float(numbers[0]), numbers[1:])
        elif name == "LookAt":
            matrix = look_at(numbers[:3], numbers[3:6], numbers[6:])
        else:
            matrix = numbers.reshape(4, 4).T
        if matrix is None:
            text = "has no direction: an axis of length 0, or nothing to look at"
            self.context.report.error(directive, text)
        else:
            self.state.append(matrix)

    def set_matrix(self, directive: Directive) -> None:
        """Identity, Transform or CoordSysTransform."""
        if directive.name == "Identity":
            self.state.set_matrix(np.eye(4))
        elif directive.name == "Transform":
            self.state.set_matrix(directive.numbers.reshape(4, 4).T)
        elif directive.type in self.systems:
            self.state.set_matrix(self.systems[directive.type])
        else:
            kind = "coordinate system"
            message = unknown_name(kind, directive.type, self.systems, listed_as="known")
            self.context.report.error(directive, message)

    def name_system(self, directive: Directive) -> None:
        """Follow CoordinateSystem."""
        self.systems[directive.type] = self.state.matrix

    def activate(self, directive: Directive) -> None:
        """Follow ActiveTransform."""
        if directive.type not in _TIMES:
            message = unknown_name("time", directive.type, _TIMES, listed_as="times")
            self.context.report.error(directive, message)
            return
        self.state.changes_start, self.state.changes_end = _TIMES[directive.type]

    def set_times(self, directive: Directive) -> None:
        """Follow TransformTimes."""
        start, end = (float(number) for number in directive.numbers)
        if not start < end:
            text = f"must have an end after its start, got {start:g} and {end:g}"
            self.context.report.error(directive, text)
        else:
            self.times = start, end

    def report_motion(self, directive: Directive) -> None:
        """Warn of what moves while the shutter is open, and does not here."""
        if self.state.is_animated:
            text = "moves: it stands where it is at the start time"
            self.context.report.approximated(directive, text)

    def rests(self, directive: Directive, shines: bool) -> bool:
        """Whether a shape stands still, as one that shines does unless it only shifts and turns."""
        state = self.state
        if shines and state.is_animated and not only_turns(state.matrix, state.ends):
            self.report_motion(directive)
            return True
        return not state.is_animated

    # ------------------------------------------------------------ attributes

    def begin_attributes(self, directive: Directive) -> None:
        """Keep the state."""
        if len(self.stack) >= MOST_LEVELS:
            self.context.report.error(directive, f"is nested deeper than {MOST_LEVELS} levels")
        else:
            self.stack.append(("Attribute", self.state, directive))
            self.state = self.state.copied()

    def end_attributes(self, directive: Directive) -> None:
        """Go back to the state that was kept."""
        kept = self.pop("Attribute", directive)
        if isinstance(kept, State):
            self.state = kept

    def begin_transform(self, directive: Directive) -> None:
        """Keep the transformations; in pbrt 4 it is another word for AttributeBegin."""
        if len(self.stack) >= MOST_LEVELS:
            self.context.report.error(directive, f"is nested deeper than {MOST_LEVELS} levels")
            return
        state = self.state
        kept = (state.matrix, state.ends, state.changes_start, state.changes_end)
        self.stack.append(("Transform", kept, directive))

    def end_transform(self, directive: Directive) -> None:
        """Go back to the transformations that were kept."""
        kept = self.pop("Transform", directive)
        if isinstance(kept, tuple):
            state = self.state
            state.matrix, state.ends, state.changes_start, state.changes_end = kept

    def pop(self, kind: str, directive: Directive) -> State | tuple | None:
        """Take what was kept last, if it is of the kind."""
        if not self.stack or self.stack[-1][0] != kind:
            text = f"has no {kind}Begin before it"
            if self.stack:
                text += f": the last one open is {self.stack[-1][2].name}"
            self.context.report.error(directive, text)
            return None
        return self.stack.pop()[1]

    def set_defaults(self, directive: Directive) -> None:
        """Follow Attribute: parameters for all that follows."""
        if directive.type not in _TARGETS:
            message = unknown_name("target", directive.type, _TARGETS)
            self.context.report.error(directive, message)
            return
        given = {p.name for p in directive.parameters}
        old = [p for p in self.defaults(directive.type) if p.name not in given]
        self.state.defaults = {
            **self.state.defaults,
            directive.type: [*directive.parameters, *old],
        }

    def defaults(self, target: str) -> list[Parameter]:
        """Parameters that ``Attribute`` has set."""
        return self.state.defaults.get(target, [])

    def reverse(self, directive: Directive) -> None:
        """Turn surfaces inside out."""
        self.state.reverse = not self.state.reverse

    def set_space(self, directive: Directive) -> None:
        """Follow ColorSpace."""
        if directive.type in SPACES:
            self.state.space = directive.type
        else:
            message = unknown_name("colour space", directive.type, SPACES)
            self.context.report.error(directive, message)

    # ------------------------------------------------------------ materials, textures, media

    def texture(self, directive: Directive) -> None:
        """Follow Texture."""
        found = textures.define(
            self.context, directive, self.defaults("texture"), self.state.textures
        )
        if found is not None:
            key, item = found
            self.textures.append(item)
            self.state.textures = {**self.state.textures, key: item}
            # In pbrt 4 the names of textures are known everywhere from here on.
            for i, (kind, kept, begin) in enumerate(self.stack):
                if isinstance(kept, State) and not self.context.old:
                    copy = kept.copied()
                    copy.textures = {**kept.textures, key: item}
                    self.stack[i] = (kind, copy, begin)

    def material(self, directive: Directive) -> None:
        """Follow Material or MakeNamedMaterial."""
        defaults = self.defaults("material")
        parameters = [*directive.parameters, *defaults]
        kind, name = directive.type, directive.type or "interface"
        if directive.name == "MakeNamedMaterial":
            found = next((p for p in parameters if p.name == "type" and p.is_text), None)
            kind = found.values[0] if found else ""
            if found is None:
                self.context.report.error(directive, 'needs "string type"')
                kind = "diffuse"
        bound = textures.bind(self.context, parameters, self.state.textures)
        item = MaterialItem(directive, kind, name, defaults, bound, self.state.space)
        if directive.name == "MakeNamedMaterial":
            if name in self.named and not self.context.old:
                first = self.named[name].directive.place
                self.context.report.error(directive, f"is given twice, first at {first}")
            self.named[name] = item
        else:
            self.state.material = item

    def name_material(self, directive: Directive) -> None:
        """Follow NamedMaterial."""
        if directive.type in self.named:
            self.state.material = self.named[directive.type]
        else:
            known = unknown_name(
                "material", directive.type, self.named, listed_as="named materials"
            )
            self.context.report.error(directive, known)

    def medium(self, directive: Directive) -> None:
        """Follow MakeNamedMedium."""
        self.media.define(directive, self.defaults("medium"), self.state.matrix)

    def set_media(self, directive: Directive) -> None:
        """Follow MediumInterface."""
        self.state.media = directive

    # ------------------------------------------------------------ lights

    def area_light(self, directive: Directive) -> None:
        """Follow AreaLightSource."""
        self.state.light = directive
        self.state.light_defaults = self.defaults("light")
        self.state.light_space = self.state.space

    def light(self, directive: Directive) -> None:
        """Follow LightSource."""
        self.report_motion(directive)
        p = Parameters(directive, self.context.report, self.defaults("light"))
        if directive.type == "infinite":
            self.surroundings(directive, p)
        else:
            node = lights.light_node(self.context, p, self.state.matrix)
            if node is not None:
                self.add(self.nodes, "nodes", directive, node)
        p.finish()

    def surroundings(self, directive: Directive, p: Parameters) -> None:
        """Follow an infinite light; they add up, constant ones in one."""
        constant, node = lights.surroundings(self.context, p, self.state.matrix)
        if any(constant):
            before = self.environment["radiance"] if self.environment else [0.0] * 3
            total = [x + y for x, y in zip(before, constant, strict=True)]
            self.environment = {"type": "constant", "radiance": total}
            self.context.places["environment"] = directive.place
        elif node is not None:
            self.add(self.nodes, "nodes", directive, node)

    # ------------------------------------------------------------ shapes and objects

    def shape(self, directive: Directive) -> None:
        """Follow Shape."""
        context, state = self.context, self.state
        p = Parameters(directive, context.report, self.defaults("shape"))
        bound = textures.bind(context, [*p.named.values()], state.textures, numbers=True)
        bsdf: str | Data = materials.material_name(context, state.material, self.named)
        alpha = Source(context, p, bound).number("alpha", None)
        light, sides = self.light_of_shape(directive)
        textured = any(context.sees_coordinates(part) for part in (bsdf, alpha, light))
        mirrored = swaps_handedness(state.matrix)
        placed = Placed(context, p, state.matrix, state.reverse, mirrored, textured)
        shape = convert_shape(placed)
        p.finish()
        if shape is None:
            return
        if isinstance(alpha, str) or (alpha is not None and alpha < 1.0):
            opacity = alpha if isinstance(alpha, str) else max(alpha, 0.0)
            bsdf = {"type": "mask", "opacity": opacity, "bsdf": bsdf}
        node: Data = {"shape": shape, "bsdf": bsdf, **self.media.sides(state.media)}
        if alpha is not None and "interior" in node:
            context.report.approximated(directive, "is a border of media in its holes too")
        step = steps(placed.matrix)
        if step is not None:
            node["transform"] = step
        if light is not None:
            self.shine(directive, node, light, sides, placed.matrix)
        else:
            self.add(self._target, self._path, directive, node, self.rests(directive, False))

    def light_of_shape(self, directive: Directive) -> tuple[Data | None, bool]:
        """The light that the shape shines with, and whether from both sides."""
        state, context = self.state, self.context
        if state.light is None:
            return None, False
        if self._target is not self.nodes:
            text = "shines in an object: pbrt shows no light there"
            context.report.approximated(directive, text)
            return None, False
        if state.light.type not in ("diffuse", "area"):
            text = unknown_name("area light", state.light.type, ("diffuse",))
            context.report.not_covered(state.light, text, "left out")
            return None, False
        context.colors.space = state.light_space
        p = Parameters(state.light, context.report, state.light_defaults)
        light = lights.area_light(context, p)
        sides = p.flag("twosided", False)
        p.finish()
        return light, sides

    def shine(
        self, directive: Directive, node: Data, light: Data, sides: bool, matrix: np.ndarray
    ) -> None:
        """Add a shape that shines."""
        shape = node["shape"]
        power = light.pop("power")
        if power > 0.0:
            whole = np.pi * area_of(shape, matrix) * (2.0 if sides else 1.0)
            light["radiance"] = [c * power / whole if whole else c for c in light["radiance"]]
        node["light"] = light
        rests = self.rests(directive, True)
        self.add(self.nodes, "nodes", directive, node, rests)
        if sides and not has_one_side(shape):
            text = f"shines from two sides: two surfaces, {GAP:g} of its size apart, are taken"
            self.context.report.approximated(directive, text)
            back = back_of(node, matrix)
            # The first of both is the border of media.
            sides_of_media = ("interior", "exterior")
            back = {key: value for key, value in back.items() if key not in sides_of_media}
            self.add(self.nodes, "nodes", directive, back, rests)

    def begin_object(self, directive: Directive) -> None:
        """Follow ObjectBegin."""
        if self._target is not self.nodes:
            self.context.report.error(directive, "stands in another object")
            return
        if directive.type in self.objects:
            self.context.report.error(directive, "is given twice")
        self.begin_attributes(directive)
        name = self.context.name("prototypes", directive.type)
        self.objects[directive.type] = name
        children: dict[str, Data] = {}
        self.context.tables["prototypes"][name] = {"children": children}
        path = join_path("prototypes", name)
        self.context.places[path] = directive.place
        self._target, self._path = children, f"{path}.children"

    def end_object(self, directive: Directive) -> None:
        """Follow ObjectEnd."""
        if self._target is self.nodes:
            self.context.report.error(directive, "has no ObjectBegin before it")
            return
        self._target, self._path = self.nodes, "nodes"
        self.end_attributes(directive)

    def instance(self, directive: Directive) -> None:
        """Follow ObjectInstance."""
        name = self.objects.get(directive.type)
        if name is None:
            message = unknown_name("object", directive.type, self.objects, listed_as="objects")
            self.context.report.error(directive, message)
            return
        node: Data = {"instance": name}
        step = steps(self.state.matrix)
        if step is not None:
            node["transform"] = step
        self.add(self._target, self._path, directive, node, self.rests(directive, False))

    def add(
        self,
        target: dict[str, Data],
        path: str,
        directive: Directive,
        node: Data,
        rests: bool = True,
    ) -> None:
        """Put a node among others, with a name of its own."""
        wanted = quote(directive.type)[1:-1] or directive.name
        name = self.context.name(path, wanted)
        if not rests:
            node = moving(node, wanted, self.state.matrix, self.state.ends, self.times)
        target[name] = node
        self.context.places[join_path(path, name)] = directive.place


_FOLLOW: dict[str, Callable[[World, Directive], None]] = {
    "ActiveTransform": World.activate,
    "AreaLightSource": World.area_light,
    "Attribute": World.set_defaults,
    "AttributeBegin": World.begin_attributes,
    "AttributeEnd": World.end_attributes,
    "ColorSpace": World.set_space,
    "ConcatTransform": World.append,
    "CoordSysTransform": World.set_matrix,
    "CoordinateSystem": World.name_system,
    "Identity": World.set_matrix,
    "LightSource": World.light,
    "LookAt": World.append,
    "MakeNamedMaterial": World.material,
    "MakeNamedMedium": World.medium,
    "Material": World.material,
    "MediumInterface": World.set_media,
    "NamedMaterial": World.name_material,
    "ObjectBegin": World.begin_object,
    "ObjectEnd": World.end_object,
    "ObjectInstance": World.instance,
    "ReverseOrientation": World.reverse,
    "Rotate": World.append,
    "Scale": World.append,
    "Shape": World.shape,
    "Texture": World.texture,
    "Transform": World.set_matrix,
    "TransformBegin": World.begin_transform,
    "TransformEnd": World.end_transform,
    "TransformTimes": World.set_times,
    "Translate": World.append,
}
