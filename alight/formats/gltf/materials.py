"""Materials -> `principled`, with what alight has for normal textures, opacity and emission.

Where a number is a product of a factor and a texture, it becomes a `multiply`; the channels that
glTF packs into one picture are taken apart by `channel`.

Source: Khronos Group, glTF 2.0 specification, section 3.9, and the extensions KHR_materials_*.
"""

from __future__ import annotations

from typing import Any

from alight.core.uv_sets import MOST_SETS
from alight.formats.gltf.bodies import SCATTERING, body_of
from alight.formats.gltf.container import Document
from alight.formats.gltf.textures import Data, Textures
from alight.formats.gltf.values import Item
from alight.formats.gltf.vertex_colors import OPACITY_SET, color_channels, opacity_texture
from alight.formats.materials.surfaces import (
    BRIGHTEST,
    LARGEST_IOR,
    Surface,
    abbe_number,
    index_of,
    is_metal,
    reflection,
)
from alight.formats.materials.textures import (
    FLAT_NORMAL,
    between,
    by_vertices,
    channel,
    complement,
    cut,
    multiplied,
    product,
    scaled,
)

ALPHA_MODES = ("OPAQUE", "MASK", "BLEND")
#: Extensions of materials that are read.
COVERED = (
    "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion", "KHR_materials_emissive_strength", "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume", "KHR_materials_volume_scatter", "KHR_materials_pbrSpecularGlossiness",
)  # fmt: skip
GLOSSY = "KHR_materials_pbrSpecularGlossiness"
_BASE = ("baseColorFactor", "baseColorTexture")
_DIFFUSE = ("diffuseFactor", "diffuseTexture")
#: Where textures stand: owner's extension ("" for the material, "pbr" for its core) and keys. Those
#: that turn with the tangents come first.
TEXTURE_KEYS = (
    ("", ("normalTexture",)),
    ("KHR_materials_anisotropy", ("anisotropyTexture",)),
    ("pbr", ("baseColorTexture", "metallicRoughnessTexture")),
    (GLOSSY, ("diffuseTexture", "specularGlossinessTexture")),
    ("", ("emissiveTexture",)),
    (
        "KHR_materials_clearcoat",
        ("clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"),
    ),
    ("KHR_materials_iridescence", ("iridescenceTexture", "iridescenceThicknessTexture")),
    ("KHR_materials_sheen", ("sheenColorTexture", "sheenRoughnessTexture")),
    ("KHR_materials_specular", ("specularTexture", "specularColorTexture")),
    ("KHR_materials_transmission", ("transmissionTexture",)),
)


