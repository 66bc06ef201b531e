"""What light paths tell a guide: flux, directions and distances in closed form."""

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.equal_area import around_edges, sphere_to_square
from alight.core.vec import Vec3, luminance
from alight.formats import loads
from alight.guiding.light_records import add_arrivals
from alight.guiding.lookup import direction_density, leaf_at, place_at
from alight.guiding.parallax import focus_at, from_middle
from alight.guiding.records import cell_of
from alight.guiding.tables import LIGHT_RECORD, LightLog
from alight.integrators.walk import make_settings
from alight.rendering.training.guide_training import untrained
from alight.rendering.training.trainer import Trainer
from alight.scene import flatten
from lanewise.jit import instantiate
from lanewise.view import View
from tests.guiding.test_tree import FRAME, random_tree

#: Light from above meets a mirror of 2 m x 1 m, which slopes at 45 degrees, and turns to a wall.
MIRROR = """
alight: 1
camera: {{type: pinhole, fov: 70, transform: {{look_at: {{origin: [4, 1, 4], target: [2, 0, 0]}}}}}}
film: {{size: [64, 64]}}
integrator: {{type: path, max_depth: {depth}, guiding: "on", light_sampling: {sampling}}}
nodes:
  mirror:
    shape: rectangle
    bsdf: {{type: {first}, reflectance: 0.5}}
    transform:
      - {{scale: [1, 0.5, 1]}}
      - {{rotate: {{axis: x, angle: -90}}}}
      - {{rotate: {{axis: z, angle: -45}}}}
  wall:
    shape: rectangle
    bsdf: {{type: {wall}}}
    transform: [{{scale: 3}}, {{rotate: {{axis: y, angle: -90}}}}, {{translate: [3, 0, 0]}}]
  light: {light}
"""
SUN = "{light: {type: directional, irradiance: 2}, transform: {rotate: {axis: x, angle: 90}}}"
POINT = "{light: {type: point, intensity: 3}, transform: {translate: [0, 4, 0]}}"
LAMP = """
    shape: {type: sphere, radius: 0.01}
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: 1000}
    transform: {translate: [0, 4, 0]}
"""


def arrivals(light, *, sampling="mis", first="mirror", wall="diffuse", depth=4, samples=16, air=""):
    """Rows of a log, and the number of paths; `air` is a medium that fills the scene."""
    text = MIRROR.format(light=light, sampling=sampling, first=first, wall=wall, depth=depth)
    if air:
        text = text.replace("type: path", "type: volpath") + f"medium: {air}\n"
    trainer = Trainer(untrained(compile_scene(flatten(loads(text, "mirror.yaml")))), 1)
    settings = make_settings(trainer.scene.integrator, seed=5, replicates=1)
    logs = [trainer._light_tile(settings, tile, 0, samples) for tile in trainer.tiles]
    rows = np.concatenate([log.rows.shaped for log in logs]).astype(np.float64)
    return rows, samples * trainer.size[0] * trainer.size[1]


def test_a_mirror_sends_the_flux_of_the_sun_to_the_wall():
    """2 W/m2 on a projected area of sqrt(2) x 1 m2, half of it reflected, and from infinity."""
    rows, paths = arrivals(SUN, depth=3)
    assert len(rows) > 500
    # Light sampling finds the sun itself: nothing is recorded of it.
    assert rows[:, 3:6] == pytest.approx(np.tile([-1.0, 0.0, 0.0], (len(rows), 1)), abs=1e-5)
    assert (rows[:, 7] == 0.0).all()
    values = np.zeros(paths)
    values[: len(rows)] = rows[:, 6]
    error = values.std() / paths**0.5
    assert values.mean() == pytest.approx(2.0 * 2.0**0.5 * 0.5, abs=4.5 * error)
    assert error < 0.02


@pytest.mark.parametrize(("light", "radiant"), [(POINT, 3.0), (LAMP, 1000 * np.pi * 1e-4)])
def test_the_length_of_a_way_goes_over_mirrors(light, radiant):
    """Flux of the mirror's solid angle; 1 / distance to the image of the light at x = -4."""
    rows, paths = arrivals(light, depth=3)
    assert len(rows) > 100
    image = np.array([-4.0, 0.0, 0.0])
    way = np.linalg.norm(rows[:, :3] - image, axis=1)
    assert 1.0 / rows[:, 7] == pytest.approx(way, abs=0.03)
    w = (image - rows[:, :3]) / way[:, None]
    assert (rows[:, 3:6] * w).sum(1).min() > 1.0 - 1e-4
    # The solid angle of the mirror as the light sees it, by many points.
    a, b = (np.stack(np.meshgrid(*2 * [np.arange(400) + 0.5])) / 200 - 1.0) * [[[1]], [[0.5]]]
    d = np.stack([a / 2**0.5, -a / 2**0.5 - 4.0, b])
    cosine = np.abs(d[0] + d[1]) / 2**0.5
    solid = (cosine / (d**2).sum(0) ** 1.5).mean() * 2.0
    values = np.zeros(paths)
    values[: len(rows)] = rows[:, 6]
    error = values.std() / paths**0.5
    assert values.mean() == pytest.approx(0.5 * radiant * solid, abs=4.5 * error + 0.002 * solid)


