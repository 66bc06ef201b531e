"""Laws of the light beyond a depth cap, from tiles whose every sample is known."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from alight.films import Film
from alight.films.fixed_point import to_limbs
from alight.integrators.path import Path
from alight.integrators.random_walk import RandomWalk
from alight.rendering import depth_cap
from alight.rendering.depth_cap import light_beyond, measured
from alight.rendering.rare_light import RareLight

#: Light of a path of one edge more over that of the path.
DECAY = 0.6


class Box:
    """A picture in which depth d brings `light` times DECAY^(d - 1), without noise."""

    def __init__(self, monkeypatch, integrator, light, corner=(0, 0), replicates=4):
        h, w = light.shape
        size = (corner[0] + w + 3, corner[1] + h + 5)
        film = Film(*size, crop=(*corner, w, h), replicates=replicates)
        self.light, self.corner, self.tiles = light, corner, []
        settings = SimpleNamespace(_replace=lambda **changes: SimpleNamespace(**changes))
        scene = SimpleNamespace(integrator=integrator)
        self.job = SimpleNamespace(
            rounds=[film], scene=scene, settings=settings, kernels=None, rare_light=RareLight()
        )
        monkeypatch.setattr(depth_cap, "render_tile", self.render)

    def render(self, kernels, scene, settings, tile, ranges, scratch):
        self.tiles.append((tile.x0, tile.y0, tile.x1, tile.y1, settings.max_depth, settings.seed))
        replicates = self.job.rounds[0].replicates
        assert ranges.tolist() == [[[0, replicates]]]
        x, y = self.corner
        own = self.light[tile.y0 - y : tile.y1 - y, tile.x0 - x : tile.x1 - x]
        depth = min(float(settings.max_depth), 1e4)
        values = own * (1.0 - DECAY**depth) / (1.0 - DECAY)
        values = values[:, :, None, None] * np.ones((replicates, 3))
        return SimpleNamespace(sums=to_limbs(values.astype(np.float32))[0]), None

    def beyond(self, cap):
        """What the cap truly cuts off, mean over the picture."""
        return float(self.light.mean()) * DECAY**cap / (1.0 - DECAY)


def uneven(rng, size, corner=(0, 0)):
    """Brightness by cells of the full picture."""
    w, h = size
    cells = rng.gamma(2.0, 0.5, (40, 40))
    y, x = np.mgrid[corner[1] : corner[1] + h, corner[0] : corner[0] + w] // 8
    return cells[y, x]


INTEGRATORS = {
    "roulette": Path(max_depth=3),
    "series": Path(max_depth=3, russian_roulette="none"),
    "chance": RandomWalk(max_depth=3),
}


@pytest.mark.parametrize("name", INTEGRATORS)
@pytest.mark.parametrize("cap", [1, 3, 8])
def test_an_even_picture_has_the_light_of_longer_paths_and_no_error(monkeypatch, name, cap):
    box = Box(monkeypatch, INTEGRATORS[name], np.full((32, 48), 0.7))
    lost = light_beyond(box.job, cap, 1)
    assert lost.radiance == pytest.approx(box.beyond(cap), rel=1e-5)
    depths = sorted({tile[4] for tile in box.tiles})
    assert depths[0] == cap
    assert depths[1:] == ([cap + 8, cap + 16] if name != "roulette" else [max(depths)])
    if name != "chance":
        assert lost.error == pytest.approx(0.0, abs=1e-6)
        return
    # As if the brightest sample had just been missed, of all samples of the pilot.
    samples = len({tile[:4] for tile in box.tiles}) * 64 * 4
    brightest = 0.7 * (1.0 - DECAY ** (cap + 16)) / (1.0 - DECAY)
    assert lost.error == pytest.approx(3.0 / 1.96 * brightest / samples, rel=1e-3)


@pytest.mark.parametrize("name", ["roulette", "series"])
@pytest.mark.parametrize("corner", [(0, 0), (5, 11)])
def test_the_estimate_is_unbiased_and_its_standard_error_its_spread(monkeypatch, name, corner):
    """Eight of the picture's cells are looked at, others with each seed."""
    light = uneven(np.random.default_rng(1), (122, 90), corner)
    box = Box(monkeypatch, INTEGRATORS[name], light, corner)
    found = [light_beyond(box.job, 3, seed) for seed in range(300)]
    values = np.array([one.radiance for one in found])
    truth = box.beyond(3)
    # A ratio of sums: its bias is of second order.
    assert values.mean() == pytest.approx(truth, abs=4.0 * values.std() / math.sqrt(300))
    errors = np.array([one.error for one in found])
    # Eight cells of some two hundred; the deviation of 300 numbers is right to 4 %.
    assert math.sqrt((errors**2).mean()) == pytest.approx(values.std(), rel=0.2)


@pytest.mark.parametrize(
    ("name", "size", "replicates", "cells"),
    [
        ("roulette", (64, 64), 4, 8), ("roulette", (256, 256), 4, 32), ("roulette", (64, 64), 8, 8),
        ("chance", (128, 128), 4, 64), ("roulette", (8, 16), 4, 2), ("series", (800, 800), 1, 1024),
    ],
)  # fmt: skip
def test_one_sample_for_eight_pixels_and_2048_and_eight_cells_at_least(
    monkeypatch, name, size, replicates, cells
):
    box = Box(monkeypatch, INTEGRATORS[name], np.ones(size[::-1]), replicates=replicates)
    if cells < 100:
        light_beyond(box.job, 3, 1)
        assert len({tile[:4] for tile in box.tiles}) == cells
        return
    assert len(depth_cap._some_cells(box.job, 1)[0]) == cells


def test_all_cells_of_the_window_are_looked_at_and_nothing_else(monkeypatch):
    corner, (w, h) = (13, 6), (60, 43)
    box = Box(monkeypatch, INTEGRATORS["roulette"], np.ones((h, w)), corner)
    seen, visits = np.zeros((h, w), int), np.zeros((h, w), int)
    for seed in range(60):
        box.tiles.clear()
        light_beyond(box.job, 3, seed)
        visits[:] = 0
        for x0, y0, x1, y1, _, used in box.tiles:
            assert used == seed
            assert corner[0] <= x0 < x1 <= corner[0] + w
            assert corner[1] <= y0 < y1 <= corner[1] + h
            assert x0 // 8 == (x1 - 1) // 8
            assert y0 // 8 == (y1 - 1) // 8
            visits[y0 - corner[1] : y1 - corner[1], x0 - corner[0] : x1 - corner[0]] += 1
        # Both depths of a cell, and no cell twice.
        assert set(np.unique(visits)) == {0, 2}
        seen += visits
    # Eight of 54 cells each time.
    assert seen.min() > 0
    assert seen.max() < 2 * 60 * 0.5


def test_the_ledger_says_how_much_darker_the_picture_is(monkeypatch):
    box = Box(monkeypatch, INTEGRATORS["series"], uneven(np.random.default_rng(2), (64, 64)))
    lost = light_beyond(box.job, 3, 4)
    (bias,) = measured(box.job, 4)
    assert (bias.effect, bias.error) == (-lost.radiance, lost.error)
    assert lost.error > 0.0
    assert measured(SimpleNamespace(scene=SimpleNamespace(integrator=Path())), 4) == ()
