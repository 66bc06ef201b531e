"""What finds the closest hits of a scene is compiled for its shapes alone."""

import numpy as np
import pytest

from alight.accel import batch
from alight.compiled.at_times import tables_at
from alight.compiled.scene import compile_scene
from alight.core.vec import Vec3
from alight.formats import loads
from alight.scene import flatten
from lanewise.machine_code import kind_of

SCENE = """
alight: 1
integrator: %s
camera: {type: pinhole}
nodes:
  ball: {shape: sphere, bsdf: {type: %s}%s}
  lamp: {light: {type: %s}}
"""
MOVES = ", transform: {keyframes: [{time: 0, scale: 1}, {time: 1, translate: [1, 0, 0]}]}"


def asked_for(monkeypatch, *words, **changes):
    """Program and kinds of arguments of the kernel that finds hits in a scene."""
    asked = []

    def remember(root, program):
        return lambda *arguments: asked.append((root, program, kind_of(arguments)))

    scene = compile_scene(flatten(loads(SCENE % words)), structure="list")
    program, tables = scene.program._replace(**changes), scene.tables
    if program.motion:
        tables = tables_at(tables, np.zeros(4, np.float32))
    rows = Vec3(*np.zeros((3, 4), np.float32))
    with monkeypatch.context() as patched:
        patched.setattr(batch, "instantiate", remember)
        batch.closest_hits(program, tables, rows, rows, np.ones(4, np.float32))
    [one] = asked
    return program, one


@pytest.mark.parametrize("motion", ["", MOVES], ids=["at rest", "in motion"])
def test_scenes_of_like_shapes_share_it(monkeypatch, motion):
    programs, kernels = zip(
        asked_for(monkeypatch, "path", "diffuse", motion, "point"),
        asked_for(monkeypatch, "direct", "plastic", motion, "spot"),
        strict=True,
    )
    assert programs[0] != programs[1]
    assert kernels[0] == kernels[1]
    assert bool(programs[0].motion) == bool(motion)


def test_a_users_own_shape_is_given_the_whole_program(monkeypatch):
    registered = (("shapes", "torus", "1"),)
    program, (_, asked, _) = asked_for(
        monkeypatch, "path", "diffuse", "", "point", registered=registered
    )
    assert asked == program
