"""Sets of pictures that lie side by side on a surface: ``wood.<UDIM>.png``.

The tile 1001 + c + 10 r covers the unit square of (u, v) from (c, r). All tiles become one picture,
which is looked up as one: where two tiles meet, texels of both are interpolated, so that a surface
that goes on from tile to tile shows no seam. Squares without a tile show the border of the tile
that is nearest to them. Smaller tiles are enlarged to the size of the largest; a set with too many
texels for one picture is made smaller.

Source: Foundry, "UDIM workflow", as OpenUSD and MaterialX 1.39 (``<UDIM>`` in file names) have it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import SceneError, quote
from alight.core.srgb import decode_srgb, encode_srgb
from alight.formats.reading.reach import OutOfReachError, Reach, UnreadableError
from alight.formats.reading.report import Report
from alight.scene.files import Files
from alight.scene.images import read_image
from alight.textures.images import MOST_SIDE, MOST_TEXELS, Image

Data = dict[str, Any]
#: What stands for the number of a tile in a name.
TOKEN = "<UDIM>"
FIRST, COLUMNS, LAST = 1001, 10, 1999


@dataclass(frozen=True)
class Tiles:
    """A set of tiles as one picture.

    Attributes
    ----------
    image : Image
        Its lower left corner is that of the lowest and leftmost tile.
    corner : (int, int)
        Where in (u, v) that is.
    size : (int, int)
        Tiles along u and v.
    shrunk : int
        By how much its sides are shorter than those of its tiles.
    is_decoded : bool
        Whether texels that were whole numbers have become linear floats.
    """

    image: Image
    corner: tuple[int, int]
    size: tuple[int, int]
    shrunk: int
    is_decoded: bool


def is_tiled(name: str) -> bool:
    """Whether a name means a set of tiles."""
    return TOKEN in name


def find_tiles(name: str, reach: Reach) -> str:
    """Find a set of tiles, and read it.

    Parameters
    ----------
    name : str
        With `TOKEN` in its last part.
    reach : Reach

    Returns
    -------
    str
        Its name from the scene's folder.

    Raises
    ------
    OutOfReachError
        If it lies outside, or has no tile.
    UnreadableError
        If a tile cannot be read.
    """
    for folder in reach.searched:
        path = reach.inside(name, folder)
        tiles = _paths(path)
        for tile in tiles.values():
            # A tile may be a link.
            reach.inside(reach.name_of(tile), shown=tile.name)
        if tiles:
            found = reach.name_of(path)
            _tiles(found, reach.files, "auto")
            return found
    first = name.replace(TOKEN, str(FIRST))
    raise OutOfReachError(f"no such file: {quote(name)} (no tile, such as {quote(first)})")


def lay_out(bitmap: Data, reach: Reach, report: Report) -> None:
    """Let a bitmap of a set that `find_tiles` found show its picture; others stay as they are."""
    name = bitmap.get("file", "")
    if not is_tiled(name):
        return
    tiles = _tiles(name, reach.files, "auto")
    space = bitmap.get("color_space", "auto")
    if space != "auto" and (tiles.shrunk > 1 or tiles.is_decoded):
        tiles = _tiles(name, reach.files, space)
    before = bitmap.get("to_uv", [])
    steps = list(before) if isinstance(before, list) else [before]
    steps += [{"translate": [float(-c) for c in tiles.corner]}]
    steps += [{"scale": [1.0 / n for n in tiles.size]}]
    bitmap.pop("file")
    bitmap.pop("wrap_v", None)
    bitmap |= {"pixels": tiles.image, "wrap": "clamp", "to_uv": steps}
    if tiles.is_decoded:
        bitmap["color_space"] = "linear"
    if tiles.shrunk > 1:
        text = f"its tiles are {tiles.shrunk} times smaller, to fit into one picture"
        report.approximate(f"{quote(name)}: {text}")


def _paths(path: Path) -> dict[int, Path]:
    """The tiles that there are, by their numbers."""
    before, _, after = path.name.partition(TOKEN)
    wanted = re.compile(re.escape(before) + r"(1\d{3})" + re.escape(after))
    try:
        names = sorted(entry.name for entry in path.parent.iterdir())
    except OSError:
        return {}
    found = {int(m[1]): path.with_name(n) for n in names if (m := wanted.fullmatch(n))}
    return {number: tile for number, tile in found.items() if FIRST <= number <= LAST}


def _tiles(name: str, files: Files, space: str) -> Tiles:
    try:
        return files.read(_READERS[space], name)
    except SceneError as error:
        raise UnreadableError(error.issues[0].message) from None


def _read(path: Path, name: str, space: str) -> Tiles:
    """Read all tiles of a set; the colour space counts where texels have to be decoded."""
    paths = _paths(path)
    images = {number: read_image(tile, tile.name) for number, tile in paths.items()}
    places = {n: ((n - FIRST) % COLUMNS, (n - FIRST) // COLUMNS) for n in images}
    low, high = ([f(p[i] for p in places.values()) for i in (0, 1)] for f in (min, max))
    columns, rows = high[0] - low[0] + 1, high[1] - low[1] + 1
    width = max(image.width for image in images.values())
    height = max(image.height for image in images.values())
    shrunk = 1
    while (width // shrunk) * columns * (height // shrunk) * rows > MOST_TEXELS or max(
        (width // shrunk) * columns, (height // shrunk) * rows
    ) > MOST_SIDE:
        shrunk *= 2
    width, height = max(width // shrunk, 1), max(height // shrunk, 1)
    kinds = {image.texels.dtype.kind for image in images.values()}
    whole = _together(list(images.values()), space)
    # Whole numbers are averaged as what they stand for.
    encoded = len(kinds) == 1 and Image(whole[0][..., :1].copy()).is_encoded(space)
    fitted = {n: _fitted(t, width, height, encoded) for n, t in zip(images, whole, strict=True)}
    texels = np.zeros((rows * height, columns * width, whole[0].shape[2]), whole[0].dtype)
    for column in range(columns):
        for row in range(rows):
            here = (low[0] + column, low[1] + row)
            nearest = min(places, key=lambda n: (_distance(places[n], here), n))
            tile = fitted[nearest]
            if places[nearest] != here:
                tile = _beside(tile, places[nearest], here)
            # Rows are counted from the top.
            top = (rows - 1 - row) * height
            texels[top : top + height, column * width : (column + 1) * width] = tile
    texels.setflags(write=False)
    channels = texels.shape[2]
    alpha = np.ascontiguousarray(texels[..., -1]) if channels in (2, 4) else None
    colors = np.ascontiguousarray(texels[..., : 3 if channels > 2 else 1])
    return Tiles(Image(colors, alpha), (low[0], low[1]), (columns, rows), shrunk, len(kinds) > 1)


_READERS = {space: partial(_read, space=space) for space in ("auto", "linear", "srgb")}


def _distance(a: tuple[int, int], b: tuple[int, int]) -> int:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2


def _together(images: list[Image], space: str) -> list[NDArray[Any]]:
    """Texels of one type and with as many channels; whole numbers stay encoded as they are."""
    kinds = {image.texels.dtype.kind for image in images}
    if len(kinds) > 1:
        images = [
            Image(image.linear(space), None if image.alpha is None else image.alpha / image.levels)
            for image in images
        ]
    elif len({image.levels for image in images}) > 1:
        images = [_of_16_bits(image) for image in images]
    channels = max(image.whole.shape[2] for image in images)
    result = []
    for image in images:
        texels = image.texels
        if channels > 2 and texels.shape[2] == 1:
            texels = np.repeat(texels, 3, axis=2)
        if channels in (2, 4):
            alpha = image.alpha
            if alpha is None:
                alpha = np.full(texels.shape[:2], image.levels, texels.dtype)
            texels = np.concatenate([texels, alpha[..., None]], axis=2)
        result.append(texels)
    return result


def _of_16_bits(image: Image) -> Image:
    """The same values, of which 16 bits hold those of 8 exactly."""
    factor = np.uint16(0xFFFF // image.levels)
    alpha = None if image.alpha is None else image.alpha * factor
    return Image(image.texels * factor, alpha)


def _fitted(texels: NDArray[Any], width: int, height: int, encoded: bool) -> NDArray[Any]:
    """A tile of another size: the means of texels, or the nearest ones."""
    rows, columns = texels.shape[:2]
    if (rows, columns) == (height, width):
        return texels
    if rows % height == 0 and columns % width == 0 and rows >= height and columns >= width:
        step = rows // height
        # Few rows at a time, as floats take much more memory.
        parts = [texels[r : r + 16 * step] for r in range(0, rows, 16 * step)]
        return np.concatenate([_shrunk(part, step, width, encoded) for part in parts])
    y = (np.arange(height) + 0.5) * rows / height
    x = (np.arange(width) + 0.5) * columns / width
    return texels[y.astype(int)][:, x.astype(int)]


def _shrunk(texels: NDArray[Any], step: int, width: int, encoded: bool) -> NDArray[Any]:
    """Means of blocks of texels: linear ones, encoded again and rounded."""
    rows, columns, channels = texels.shape
    levels = np.iinfo(texels.dtype).max if texels.dtype.kind == "u" else 1
    linear = texels / levels
    colors = slice(3 if channels > 2 else 1)
    if encoded:
        linear[..., colors] = decode_srgb(linear[..., colors])
    means = linear.reshape(rows // step, step, width, columns // width, channels).mean(axis=(1, 3))
    if encoded:
        means[..., colors] = encode_srgb(means[..., colors])
    return (np.round(means * levels) if levels > 1 else means).astype(texels.dtype)


def _beside(tile: NDArray[Any], place: tuple[int, int], here: tuple[int, int]) -> NDArray[Any]:
    """What a square without a tile shows of the tile that is nearest: its border."""
    if here[0] != place[0]:
        tile = np.repeat(tile[:, -1:] if here[0] > place[0] else tile[:, :1], tile.shape[1], axis=1)
    if here[1] != place[1]:
        # Rows are counted from the top: above lies the first one.
        tile = np.repeat(tile[:1] if here[1] > place[1] else tile[-1:], tile.shape[0], axis=0)
    return tile
