"""Mutated scenes with what built-in scenes do not have together, and the files that they name.

Portals, several surroundings, keyframes, lamps with a profile, projectors, media on grids.
"""

from __future__ import annotations

import base64
import io
import random
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from alight.bsdfs.measured.examples import satin
from tests.formats.mutate import TEXT_MUTATIONS, Mutation, mutate_bytes
from tests.fuzz.extremes import extreme_numbers

_HEAD = """alight: 1
camera:
  type: thin_lens
  fov: 40
  aperture_radius: 0.05
  focus_distance: 4
  shutter: [0.1, 0.8]
  transform: {keyframes: [{time: 0, translate: [0, 0, 4]}, {time: 1, rotate: {axis: y,
      angle: 5}, translate: [0.3, 0, 4]}]}
film: {size: [8, 8]}
"""
_SCENES = (
    """environment: {type: sunsky, time: "2026-06-21T18:45:00+02:00", latitude: 52.5,
    longitude: 13.4, scale: 0.02}
nodes:
  overcast: {light: {type: environment, pixels: [[1, 0.5], [0.25, 2]], scale: 0.5}}
  glow: {light: {type: constant, radiance: 0.1}}
  evening: {light: {type: sun, sun_direction: [1, 0.3, 0.5], diameter: 2, scale: 0.02}}
  window: {light: portal, transform: [{scale: [1, 0.5, 1]}, {rotate: {axis: y, angle: -90}},
      {translate: [3, 1.5, 0]}]}
  skylight: {light: portal, transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 2, 0]}]}
  ball: {shape: sphere, bsdf: {type: principled, metallic: 0.5, clearcoat: 1, sheen_color: 0.3,
      iridescence: 0.5}}
  sample: {shape: disk, bsdf: {type: measured, file: sample.bsdf}}
  floor: {shape: plane, transform: [{rotate: {axis: x, angle: -90}}, {translate: [0, -1, 0]}]}
""",
    """integrator: {type: path, light_choice: auto, max_depth: 6}
nodes:
  hub:
    transform: {keyframes: [{time: 0}, {time: 0.5, rotate: {axis: z, angle: 60}}, {time: 1,
        rotate: {axis: z, angle: 120}}]}
    children:
      lamp: {light: {type: ies, file: lamp.ies, scale: 2}, transform: [{rotate: {axis: x,
          angle: 90}}, {translate: [0, 2, 1]}]}
      bulb: {shape: {type: sphere, radius: 0.2}, light: {type: area, radiance: 3},
          transform: {translate: [1, 1, 0]}}
      spot: {light: {type: spot, intensity: 5, cutoff_angle: 30, beam_width: 20},
          transform: {look_at: {origin: [0, 2, 3], target: [0, 0, 0]}}}
  beamer: {light: {type: projector, pixels: [[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], 1]], fov: 40,
      scale: 5}, transform: {look_at: {origin: [0, 0, 4], target: [0, 0, 0]}}}
  thrown:
    shape: cube
    bsdf: {type: rough_conductor, metal: gold, alpha: 0.2}
    transform: {keyframes: [{time: -1, scale: 0.5, translate: [0, 1, 0]}, {time: 2, scale: [0.5,
        0.7, 0.5], translate: [1, 0, 0]}]}
  wall: {shape: rectangle, bsdf: {type: eon, roughness: 0.5}, transform: [{scale: 3},
      {translate: [0, 0, -1]}]}
""",
    """integrator: {type: volpath, max_depth: 6}
environment: {type: constant, radiance: 0.8}
media:
  milk: {type: homogeneous, sigma_s: [2.5, 3.2, 3.8], sigma_a: [0.001, 0.002, 0.014],
      phase: {type: henyey_greenstein, g: 0.5}}
  fire: {type: homogeneous, sigma_t: 0.5, albedo: 0.2, emission: [2, 1, 0.1], phase: rayleigh}
  smoke: {type: grid, file: smoke.npy, low: [-1, -1, -1], high: [1, 1, 1], sigma_t: 3,
      albedo: 0.6}
  cloud: {type: grid, file: cloud.vol, low: [-1, -1, -1], high: [1, 1, 1], sigma_t: 3,
      albedo: [0.9, 0.8, 0.7]}
medium: fire
nodes:
  glass: {shape: sphere, bsdf: {type: dielectric, int_ior: water}, interior: milk, exterior: fire}
  box: {shape: cube, bsdf: {type: "null"}, interior: smoke, exterior: fire,
      transform: {translate: [2, 0, 0]}}
  puff: {shape: cube, bsdf: {type: "null"}, interior: cloud, exterior: fire,
      transform: {translate: [-2, 0, 0]}}
""",
)  # fmt: skip

_LAMP = b"""IESNA:LM-63-2002
[TEST] of a lamp
[MANUFAC] nobody
TILT=NONE
1 1000 1.5 4 3 1 2 0.1 0.2 0
1.0 1.0 50
0 30 60 90
0 45 90
1200 900 150 0
1000 800 120 0
900 700 100 0
"""
_WORDS = (
    b"0", b"-1", b"1e30", b"nan", b"inf", b"1e999", b"99999999999", b"3", b"90", b"180", b"360",
    b"TILT=INCLUDE", b"TILT=x.tlt", b"IESNA91", b"", b"x", b"\n",
)  # fmt: skip


def files() -> dict[str, bytes]:
    """The files that the scenes name, all of them valid."""
    stream = io.BytesIO()
    values = np.random.default_rng(4).random((3, 2, 2)).astype(np.float32)
    np.save(stream, values)
    head = b"VOL\x03" + struct.pack("<5i", 1, 2, 2, 3, 1)
    volume = head + struct.pack("<6f", 0, 0, 0, 1, 1, 1) + values.tobytes()
    sample = base64.b64decode(satin().plain())
    return {
        "lamp.ies": _LAMP, "smoke.npy": stream.getvalue(), "cloud.vol": volume,
        "sample.bsdf": sample,
    }  # fmt: skip


def write_files(folder: Path) -> None:
    """Put the valid files into a folder."""
    for name, data in files().items():
        (folder / name).write_bytes(data)


def features(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` scenes, about a third of them with another file mutated.

    They lie in a folder that `write_files` has filled; a mutated file has a name of its own.
    """
    rng = random.Random(seed)
    valid = files()
    for _ in range(n):
        if rng.random() < 0.35:
            name = rng.choice(sorted(valid))
            data = _words_swapped(valid[name], rng) if name == "lamp.ies" else valid[name]
            if name != "lamp.ies" or rng.random() < 0.3:
                data = mutate_bytes(data, rng)
            text = _HEAD + next(scene for scene in _SCENES if name in scene)
            yield Mutation(text.replace(name, f"broken-{name}"), f"broken-{name}", data)
        elif rng.random() < 0.5:
            yield Mutation(extreme_numbers(_HEAD + rng.choice(_SCENES), rng), "unused", b"")
        else:
            text = _HEAD + rng.choice(_SCENES)
            for _ in range(rng.choice((1, 1, 1, 2, 5))):
                text = rng.choice(TEXT_MUTATIONS)(text, rng)
            yield Mutation(text, "unused", b"")


def _words_swapped(data: bytes, rng: random.Random) -> bytes:
    lines = [line.split(b" ") for line in data.split(b"\n")]
    for _ in range(rng.choice((1, 1, 2, 4))):
        line = rng.choice(lines)
        line[rng.randrange(len(line))] = rng.choice(_WORDS)
    return b"\n".join(b" ".join(line) for line in lines)
