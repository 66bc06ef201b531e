"""A user's texture displaces, too."""

import numpy as np

import alight
from alight.compiled.displacement import displaced
from alight.core.registration import unregister
from alight.formats import loads
from alight.scene import flatten
from tests.extension.models import SCENE, module_of

STEP = '''
from typing import Literal

from alight.core.spec import Texture
from lanewise.jit import kernel
from lanewise.simd import lanes_vec3


class Step(Texture):
    """A number, as a texture."""

    type: Literal["step"] = "step"


EXAMPLES = (Step(),)
SLOTS = {"unused": 3}


def pack(spec, packer):
    packer.color("unused", (0.0, 0.0, 0.0))


@kernel
def evaluate(scene, base, surface):
    return lanes_vec3(HEIGHT)


HEIGHT = 0.25
'''


def test_heights_are_of_the_version_of_their_texture():
    mesh = "{type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 2]], %s}"
    text = SCENE % "diffuse" + f"  hill: {{shape: {mesh % 'displacement: {type: step}'}}}\n"
    try:
        for height in (0.25, 0.5):
            alight.register(module_of(STEP.replace("0.25", str(height)), "step"))
            scene = displaced(flatten(loads(text)))
            np.testing.assert_allclose(scene.geometries[-1].vertices[:, 2], height)
    finally:
        unregister("textures", "step")
