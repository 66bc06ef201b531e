"""Pictures and lamps' profiles of descriptions, read from files where these name one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError

from alight.core.errors import Issue, SceneError, quote
from alight.core.field_types import texture_interval
from alight.core.fields import invalid
from alight.core.spec import Bsdf, Light, Shape, Spec, Texture
from alight.outputs.primaries import foreign_primaries
from alight.outputs.texels import SUFFIXES, read_texels
from alight.scene.builtin.pictures import builtin_texels, is_builtin
from alight.scene.files import Files
from alight.scene.meshes import unreadable
from alight.shapes.arrays import is_displaced
from alight.textures.images import Image, as_image, holds_image, size_problem

AnySpec = TypeVar("AnySpec", bound=Spec)


def loaded(spec: AnySpec, files: Files) -> AnySpec:
    """Put the picture of a file into the place of its name; other descriptions stay.

    Raises
    ------
    SceneError
        If the file is missing or broken; its path is ``file``.
    """
    if isinstance(spec, Bsdf | Light):
        spec = spec.read(files)
    name = getattr(spec, "file", None) if holds_image(spec) else None
    if name is None:
        return spec
    # Numbers that are no colours have no primaries.
    data = getattr(spec, "color_space", "auto") == "linear"
    return spec.replaced(file=None, pixels=picture(name, files, files.note, data=data))


def picture(
    name: str,
    files: Files,
    note: Callable[[str], None] | None = None,
    path: Path | None = None,
    *,
    data: bool = False,
) -> Image:
    """A picture of a scene; see `read_image`, which is called once for each file and use."""
    image, notes = files.read(_noted_data if data else _noted, name, path)
    if note is not None:
        for text in notes:
            note(text)
    return image


def _noted(path: Path, name: str) -> tuple[Image, list[str]]:
    """A picture, and what had to be changed in it."""
    notes: list[str] = []
    return read_image(path, name, notes.append), notes


def _noted_data(path: Path, name: str) -> tuple[Image, list[str]]:
    """The same of what is no colour."""
    notes: list[str] = []
    return read_image(path, name, notes.append, data=True), notes


def resolved(spec: AnySpec, textures: Mapping[str, Texture], files: Files) -> AnySpec:
    """Put textures into the places of their names, and pictures into those of files.

    Textures inside textures are resolved too; names must not go in circles.
    """
    spec = loaded(spec, files)
    changes: dict[str, Any] = {}
    for name, value in spec:
        if isinstance(value, str | Texture) and texture_interval(type(spec), name):
            found = textures[value] if isinstance(value, str) else value
            texture = resolved(found, textures, files)
            if texture is not value:
                changes[name] = texture
    return spec.replaced(**changes) if changes else spec


def with_heights(shape: Shape, textures: Mapping[str, Texture], files: Files) -> Shape:
    """A shape whose displacement is put into the place of its name; any other one stays."""
    return resolved(shape, textures, files) if is_displaced(shape) else shape


def read_image(
    path: Path,
    name: str = "",
    note: Callable[[str], None] | None = None,
    *,
    data: bool = False,
) -> Image:
    """Read a picture.

    Negative light, which lossy compression and changes of the colour space leave behind in many
    HDR pictures, is taken for none.

    Parameters
    ----------
    path : Path
        The file.
    name : str, optional
        How messages call it; names such as ``builtin:sky`` mean computed pictures.
    note : callable, optional
        Called with what had to be changed.
    data : bool, default False
        The numbers are no colours: they stay as they are, whatever primaries the file names.

    Raises
    ------
    SceneError
        If it is missing, broken, too large, or holds numbers that are no amounts of light.
    """
    name = name or str(path)
    try:
        if is_builtin(name):
            texels = builtin_texels(name)
        else:
            tell = note or (lambda text: None)
            texels = read_texels(path, _check_size, lambda text: tell(f"{quote(name)}: {text}"))
            texels = texels if data else _with_our_primaries(texels, path, name, note)
        texels = _without_negative_light(texels, name, note)
        # Nobody else has this array: marked so, it is not copied.
        texels.setflags(write=False)
        return as_image(texels)
    except OSError as error:
        # Decoders report broken files as errors without a number.
        text = unreadable(path, name, error, SUFFIXES) if error.errno else _broken(name, error)
    except PydanticCustomError as error:
        text = f"{quote(name)}: {error.message()}"
    except ValueError as error:
        text = _broken(name, error)
    raise SceneError([Issue("file", text)])


def _with_our_primaries(
    texels: NDArray[Any], path: Path, name: str, note: Callable[[str], None] | None
) -> NDArray[Any]:
    """Texels in linear sRGB, where an OpenEXR file says that they are in another space."""
    colored = texels.ndim == 3 and texels.shape[2] >= 3 and texels.dtype.kind == "f"
    primaries = foreign_primaries(path) if colored and path.suffix.lower() == ".exr" else None
    if primaries is None:
        return texels
    said = f"{quote(name)}: its primaries are not those of sRGB ({primaries.name})"
    if primaries.to_srgb is None:
        note = note or (lambda text: None)
        note(f"{said} and span no space: its numbers were taken as they are")
        return texels
    if note is not None:
        note(f"{said}: its colours were converted")
    turned = texels.astype(np.float32)
    # Large numbers may overflow; the check of the texels reports them.
    with np.errstate(over="ignore", invalid="ignore"):
        turned[..., :3] = texels[..., :3] @ primaries.to_srgb.T.astype(np.float32)
    return turned


def _without_negative_light(
    texels: NDArray[Any], name: str, note: Callable[[str], None] | None
) -> NDArray[Any]:
    if texels.dtype.kind != "f" or not -math.inf < (lowest := np.fmin.reduce(texels, None)) < 0.0:
        return texels
    if note is not None:
        count, size = int((texels < 0.0).any(axis=-1).sum()), texels.shape[0] * texels.shape[1]
        note(
            f"{quote(name)}: {count} of {size} texels hold negative light (down to {lowest:.3g}), "
            "which was taken for none"
        )
    return np.maximum(texels, 0.0)


def _broken(name: str, error: Exception) -> str:
    reason = " ".join(str(error).split())[:200]
    return f"{quote(name)}: {reason or 'is broken'}"


def _check_size(width: int, height: int) -> None:
    problem = size_problem(width, height)
    if problem:
        raise invalid(problem)
