"""Pieces of HTML for notebooks: tables, pictures and text, with every name escaped."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence

import numpy as np

from alight.outputs.display import Display
from alight.outputs.png import encode_png

#: Cells without the lines and stripes of notebooks; figures below each other.
_TABLE = "border-collapse:collapse;font-variant-numeric:tabular-nums"
_CELL = "text-align:left;padding:0.1em 1em 0.1em 0;white-space:pre-wrap;vertical-align:top"


def paragraph(text: str) -> str:
    """A line of text."""
    return f"<p>{html.escape(text)}</p>"


def preformatted(lines: Iterable[str]) -> str:
    """Lines that keep their blanks, as on a terminal; empty if there are none."""
    text = "\n".join(lines)
    return f'<pre style="white-space:pre-wrap">{html.escape(text)}</pre>' if text else ""


def table(rows: Sequence[Sequence[object]], heads: Sequence[str] = (), caption: str = "") -> str:
    """Rows of texts; the first cell of each names it.

    Parameters
    ----------
    rows : sequence of sequences
        Each as long as `heads`, if there are any.
    heads : sequence of str, optional
    caption : str, optional
    """
    lines = [f'<table style="{_TABLE}">']
    if caption:
        style = "text-align:left;font-weight:bold"
        lines.append(f'<caption style="{style}">{html.escape(caption)}</caption>')
    if heads:
        lines.append(_row([_cell("th", 'scope="col"', head) for head in heads]))
    for name, *cells in rows:
        row = [_cell("th", 'scope="row"', name)]
        lines.append(_row([*row, *(_cell("td", "", cell) for cell in cells)]))
    return "\n".join([*lines, "</table>"])


def _row(cells: Sequence[str]) -> str:
    return f"<tr>{''.join(cells)}</tr>"


def _cell(tag: str, attributes: str, content: object) -> str:
    opening = " ".join(filter(None, [tag, attributes, f'style="{_CELL}"']))
    return f"<{opening}>{html.escape(str(content))}</{tag}>"


def picture(png: bytes, name: str, width: int | None = None) -> str:
    """A PNG file inside the page.

    Parameters
    ----------
    png : bytes
    name : str
        For those who cannot see it.
    width : int, optional, pixels
    """
    data = base64.b64encode(png).decode("ascii")
    size = "" if width is None else f' width="{width}"'
    style = ' style="max-width:100%"'
    return f'<img alt="{html.escape(name)}"{size}{style} src="data:image/png;base64,{data}">'


def figure(image: np.ndarray, caption: str, exposure: float | str = 0.0, width: int = 240) -> str:
    """A linear picture, with its name below."""
    shown = picture(encode_png(Display(exposure).apply(image), bits=8), caption, width)
    style = "display:inline-block;margin:0 1em 1em 0"
    text = html.escape(caption)
    return f'<figure style="{style}">{shown}<figcaption>{text}</figcaption></figure>'


def division(*parts: str) -> str:
    """One piece of several."""
    return "<div>\n" + "\n".join(filter(None, parts)) + "\n</div>"
