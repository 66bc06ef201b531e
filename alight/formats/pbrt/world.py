"""The directives of the world: where things stand, what they are made of, and the things."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.core.errors import join_path, quote, unknown_name
from alight.formats.pbrt import lights, materials, patterns, textures
from alight.formats.pbrt.attributes import Attributes
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.directives import Directive
from alight.formats.pbrt.making import MaterialItem, default_material, material_name
from alight.formats.pbrt.materials_of_3 import OF_3
from alight.formats.pbrt.media import Media
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.placed import Placed
from alight.formats.pbrt.portals import portal
from alight.formats.pbrt.shapes import convert as convert_shape
from alight.formats.pbrt.shining import GAP, area_of, back_of, has_one_side
from alight.formats.pbrt.stand_ins import STAND_INS
from alight.formats.pbrt.state import State
from alight.formats.pbrt.strands import MOST, Bundle, has_strands
from alight.formats.pbrt.textures import Source, TextureItem
from alight.formats.pbrt.transforms import keeps_angles, moving, steps, swaps_handedness
from alight.formats.reading.context import sees_coordinates
from alight.formats.scenes.lamps import point
from alight.shapes.mesh import Mesh
from alight.shapes.strands import StrandShape

MOST_NAMED = 20
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

#: What converts textures and materials, those that are approximated included.
TEXTURES = textures.COVERED | patterns.PATTERNS
MATERIALS = materials.COVERED | OF_3 | STAND_INS


class World(Attributes):
    """Follows directives, and collects nodes.

    Attributes
    ----------
    nodes : dict of str to dict
        Of the native format.
    environment : dict or None
        The same light from everywhere.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        context.textures, context.materials = TEXTURES, MATERIALS
        self.named: dict[str, MaterialItem] = {}
        self.textures: list[TextureItem] = []
        self.objects: dict[str, str] = {}
        self.nodes: dict[str, Data] = {}
        self.environment: Data | None = None
        self.media = Media(context)
        self.bundles: dict[object, Bundle] = {}
        self._target, self._path = self.nodes, "nodes"

    def begin(self) -> None:
        """Start the world: its space is that of the world."""
        self.state = State(
            default_material(),
            space=self.state.space,
            media=self.state.media,
            textures=self.state.textures,
        )
        self.stack.clear()
        self.systems["world"] = np.eye(4)

    def close(self) -> None:
        """Finish at the end of the file; say what nothing uses."""
        self.tie()
        super().close()
        unused = {
            "textures": [item.directive for item in self.textures if not item.is_read],
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

    # ------------------------------------------------------------ materials, textures, media

    def texture(self, directive: Directive) -> None:
        """Follow Texture."""
        state = self.state
        found = textures.define(
            self.context, directive, self.defaults("texture"), state.textures, state.matrix
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
        window = portal(p)
        if window is not None:
            self.add(self.nodes, "nodes", directive, window)

    # ------------------------------------------------------------ shapes and objects

    def shape(self, directive: Directive) -> None:
        """Follow Shape."""
        context, state = self.context, self.state
        p = Parameters(directive, context.report, self.defaults("shape"))
        bound = textures.bind(context, [*p.named.values()], state.textures, numbers=True)
        bsdf: str | Data = material_name(context, state.material, self.named)
        alpha = Source(context, p, bound).opacity()
        light, both = self.light_of_shape(directive)
        textured = context.holds((bsdf, alpha, light), sees_coordinates)
        sides = (state.reverse, swaps_handedness(state.matrix))
        placed = Placed(context, p, state.matrix, *sides, textured, state.is_animated)
        shape = convert_shape(placed)
        p.finish()
        if shape is None:
            return
        if isinstance(alpha, str | dict) or (alpha is not None and alpha < 1.0):
            opacity = alpha if isinstance(alpha, str | dict) else max(alpha, 0.0)
            bsdf = {"type": "mask", "opacity": opacity, "bsdf": bsdf}
        node: Data = {"shape": shape, "bsdf": bsdf, **self.media.sides(state.media, shape)}
        if alpha is not None and "interior" in node:
            context.report.warn(directive, "is a border of media in its holes too")
        step = steps(placed.matrix)
        if step is not None:
            node["transform"] = step
        if light is not None and alpha == 0.0 and self.unseen(directive, node, light, placed):
            pass
        elif light is not None:
            self.shine(directive, node, light, both, placed.matrix)
        elif directive.type == "curve" and not isinstance(shape, dict) and not placed.moves:
            self.bundle(directive, node, shape)
        else:
            self.add(self._target, self._path, directive, node, self.rests(directive, False))

    def bundle(self, directive: Directive, node: Data, shape: Mesh | StrandShape) -> None:
        """Add a curve to those of the same material, of which there may be a million."""
        context, rest = self.context, {key: node[key] for key in node if key != "shape"}
        look = (shape.type_name(), shape.flip_normals, self.state.matrix.tobytes())
        known = (self._path, *look, repr([node.get(k) for k in ("bsdf", "interior", "exterior")]))
        if known not in self.bundles:
            self.bundles[known] = Bundle(directive, rest)
            if isinstance(shape, Mesh):
                context.report.warn(directive, "and those like it become ribbons of triangles")
        if not self.bundles[known].add(shape):
            context.report.error(directive, f"has over {MOST} triangles or points before it")

    def tie(self) -> None:
        """Add the curves that were collected."""
        for bundle in self.bundles.values():
            self.add(self._target, self._path, bundle.directive, bundle.tied())
        self.bundles.clear()

    def light_of_shape(self, directive: Directive) -> tuple[Data | None, bool]:
        """The light that the shape shines with, and whether from both sides."""
        state, context = self.state, self.context
        if state.light is None:
            return None, False
        if self._target is not self.nodes:
            context.report.warn(directive, "shines in an object: pbrt shows no light there")
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

    def unseen(self, directive: Directive, node: Data, light: Data, placed: Placed) -> bool:
        """Add a light that pbrt 4 does not show, by an opacity of 0; False if it is no sphere."""
        report, shape = self.context.report, node["shape"]
        round_ = isinstance(shape, dict) and shape["type"] == "sphere"
        if self.context.old or not round_ or not keeps_angles(placed.matrix):
            report.warn(directive, "has no opacity, but shines: it is seen here")
            return False
        # From outside a sphere lights as a point does, but for the edges of shadows.
        area = area_of(shape, placed.matrix)
        color, power = light["radiance"], light["power"]
        intensity = [c * (power / np.pi if power > 0.0 else area) / 4.0 for c in color]
        report.warn(directive, "shines without being seen: it becomes a point light")
        center = placed.matrix[:3, 3].tolist()
        node = {"light": point(intensity), "transform": {"translate": center}}
        self.add(self.nodes, "nodes", directive, node)
        return True

    def shine(
        self, directive: Directive, node: Data, light: Data, sides: bool, matrix: np.ndarray
    ) -> None:
        """Add a shape that shines."""
        shape = node["shape"]
        power = light.pop("power")
        if power > 0.0:
            whole = np.pi * area_of(shape, matrix) * (2.0 if sides else 1.0)
            light["radiance"] = [c * power / whole if whole else c for c in light["radiance"]]
        picture = light.pop("picture", None)
        if picture is not None:
            light["radiance"] = {"type": "multiply", "a": picture, "b": light["radiance"]}
        node["light"] = light
        rests = self.rests(directive, True)
        self.add(self.nodes, "nodes", directive, node, rests)
        if sides and not has_one_side(shape):
            text = f"shines from two sides: two surfaces, {GAP:g} of its size apart, are taken"
            self.context.report.warn(directive, text)
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
        self.tie()
        name = self.context.free_name("prototypes", directive.type)
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
        self.tie()
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
        strands = has_strands(self.context.tables["prototypes"], name)
        self.add(self._target, self._path, directive, node, self.rests(directive, False, strands))

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
        name = self.context.free_name(path, wanted)
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
