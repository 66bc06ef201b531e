"""Bidirectional path tracing: the picture of path tracing, to the same bits however divided."""

from __future__ import annotations

import numpy as np
import pytest

import alight
from alight.compiled.program import Program
from alight.compiled.scene import compile_scene
from alight.core.errors import OptionError, SceneError
from alight.films import Film
from alight.formats import loads
from alight.integrators.bidirectional import Bidirectional
from alight.integrators.both_ends import camera_subpath, light_subpath
from alight.integrators.both_ends.camera_subpath import weight_of_hit
from alight.integrators.both_ends.connection_weights import (
    Techniques,
    all_behind,
    techniques_at,
    techniques_beyond,
    together,
    weight_beside,
)
from alight.integrators.light import Light
from alight.integrators.path import Path
from alight.laws.integrators import DARK_LAMP, picture
from alight.laws.integrators import REPLICATES as FEW_REPLICATES
from alight.rendering.tiles import both_ends_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from lanewise.jit import instantiate
from tests.rendering.light_scenes import (
    BALL,
    BY_THE_CEILING,
    CASES,
    DEPTH,
    IN_GLASS,
    IN_STAINED_GLASS,
    LAMP,
    LONG_CASES,
    LOOK,
    MANY,
    ORTHO,
    PINHOLE,
    SCENE,
    SKY,
    STAINED_WATER,
    p_value,
    pictures,
    same,
    small,
)
from tests.sampling.statistics import SIGNIFICANCE

#: Far below everything: one of each model, so that several scenes share a kernel.
BELOW = "".join(
    f"  below {i}: {{shape: {shape}, bsdf: {bsdf}, {more}"
    "transform: [{scale: 1e-3}, {translate: [%d, -30, 0]}]}\n" % i
    for i, (shape, bsdf, more) in enumerate(
        [
            ("sphere", "{type: diffuse}", "light: {type: area, radiance: 1e-3}, "),
            ("rectangle", "{type: mirror}", "light: {type: area, radiance: 1e-3}, "),
            ("sphere", "{type: dielectric}", ""),
            (
                "{type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 2]]}",
                "{type: plastic}",
                "",
            ),
        ]
    )
)
PLANE = """
  ground:
    shape: plane
    bsdf: {type: diffuse, reflectance: %s}
    transform: [{rotate: {axis: x, angle: -90}}, {translate: [0, -40, 0]}]
"""


def with_all_models(text, radiance=1e-6):
    """A scene with one of each model far away, under a sky and on ground as bright as the sky."""
    below = BELOW if "shape: plane" in text else BELOW + PLANE % radiance
    return f"{text}{below}environment: {{type: constant, radiance: {radiance}}}\n"


#: Of the furnace, where light that goes around in glass lives long.
FURNACE = Bidirectional(max_depth=24, rr_depth=24)


def small_picture_in_the_twin():
    """Means (16, 16, replicates, 3) of a room under a sky, which paths meet at every depth."""
    spec = Bidirectional(max_depth=4, russian_roulette="none")
    scene = loads(DARK_LAMP, "room.yaml").replaced(integrator=spec)
    compiled = compile_scene(flatten(scene), structure="list")
    return picture(compiled, Tile(0, 0, 16, 16), spp=FEW_REPLICATES)


def agreement(text, depth=DEPTH, spp=256, light_choice="auto", **options):
    """Pictures by light from both ends and by path tracing."""
    of_both = {"max_depth": depth, "light_choice": light_choice}
    mine = pictures(text, Bidirectional(**of_both, **options), spp, 1)
    return mine, pictures(text, Path(**of_both), 2 * spp, 2)


#: As in `light_scenes`.
SCENES = {**CASES, "under water": with_all_models(CASES["under water"])}


@pytest.mark.parametrize("name", SCENES)
def test_it_finds_what_path_tracing_finds(name):
    mine, expected = agreement(SCENES[name])
    assert p_value(mine, expected) > SIGNIFICANCE
    assert p_value(0.97 * mine, expected) < SIGNIFICANCE