@pytest.mark.parametrize("air", ["", "{type: homogeneous, sigma_t: 1e-9}"])
def test_a_way_begins_where_light_was_scattered(air):
    """At a matt plate in the mirror's place, which is the plane x + y = 0."""
    rows, _ = arrivals(POINT, first="diffuse", air=air)
    # Some meet a molecule very far away.
    rows = rows[np.abs(rows[:, :3]).max(1) < 10.0]
    way = 1.0 / rows[:, 7]
    began = rows[:, :3] + way[:, None] * rows[:, 3:6]
    at_wall = rows[:, 0] > 2.9
    assert at_wall.sum() > 100
    assert np.abs(began[at_wall, :2].sum(1)).max() < 1e-3
    # And what comes back to the plate comes from the wall, at x = 3.
    assert (~at_wall).sum() > 10
    assert began[~at_wall, 0] == pytest.approx(np.full((~at_wall).sum(), 3.0), abs=1e-3)


def test_only_what_light_sampling_misses_is_recorded():
    """Without it a lamp's direct light is recorded too; of a point there is none to be found."""
    seen, _ = arrivals(LAMP, sampling="bsdf")
    missed, _ = arrivals(LAMP)
    assert len(seen) > 4 * len(missed) > 0
    assert len(arrivals(POINT, sampling="bsdf")[0]) == len(arrivals(POINT)[0])


def test_walls_of_mirrors_and_too_long_paths_leave_no_records():
    """Nobody asks a guide at a mirror; light after two edges needs a third to be seen."""
    assert len(arrivals(SUN, wall="mirror")[0]) == 0
    assert len(arrivals(SUN, depth=3)[0]) > 0
    assert len(arrivals(SUN, depth=2)[0]) == 0


@pytest.mark.parametrize("depth", [2, 3, 4])
def test_air_that_hardly_scatters_changes_no_arrivals(depth):
    """The last vertex that light may have is recorded on both walks."""
    air = "{type: homogeneous, sigma_t: 1.0e-7, albedo: 0.5}"
    found = [arrivals(POINT, depth=depth, air=one)[0] for one in ("", air)]
    # What misses the wall is scattered far away.
    clear, foggy = ((np.abs(rows[:, :3]) < 10.0).all(1).sum() for rows in found)
    assert abs(clear - foggy) <= 5.0 * np.sqrt(clear)
    assert (clear > 1000) == (depth > 2)


