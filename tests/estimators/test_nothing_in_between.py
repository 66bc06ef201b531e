"""Surfaces that are not there change no sample, whatever stands behind them.

Light is then found by the same random numbers, at the same places, with the same weights.
"""

import numpy as np
import pytest

from alight.integrators.path import Path
from alight.integrators.volpath import VolPath
from tests.rendering.many_paths import compiled, samples_of

#: A floor seen from above, lamps of every shape over the camera, and a sky with a window.
ROOM = """
alight: 1
camera: {fov: 50, transform: {look_at: {origin: [0, 1.2, 0.8], target: [0, 0, 0]}}}
film: {size: [16, 16]}
sampler: independent
environment: {type: constant, radiance: 0.3}
bsdfs:
  black: {type: diffuse, reflectance: 0}
  nothing: {type: "null"}
  open: {type: mask, opacity: 0, bsdf: {type: diffuse}}
nodes:
  floor: {shape: plane, bsdf: {type: rough_conductor, alpha: 0.5},
          transform: {rotate: {axis: x, angle: -90}}}
  lamps:
    transform: {translate: [0, 3, 0]}
    children:
      ball: {shape: {type: sphere, radius: 0.4}, light: {type: area, radiance: 3}, bsdf: black}
      egg: {shape: sphere, light: {type: area, radiance: 4}, bsdf: black,
            transform: [{scale: [0.2, 0.5, 0.3]}, {translate: [1.2, 0, -1]}]}
      tube: {shape: {type: cylinder, p0: [-1, 0, -1.5], p1: [0, 0.3, -1.5], radius: 0.2},
             light: {type: area, radiance: 3}, bsdf: black}
      plate: {shape: disk, light: {type: area, radiance: 3}, bsdf: black,
              transform: [{scale: [0.6, 0.3, 1]}, {rotate: {axis: x, angle: 90}},
                          {translate: [-1.5, 0.5, 0]}]}
      panel: {shape: rectangle, light: {type: area, radiance: 3}, bsdf: black,
              transform: [{scale: [0.5, 0.3, 1]}, {rotate: {axis: x, angle: 70}},
                          {translate: [1.5, 0.5, 0.5]}]}
      prism: {light: {type: area, radiance: 3}, bsdf: black, transform: {translate: [0.3, 0, 1]},
              shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                      faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}}
      window: {light: portal, transform: [{scale: 2}, {rotate: {axis: x, angle: 90}},
                                          {translate: [0, 2, 0]}]}
"""
#: Two planes that cut through the room, and a bubble around one of the lamps.
HOLES = """
  veil: {shape: plane, bsdf: %(one)s, transform: [{rotate: {axis: x, angle: 80}},
                                                  {translate: [0, 1.8, 0]}]}
  glazing: {shape: plane, bsdf: %(other)s, transform: [{rotate: {axis: x, angle: -100}},
                                                       {translate: [0, 2.1, 0]}]}
  bubble: {shape: {type: sphere, center: [0, 3, 0], radius: 0.45}, bsdf: %(other)s}
"""
INTEGRATORS = {
    "path": Path(max_depth=8, rr_depth=8),
    "balance": Path(max_depth=8, rr_depth=8, heuristic="balance", light_choice="tree"),
    "by bsdf": Path(max_depth=8, rr_depth=8, light_sampling="bsdf"),
    "by light": Path(max_depth=8, rr_depth=8, light_sampling="emitter"),
    "volpath": VolPath(max_depth=2, rr_depth=8),
    "tree": VolPath(max_depth=2, rr_depth=8, light_choice="tree"),
}


@pytest.mark.parametrize("name", INTEGRATORS)
@pytest.mark.parametrize("kinds", [("nothing", "nothing"), ("nothing", "open")], ids="/".join)
def test_surfaces_that_are_not_there_change_no_sample(name, kinds):
    holes = HOLES % {"one": kinds[0], "other": kinds[1]}
    clear, behind = (samples_of(compiled(text, INTEGRATORS[name])) for text in (ROOM, ROOM + holes))
    assert (clear.max(axis=-1) > 0.0).mean() > 0.3
    same = np.isclose(behind, clear, rtol=1e-3, atol=1e-6).all(axis=-1)
    # A ray that just meets the rim of a lamp may miss it.
    assert same.mean() > 0.995, (same.mean(), behind.mean() / clear.mean())
