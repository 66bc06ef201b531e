"""Documents of MaterialX that the layers of a stage refer to, as layers of their own.

OpenUSD's package for Python does not read them. Each becomes a layer in memory with a prim for each
material, where its own plug-in would have put it: ``/MaterialX/Materials/NAME``. The material
itself is read from the document.

Source: Pixar, OpenUSD documentation, UsdMtlx.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from alight.core.errors import SceneError
from alight.formats.materialx.document import Document, Material
from alight.formats.materialx.scene import decoded
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import Reach, UnreadableError
from alight.formats.reading.report import Report
from alight.formats.reading.xml import MOST_BYTES
from alight.formats.usd.modules import Sdf, Tf

SUFFIX = ".mtlx"
#: Where a prim keeps the document that its material is read from, and its name there.
DOCUMENT, NAME = "alightDocument", "alightMaterial"


class Documents:
    """Reads documents, each once.

    Parameters
    ----------
    reach : Reach
    report : Report
    """

    def __init__(self, reach: Reach, report: Report) -> None:
        self.reach, self.report = reach, report
        self._materials: dict[str, dict[str, Material]] = {}

    def layer(self, path: Path) -> Any:
        """A layer with the materials of a document.

        Raises
        ------
        SceneError, UnreadableError
            If it is no document, or cannot be read.
        """
        name = str(path)
        text = decoded(content_of(path, MOST_BYTES), name)
        document = Document(text, name, path.parent, self.reach, self.report)
        materials = {material.name: material for material in document.materials()}
        self._materials[name] = materials
        layer = Sdf.Layer.CreateAnonymous(f"{path.stem}.usda")
        for material in materials:
            identifier = Tf.MakeValidIdentifier(material)
            prim = Sdf.CreatePrimInLayer(layer, f"/MaterialX/Materials/{identifier}")
            prim.specifier, prim.typeName = Sdf.SpecifierDef, "Material"
            prim.customData = {DOCUMENT: name, NAME: material}
        for scope in ("/MaterialX", "/MaterialX/Materials"):
            if (prim := layer.GetPrimAtPath(scope)) is not None:
                prim.specifier = Sdf.SpecifierDef
        layer.defaultPrim = "MaterialX"
        return layer

    def material(self, prim: Any) -> Material | None:
        """The material of a prim that stands for one of a document."""
        named = prim.GetCustomDataByKey(DOCUMENT)
        if not named:
            return None
        found = self._materials.get(str(named), {})
        return found.get(str(prim.GetCustomDataByKey(NAME)))


def read_layer(documents: Documents, path: Path) -> tuple[Any, str]:
    """A layer of a document, or what is wrong with it."""
    try:
        return documents.layer(path), ""
    except SceneError as error:
        return None, error.issues[0].sentence
    except UnreadableError as error:
        return None, str(error)