#: Scene, heuristic, and how lamps are chosen: that of the second is the third's "auto".
HIDDEN = {
    "in glass": (with_all_models(IN_GLASS), "power", "auto"),
    "in stained glass": (IN_STAINED_GLASS, "balance", "tree"),
    "many": (MANY, "balance", "auto"),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_it_finds_what_hides_in_glass_and_among_many_lamps(name):
    text, heuristic, light_choice = HIDDEN[name]
    mine, expected = agreement(text, light_choice=light_choice, heuristic=heuristic)
    assert p_value(mine, expected) > SIGNIFICANCE
    assert p_value(0.97 * mine, expected) < SIGNIFICANCE


def test_shapes_without_bounds_stop_light_from_infinity():
    turned = "[{rotate: {axis: x, angle: 90}}, {translate: [0, 30, 0]}]"
    roof = f"  roof: {{shape: plane, transform: {turned}}}"
    sky = "\nenvironment: {type: constant, radiance: 1}\n"
    mine, expected = agreement(SCENE % ("box", PINHOLE) + roof + sky, depth=4, spp=128)
    assert p_value(mine, expected) > SIGNIFICANCE


@pytest.mark.parametrize("integrator", [Bidirectional, Light])
def test_stained_water_dims_what_the_camera_sees_in_it(integrator):
    mine = pictures(STAINED_WATER, integrator(max_depth=4), 2048, 1)
    expected = pictures(STAINED_WATER, Path(max_depth=4), 512, 2)
    assert p_value(mine, expected) > SIGNIFICANCE
    assert p_value(0.9 * mine, expected) < SIGNIFICANCE


@pytest.mark.parametrize("integrator", [Bidirectional, Light])
def test_no_path_is_longer_than_the_longest(integrator):
    scene = loads(BY_THE_CEILING, "scene.yaml")
    short, long = (
        alight.render(scene.replaced(integrator=integrator(max_depth=depth)), spp=4).image
        for depth in (2, 3)
    )
    assert not short.any()
    assert long.mean() > 0.0


@pytest.mark.proofs
@pytest.mark.parametrize("name", LONG_CASES)
def test_it_finds_what_path_tracing_finds_everywhere(name):
    mine, expected = agreement(LONG_CASES[name], spp=1024)
    assert p_value(mine, expected) > SIGNIFICANCE
    assert p_value(0.99 * mine, expected) < SIGNIFICANCE


def test_in_a_furnace_everything_shines_alike():
    text = SCENE % ("box", PINHOLE) + BALL % "{type: dielectric, int_ior: 1.5}"
    text = text.replace("reflectance: [0.6, 0.5, 0.4]", "reflectance: 1")
    text = text.replace("type: plastic", "type: diffuse, reflectance: 1")
    furnace = pictures(with_all_models(text, radiance=1), FURNACE, 128, 5)
    assert p_value(furnace, np.ones_like(furnace)) > SIGNIFICANCE
    assert p_value(0.98 * furnace, np.ones_like(furnace)) < SIGNIFICANCE


# ---------------------------------------------------------------- weights


class Chain:
    """A path x_0 ... x_k from a light to the camera: densities and cosines of its vertices.

    Pairs are those of the light's side and of the camera's.
    """

    def __init__(self, rng, k, deltas):
        self.k, self.deltas = k, deltas
        self.pdf = rng.uniform(0.1, 3.0, (k, 2))
        self.pdf[deltas] = 1.0
        self.cosine = rng.uniform(0.1, 1.0, (k, 2))
        self.distance = rng.uniform(0.5, 2.0, k)
        self.emission, self.direct, self.importance = rng.uniform(0.2, 2.0, 3)
        self.paths = 30.0

    def densities(self):
        """p_s by its definition, of x_0 per steradian at x_1; 0 where there is no technique s."""
        k, squared = self.k, self.distance**2
        light, camera = np.ones(k), np.ones(k)
        light[1] = self.emission * self.cosine[1, 0]
        light[2:] = self.pdf[1:-1, 0] * self.cosine[2:, 0] / squared[1:-1]
        camera[1:-1] = self.pdf[2:, 1] * self.cosine[1:-1, 1] / squared[1:-1]
        camera[-1] = self.importance * self.cosine[-1, 1]
        found = np.array([light[1:s].prod() * camera[max(s, 1) :].prod() for s in range(k + 1)])
        found[0] *= self.pdf[1, 1]
        found[1] *= self.direct
        found[k] *= self.paths
        joins = [s > 0 and not {s - 1, s}.isdisjoint(self.deltas) for s in range(k + 1)]
        return np.where(joins, 0.0, found)

    def weights(self, program):
        """Those of all techniques, as kernels have them."""
        behind_all, at, beyond, beside, either, hit = (
            instantiate(f, program, compiled=False)
            for f in (all_behind, techniques_at, techniques_beyond, weight_beside, together,
                      weight_of_hit)
        )  # fmt: skip
        k, pdf, cosine = self.k, self.pdf, self.cosine
        squared = self.distance**2

        def walk(start, first, step, here):
            """Techniques behind each vertex, and beyond it."""
            there, found, left = 1 - here, {first: start}, {}
            for i in range(first, k if step > 0 else 0, step):
                delta = np.bool_(i in self.deltas)
                left[i] = beyond(found[i], cosine[i, there], pdf[i, here], pdf[i, there], delta)
                if 0 < i + step < k:
                    distance = self.distance[min(i, i + step)]
                    found[i + step] = at(left[i], distance, 1.0 / cosine[i + step, here])
            return found, left

        per_start = 1.0 / (self.emission * cosine[1, 0])
        light, _ = walk(Techniques(self.direct * per_start, per_start), 1, 1, 0)
        start = Techniques(self.paths / (self.importance * cosine[-1, 1]), 0.0)
        camera, left = walk(start, k - 1, -1, 1)
        arriving = self.emission * cosine[1, 0] * behind_all(camera[1], pdf[1, 0])
        found = [
            hit(left[1], self.direct, self.emission, np.uint32(k)),
            beside(either(pdf[1, 1], arriving) / self.direct),
        ]
        for s in range(2, k):
            by_camera = pdf[s, 1] * cosine[s - 1, 1] * behind_all(light[s - 1], pdf[s - 1, 1])
            by_light = pdf[s - 1, 0] * cosine[s, 0] * behind_all(camera[s], pdf[s, 0])
            found.append(beside(either(by_camera, by_light) / squared[s - 1]))
        seen = self.importance * cosine[-1, 1] / self.paths
        return [*found, beside(seen * behind_all(light[k - 1], pdf[-1, 1]))]


@pytest.mark.parametrize("heuristic", ["balance", "power"])
@pytest.mark.parametrize("k", [2, 3, 6])
def test_weights_are_the_shares_of_densities_and_sum_to_one(heuristic, k):
    rng, program = np.random.default_rng(k), Program(options=(("heuristic", heuristic),))
    for deltas in ([], [1], [k - 1], [k // 2], [2, 3][: k - 2]):
        chain = Chain(rng, k, deltas)
        powers = chain.densities() ** (2.0 if heuristic == "power" else 1.0)
        exist = powers > 0.0
        found = np.array(chain.weights(program))[exist]
        assert exist.any()
        np.testing.assert_allclose(found, (powers / powers.sum())[exist], rtol=1e-5)


def test_paths_that_are_too_long_to_be_joined_are_found_all_the_same(monkeypatch):
    whole = small_picture_in_the_twin()
    for module in (light_subpath, camera_subpath, both_ends_tile):
        monkeypatch.setattr(module, "LONGEST", 2)
    difference = small_picture_in_the_twin() - whole
    error = np.sqrt(difference.var(axis=2, ddof=1).mean() / (FEW_REPLICATES * 256))
    assert abs(difference.mean()) < 5.0 * error
    assert 0.0 < error < 0.005 * whole.mean()


# ---------------------------------------------------------------- bits


SHORT = Bidirectional(max_depth=4)


def test_threads_passes_and_merging_leave_the_bits():
    whole = alight.render(small(SHORT), spp=32, threads=1)
    assert whole.replicates == 16
    assert (whole.counts.sum(axis=2) == 32).all()
    assert same(whole, alight.render(small(SHORT), spp=32, threads=3, spp_per_pass=5))
    parts = [alight.render(small(SHORT), spp=16, first_sample=first) for first in (16, 0)]
    assert same(whole, Film.merge(*parts))


def test_films_of_unequal_numbers_of_paths_merge_without_bias():
    expected = alight.render(small(SHORT), spp=512, seed=7).replicate_means()[0]
    parts = [
        alight.render(small(SHORT), spp=n, first_sample=first) for n, first in ((32, 0), (96, 32))
    ]
    assert same(Film.merge(*parts), alight.render(small(SHORT), spp=128))
    assert abs(Film.merge(*parts).image.mean() / expected.mean() - 1.0) < 0.02


def test_an_interrupted_render_goes_on(tmp_path):
    path = tmp_path / "half.alight"
    scene = small(SHORT)
    alight.render(scene, spp=16, checkpoint=path)
    assert same(alight.resume(path, spp=32, scene=scene), alight.render(scene, spp=32))


def test_light_beside_the_window_is_lost():
    whole = alight.render(small(SHORT), spp=256, seed=3)
    part = alight.render(small(SHORT, crop=(8, 8, 16, 24)), spp=512, seed=4)
    a, b = whole.image[8:32, 8:24].mean(), part.image.mean()
    assert abs(a - b) < 0.02 * a


def test_nothing_is_missing_from_the_picture():
    film = alight.render(small(SHORT), spp=16)
    assert not any(bias.cause == "light paths" for bias in film.biases)


# ---------------------------------------------------------------- refusals


def refused(text, **options):
    scene = loads(text, "scene.yaml").replaced(integrator=Bidirectional(max_depth=3))
    with pytest.raises(OptionError) as caught:
        alight.render(scene, **(options or {"spp": 1}))
    return str(caught.value)


def test_what_it_cannot_do_is_refused():
    lamp = CASES["a lamp"]
    assert "bidirectional cannot render this: it takes the same" in refused(lamp, error=0.1)
    assert "has no layers, and depth is asked for" in refused(lamp, spp=1, aovs=["depth"])
    moving = lamp.replace(
        LOOK, "transform: {keyframes: [{time: 0}, {time: 1, translate: [1, 0, 0]}]}"
    )
    assert "the camera moves" in refused(moving)
    veil = SCENE % ("box", PINHOLE) + BALL % "{type: mask, opacity: 0.5, bsdf: {type: diffuse}}"
    plane = veil.replace("shape: rectangle", "shape: plane", 1)
    assert "shapes without bounds" in refused(plane + SKY)
    blend = "{type: blend, weight: 0.5, bsdfs: [{type: dielectric}, {type: diffuse}]}"
    assert "made of others" in refused(SCENE % ("box", PINHOLE) + BALL % blend + LAMP)


def test_parallel_rays_see_the_surroundings():
    mine, expected = agreement(SCENE % ("box", ORTHO) + SKY, spp=128)
    assert p_value(mine, expected) > SIGNIFICANCE


def test_media_and_traces_are_refused():
    fog = "medium: {type: homogeneous, sigma_t: 0.1}\n"
    text = CASES["a lamp"] + "integrator: bidirectional\n" + fog
    with pytest.raises(SceneError, match="bidirectional does not see media"):
        alight.render(loads(text, "scene.yaml"), spp=1)
    with pytest.raises(OptionError, match="no path of bidirectional starts at a pixel alone"):
        alight.trace(small(SHORT), (1, 1))
    with pytest.raises(OptionError, match="does not record where its light comes from"):
        alight.why(small(Light(max_depth=4)))
    with pytest.raises(OptionError, match="takes the same samples everywhere"):
        alight.plan(small(SHORT), error=0.1)