class Materials:
    """Builds materials, each once for meshes with and without vertex colours."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.textures = Textures(document)
        self._built: dict[tuple[int | None, int], Surface] = {}

    def get(self, index: int | None, channels: int) -> Surface:
        """The material with an index, None being the default one, for vertices with colours.

        Parameters
        ----------
        index : int or None
        channels : int
            Of the colours of the vertices: see `channels`.
        """
        key = (index, channels)
        if key not in self._built:
            self._built[key] = self._build(self._item(index), channels)
        return self._built[key]

    def channels(self, index: int | None, attributes: Item | None) -> int:
        """How many channels of the colours of vertices a material shows: 0, 3 or 4."""
        mode = self._item(index).text("alphaMode", "OPAQUE", ALPHA_MODES)
        return color_channels(self.document, attributes, is_opaque=mode == "OPAQUE")

    def _item(self, index: int | None) -> Item:
        root = self.document.root
        empty = Item({}, "/materials", root.name, root.report)
        return empty if index is None else self.document.list("materials")[index]

    def _build(self, item: Item, channels: int) -> Surface:
        self._say_what_is_dropped(item)
        empty = Item({}, item.at("pbrMetallicRoughness"), item.name, item.report)
        pbr = item.object("pbrMetallicRoughness") or empty
        self.textures.sets = self._sets(item, pbr, has_opacity=channels == 4)
        shiny = item.extension(GLOSSY)
        owner, names = (pbr, _BASE) if shiny is None else (shiny, _DIFFUSE)
        *color, opacity = owner.numbers(names[0], (1.0, 1.0, 1.0, 1.0), 0.0, 1.0)
        picture = self.textures.bitmap(owner, names[1], is_color=True)
        base = multiplied(list(color), picture)
        if channels:
            base = by_vertices(base)
        unlit = item.extension("KHR_materials_unlit") is not None
        bent, inside = None, None
        if unlit:
            self.document.report.approximate(
                "KHR_materials_unlit: such surfaces shine with their colour, and light others"
            )
            core: Data = {"type": "diffuse", "reflectance": 0.0}
        else:
            core = {"type": "principled", "base_color": base}
            core |= self._metal(pbr) if shiny is None else self._glossy(shiny, list(color))
            self._extend(item, core)
            bent = self._bent(item)
        alpha = self._opacity(item, opacity, picture)
        if not unlit:
            inside = body_of(item, core, alpha)
        emission = base if unlit else self._emission(item)
        if emission is not None:
            # What is cut out of a surface does not shine either.
            emission = product(emission, alpha)
            if item.flag("doubleSided"):
                self.document.report.approximate(
                    "doubleSided: what shines does so on its outer side only"
                )
        return Surface(core, bent, alpha, emission, unlit, self.textures.sets, inside=inside)

    def _metal(self, pbr: Item) -> Data:
        picture = self.textures.bitmap(pbr, "metallicRoughnessTexture", is_color=False)
        metallic = pbr.number("metallicFactor", 1.0, 0.0, 1.0)
        roughness = pbr.number("roughnessFactor", 1.0, 0.0, 1.0)
        return {
            "metallic": scaled(metallic, picture, "b"),
            "roughness": scaled(roughness, picture, "g"),
        }

    def _glossy(self, shiny: Item, diffuse: list[float]) -> Data:
        """What the specular colour and the glossiness say, in the place of metal and roughness."""
        picture = self.textures.bitmap(shiny, "specularGlossinessTexture", is_color=True)
        specular = list(shiny.numbers("specularFactor", (1.0, 1.0, 1.0), 0.0, 1.0))
        gloss = scaled(shiny.number("glossinessFactor", 1.0, 0.0, 1.0), picture, "a")
        if is_metal(diffuse, specular):
            metal = multiplied(specular, picture)
            return {"metallic": 1.0, "roughness": complement(gloss), "base_color": metal}
        found = reflection(specular)
        self.document.report.approximate(
            f"{GLOSSY}: becomes a dielectric, which reflects at most {BRIGHTEST:.3g} straight on"
        )
        tint: Any = [min(part, 1.0) for part in found.tint]
        if picture is not None:
            tint = {"type": "clamp", "texture": multiplied(found.tint, picture)}
        return {
            "metallic": 0.0,
            "roughness": complement(gloss),
            "ior": found.ior,
            "specular_color": tint,
        }

    def _bent(self, item: Item) -> Data | None:
        picture = self.textures.bitmap(item, "normalTexture", is_color=False)
        info = item.object("normalTexture")
        if picture is None or info is None:
            return None
        return {"type": "normal_map", "texture": picture, "scale": info.number("scale", 1.0)}

    def _opacity(self, item: Item, opacity: float, picture: Data | None) -> Any:
        """A number or a texture; 1 for what is opaque."""
        mode = item.text("alphaMode", "OPAQUE", ALPHA_MODES)
        cutoff = item.number("alphaCutoff", 0.5, 0.0)
        if mode == "OPAQUE":
            return 1.0
        alpha: Any = scaled(opacity, picture, "a")
        if OPACITY_SET in self.textures.sets:
            of_vertices = opacity_texture(self.textures.sets.index(OPACITY_SET))
            alpha = multiplied(alpha, of_vertices)
        return cut(alpha, cutoff) if mode == "MASK" else alpha

    def _emission(self, item: Item) -> Any:
        factor = item.numbers("emissiveFactor", (0.0, 0.0, 0.0), 0.0)
        extension = item.extension("KHR_materials_emissive_strength")
        strength = extension.number("emissiveStrength", 1.0, 0.0) if extension else 1.0
        color = [strength * c for c in factor]
        picture = self.textures.bitmap(item, "emissiveTexture", is_color=True)
        has_two_sides = item.flag("doubleSided")
        if max(color) == 0.0:
            return None
        if has_two_sides:
            self.document.report.approximate(
                "emission of doubleSided materials: they shine on the outer side alone"
            )
        return multiplied(color, picture)

    def _extend(self, item: Item, bsdf: Data) -> None:
        """Add what the extensions say."""
        add = _Extensions(item, bsdf, self.textures)
        add.ior_and_specular()
        add.transmission_and_volume()
        add.clearcoat_and_sheen()
        add.anisotropy_and_iridescence()

    def _say_what_is_dropped(self, item: Item) -> None:
        report = self.document.report
        if item.has("occlusionTexture"):
            report.drop("occlusionTexture: the light itself is traced")

    def _sets(self, item: Item, pbr: Item, *, has_opacity: bool) -> tuple[int, ...]:
        """The sets of coordinates of all textures, that of the tangents first."""
        used: list[int] = []
        for owner_name, keys in TEXTURE_KEYS:
            owner = {"": item, "pbr": pbr}.get(owner_name) or item.extension(owner_name)
            if owner is not None:
                present = [key for key in keys if owner.has(key)]
                used += [self.textures.coordinates(owner, key) for key in present]
        sets = tuple(dict.fromkeys(used + [OPACITY_SET] * has_opacity))
        if len(sets) > MOST_SETS:
            self.document.report.approximate(
                f"{item.pointer}: its textures use {len(sets)} sets of coordinates, of which "
                f"{MOST_SETS} can be kept; TEXCOORD_{sets[0]} is taken for the rest"
            )
        return sets[:MOST_SETS]


class _Extensions:
    """Adds what the extensions of a material say to a description."""

    def __init__(self, item: Item, bsdf: Data, textures: Textures) -> None:
        self.item = item
        self.bsdf = bsdf
        self.textures = textures

    def _number(
        self, owner: Item, name: str, default: float, channel: str, *, high: float = 1.0
    ) -> Any:
        picture = self.textures.bitmap(owner, f"{name}Texture", is_color=False)
        return scaled(owner.number(f"{name}Factor", default, 0.0, high), picture, channel)

    def _color(self, owner: Item, name: str, default: float) -> Any:
        factor = list(owner.numbers(f"{name}Factor", (default,) * 3, 0.0, 1.0))
        return multiplied(factor, self.textures.bitmap(owner, f"{name}Texture", is_color=True))

    def ior_and_specular(self) -> None:
        """KHR_materials_ior, KHR_materials_specular."""
        ior = self.item.extension("KHR_materials_ior")
        specular = self.item.extension("KHR_materials_specular")
        if ior is not None:
            index = ior.number("ior", 1.5, 0.0)
            if index == 0.0 and specular is not None and self._is_metal(specular):
                return
            if index == 0.0 or index > LARGEST_IOR:
                self.item.report.approximate(f"{ior.pointer}: ior {index:g} became {LARGEST_IOR:g}")
                index = LARGEST_IOR
            elif index < 1.0:
                ior.wrong("ior", f"must be 0 or >= 1, got {index:g}")
                index = 1.0
            self.bsdf["ior"] = index
        if specular is not None:
            self.bsdf["specular"] = self._number(specular, "specular", 1.0, "a")
            factor = specular.numbers("specularColorFactor", (1.0, 1.0, 1.0), 0.0)
            if max(factor) > 1.0:
                factor = self._brighter(specular, factor)
            picture = self.textures.bitmap(specular, "specularColorTexture", is_color=True)
            self.bsdf["specular_color"] = multiplied(list(factor), picture)

    def _is_metal(self, specular: Item) -> bool:
        """Take a specular workflow, which an index of 0 stands for, for a metal if it is one."""
        color = list(specular.numbers("specularColorFactor", (1.0, 1.0, 1.0), 0.0))
        weight = specular.number("specularFactor", 1.0, 0.0, 1.0)
        color = [weight * min(part, 1.0) for part in color]
        if self.bsdf["metallic"] != 0.0 or specular.has("specularTexture"):
            return False
        if not is_metal(self.bsdf["base_color"], color):
            return False
        picture = self.textures.bitmap(specular, "specularColorTexture", is_color=True)
        self.bsdf |= {"metallic": 1.0, "base_color": multiplied(color, picture)}
        return True

    def _brighter(self, specular: Item, factor: tuple[float, ...]) -> tuple[float, ...]:
        """A reflection stronger than that of the index: the index that has it, and the tint left.

        Source: KHR_materials_specular, F0 = min(((n - 1) / (n + 1))^2 specularColor, 1).
        """
        if self.item.extension("KHR_materials_transmission") is not None:
            # Light would be refracted otherwise.
            self.item.report.approximate(f"{specular.pointer}: specularColorFactor was cut to 1")
            return tuple(min(c, 1.0) for c in factor)
        index, most = self.bsdf.get("ior", 1.5), max(factor)
        brightest = index_of(most * ((index - 1.0) / (index + 1.0)) ** 2)
        if brightest > LARGEST_IOR:
            text = f"{specular.pointer}: its reflection became that of index {LARGEST_IOR:g}"
            self.item.report.approximate(text)
        self.bsdf["ior"] = min(brightest, LARGEST_IOR)
        return tuple(c / most for c in factor)

    def transmission_and_volume(self) -> None:
        """KHR_materials_transmission, KHR_materials_volume."""
        transmission = self.item.extension("KHR_materials_transmission")
        if transmission is None:
            self._say_no_part()
            return
        share = self._number(transmission, "transmission", 0.0, "r")
        if share == 0.0:
            self._say_no_part()
            return
        self.bsdf["transmission"] = share
        volume = self.item.extension("KHR_materials_volume")
        thickness = 0.0 if volume is None else volume.number("thicknessFactor", 0.0, 0.0)
        if volume is None or thickness == 0.0:
            self.bsdf["thin"] = True
            return
        if volume.has("thicknessTexture"):
            self.item.report.drop("thicknessTexture: the mesh itself says how thick it is")
        self.bsdf["attenuation_color"] = list(
            volume.numbers("attenuationColor", (1.0, 1.0, 1.0), 0.0, 1.0)
        )
        if volume.has("attenuationDistance"):
            self.bsdf["attenuation_distance"] = volume.number("attenuationDistance", 1.0, 1e-9)
        self._dispersion()

    def _dispersion(self) -> None:
        """KHR_materials_dispersion, of bodies: 20 over Abbe's number."""
        found = self.item.extension("KHR_materials_dispersion")
        strength = 0.0 if found is None else found.number("dispersion", 0.0, 0.0)
        if found is None or strength == 0.0:
            return
        wanted = 20.0 / strength
        number = abbe_number(wanted, self.bsdf.get("ior", 1.5))
        if abs(number - wanted) > 1e-6 * wanted:
            text = f"dispersion {strength:g} became {20.0 / number if number else 0.0:g}"
            self.item.report.approximate(f"{found.pointer}: {text}")
        self.bsdf["dispersion"] = number

    def _say_no_part(self) -> None:
        scatters = self.item.extension(SCATTERING) is not None
        if self.item.extension("KHR_materials_volume") is not None and not scatters:
            text = "KHR_materials_volume: plays no part without transmission"
            self.item.report.drop(text)

    def clearcoat_and_sheen(self) -> None:
        """KHR_materials_clearcoat, KHR_materials_sheen."""
        coat = self.item.extension("KHR_materials_clearcoat")
        if coat is not None:
            self.bsdf["clearcoat"] = self._number(coat, "clearcoat", 0.0, "r")
            self.bsdf["clearcoat_roughness"] = self._number(coat, "clearcoatRoughness", 0.0, "g")
            self._coat_normals(coat)
        sheen = self.item.extension("KHR_materials_sheen")
        if sheen is not None:
            self.bsdf["sheen_color"] = self._color(sheen, "sheenColor", 0.0)
            self.bsdf["sheen_roughness"] = self._number(sheen, "sheenRoughness", 0.0, "a")

    def _coat_normals(self, coat: Item) -> None:
        """Of its texture; without one the coat is smooth, whatever bends the normals below it."""
        picture = self.textures.bitmap(coat, "clearcoatNormalTexture", is_color=False)
        info = coat.object("clearcoatNormalTexture")
        below = self.item.object("normalTexture")
        if picture is not None and info is not None:
            if below is None or below.value != info.value:
                self.bsdf["clearcoat_normal"] = picture
                self.bsdf["clearcoat_normal_scale"] = info.number("scale", 1.0)
        elif below is not None and self.bsdf["clearcoat"] != 0.0:
            self.bsdf["clearcoat_normal"] = FLAT_NORMAL

    def anisotropy_and_iridescence(self) -> None:
        """KHR_materials_anisotropy, KHR_materials_iridescence."""
        turned = self.item.extension("KHR_materials_anisotropy")
        if turned is not None:
            picture = self.textures.bitmap(turned, "anisotropyTexture", is_color=False)
            strength = turned.number("anisotropyStrength", 0.0, 0.0, 1.0)
            self.bsdf["anisotropy"] = scaled(strength, picture, "b")
            self.bsdf["anisotropy_rotation"] = turned.number("anisotropyRotation", 0.0)
            if picture is not None:
                text = "anisotropyTexture: its strength is used, its directions are not"
                self.item.report.approximate(text)
        film = self.item.extension("KHR_materials_iridescence")
        if film is not None:
            self.bsdf["iridescence"] = self._number(film, "iridescence", 0.0, "r")
            self.bsdf["iridescence_ior"] = film.number("iridescenceIor", 1.3, 1.0, LARGEST_IOR)
            thickest = film.number("iridescenceThicknessMaximum", 400.0, 0.0, 1e5)
            thinnest = film.number("iridescenceThicknessMinimum", 100.0, 0.0, 1e5)
            picture = self.textures.bitmap(film, "iridescenceThicknessTexture", is_color=False)
            thickness: Any = thickest
            if picture is not None:
                thickness = between(thinnest, thickest, channel(picture, "g"))
            self.bsdf["iridescence_thickness"] = thickness
