"""Every camera on its way sees at each time what it sees at rest where it is then."""

import numpy as np
import pytest

from alight.cameras import MODELS
from alight.cameras.rays import generate_ray
from alight.compiled.cameras import compile_camera
from alight.compiled.program import Program
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.scene.flatten import flatten
from alight.scene.motion import NOWHERE
from lanewise.jit import instantiate
from tests.motion.test_kernels import seen

SCENE = """
alight: 1
camera:
  type: %s
  transform:
    keyframes:
      - {time: 0, scale: 2, rotate: {axis: [1, 2, 3], angle: 10}, translate: [1, 2, 3]}
      - {time: 1, scale: 3, rotate: {axis: y, angle: 80}, translate: [-1, 0, 2]}
film: {size: [8, 6]}
nodes: {ball: {shape: sphere}}
"""
N = 12


def stacked(v):
    return np.stack([np.broadcast_to(c, N) for c in (v.x, v.y, v.z)], axis=-1).astype(float)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__.rpartition(".")[2])
def test_rays_are_those_of_the_camera_where_it_is_then(model):
    name = model.EXAMPLES[0].type_name()
    scene = loads(SCENE % name)
    compiled = compile_scene(flatten(scene), structure="list")
    motion = NOWHERE.then(scene.camera.transform, scene.camera.camera.shutter).motion
    rng = np.random.default_rng(3)
    x, y, u, v, time = rng.random((5, N)).astype(np.float32)
    x, y = 8.0 * x, 6.0 * y
    moving = instantiate(generate_ray, compiled.program, compiled=False)
    o, d = map(stacked, moving(seen(compiled, time), x, y, (u, v)))
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0, rtol=1e-6)
    resting = instantiate(generate_ray, Program(camera=name), compiled=False)
    for lane in range(N):
        matrix = motion.at(float(time[lane]))
        table = compile_camera(scene.camera.camera, matrix, (8, 6))
        still = seen(compiled, time)._replace(camera=table)
        at, ahead = map(stacked, resting(still, x, y, (u, v)))
        np.testing.assert_allclose(o[lane], at[lane], atol=2e-5)
        np.testing.assert_allclose(d[lane], ahead[lane], atol=2e-6)
