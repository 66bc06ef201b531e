"""Kernels of one kind of light meet rows of all others: none may read what is not there.

The twin complains of places that do not exist, where machine code reads whatever lies there, or
crashes.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from alight.formats import loads
from alight.lights.hits import _emission_chain, _pdf_chain
from alight.lights.tables import INFO
from alight.scene import flatten
from lanewise.view import View
from tests.fuzz.in_the_twin import picture

HEAD = """alight: 1
camera: {type: pinhole, transform: {translate: [0, 0, 4]}}
nodes:
  wall: {shape: rectangle, transform: [{scale: 3}, {translate: [0, 0, -1]}]}
"""
MAP = [[0.5] * 64] * 32
LIGHTS = {
    "ies": """{light: {type: ies, vertical_angles: [0, 90], horizontal_angles: [0, 45, 90],
    candela: [[9.0e+8, 1], [3, 2], [1, 0]]}, transform: {translate: [0, 0, 3]}}""",
    "projector": """{light: {type: projector, pixels: [[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], 1]]},
    transform: {translate: [0, 0, 3]}}""",
    "disk": "{light: {type: area, radiance: 3}, shape: disk}",
    "mesh": """{light: {type: area, radiance: 3}, shape: {type: mesh,
    vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 2]]}}""",
    "spot": "{light: spot}",
    "map": f"{{light: {{type: environment, pixels: {MAP}}}}}",
    "sky": "{light: {type: sky, sun_direction: [0, 1, 0]}}",
    "portal": "{light: portal, transform: {translate: [0, 0, 2]}}",
}


@pytest.mark.parametrize(
    "kinds",
    [
        ("ies", "projector", "disk", "spot"),
        ("spot", "disk", "projector", "ies"),
        ("ies", "disk", "map"),
        ("projector", "mesh", "map"),
        ("map", "map", "disk"),
        ("map", "sky", "map", "mesh", "spot"),
        ("map", "portal", "disk", "map", "ies"),
    ],
    ids="-".join,
)
def test_no_light_reads_the_tables_of_another(kinds):
    nodes = "".join(f"  lamp{i}: {LIGHTS[kind]}\n" for i, kind in enumerate(kinds))
    assert picture(flatten(loads(HEAD + nodes, "scene.yaml"))) == 0


def test_a_large_mesh_that_does_not_shine_is_no_light():
    """It is the first shape, and rows of lights without a shape have its number."""
    count = 200
    vertices = [[i % 3, i % 7, -2] for i in range(count + 2)]
    faces = [[i, i + 1, i + 2] for i in range(count) if i % 3]
    rock = f"  a-rock: {{shape: {{type: mesh, vertices: {vertices}, faces: {faces}}}}}\n"
    nodes = f"  lamp: {LIGHTS['mesh']}\n  spot: {LIGHTS['spot']}\n"
    head = HEAD.replace("  wall", rock + "  wall")
    assert picture(flatten(loads(head + nodes, "scene.yaml"))) == 0


@pytest.mark.parametrize(("chain", "part"), [(_emission_chain, "emitted"), (_pdf_chain, "pdf")])
def test_shapes_that_shine_each_in_its_way_are_asked_by_their_own_model(chain, part):
    """Users may add such lights to the one that there is."""
    numbers = (5, 2, 9)

    def model(number):
        def answer(scene, index, *arguments):
            return np.float32(number) + 0.01 * index

        return SimpleNamespace(number=number, **{part: answer})

    kinds = np.random.default_rng(1).choice(numbers, 40)
    # All other words of the rows are numbers of models too.
    info = np.random.default_rng(2).choice(numbers, (40, INFO)).astype(np.uint32)
    info[:, 0] = kinds
    index = np.random.default_rng(3).permutation(40).astype(np.uint32)
    scene = SimpleNamespace(lights=SimpleNamespace(info=View(info)))
    found = chain(tuple(map(model, numbers)))(scene, index, None, None)
    np.testing.assert_allclose(found, kinds[index] + 0.01 * index, rtol=1e-6)
