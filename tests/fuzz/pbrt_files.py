"""Mutated files of pbrt, versions 3 and 4, with what they include."""

from __future__ import annotations

import gzip
import random
from collections.abc import Iterator
from pathlib import Path

from tests.formats.mutate import TEXT_MUTATIONS, Mutation, mutate_bytes

FOLDER = Path(__file__).parents[1] / "formats" / "mitsuba" / "picture" / "files"

# fmt: off
WORDS = (
    "0", "-1", "1e30", "1e-30", "nan", "inf", "1e999", "99999999999999999999", "true", "false", "",
    "[", "]", "[ ]", '"', "#", "AttributeBegin", "AttributeEnd", "ObjectBegin", "WorldBegin",
    "ReverseOrientation", "Identity", "Scale 1e20 1 1", "Scale 0 0 0", "float", "rgb", "point3",
    "texture", "spectrum", "sphere", "disk", "loopsubdiv", "bilinearmesh", "mix", "glass", "hair",
    "conductor", "../x", "/etc/passwd", "letters.png", "scene.pbrt", "part.pbrt", "t", "m", "o",
    "fog", "MediumInterface", "uniformgrid", "volpath",
)
# fmt: on

_HEADS = {
    4: """LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 40 "float lensradius" 0.05 "float focaldistance" 4
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "float iso" 150
PixelFilter "gaussian" "float xradius" 1.5 "float yradius" 1.5
Sampler "zsobol" "integer pixelsamples" 4
Integrator "volpath" "integer maxdepth" 4
WorldBegin
""",
    3: """LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" [40]
Film "image" "integer xresolution" 8 "integer yresolution" 8 "float scale" 1.5
Sampler "halton" "integer pixelsamples" 4
Integrator "path" "integer maxdepth" 4
WorldBegin
""",
}

_WORLDS = (
    (4, """LightSource "infinite" "string filename" "square.npy" "float scale" 0.5
Texture "t" "spectrum" "imagemap" "string filename" "letters.png" "float uscale" 2
Texture "u" "spectrum" "scale" "texture tex" "t" "float scale" 0.5
MakeNamedMaterial "m" "string type" "diffuse" "texture reflectance" "u"
AttributeBegin
  Rotate 30 0 1 0 Scale -1 1 1 NamedMaterial "m"
  Include "part.pbrt"
  Shape "plymesh" "string filename" "tent.ply.gz"
AttributeEnd
"""),
    (4, """AttributeBegin
  AreaLightSource "diffuse" "blackbody L" 4000 "float power" 100 "bool twosided" true
  Shape "disk" "float radius" 2 "float height" -1.5
AttributeEnd
Material "coateddiffuse" "float roughness" 0.1 "rgb reflectance" [0.5 0.3 0.2]
ObjectBegin "o"
  Shape "loopsubdiv" "integer levels" 1 "point3 P" [1 0 0 0 1 0 0 0 1 -1 0 0 0 -1 0 0 0 -1]
    "integer indices" [0 1 2 1 3 2 3 4 2 4 0 2 1 0 5 3 1 5 4 3 5 0 4 5]
ObjectEnd
TransformBegin Translate 0.5 0 0 ObjectInstance "o" TransformEnd
ReverseOrientation
Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" [400 1.5 700 3.5]
Shape "bilinearmesh" "point3 P" [-1 -1 0 0 -1 0 -1 0 0 0 0 1] "float alpha" 0.7
"""),
    (4, """LightSource "infinite" "float scale" 0.5
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.1 0.2 0.3]
  "rgb sigma_s" [1 2 3] "float scale" 0.5 "float g" 0.4
Attribute "medium" "float g" 0.1
MakeNamedMedium "cloud" "string type" "uniformgrid" "integer nx" 2 "integer ny" 1 "integer nz" 3
  "float density" [1 2 3 4 5 6] "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1]
MediumInterface "fog" ""
Material "interface"
Shape "sphere" "float radius" 0.8
AttributeBegin
  MediumInterface "cloud" "fog" Material "dielectric"
  Shape "sphere" "float radius" 0.5
AttributeEnd
"""),
    (4, """LightSource "infinite" "point3 portal" [-1 0 -1  1 0 -1  1 1 -1  -1 1 -1]
LightSource "projection" "string filename" "letters.png" "float fov" 50 "float power" 20
LightSource "goniometric" "string filename" "square.npy" "rgb I" [3 2 1]
AreaLightSource "diffuse" "string filename" "letters.png" "float scale" 2
Shape "bilinearmesh" "point3 P" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1] "point2 uv" [0 0 1 0 0 1 1 1]
"""),
    (4, """LightSource "infinite" "string filename" "square.npy" "float scale" 0.5
LightSource "infinite" "rgb L" [0.5 0.4 0.3]
TransformTimes 0 2
AttributeBegin
  ActiveTransform EndTime Translate 1 0 0 Rotate 40 0 0 1
  ActiveTransform All
  Material "coatedconductor" "float interface.roughness" 0.1
  Shape "sphere" "float radius" 0.5
  AreaLightSource "diffuse" "rgb L" [1 2 3]
  Shape "disk" "float radius" 0.3
AttributeEnd
ObjectBegin "o"
  Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [-1 -1 -1 1 -1 -1 0 1 -1]
ObjectEnd
ActiveTransform EndTime Scale 1 1.5 1 ActiveTransform All
ObjectInstance "o"
"""),
    (3, """LightSource "infinite" "rgb L" [0.5 0.5 0.4]
LightSource "spot" "color I" [4 3 2] "point from" [0 2 4] "point to" [0 0 0] "float coneangle" 40
Texture "t" "color" "checkerboard" "rgb tex1" [0.9 0.1 0.1] "float vscale" 4
Material "uber" "texture Kd" "t" "color Ks" [0.2 0.2 0.2] "float roughness" 0.1
Shape "sphere" "float radius" 1 "float zmax" 0.5
MakeNamedMaterial "m" "string type" "glass" "float index" 1.4
MakeNamedMaterial "n" "string type" "mix" "string namedmaterial1" "m" "string namedmaterial2" "m"
NamedMaterial "n"
Shape "cylinder" "float radius" 0.5 "float phimax" 270
Shape "trianglemesh" "integer indices" [0 1 2] "point P" [-1 -1 -1 1 -1 -1 0 1 -1]
WorldEnd
"""),
)  # fmt: skip

