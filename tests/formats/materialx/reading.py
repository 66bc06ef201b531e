"""Small documents of MaterialX, read."""

import numpy as np
from PIL import Image

from alight.core.errors import SceneError
from alight.formats.materialx.baking import _bitmaps, _evaluated, _image, _key
from alight.formats.materialx.scene import parse
from alight.formats.reading.reach import Reach
from alight.scene.files import Files
from tests.formats.gltf.reading import core as core

#: A picture of 2 x 2 texels, top row first.
TEXELS = np.array([[[0, 64, 128], [255, 128, 0]], [[32, 32, 32], [255, 255, 255]]], np.uint8)


def value(name, kind, text, more=""):
    """An input with a value."""
    return f'<input name="{name}" type="{kind}" value="{text}"{more}/>'


def link(name, kind, node, more=""):
    """An input that is connected to a node."""
    return f'<input name="{name}" type="{kind}" nodename="{node}"{more}/>'


def node(category, name, kind, *inputs):
    """A node."""
    return f'<{category} name="{name}" type="{kind}">{"".join(inputs)}</{category}>'


def picture(name="p", kind="color3", *inputs, file="a.png", space=' colorspace="srgb_texture"'):
    """A node that shows a picture."""
    space = space if kind.startswith("color") else ""
    return node("image", name, kind, value("file", "filename", file, space), *inputs)


def document(shader, *nodes, category="standard_surface", head=""):
    """A document with one material of one shader; `shader` is its inputs."""
    surface = node(category, "S", "surfaceshader", shader)
    material = node("surfacematerial", "M", "material", link("surfaceshader", "surfaceshader", "S"))
    return f'<materialx version="1.39"{head}>{"".join(nodes)}{surface}{material}</materialx>'


def parsed(text, folder, lenient=False):
    """What a document becomes."""
    Image.fromarray(TEXELS).save(folder / "a.png")
    return parse(text.encode(), "a.mtlx", Reach(folder), lenient=lenient)


def material(shader, folder, *nodes, category="standard_surface", lenient=False, head=""):
    """The description of the material of a shader, and what was said."""
    found = parsed(document(shader, *nodes, category=category, head=head), folder, lenient)
    return found.data["bsdfs"]["M"], found.warnings


def problem(text, folder):
    """The message of a document that cannot be read."""
    try:
        parsed(text, folder)
    except SceneError as error:
        return str(error)
    raise AssertionError("was read")


def texels(texture, folder):
    """What a texture of bitmaps shows at the centres of its texels, top row first."""
    files = Files(folder)
    images = {_key(b): _image(b, files) for b in _bitmaps(texture)}
    rows = np.broadcast_to(_evaluated(texture, images), (4, 3))
    return rows.reshape(2, 2, 3)
