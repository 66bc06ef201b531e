"""Light through holes: paths go through at random, shadow rays are dimmed, and both agree."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.integrators.path import Path
from alight.integrators.volpath import VolPath
from alight.laws.integrators import picture
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten

SIDE = 16
SCENE = """
alight: 1
camera: {fov: 40, transform: {look_at: {origin: [0, 0.6, 3], target: [0, 0.4, 0]}}}
film: {size: [16, 16]}
sampler: independent
nodes:
  floor: {shape: plane, transform: {rotate: {axis: x, angle: -90}}}
  veil:
    shape: plane
    bsdf: {type: mask, opacity: 0.3, bsdf: {type: diffuse, reflectance: 0.8}}
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 1.5, 0]}]
  glazing:
    shape: plane
    bsdf: {type: blend, weight: 0.6, bsdfs: [{type: "null"}, {type: mirror}]}
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 1.7, 0]}]
  bulb: {light: {type: point, intensity: 5}, transform: {translate: [0.2, 2.5, 0.3]}}
  lamp:
    shape: rectangle
    light: {type: area, radiance: 1}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 2}, {translate: [0, 2.5, 0]}]
"""
#: Part of the light that comes straight through both.
OPEN = 0.7 * 0.4
FOG = "medium: {type: homogeneous, sigma_t: 0.2, albedo: 0.8}\n"


def scene(integrator, text=SCENE, without=()):
    whole = loads(text, "holes").replaced(integrator=integrator)
    nodes = {name: node for name, node in whole.nodes.items() if name not in without}
    return whole.replaced(nodes=nodes)


def prepared(integrator, without=()):
    return compile_scene(flatten(scene(integrator, without=without)), structure="list")


def twin(integrator, without=()):
    return picture(prepared(integrator, without), Tile(0, 0, SIDE, SIDE)).mean((0, 1, 2))


@pytest.mark.parametrize(("integrator", "edges"), [(Path, 4), (VolPath, 2)])
def test_a_point_light_is_dimmed_by_what_stands_before_it(integrator, edges):
    """For `path` a hole is the end of an edge, for `volpath` it is nothing."""
    bulb, clear = ("lamp",), ("lamp", "veil", "glazing")
    free = twin(integrator(max_depth=2), clear)
    # One more edge would let light be reflected by the floor and the veil.
    found = twin(integrator(max_depth=edges), bulb)
    np.testing.assert_allclose(found, OPEN * free, rtol=1e-5)
    assert np.all(twin(integrator(max_depth=edges - 1), bulb) == 0.0)


def test_path_and_volpath_see_the_same_through_holes():
    """Same random numbers; few paths are so long that their depths matter."""
    options = {"max_depth": 16, "rr_depth": 16}
    tile = Tile(0, 8, 8, 16)
    ours, expected = (
        picture(prepared(integrator), tile).sum(axis=2)
        for integrator in (VolPath(**options), Path(heuristic="balance", **options))
    )
    close = np.isclose(ours, expected, rtol=1e-3).all(axis=-1)
    assert close.mean() > 0.9, close.mean()


@pytest.mark.proofs
@pytest.mark.parametrize("text", [SCENE, SCENE + FOG], ids=["clear", "fog"])
def test_all_strategies_find_the_light_behind_holes(text):
    integrator = VolPath if FOG in text else Path
    found = {
        strategy: alight.render(
            scene(integrator(light_sampling=strategy, max_depth=5), text, ("bulb",)), spp=spp
        )
        for strategy, spp in (("mis", 2048), ("emitter", 2048), ("bsdf", 8192))
    }
    mean = {name: film.image.mean(dtype=np.float64) for name, film in found.items()}
    error = {
        name: np.sqrt((film.standard_error[..., 0].astype(np.float64) ** 2).sum()) / SIDE**2
        for name, film in found.items()
    }
    for name in ("emitter", "bsdf"):
        off = np.hypot(error[name], error["mis"])
        assert abs(mean[name] - mean["mis"]) < 4.5 * off, (name, mean, error)
        assert off < 0.004 * mean["mis"], (name, off / mean["mis"])
