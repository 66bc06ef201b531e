"""How a film shows itself in a notebook: the picture and a line of facts."""

from __future__ import annotations

import base64
import html
import math
from typing import TYPE_CHECKING

from alight.outputs.display import Display
from alight.outputs.png import encode_png

if TYPE_CHECKING:
    from alight.films.film import Film


def png_of(film: Film, display: Display | None = None) -> bytes:
    """Encode the picture as an 8-bit sRGB PNG."""
    picture = film.picture(layers=False)
    shown = (display or Display()).developed(picture.straight).apply(picture.straight)
    colors, alpha = picture.over_display(shown)
    return encode_png(colors, bits=8, alpha=alpha)


def html_of(film: Film, display: Display | None = None) -> str:
    """Show the picture with size, samples, error, and what is suspicious or went wrong."""
    picture = base64.b64encode(png_of(film, display)).decode("ascii")
    _, _, w, h = film.crop
    facts = [f"{w} × {h} pixels", f"{film.spp:g} samples per pixel"]
    error = film.relmse_estimate().relrmse.value
    facts.append("error unknown" if math.isnan(error) else f"relative error {error:.2%}")
    line = html.escape(", ".join(facts))
    shown = f'<img alt="{line}" src="data:image/png;base64,{picture}"><br><small>{line}</small>'
    return shown + html_of_warnings(film)


def html_of_warnings(film: Film) -> str:
    """List what is suspicious or went wrong; nothing where nothing is."""
    items = "".join(f"<li>{html.escape(text)}</li>" for text in film.warnings)
    return f"<small>Warnings<ul>{items}</ul></small>" if items else ""
