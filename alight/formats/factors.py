"""What readers make of textures: packed pictures decoded, and products and sums with numbers."""

from __future__ import annotations

from typing import Any

from alight.core.spec import invalid
from alight.outputs.texels import decode_texels
from alight.textures.images import Image, as_image, size_problem

Data = dict[str, Any]


def packed_picture(data: bytes | memoryview) -> Image:
    """Decode a picture that lies inside of another file.

    Parameters
    ----------
    data : bytes or memoryview
        PNG, JPEG or another format that `decode_texels` reads.

    Raises
    ------
    PydanticCustomError
        If it is larger than textures may be; the size is looked at before it is decoded.
    OSError, ValueError
        If it is broken.
    """
    texels = decode_texels(data, _check_size)
    texels.setflags(write=False)
    return as_image(texels)


def _check_size(width: int, height: int) -> None:
    problem = size_problem(width, height)
    if problem:
        raise invalid(problem)


def multiplied(factor: float | list[float], texture: Data | None) -> Any:
    """A number or colour times a texture; the factor itself where there is no texture."""
    if texture is None:
        return factor
    is_one = set(factor) == {1.0} if isinstance(factor, list) else factor == 1.0
    return texture if is_one else {"type": "multiply", "a": factor, "b": texture}


def shifted(texture: Data, bias: float | list[float]) -> Data:
    """A texture plus a number or colour."""
    is_zero = set(bias) == {0.0} if isinstance(bias, list) else bias == 0.0
    return texture if is_zero else {"type": "add", "a": texture, "b": bias}
