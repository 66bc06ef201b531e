"""Lights without a size light a wall as much by the rays that they emit as by light sampling."""

import numpy as np
import pytest

from alight.bsdfs.matte.diffuse import Diffuse
from alight.cameras.pinhole import Pinhole
from alight.compiled.scene import compile_scene
from alight.core.spec import Light
from alight.films.fixed_point import carry, to_float
from alight.integrators import bidirectional, light, path
from alight.integrators.walk import make_settings
from alight.laws.statistics import LARGEST_Z
from alight.lights.model import LIGHTS
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import FilmSettings, Node, Scene, flatten
from alight.scene.transform import look_at, rotate, scale, translate
from alight.shapes.rectangle import Rectangle
from tests.portion import portion

SIDE, SPP, REPLICATES = 8, 256, 32
#: So many times as many samples by light sampling, which are cheap.
MORE = 4
PATH, *OTHERS = (
    path.Path(max_depth=2),
    bidirectional.Bidirectional(max_depth=2),
    light.Light(max_depth=2),
)
EMITTERS = [
    pytest.param(spec, id=f"{name} {i}")
    for name, model in LIGHTS.items()
    if model.DELTA and model.emit is not None
    for i, spec in enumerate(model.EXAMPLES)
    if not spec.is_black
]


def lit_by(spec: Light) -> Scene:
    """A light that shines at a wall 1 m away, and a camera that sees all of it."""
    wall = translate(0.1, 0.2, 1) @ rotate("y", 160) @ scale(2)
    eye = look_at((0, 0, -3), (0, 0, 1))
    return Scene(
        film=FilmSettings(size=(SIDE, SIDE)),
        nodes={
            "light": Node(light=spec),
            "wall": Node(shape=Rectangle(), bsdf=Diffuse(), transform=wall),
        },
        camera=Node(camera=Pinhole(fov=30.0), transform=eye),
    )


def flux(scene: Scene, integrator, spp: int = SPP) -> np.ndarray:
    """Of quarters of the picture by one sample a pixel, (4, replicates, 3)."""
    compiled = compile_scene(flatten(scene.replaced(integrator=integrator)), structure="list")
    settings = make_settings(integrator, seed=1, replicates=REPLICATES)
    ranges = np.array([[[0, spp]]], np.int64)
    kernels = make_kernels(compiled, compiled=False)
    film, _ = render_tile(kernels, compiled, settings, Tile(0, 0, SIDE, SIDE), ranges)
    carry(film.sums)
    sums, half = to_float(film.sums) * (REPLICATES / spp), SIDE // 2
    return sums.reshape(2, half, 2, half, REPLICATES, 3).sum(axis=(1, 3)).reshape(4, REPLICATES, 3)


@pytest.mark.proofs
@pytest.mark.parametrize("spec", portion(EMITTERS))
def test_every_integrator_sees_as_much_of_a_light(spec):
    scene = lit_by(spec)
    expected = flux(scene, PATH, MORE * SPP)
    for integrator in OTHERS:
        found = flux(scene, integrator)
        error = np.sqrt((found.var(axis=1, ddof=1) + expected.var(axis=1, ddof=1)) / REPLICATES)
        a, b = found.mean(axis=1), expected.mean(axis=1)
        rounding = 1e-5 * b.max()
        assert (np.abs(a - b) < LARGEST_Z * error + rounding).all(), (integrator.type, a / b)
        # It would see a tenth of all light.
        whole = np.sqrt((error**2).sum(axis=0)) / np.maximum(b.sum(axis=0), rounding)
        assert LARGEST_Z * whole[b.sum(axis=0) > rounding].max() < 0.1
