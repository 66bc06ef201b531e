"""Keys and extensions of a glTF file that nobody reads: misspelt ones above all.

The format allows keys of any name, so they are no errors; but they are reported.

Source: Khronos Group, glTF 2.0 specification, section 5, and the extensions that are read.
"""

from __future__ import annotations

import difflib
from typing import Any

from alight.core.errors import quote
from alight.formats.reading.report import Report, did_you_mean

#: Kind of object -> its keys -> the kind of what stands there: "" for plain values.
_INFO = {"index": "", "texCoord": ""}
KINDS: dict[str, dict[str, str]] = {
    "file": {
        "accessors": "accessor", "animations": "", "asset": "asset", "buffers": "buffer",
        "bufferViews": "bufferView", "cameras": "camera", "extensionsRequired": "",
        "extensionsUsed": "", "images": "image", "materials": "material", "meshes": "mesh",
        "nodes": "node", "samplers": "sampler", "scene": "", "scenes": "scene", "skins": "skin",
        "textures": "texture",
    },
    "accessor": dict.fromkeys(
        ("bufferView", "byteOffset", "componentType", "count", "max", "min", "name", "normalized",
         "type"), "",
    ) | {"sparse": "sparse"},
    "asset": dict.fromkeys(("copyright", "generator", "minVersion", "version"), ""),
    "buffer": dict.fromkeys(("byteLength", "name", "uri"), ""),
    "bufferView": dict.fromkeys(
        ("buffer", "byteLength", "byteOffset", "byteStride", "name", "target"), ""
    ),
    "camera": {"name": "", "orthographic": "lens", "perspective": "lens", "type": ""},
    "image": dict.fromkeys(("bufferView", "mimeType", "name", "uri"), ""),
    "lens": dict.fromkeys(("aspectRatio", "xmag", "yfov", "ymag", "zfar", "znear"), ""),
    "light": dict.fromkeys(("color", "intensity", "name", "range", "type"), "") | {"spot": "cone"},
    "cone": {"innerConeAngle": "", "outerConeAngle": ""},
    "material": {
        "alphaCutoff": "", "alphaMode": "", "doubleSided": "", "emissiveFactor": "",
        "emissiveTexture": "info", "name": "", "normalTexture": "normal",
        "occlusionTexture": "occlusion", "pbrMetallicRoughness": "pbr",
    },
    "mesh": {"name": "", "primitives": "primitive", "weights": ""},
    "node": dict.fromkeys(
        ("camera", "children", "matrix", "mesh", "name", "rotation", "scale", "skin",
         "translation", "weights"), "",
    ),
    "pbr": {
        "baseColorFactor": "", "baseColorTexture": "info", "metallicFactor": "",
        "metallicRoughnessTexture": "info", "roughnessFactor": "",
    },
    "primitive": dict.fromkeys(("attributes", "indices", "material", "mode", "targets"), ""),
    "sampler": dict.fromkeys(("magFilter", "minFilter", "name", "wrapS", "wrapT"), ""),
    "scene": {"name": "", "nodes": ""},
    "skin": dict.fromkeys(("inverseBindMatrices", "joints", "name", "skeleton"), ""),
    "sparse": {"count": "", "indices": "sparse view", "values": "sparse view"},
    "sparse view": {"bufferView": "", "byteOffset": "", "componentType": ""},
    "mapping": {"material": "", "name": "", "variants": ""},
    "variant": {"name": ""},
    "texture": {"name": "", "sampler": "", "source": ""},
    "info": _INFO,
    "normal": _INFO | {"scale": ""},
    "occlusion": _INFO | {"strength": ""},
}  # fmt: skip
#: Extension -> the kind of its owner -> its keys, with the kinds of what stands there.
EXTENSIONS: dict[str, dict[str, dict[str, str]]] = {
    "EXT_mesh_gpu_instancing": {"node": {"attributes": ""}},
    "KHR_materials_variants": {
        "file": {"variants": "variant"}, "primitive": {"mappings": "mapping"},
    },
    "EXT_texture_webp": {"texture": {"source": ""}},
    "KHR_draco_mesh_compression": {"primitive": {"attributes": "", "bufferView": ""}},
    "KHR_lights_punctual": {"file": {"lights": "light"}, "node": {"light": ""}},
    "KHR_texture_transform": {
        kind: dict.fromkeys(("offset", "rotation", "scale", "texCoord"), "")
        for kind in ("info", "normal", "occlusion")
    },
} | {
    f"KHR_materials_{name}": {"material": dict.fromkeys(plain.split(), "") | pictures}
    for name, plain, pictures in (
        ("anisotropy", "anisotropyRotation anisotropyStrength", {"anisotropyTexture": "info"}),
        (
            "clearcoat",
            "clearcoatFactor clearcoatRoughnessFactor",
            {"clearcoatTexture": "info", "clearcoatRoughnessTexture": "info",
             "clearcoatNormalTexture": "normal"},
        ),
        (
            "diffuse_transmission",
            "diffuseTransmissionFactor diffuseTransmissionColorFactor",
            {"diffuseTransmissionTexture": "info", "diffuseTransmissionColorTexture": "info"},
        ),
        ("emissive_strength", "emissiveStrength", {}),
        ("dispersion", "dispersion", {}),
        ("ior", "ior", {}),
        (
            "iridescence",
            ("iridescenceFactor iridescenceIor iridescenceThicknessMaximum "
             "iridescenceThicknessMinimum"),
            {"iridescenceTexture": "info", "iridescenceThicknessTexture": "info"},
        ),
        (
            "pbrSpecularGlossiness",
            "diffuseFactor glossinessFactor specularFactor",
            {"diffuseTexture": "info", "specularGlossinessTexture": "info"},
        ),
        (
            "sheen",
            "sheenColorFactor sheenRoughnessFactor",
            {"sheenColorTexture": "info", "sheenRoughnessTexture": "info"},
        ),
        (
            "specular",
            "specularColorFactor specularFactor",
            {"specularColorTexture": "info", "specularTexture": "info"},
        ),
        ("transmission", "transmissionFactor", {"transmissionTexture": "info"}),
        ("unlit", "", {}),
        (
            "volume",
            "attenuationColor attenuationDistance thicknessFactor",
            {"thicknessTexture": "info"},
        ),
        ("volume_scatter", "multiscatterColor scatterAnisotropy", {}),
    )
}  # fmt: skip
#: Refused or reported where they are read.
_ELSEWHERE = (
    "EXT_meshopt_compression", "EXT_texture_avif",
    "KHR_texture_basisu", "MSFT_texture_dds",
)  # fmt: skip
#: What every object may have.
_ALWAYS = ("extensions", "extras")