_PART = """Translate 0 0 0.5
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
  "point3 P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] "point2 uv" [0 0 1 0 1 1 0 1]
"""


def contents() -> dict[str, bytes]:
    """The files that scenes name, all of them valid."""
    import io

    import numpy as np

    stream = io.BytesIO()
    np.save(stream, np.random.default_rng(1).random((4, 4, 3)).astype(np.float32))
    return {
        "letters.png": (FOLDER / "letters.png").read_bytes(),
        "part.pbrt": _PART.encode(),
        "square.npy": stream.getvalue(),
        "tent.ply.gz": gzip.compress((FOLDER / "tent.ply").read_bytes(), mtime=0),
    }


def write_files(folder: Path) -> None:
    """Put the valid files into a folder."""
    for name, data in contents().items():
        (folder / name).write_bytes(data)


def pbrt_files(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` scenes, about a quarter of them with another file mutated.

    They lie in a folder that `write_files` has filled; a mutated file has a name of its own.
    """
    rng = random.Random(seed)
    files = contents()
    for _ in range(n):
        if rng.random() < 0.25:
            name = rng.choice(sorted(files))
            version, world = next(w for w in _WORLDS if name in w[1])
            text = (_HEADS[version] + world).replace(name, f"broken-{name}")
            yield Mutation(text, f"broken-{name}", mutate_bytes(files[name], rng), "scene.pbrt")
            continue
        version, world = rng.choice(_WORLDS)
        text = _HEADS[version] + world
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            change = rng.choice((_swap_word, _swap_word, *TEXT_MUTATIONS))
            text = change(text, rng)
        yield Mutation(text, "unused", b"", "scene.pbrt")


def _swap_word(text: str, rng: random.Random) -> str:
    """Replace what stands between two blanks, or within quotes."""
    ends = [i for i, c in enumerate(text) if c in ' \n"[]']
    if len(ends) < 2:
        return text
    at = rng.randrange(len(ends) - 1)
    return text[: ends[at] + 1] + rng.choice(WORDS) + text[ends[at + 1] :]
