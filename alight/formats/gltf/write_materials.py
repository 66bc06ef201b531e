"""Materials -> the words of glTF, as far as it has them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from alight.bsdfs.adapters.normal_map import NormalMap
from alight.bsdfs.disney.principled import Principled
from alight.core.spec import Bsdf, Light, Texture
from alight.formats.gltf.models import as_principled
from alight.formats.gltf.planes import Plane, plane_of
from alight.formats.gltf.store import Json, Store
from alight.formats.gltf.write_textures import TextureWriter
from alight.textures.bitmap import Bitmap
from alight.textures.mix import Mix
from alight.textures.multiply import Multiply
from alight.textures.threshold import Threshold

_BLACK, _WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
_FLAT = (0.5, 0.5, 1.0)


class MaterialWriter:
    """Writes materials into a file.

    Parameters
    ----------
    store : Store
    mirrored : bool
        Whether the world is mirrored, so that what turned to the left turns to the right.
    """

    def __init__(self, store: Store, mirrored: bool) -> None:
        self.store = store
        self.mirrored = mirrored
        self.textures = TextureWriter(store)

    def material(
        self, bsdf: Bsdf, light: Light | None, has_colors: bool
    ) -> tuple[int, frozenset[int], bool]:
        """Write a material.

        Parameters
        ----------
        bsdf : Bsdf
        light : Light or None
            Emission of the surface.
        has_colors : bool
            Whether its mesh has colours at the vertices.

        Returns
        -------
        int
            Its index.
        frozenset of int
            Sets of texture coordinates that it uses.
        bool
            Whether it uses the colours of vertices.
        """
        self.textures.sets, self.textures.has_colors = set(), False
        made = self._surface(bsdf, has_colors)
        if light is not None and "radiance" in dict(light):
            self._emit(_outside(light, bsdf, self.store.lose), made)
        elif light is not None:
            self.store.lose(f"{light.type_name()} light: glTF has no word for it")
        number = self.store.put("materials", made)
        return number, frozenset(self.textures.sets), self.textures.has_colors

    def _surface(self, bsdf: Bsdf, has_colors: bool) -> Json:
        made: Json = {}
        opacity: Any = 1.0
        while "bsdf" in (fields := dict(bsdf)):
            kind = bsdf.type_name()
            if kind == "two_sided":
                made["doubleSided"] = True
            elif kind == "mask" and "alphaMode" not in made:
                opacity = self._cut(fields["opacity"], made)
            elif kind == "normal_map" and isinstance(fields["texture"], Bitmap):
                info = self.textures.normals(fields["texture"])
                made["normalTexture"] = {**info, "scale": fields["scale"]}
                usual = dict(NormalMap(texture=fields["texture"], bsdf=fields["bsdf"]))
                for name in ("rims", "fading", "follow_uv"):
                    if fields[name] != usual[name]:
                        self.store.lose(f"normal_map: its {name}")
            else:
                self.store.lose(f"{kind}: what it does to a material")
            bsdf = fields["bsdf"]
        bsdf, lost = as_principled(bsdf)
        for line in lost:
            self.store.lose(line)
        if isinstance(bsdf, Principled):
            pbr = self._colored(bsdf.base_color, opacity, has_colors)
            self._metal(bsdf, pbr)
            self._extend(bsdf, made)
        else:
            pbr = self._colored(dict(bsdf)["reflectance"], opacity, has_colors)
            pbr["metallicFactor"] = 0.0
            self.store.extension(made, "KHR_materials_specular", {"specularFactor": 0.0})
        return {**made, "pbrMetallicRoughness": pbr}

    def _cut(self, value: Any, made: Json) -> Plane | float:
        """The opacity of a mask, and how the file wants it to be taken."""
        made["alphaMode"] = "BLEND"
        cutoff = None
        if isinstance(value, Threshold):
            cutoff, value = value.cutoff, value.texture
        plane = plane_of(value)
        if plane is None:
            self.store.lose("opacity: its texture became the mean")
            plane = float(value.mean()[1])
        if cutoff is not None:
            made["alphaMode"] = "MASK"
            if not isinstance(plane, Plane):
                made["alphaMode"], plane = "BLEND", float(plane >= cutoff)
            elif plane.factor > 1.0:
                cutoff, plane = cutoff / plane.factor, plane._replace(factor=1.0)
            if made["alphaMode"] == "MASK":
                made["alphaCutoff"] = cutoff
        if plane == 1.0:
            del made["alphaMode"]
        return self.textures.within_one(plane) if isinstance(plane, Plane) else plane

    def _colored(self, value: Any, opacity: Plane | float, has_colors: bool) -> Json:
        """Base colour, its picture, and opacity."""
        factor, info = self.textures.base(value, opacity, has_colors)
        made: Json = {"baseColorTexture": info} if info else {}
        return {**made, "baseColorFactor": [min(c, 1.0) for c in factor]}

    def _metal(self, bsdf: Principled, pbr: Json) -> None:
        metallic, roughness, info = self.textures.pair(bsdf.metallic, bsdf.roughness)
        pbr |= {"metallicFactor": metallic, "roughnessFactor": roughness}
        if info:
            pbr["metallicRoughnessTexture"] = info

    def _extend(self, bsdf: Principled, made: Json) -> None:
        """Extensions for what is not at its default."""
        if bsdf.ior != 1.5:
            self.store.extension(made, "KHR_materials_ior", {"ior": bsdf.ior})
        specular: Json = {}
        if bsdf.specular != 1.0:
            self._number(specular, "specular", bsdf.specular, "a")
        if bsdf.specular_color != _WHITE:
            self._color(specular, "specularColor", bsdf.specular_color)
        if specular:
            self.store.extension(made, "KHR_materials_specular", specular)
        self._add_glass(bsdf, made)
        if bsdf.clearcoat != 0.0:
            coat: Json = {}
            self._number(coat, "clearcoat", bsdf.clearcoat, "r")
            self._number(coat, "clearcoatRoughness", bsdf.clearcoat_roughness, "g")
            self._coat_normals(bsdf, coat, made.get("normalTexture"))
            self.store.extension(made, "KHR_materials_clearcoat", coat)
        if bsdf.sheen_color != _BLACK:
            sheen: Json = {}
            self._color(sheen, "sheenColor", bsdf.sheen_color)
            self._number(sheen, "sheenRoughness", bsdf.sheen_roughness, "a")
            self.store.extension(made, "KHR_materials_sheen", sheen)
        self._add_directions(bsdf, made)
        if not bsdf.compensation:
            self.store.lose("principled: light that met several facets is given back")

    def _coat_normals(self, bsdf: Principled, coat: Json, below: Json | None) -> None:
        """Of its own, or those of what is below it: a file's coat is smooth where it has none."""
        own = bsdf.clearcoat_normal
        if own is None and below is not None:
            coat["clearcoatNormalTexture"] = below
        elif isinstance(own, Bitmap):
            info = self.textures.normals(own)
            coat["clearcoatNormalTexture"] = {**info, "scale": bsdf.clearcoat_normal_scale}
        elif own is not None and own != _FLAT:
            self.store.lose("clearcoat_normal: became the normals of the surface")

    def _add_glass(self, bsdf: Principled, made: Json) -> None:
        if bsdf.transmission == 0.0:
            return
        share: Json = {}
        self._number(share, "transmission", bsdf.transmission, "r")
        self.store.extension(made, "KHR_materials_transmission", share)
        if bsdf.thin:
            return
        volume: Json = {"thicknessFactor": 1.0, "attenuationColor": list(bsdf.attenuation_color)}
        if math.isfinite(bsdf.attenuation_distance):
            volume["attenuationDistance"] = bsdf.attenuation_distance
        self.store.extension(made, "KHR_materials_volume", volume)
        if bsdf.dispersion != 0.0:
            strength = {"dispersion": 20.0 / bsdf.dispersion}
            self.store.extension(made, "KHR_materials_dispersion", strength)

    def _add_directions(self, bsdf: Principled, made: Json) -> None:
        """Anisotropy and the thin film."""
        if bsdf.anisotropy != 0.0:
            angle = self._plain(bsdf.anisotropy_rotation, "anisotropy_rotation")
            turned = {
                "anisotropyStrength": self._plain(bsdf.anisotropy, "anisotropy"),
                "anisotropyRotation": -angle if self.mirrored else angle,
            }
            self.store.extension(made, "KHR_materials_anisotropy", turned)
        if bsdf.iridescence == 0.0:
            return
        film: Json = {"iridescenceIor": bsdf.iridescence_ior}
        self._number(film, "iridescence", bsdf.iridescence, "r")
        thickness = bsdf.iridescence_thickness
        ends = (0.0, 1.0)
        if isinstance(thickness, Mix) and not isinstance(thickness.a, Texture | str):
            ends = (plane_of(thickness.a), plane_of(thickness.b))
        if isinstance(thickness, Mix) and all(isinstance(end, float) for end in ends):
            low, high = (float(end) for end in ends if isinstance(end, float))
            share, info = self.textures.number(thickness.weight, "g")
            # The file's picture has no factor; without a picture the maximum counts.
            high = low + share * (high - low)
            film |= {"iridescenceThicknessMinimum": low, "iridescenceThicknessMaximum": high}
            if info:
                film["iridescenceThicknessTexture"] = info
        else:
            film["iridescenceThicknessMaximum"] = self._plain(thickness, "iridescence_thickness")
        self.store.extension(made, "KHR_materials_iridescence", film)

    def _number(self, owner: Json, name: str, value: Any, channel: str) -> None:
        factor, info = self.textures.number(value, channel)
        owner[f"{name}Factor"] = factor
        if info:
            owner[f"{name}Texture"] = info

    def _color(self, owner: Json, name: str, value: Any) -> None:
        factor, info = self.textures.color(value)
        owner[f"{name}Factor"] = list(factor)
        if info:
            owner[f"{name}Texture"] = info

    def _plain(self, value: Any, name: str) -> float:
        if isinstance(value, Texture):
            self.store.lose(f"{name}: its texture became the mean")
            return value.mean()[1]
        return float(value)

    def _emit(self, radiance: Any, made: Json) -> None:
        factor, info = self.textures.color(radiance)
        strength = max(*factor, 1.0)
        made["emissiveFactor"] = [c / strength for c in factor]
        if info:
            made["emissiveTexture"] = info
        if strength > 1.0:
            content = {"emissiveStrength": strength}
            self.store.extension(made, "KHR_materials_emissive_strength", content)


def _outside(light: Light, bsdf: Bsdf, lose: Callable[[str], None]) -> Any:
    """What a surface would send out if nothing were cut out of it: glTF cuts that, too."""
    radiance = dict(light)["radiance"]
    while (fields := dict(bsdf)).get("bsdf") is not None and bsdf.type_name() != "mask":
        bsdf = fields["bsdf"]
    share = fields.get("opacity", 1.0) if bsdf.type_name() == "mask" else 1.0
    if isinstance(share, float):
        return radiance if share in (0.0, 1.0) else _divided(radiance, share)
    if isinstance(radiance, Multiply) and radiance.b == share:
        return radiance.a
    lose("emission: it is cut out with the surface")
    return radiance


def _divided(radiance: Any, share: float) -> Any:
    if isinstance(radiance, tuple):
        return tuple(channel / share for channel in radiance)
    if isinstance(radiance, Multiply) and isinstance(radiance.a, tuple):
        return radiance.replaced(a=tuple(channel / share for channel in radiance.a))
    return Multiply(a=1.0 / share, b=radiance)