@pytest.mark.parametrize("compiled", [False, True])
def test_sums_of_arrivals_are_those_of_their_leaves(compiled):
    """Flux within the box, by leaf and by quadrant: whole numbers, whose order does not matter."""
    tree = random_tree(2)
    guide = tree.guide(FRAME)
    rng = np.random.default_rng(3)
    n = 4003
    rows = np.zeros((n, LIGHT_RECORD), np.float32)
    # A part of the points is beside the box.
    rows[:, :3] = FRAME.box[:3] + rng.uniform(-0.1, 1.1, (n, 3)) / FRAME.box[3:]
    w = rng.standard_normal((n, 3))
    rows[:, 3:6] = w / np.linalg.norm(w, axis=1, keepdims=True)
    rows[:, 6], rows[:, 7] = rng.exponential(1.0, n), rng.uniform(0.0, 2.0, n)
    totals = tree.empty_totals()
    add = instantiate(add_arrivals, compiled=compiled) if compiled else add_arrivals
    add(guide, LightLog(View(rows), View(np.array([n, 0]))), totals, np.float32(1.0))
    place = (rows[:, :3] - FRAME.box[:3]) * FRAME.box[3:]
    inside = ((place >= 0.0) & (place < 1.0)).all(1)
    assert 0.3 < inside.mean() < 0.9
    leaf = leaf_at(guide, Vec3(*rows[inside, :3].T.copy()))
    flux = np.bincount(leaf, np.rint(rows[inside, 6] * 2.0**20), len(tree.roots))
    p, w = (Vec3(*rows[inside, k : k + 3].T.copy()) for k in (0, 3))
    density = direction_density(guide, place_at(guide, p), w, np.ones(len(leaf), bool))
    assert density.std() > 0.1 * density.mean()
    sharp = rows[inside, 6] * density * 2.0**20
    few = np.bincount(leaf, sharp, len(tree.roots))
    # Beside the border of a quadrant a rounding may choose the other one.
    assert totals.near.shaped[:, 0] == pytest.approx(few, rel=2e-3, abs=30)
    # From the middle of a leaf with a sphere, from the record itself in others.
    way, middle = 1.0 / np.maximum(rows[inside, 7], 1e-9), tree.focus[leaf, :3]
    source = rows[inside, :3] + way[:, None] * rows[inside, 3:6]
    has_sphere = focus_at(guide, leaf, p).r > 0.0
    assert 0.2 < has_sphere.mean() < 0.95
    far = np.where(has_sphere, np.linalg.norm(source - middle, axis=1), way)
    # The box is 4 m long.
    near = np.bincount(leaf, sharp * np.minimum(4.0 / far, 1000.0), len(tree.roots))
    assert totals.near.shaped[:, 1] == pytest.approx(near, rel=2e-3, abs=30)
    by_leaf = np.bincount(tree.leaf, totals.lit.shaped.sum(1), len(tree.roots))
    # Each of a record's quarters is a whole number.
    rounded = 2.0 * np.bincount(leaf, minlength=len(tree.roots))
    assert (np.abs(by_leaf - flux) <= rounded + 3).all()
    assert (totals.lit.shaped > 0).sum() > 2 * len(tree.roots)
    assert (totals.lit.shaped[tree.children > 0] == 0).all()
    # Quarters lie around the direction as the middle of the leaf sees it.
    seen, _ = from_middle(focus_at(guide, leaf, p), w)
    x, y = sphere_to_square(seen)
    active = np.ones(len(leaf), bool)
    _, side = cell_of(guide, leaf, x, y, active)
    quarters = np.zeros(totals.lit.shaped.size)
    for right, up in ((-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25)):
        around = around_edges(x + right * side, y + up * side)
        cell, _ = cell_of(guide, leaf, *around, active)
        quarters += np.bincount(cell, rows[inside, 6] * 2.0**18, quarters.size)
    misplaced = np.abs(totals.lit.shaped.ravel() - quarters).sum()
    # Rounding moves a direction beyond a border now and then.
    assert misplaced < 0.01 * quarters.sum()


#: A lamp in fog, and nothing else.
FOGGY = """
alight: 1
camera: {type: pinhole, transform: {look_at: {origin: [0, 4, 6], target: [0, 4, 0]}}}
film: {size: [64, 64]}
integrator: {type: volpath, max_depth: 4, guiding: "on", light_sampling: bsdf}
medium: fog
media: {fog: {type: homogeneous, sigma_t: [0.3, 0.6, 1.2], albedo: [0.9, 0.6, 0.3]}}
nodes:
  lamp: {light}
"""


def test_fog_dims_the_flux_that_collides_in_it():
    """The flux of each channel that is scattered between half a metre and two from the lamp."""
    text = FOGGY.replace("{light}", LAMP.replace("radiance: 1000", "radiance: [1000, 600, 300]"))
    trainer = Trainer(untrained(compile_scene(flatten(loads(text, "fog.yaml")))), 1)
    settings = make_settings(trainer.scene.integrator, seed=5, replicates=1)
    logs = [trainer._light_tile(settings, tile, 0, 4) for tile in trainer.tiles]
    rows = np.concatenate([log.rows.shaped for log in logs]).astype(np.float64)
    paths = 4 * trainer.size[0] * trainer.size[1]
    to_lamp = np.array([0.0, 4.0, 0.0]) - rows[:, :3]
    r = np.linalg.norm(to_lamp, axis=1)
    straight = (rows[:, 3:6] * to_lamp).sum(1) > (1.0 - 1e-3) * r
    assert (~straight).mean() > 0.2
    first = straight & (np.abs(1.0 / rows[:, 7] - r) < 0.02)
    values = np.zeros(paths)
    mine = rows[first & (r > 0.5) & (r < 2.0), 6]
    values[: len(mine)] = mine
    sigma_t, albedo = np.array([0.3, 0.6, 1.2]), np.array([0.9, 0.6, 0.3])
    power = np.array([1000.0, 600.0, 300.0]) * 4.0 * np.pi**2 * 1e-4
    scattered = power * albedo * (np.exp(-0.5 * sigma_t) - np.exp(-2.0 * sigma_t))
    error = values.std() / paths**0.5
    assert values.mean() == pytest.approx(luminance(Vec3(*scattered)), abs=4.5 * error)
    assert error < 0.01 * values.mean()