def say_what_is_unknown(document: Any, report: Report) -> None:
    """List keys and extensions that play no part, each kind of place once.

    Parameters
    ----------
    document : dict
        The JSON; its readers report what else is wrong with it.
    report : Report
    """
    said: set[tuple[str, str]] = set()
    stack: list[tuple[Any, str, dict[str, str], str]] = [(document, "file", KINDS["file"], "")]
    while stack:
        value, kind, keys, pointer = stack.pop()
        if isinstance(value, list):
            stack += [(v, kind, keys, f"{pointer}/{i}") for i, v in enumerate(value)][::-1]
        if not isinstance(value, dict):
            continue
        for key, inner in value.items():
            if key in keys:
                if keys[key]:
                    stack.append((inner, keys[key], KINDS[keys[key]], f"{pointer}/{key}"))
            elif key not in _ALWAYS and (kind, key) not in said:
                said.add((kind, key))
                hint = did_you_mean(key, keys)
                report.approximate(f"{pointer or '/'}: unknown key {quote(key)} was left out{hint}")
        found = value.get("extensions")
        for name, inner in found.items() if isinstance(found, dict) else ():
            owners = EXTENSIONS.get(name, {})
            if kind in owners:
                place = f"{pointer}/extensions/{name}"
                stack.append((inner, f"{kind} {name}", owners[kind], place))
            elif name not in _ELSEWHERE and (kind, name) not in said:
                said.add((kind, name))
                report.approximate(left_out(name))


def left_out(name: str) -> str:
    """The remark on an extension that is not read."""
    # Other extensions have names that are alike, too: only a misspelling is nearer than this.
    near = difflib.get_close_matches(name[:80], EXTENSIONS, n=1, cutoff=0.93)
    hint = f'; did you mean "{near[0]}"?' if near and near[0] != name else ""
    return f"{quote(name)[1:-1]} is not covered and was left out{hint}"
