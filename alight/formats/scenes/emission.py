"""How much a model is lit by its own surfaces that shine: a lamp, or only the LED of a device.

Programs that show models light them from around, and what shines is decoration. A path tracer takes
it for the light of the scene, and all the rest stays dark. So the light of such surfaces, area
times radiance, is compared with the box around the model: with `LEAST` of white on all its sides it
is as bright inside as in a room of which a tenth shines white.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.constants import LUMINANCE
from alight.core.errors import SceneError
from alight.core.fields import Model
from alight.formats.geometry.bounds import Bounds
from alight.scene.build import Builder
from alight.scene.files import Files
from alight.scene.images import picture
from alight.shapes.mesh import Mesh
from alight.shapes.model import SHAPES
from alight.textures.images import Image

#: Mean radiance over the box's sides with which a model lights itself.
LEAST = 0.1

#: Faces of a mesh that are looked at.
_FACES = 2**16


class Glow:
    """Light of the surfaces of a model.

    Parameters
    ----------
    files : Files
        Reads pictures.

    Attributes
    ----------
    total : float
        Area times luminance of the radiance, summed, W/sr.
    """

    def __init__(self, files: Files) -> None:
        self.total = 0.0
        self._files = files

    def add(self, mesh: Mesh, to_world: NDArray[np.float64], radiance: Any) -> None:
        """Count a mesh that shines.

        Parameters
        ----------
        mesh : Mesh
            Vertices in metres before `to_world`.
        to_world : (4, 4) float64
        radiance : number, color or texture
            W/(m^2 sr), as an area light of the native format is described. Textures are looked up
            in the middle of the faces.
        """
        assert mesh.vertices is not None and mesh.faces is not None
        step = -(-len(mesh.faces) // _FACES)
        faces = np.asarray(mesh.faces)[::step]
        if not len(faces):
            return
        corners = np.asarray(mesh.vertices)[faces] @ to_world[:3, :3].T
        edges = corners[:, 1:] - corners[:, :1]
        areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        sets = [np.zeros((len(faces), 2))]
        if mesh.uvs is not None:
            tables = [mesh.uvs, *(() if mesh.more_uvs is None else mesh.more_uvs)]
            sets = [np.asarray(table)[faces].mean(axis=1) for table in tables]
        total = float((areas * (self._color(radiance, sets) @ LUMINANCE)).sum()) * step
        self.total += total if np.isfinite(total) else 0.0

    def add_shape(self, spec: Any, to_world: NDArray[np.float64], radiance: Any) -> None:
        """Count a shape with a formula that shines; textures are looked up in a corner.

        Parameters
        ----------
        spec : Shape or mapping
            A shape, or its description; building the scene reports what is wrong with that.
        to_world : (4, 4) float64
        radiance : number, color or texture
            As of `add`.
        """
        spec = Builder().model(Model("shape", "shapes"), spec, "")
        luminance = float((self._color(radiance, [np.zeros((1, 2))]) @ LUMINANCE)[0])
        for part, place in spec.parts() or ((spec, np.eye(4)),):
            model = SHAPES[part.type_name()]
            if model.pack is None or model.area is None:
                continue
            with np.errstate(all="ignore"), suppress(np.linalg.LinAlgError):
                total = luminance * model.area(model.pack(part, to_world @ place))
                self.total += total if np.isfinite(total) else 0.0

    def suffices(self, bounds: Bounds) -> bool:
        """Whether the model in these bounds needs no other light."""
        x, y, z = np.where(bounds.low <= bounds.high, bounds.high - bounds.low, 0.0)
        return self.total > 0.0 and self.total >= LEAST * 2.0 * float(x * y + y * z + z * x)

    def _color(self, texture: Any, sets: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Value of a texture: (n, 3), 1 where it is not known; `sets` of coordinates, (n, 2)."""
        result = np.ones((len(sets[0]), 3))
        if not isinstance(texture, Mapping):
            return result * np.asarray(texture, np.float64)
        if texture["type"] == "multiply":
            return self._color(texture["a"], sets) * self._color(texture["b"], sets)
        if texture["type"] == "bitmap":
            image = texture.get("pixels") or self._read(texture["file"])
            if isinstance(image, Image):
                number = texture.get("uv_set", 0)
                uv = sets[number if number < len(sets) else 0]
                to_uv = texture.get("to_uv")
                if isinstance(to_uv, Mapping) and "matrix" in to_uv:
                    matrix = np.asarray(to_uv["matrix"])
                    uv = uv @ matrix[:, :2].T + matrix[:, 2]
                u, v = (np.where(np.isfinite(uv), uv, 0.0) % 1.0).T
                column = np.minimum(u * image.width, image.width - 1).astype(int)
                row = np.minimum((1.0 - v) * image.height, image.height - 1).astype(int)
                texels = image.texels[row, column][None]
                return result * Image(texels).linear(texture.get("color_space", "auto"))[0]
        return result

    def _read(self, name: str) -> Image | None:
        try:
            return picture(name, self._files)
        except SceneError:
            return None  # Building the scene reports it.
