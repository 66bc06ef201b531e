"""Other materials for the same meshes, chosen by name.

Source: Khronos Group, KHR_materials_variants.
"""

from __future__ import annotations

from alight.core.errors import Issue, SceneError, quote, unknown_name
from alight.formats.gltf.container import Document

NAME = "KHR_materials_variants"


def choose_variant(document: Document, wanted: str | None) -> None:
    """Give primitives the materials that a variant has for them.

    Parameters
    ----------
    document : Document
    wanted : str or None
        Name of the variant; None for the materials that the file shows without one.

    Raises
    ------
    SceneError
        If the file has no such variant.
    """
    table = document.root.extension(NAME)
    names = [] if table is None else [item.text("name") for item in table.objects("variants")]
    if wanted is None:
        if names:
            listed = ", ".join(quote(name) for name in names[:20])
            document.report.drop(f"variants of materials ({listed}): --variant shows one of them")
        return
    if wanted not in names:
        text = "the file has no variants of materials"
        if names:
            text = unknown_name("variant", wanted, names)
        raise SceneError([Issue("--variant", text, document.root.name)])
    number = names.index(wanted)
    for mesh in document.list("meshes"):
        for primitive in mesh.objects("primitives"):
            extension = primitive.extension(NAME)
            for mapping in [] if extension is None else extension.objects("mappings"):
                if number in mapping.indices("variants", len(names), "variants"):
                    count = len(document.list("materials"))
                    material = mapping.index("material", count, "materials")
                    if material is not None:
                        primitive.value["material"] = material
