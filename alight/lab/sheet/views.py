"""What a contact sheet looks like: a picture of a grid of tiles, or a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from alight.lab.report.numbers import number
from alight.lab.report.page import render_page
from alight.lab.report.pictures import data_uri
from alight.lab.sheet.tiles import Tile
from alight.outputs.atomic import replacing

if TYPE_CHECKING:
    from PIL import ImageDraw

SUFFIXES = (".png", ".jpg", ".html")

_INK, _GREY, _BAD, _PAPER, _EMPTY = "#1c1f23", "#5d6570", "#b3401a", "#ffffff", "#f0f1f3"
_GAP, _MARGIN, _LINE, _FONT = 12, 16, 15, 12
#: Lines of text below a picture.
_LINES = 3
#: Shares of a tile that a message may fill; the rest of it is in the page.
_MESSAGE = 0.9


def write_sheet(
    path: Path,
    tiles: Sequence[Tile],
    size: tuple[int, int],
    *,
    columns: int = 6,
    notes: Sequence[str] = (),
) -> Path:
    """Write a sheet.

    Parameters
    ----------
    path : Path
        ``.png`` or ``.jpg``: one picture. ``.html``: a page in one file, with all remarks.
    tiles : sequence of Tile
    size : (int, int)
        Width and height of a tile, pixels.
    columns : int, default 6
        Of the picture; a page has as many as fit.
    notes : sequence of str
        Lines below, for instance where the scenes come from.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    with replacing(path) as beside:
        if path.suffix.lower() == ".html":
            page = render_page("sheet.html.j2", _page_context(tiles, size, notes))
            # Names of files may hold bytes that are no text.
            beside.write_text(page, encoding="utf-8", errors="backslashreplace")
        else:
            kind = "PNG" if path.suffix.lower() == ".png" else "JPEG"
            sheet = draw_sheet(tiles, size, columns, notes)
            sheet.save(beside, kind, optimize=True, quality=90)
    return path


def draw_sheet(
    tiles: Sequence[Tile], size: tuple[int, int], columns: int, notes: Sequence[str]
) -> Any:
    """Draw the grid; returns a picture of Pillow."""
    from PIL import Image, ImageDraw, ImageFont

    columns = max(1, min(columns, len(tiles)))
    rows = -(-len(tiles) // columns)
    step_x, step_y = size[0] + _GAP, size[1] + _LINES * _LINE + _GAP
    width = 2 * _MARGIN + columns * step_x - _GAP
    font = ImageFont.load_default(_FONT)
    probe = ImageDraw.Draw(Image.new("RGB", (1, 1)))
    texts = [line for note in notes for line in _wrapped(probe, note, font, width - 2 * _MARGIN)]
    height = 2 * _MARGIN + rows * step_y + len(texts) * _LINE
    sheet = Image.new("RGB", (width, height), _PAPER)
    draw = ImageDraw.Draw(sheet)
    for i, tile in enumerate(tiles):
        left, top = _MARGIN + i % columns * step_x, _MARGIN + i // columns * step_y
        draw.rectangle((left, top, left + size[0] - 1, top + size[1] - 1), fill=_EMPTY)
        if tile.pixels is not None:
            shown = Image.fromarray(tile.pixels)
            place = (left + (size[0] - shown.width) // 2, top + (size[1] - shown.height) // 2)
            sheet.paste(shown, place)
        else:
            lines = _wrapped(draw, tile.message, font, _MESSAGE * size[0])
            lines = lines[: int(_MESSAGE * size[1] / _LINE)]
            inset = round(0.5 * (1.0 - _MESSAGE) * size[0])
            draw.multiline_text((left + inset, top + inset), "\n".join(lines), _BAD, font)
        # Of long names the end tells more: folders are often the same.
        name = _cut(draw, f"{tile.name}  ({tile.kind})"[::-1], font, size[0])[::-1]
        facts = tile.facts if tile.pixels is not None else []
        for n, cut in enumerate([name, *(_cut(draw, text, font, size[0]) for text in facts)]):
            place = (left, top + size[1] + 2 + n * _LINE)
            draw.text(place, cut, _INK if n == 0 else _GREY, font)
    for n, text in enumerate(texts):
        draw.text((_MARGIN, _MARGIN + rows * step_y + n * _LINE), text, _GREY, font)
    return sheet


def _wrapped(draw: ImageDraw.ImageDraw, text: str, font: Any, width: float) -> list[str]:
    """Break text into lines, at spaces where it can."""
    lines: list[str] = []
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            longer = f"{line} {word}" if line else word
            if line and draw.textlength(longer, font) > width:
                lines.append(line)
                longer = word
            while draw.textlength(longer, font) > width and len(longer) > 1:
                kept = len(_cut(draw, longer, font, width, ""))
                lines.append(longer[:kept])
                longer = longer[kept:]
            line = longer
        lines.append(line)
    return lines


def _cut(draw: ImageDraw.ImageDraw, text: str, font: Any, width: float, end: str = "...") -> str:
    """The beginning of a text, as long as fits."""
    if draw.textlength(text, font) <= width:
        return text
    kept = len(text)
    while kept > 1 and draw.textlength(text[:kept] + end, font) > width:
        kept -= 1
    return text[:kept] + end


def _page_context(
    tiles: Sequence[Tile], size: tuple[int, int], notes: Sequence[str]
) -> dict[str, Any]:
    shown = [
        {
            "tile": tile,
            "image": None if tile.pixels is None else _picture_uri(tile.pixels),
            "facts": tile.facts,
            "all_seconds": number(tile.all_seconds),
        }
        for tile in tiles
    ]
    failed = sum(tile.pixels is None for tile in tiles)
    return {"tiles": shown, "width": size[0], "height": size[1], "notes": notes, "failed": failed}


def _picture_uri(pixels: np.ndarray) -> str:
    from alight.outputs.png import encode_png

    return data_uri(encode_png(pixels / 255.0, bits=8))
