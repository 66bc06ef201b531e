"""The picture of docs/python.md: one PNG file with alpha, over pages of three colours."""

import sys
from pathlib import Path

from pictures import IMAGES
from PIL import Image

import alight

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
PAGES = ("white", (240, 180, 90), (60, 120, 160))

if __name__ == "__main__":
    sys.path.insert(0, str(EXAMPLES))
    from mesh_figure import wavy_torus

    scene = alight.load(wavy_torus(), up="z", smooth=60, color_map="viridis")
    target = IMAGES / "shadow-catcher.png"
    alight.render(scene, size="320x260", spp=384, background="shadow", output=target)
    with Image.open(target) as file:
        figure = file.convert("RGBA")
    row = Image.new("RGB", (len(PAGES) * figure.width, figure.height))
    for number, color in enumerate(PAGES):
        page = Image.new("RGBA", figure.size, color)
        # As browsers do: encoded values.
        page.alpha_composite(figure)
        row.paste(page.convert("RGB"), (number * figure.width, 0))
    row.save(target, optimize=True)
