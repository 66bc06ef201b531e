"""Mutated files of Mitsuba: XML of both spellings, with meshes and pictures."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

from tests.formats.mutate import TEXT_MUTATIONS, Mutation, mutate_bytes

FOLDER = Path(__file__).parents[1] / "formats" / "mitsuba" / "picture" / "files"
NAMES = ("letters.png", "sky.exr", "square.obj", "squares.serialized", "tent.ply")

# fmt: off
WORDS = (
    "0", "-1", "1e30", "1e-30", "nan", "inf", "1e999", "99999999999999999999", "$spp", "$", "",
    "sphere", "ply", "shapegroup", "instance", "bitmap", "checkerboard", "mask", "twosided", "null",
    "envmap", "area", "../x", "/etc/passwd", "letters.png", "tent.ply", "it", "g", "true", "0.6.0",
    "3.0.0", "to_world", "toWorld", "filename", "reflectance", "400:1, 500:2", "1,2", "1 2 3",
)
# fmt: on

_SENSOR = """<sensor type="{camera}">
  <float name="{close}" value="1"/> <float name="fov" value="40"/>
  <float name="{aperture}" value="0.05"/>
  <transform name="{to_world}"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
  <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
    <rfilter type="tent"/></film>
  <sampler type="stratified"><integer name="{count}" value="$spp"/></sampler>
</sensor>
<integrator type="{walk}"><integer name="{depth}" value="4"/></integrator>
"""

_SCENES = (
    """<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>
<texture type="bitmap" id="it"><string name="filename" value="letters.png"/></texture>
<bsdf type="twosided" id="b"><bsdf type="diffuse"><ref name="reflectance" id="it"/></bsdf></bsdf>
<alias id="b" as="c"/>
<shape type="{mesh}"><string name="filename" value="{file}"/><ref id="c"/>
  <transform name="{to_world}"><scale x="-1"/><rotate y="1" angle="30"/></transform></shape>
""",
    """<shape type="{mesh}"><string name="filename" value="{file}"/>
  <boolean name="{face}" value="true"/><emitter type="area">
  <spectrum name="radiance" value="400:1, 550:3, 700:2"/></emitter></shape>
<shape type="shapegroup" id="g"><shape type="cylinder"><bsdf type="roughconductor">
  <string name="material" value="Cu"/><float name="alpha" value="0.2"/></bsdf></shape></shape>
<shape type="instance"><ref id="g"/>
  <transform name="{to_world}"><translate x="1" y="-0.5"/></transform></shape>
""",
    """<emitter type="spot"><rgb name="intensity" value="4,3,2"/></emitter>
<emitter type="constant"><spectrum name="radiance" value="0.5"/></emitter>
<shape type="sphere"><point name="center" x="0" y="0" z="0"/><float name="radius" value="1"/>
  <bsdf type="blendbsdf"><float name="weight" value="0.3"/>
    <bsdf type="roughplastic"><string name="{ior}" value="water"/></bsdf>
    <bsdf type="phong"><float name="exponent" value="12"/></bsdf></bsdf></shape>
<shape type="disk"><bsdf type="mask"><texture type="checkerboard" name="opacity">
  <rgb name="color0" value="0.1"/><transform name="{uv}"><scale x="4"/></transform></texture>
  <bsdf type="dielectric"/></bsdf></shape>
""",
    """<emitter type="sunsky"><float name="turbidity" value="4"/>
  <vector name="sun_direction" x="1" y="2" z="3"/></emitter>
<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>
<emitter type="projector"><float name="fov" value="40"/><texture type="bitmap" name="irradiance">
  <string name="filename" value="letters.png"/></texture></emitter>
<shape type="{mesh}"><string name="filename" value="{file}"/>
  <animation name="{to_world}"><transform time="0"><translate x="1"/></transform>
  <transform time="1"><rotate y="1" angle="40"/></transform></animation>
  <bsdf type="normalmap"><texture type="bitmap" name="normalmap"><boolean name="raw" value="true"/>
  <string name="filename" value="letters.png"/></texture>
  <bsdf type="roughconductor"/></bsdf></shape>
<shape type="sphere"><bsdf type="bumpmap"><texture type="bitmap" name="arbitrary">
  <string name="filename" value="letters.png"/></texture><float name="scale" value="0.1"/>
  <bsdf type="principled"><float name="metallic" value="0.4"/><float name="spec_trans" value="0.3"/>
  </bsdf></bsdf><medium type="homogeneous" name="interior"><rgb name="sigma_t" value="1,2,3"/>
  <float name="albedo" value="0.8"/><phase type="hg"><float name="g" value="0.4"/></phase></medium>
</shape>
""",
)

_SPELLINGS = {
    "3.0.0": {
        "to_world": "to_world", "aperture": "aperture_radius", "count": "sample_count",
        "depth": "max_depth", "face": "face_normals", "ior": "int_ior", "uv": "to_uv",
        "close": "shutter_close",
    },
    "0.6.0": {
        "to_world": "toWorld", "aperture": "apertureRadius", "count": "sampleCount",
        "depth": "maxDepth", "face": "faceNormals", "ior": "intIOR", "uv": "toUV",
        "close": "shutterClose",
    },
}  # fmt: skip
_MESHES = {"square.obj": "obj", "squares.serialized": "serialized", "tent.ply": "ply"}


def copy_files(folder: Path) -> None:
    """Put the valid meshes and pictures into a folder."""
    for name in NAMES:
        (folder / name).write_bytes((FOLDER / name).read_bytes())


def mitsuba_files(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` scenes, about a third of them with a mutated mesh or picture.

    They lie in a folder that `copy_files` has filled; a mutated file has a name of its own.
    """
    rng = random.Random(seed)
    files = {name: (FOLDER / name).read_bytes() for name in NAMES}
    for _ in range(n):
        name = rng.choice(NAMES)
        mesh = name if name in _MESHES else rng.choice(list(_MESHES))
        if rng.random() < 0.35:
            # The scene that shows the file: those without meshes and pictures come last.
            which = rng.choice((0, 3)) if name not in _MESHES else rng.choice((0, 1, 3))
            text = scene(which, mesh, rng).replace(name, f"broken-{name}")
            yield Mutation(text, f"broken-{name}", mutate_bytes(files[name], rng))
        else:
            text = scene(rng.randrange(len(_SCENES)), mesh, rng)
            for _ in range(rng.choice((1, 1, 1, 2, 5))):
                change = rng.choice((_swap_value, _swap_value, *TEXT_MUTATIONS))
                text = change(text, rng)
            yield Mutation(text, "unused", b"")


def scene(which: int, mesh: str, rng: random.Random) -> str:
    """A valid file, of either spelling."""
    version = rng.choice(list(_SPELLINGS))
    camera = rng.choice(("perspective", "thinlens"))
    body = (_SENSOR + _SCENES[which]).format(
        **_SPELLINGS[version], camera=camera, mesh=_MESHES[mesh], file=mesh,
        walk="volpath" if which == 3 else "path",
    )  # fmt: skip
    return f'<scene version="{version}">\n<default name="spp" value="4"/>\n{body}</scene>\n'


def _swap_value(text: str, rng: random.Random) -> str:
    """Replace what stands between a pair of quotes."""
    quotes = [i for i, c in enumerate(text) if c == '"']
    if len(quotes) < 2:
        return text
    at = rng.randrange(len(quotes) - 1)
    return text[: quotes[at] + 1] + rng.choice(WORDS) + text[quotes[at + 1] :]
