"""Textures at points of a surface: in the NumPy twin, and compiled."""

from collections import namedtuple

import numpy as np

from alight.bsdfs.matte.diffuse import Diffuse
from alight.compiled.materials import compile_materials
from alight.compiled.program import Program
from alight.textures import fetch
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from lanewise.view import View

Scene = namedtuple("Scene", "materials shapes")
Shapes = namedtuple("Shapes", "info")
#: The fields of `alight.shapes.hit.Surface` that textures look at.
Surface = namedtuple("Surface", "u v shape color p", defaults=[None])


def scene_of(*textures, origin=None):
    """Tables and program of a scene with a diffuse material for each texture."""
    materials = [Diffuse(reflectance=t) for t in textures]
    tables, bsdfs, names = compile_materials(materials, origin=origin)
    program = Program(bsdfs=bsdfs, textures=names)
    return Scene(tables, Shapes(View(np.zeros(8, np.uint32)))), program


def look_up(texture, u, v, z=0.0, origin=None):
    """Colours (n, 3) of a texture at (u, v), and at the place (u, v, z), in the twin."""
    u, v = (np.atleast_1d(np.asarray(x, np.float32)) for x in (u, v))
    scene, program = scene_of(texture, origin=origin)
    kernel = instantiate(fetch.color, program, compiled=False)
    zeros = np.zeros(len(u), np.uint32)
    black = Vec3(*np.zeros((3, len(u)), np.float32))
    with np.errstate(all="ignore"):
        found = kernel(
            scene, zeros, Surface(u, v, zeros, black, Vec3(u, v, np.zeros_like(u) + np.float32(z)))
        )
    return np.stack([np.broadcast_to(c, len(u)) for c in (found.x, found.y, found.z)], axis=1)
