"""What training writes down and sums up, against what is known without it."""

import itertools

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.equal_area import sphere_to_square, square_to_sphere
from alight.core.vec import Vec3
from alight.formats import loads
from alight.guiding.lookup import leaf_at
from alight.guiding.parallax import NEAR
from alight.guiding.records import CHOICES, LEAF_SUMS, MOST, UNITS, add_records, cell_at
from alight.guiding.tables import LEAF_ROW, RECORD, Frame, Log
from alight.integrators.guided import pixel_luminance
from alight.laws.statistics import LARGEST_Z
from alight.rendering.training import guide_training as training
from alight.rendering.training import trainer
from alight.samplers.state import SamplerState
from alight.scene import flatten
from lanewise.jit import instantiate
from lanewise.simd import LANES
from lanewise.view import View
from tests.guiding.test_tree import FRAME, random_tree

ALBEDO, DEPTH, ROUNDS = 0.5, 5, 3

#: A closed box whose walls shine with radiance 1: what arrives is the same from everywhere.
FURNACE = f"""
alight: 1
film: {{size: [40, 28]}}
sampler: independent
camera: {{type: pinhole, fov: 60, transform: {{look_at: {{origin: [.2, .1, .3], target: [1, .5, -1]}}}}}}
integrator:
  {{type: path, guiding: "on", light_sampling: bsdf, russian_roulette: none, max_depth: {DEPTH}}}
nodes:
  box:
    shape: {{type: cube, flip_normals: true}}
    bsdf: {{type: diffuse, reflectance: {ALBEDO}}}
    light: {{type: area, radiance: 1}}
"""  # noqa: E501


# ---------------------------------------------------------------- sums


def cells_by_geometry(tree, leaf, x, y):
    """The undivided quadrant, 4 a node, that holds a point of a leaf's square, and its side."""
    node, corner, size = int(tree.roots[leaf]), np.zeros(2), 0.5
    while True:
        right, upper = x >= corner[0] + size, y >= corner[1] + size
        place = int(right) + 2 * int(upper)
        corner = corner + size * np.array([right, upper])
        child = int(tree.children[node, place])
        if not child:
            return 4 * node + place, size
        node, size = child, size / 2


def across_the_seam(x, y):
    """The point of the square where an unfolded octahedron goes on: an edge meets its mirror."""
    while not (0.0 <= x < 1.0 and 0.0 <= y < 1.0):
        if not 0.0 <= x < 1.0:
            x, y = (-x if x < 0.0 else 2.0 - x), 1.0 - y
        else:
            x, y = 1.0 - x, (-y if y < 0.0 else 2.0 - y)
    return x, y


def seen_from_middle(focus, p, d):
    """Where a ray meets the sphere of its leaf, as its middle sees it, and what that spreads."""
    o, r = p - focus[:3], focus[3]
    if o @ o >= (NEAR * r) ** 2:
        return d, 1.0
    t = max(np.roots([1.0, 2.0 * o @ d, o @ o - r * r]))
    seen = (o + t * d) / r
    return seen, t * t / (r * r * (seen @ d))


def test_every_direction_lies_in_its_quadrant():
    """Also next to the borders of quadrants, where few directions of a record lie."""
    tree, rng = random_tree(4), np.random.default_rng(4)
    n = 3000
    squares = rng.random((2, n))
    # A third of them beside a border of some level, by up to 3 % of a quadrant.
    near = rng.random((2, n)) < 0.3
    size = 0.5 ** rng.integers(1, 5, (2, n))
    beside = size * (rng.integers(0, 16, (2, n)) % (1.0 / size) + rng.uniform(-0.03, 0.03, (2, n)))
    squares = np.clip(np.where(near, beside, squares), 1e-3, 1.0 - 1e-3).astype(np.float32)
    w = square_to_sphere(*squares)
    leaf = rng.integers(0, len(tree.roots), n).astype(np.uint32)
    found = cell_at(tree.guide(FRAME), leaf, w, np.ones(n, bool))
    x, y = sphere_to_square(w)
    expected = [cells_by_geometry(tree, *one)[0] for one in zip(leaf, x, y, strict=True)]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("seed", range(3))
def test_sums_are_those_of_the_records_one_by_one(seed):
    """Second moments of quadrants and of all choices, exact but for the rounding of a unit."""
    tree, rng = random_tree(seed), np.random.default_rng(seed)
    guide, n, samples = tree.guide(FRAME), 5 * LANES + 3, 40
    rows = np.exp(rng.standard_normal((n, RECORD))).astype(np.float32)
    low, scale = FRAME.box[:3], FRAME.box[3:]
    place = rng.random((n, 3))
    rows[:, :3] = low + place / scale
    d = rng.standard_normal((n, 3))
    rows[:, 3:6] = d / np.linalg.norm(d, axis=1)[:, None]
    # Some directions only the guide would draw, some only the BSDF.
    rows[rng.random(n) < 0.2, 7] = 0.0
    shape = (*tree.children.shape, 2)
    densities = np.exp(rng.standard_normal(shape)) * (rng.random(shape) > 0.2)
    number = rng.integers(0, samples, n).astype(np.uint32)
    rows[:, 11] = number.view(np.float32)
    ends = (5.0 * np.exp(rng.standard_normal(samples))).astype(np.float32)
    # Ends that are not finite and vertices without a throughput say nothing; few say very much.
    ends[3], ends[5] = np.nan, np.inf
    rows[7, 9], rows[9, 8], number[9] = 0.0, 1e12, 0
    rows[9, 11] = number[9:10].view(np.float32)[0]
    unit = 0.25
    log = Log(
        View(rows), View(np.array([n, 0])), View(ends), View(ends), View(np.zeros(6, np.uint32))
    )
    totals = tree.empty_totals()
    known = View(densities.astype(np.float32))
    instantiate(add_records)(guide, known, log, totals, np.float32(unit))

    cells = np.zeros(tree.children.size)
    leaves = np.zeros((len(tree.roots), LEAF_SUMS))
    middles = np.zeros((len(tree.roots), 3))
    mine = leaf_at(guide, Vec3(*rows[:, :3].T.copy()))
    for i in range(n):
        *_, pdf, of_bsdf, weight, beta, before, _ = rows[i].astype(float)
        end = float(ends[number[i]])
        gain = weight * (end - before) / (beta or 1.0) if np.isfinite(end) else 0.0
        moment = gain**2 * pdf
        w, spread = seen_from_middle(tree.focus[mine[i]], *rows[i, :6].astype(float).reshape(2, 3))
        x, y = sphere_to_square(Vec3(*w.astype(np.float32)[:, None]))
        cell, side = cells_by_geometry(tree, mine[i], x[0], y[0])
        by_camera, by_light = densities.reshape(-1, 2)[cell] * spread
        # A quarter to each quarter of a box of the quadrant's size around the direction.
        for right, up in itertools.product((-0.25, 0.25), repeat=2):
            beside = np.float32([x[0] + right * side, y[0] + up * side])
            if not ((beside >= 0.0) & (beside < 1.0)).all():
                beside = across_the_seam(*beside)
            near, _ = cells_by_geometry(tree, mine[i], *beside)
            cells[near] += 0.25 * min(moment / unit**2 * UNITS, MOST)
        leaves[mine[i], 0] += 1
        middles[mine[i]] += place[i] * UNITS
        for k, (share, mix) in enumerate(CHOICES):
            of_guide = (1.0 - mix) * by_camera + mix * by_light
            other = (1.0 - share) * of_bsdf + share * of_guide
            ratio = moment / other if other > 0.0 else 0.0
            leaves[mine[i], 1 + k] += min(ratio / unit**2 * UNITS, MOST)
    found = totals.cells.shaped.ravel(), totals.leaves.shaped, totals.middles.shaped
    assert (found[1][:, 0] == leaves[:, 0]).all()
    for a, b in zip(found, (cells, leaves, middles), strict=True):
        assert (np.abs(a - b) <= 5e-5 * b + 0.5 * np.maximum(leaves[:, 0].max(), 1.0)).all()
    assert (cells >= 0.25 * MOST).any()
    assert (tree.focus[mine, 3] > 0.0).any()


# ---------------------------------------------------------------- records


@pytest.fixture(scope="module")
def logs():
    """What the rounds of a training in the furnace left: lists of (guide, rows, ends, window)."""
    found = []
    with pytest.MonkeyPatch.context() as patch:

        def watched(root, *rest):
            made = instantiate(root, *rest)
            if root is not add_records:
                return made

            def add(guide, densities, log, totals, unit):
                count = int(log.count.array[0])
                rows = log.rows.shaped.reshape(-1, RECORD)[:count].astype(float)
                number = log.rows.shaped.reshape(-1, RECORD)[:count, 11].copy().view(np.uint32)
                if count:
                    ends, window = log.ends.array.copy(), log.window.array.copy()
                    found.append((guide, rows, number, ends, window))
                made(guide, densities, log, totals, unit)

            return add

        patch.setattr(trainer, "instantiate", watched)
        scene = compile_scene(flatten(loads(FURNACE, "furnace.yaml")))
        guided, report = training.trained(scene, seed=5, threads=1, rounds=ROUNDS)
    assert sum(len(rows) for _, rows, *_ in found) == report.vertices
    assert sum(len(ends) for *_, ends, _ in found) == report.paths
    return guided.guide, found


def series(terms):
    return (1.0 - ALBEDO**terms) / (1.0 - ALBEDO)


def places_in_paths(number):
    """0, 1, 2 ... for the vertices of each sample, which stand in their order."""
    first = np.r_[True, number[1:] != number[:-1]]
    start = np.flatnonzero(first)
    return np.arange(len(number)) - np.repeat(start, np.diff(np.r_[start, len(number)]))


def test_samples_of_a_furnace_end_with_its_radiance(logs):
    """Exactly without a guide, in the mean with one. Catches samples that overwrite each other."""
    asked = []
    for guide, _, number, ends, _ in logs[1]:
        if guide.leaves.shaped.reshape(-1, LEAF_ROW)[:, 0].max() > 0.0:
            asked.append(ends.astype(float))
            assert (ends >= 1.0 - 1e-5).all()
        else:
            assert ends == pytest.approx(series(DEPTH), rel=1e-5)
            assert (np.bincount(number, minlength=len(ends)) == DEPTH - 1).all()
    ends = np.concatenate(asked)
    z = (ends.mean() - series(DEPTH)) / (ends.std() / np.sqrt(len(ends)))
    assert abs(z) < LARGEST_Z


def test_what_a_vertex_gains_in_a_furnace_is_known(logs):
    """f cos L, whatever drew the direction: the density of the mixture cancels."""
    rounds, excess = 0, [[] for _ in range(DEPTH - 1)]
    for guide, rows, number, ends, _ in logs[1]:
        order = np.argsort(number, kind="stable")
        rows, number = rows[order], number[order]
        p, d, (pdf, of_bsdf) = rows[:, :3], rows[:, 3:6], rows[:, 6:8].T
        weight, beta, before = rows[:, 8:11].T
        assert np.abs((d**2).sum(1) - 1.0).max() < 1e-5
        # Walls are at +-1: the normal is along the axis on which the point is farthest.
        axis, each = np.abs(p).argmax(1), np.arange(len(p))
        assert np.abs(np.abs(p[each, axis]) - 1.0).max() < 1e-5
        cosine = np.maximum(-np.sign(p[each, axis]) * d[each, axis], 0.0)
        np.testing.assert_allclose(of_bsdf, cosine / np.pi, 1e-4, 1e-6)
        np.testing.assert_allclose(weight * pdf, ALBEDO * of_bsdf, 1e-4, 1e-6)
        leaf = leaf_at(guide, Vec3(*p.T.astype(np.float32)))
        share = guide.leaves.shaped.reshape(-1, LEAF_ROW)[leaf, 0].astype(float)
        assert (pdf >= (1.0 - share) * of_bsdf * (1.0 - 1e-4)).all()
        asked = share > 0.0
        np.testing.assert_allclose(pdf[~asked], of_bsdf[~asked], 1e-4)
        rounds += asked.any()
        left, place = beta > 0.0, places_in_paths(number)
        per_light = np.where(left, weight / np.where(left, beta, 1.0), 0.0)
        gained = per_light * (ends[number] - before)
        expected = ALBEDO * of_bsdf * series(DEPTH - 1 - place)
        # Sums of light are rounded once a vertex; of what follows only the mean is known, but for
        # the last vertex, and without a guide.
        error = 1e-4 * expected + DEPTH * 2.0**-24 * ends[number] * per_light * pdf
        known = left & ((place == DEPTH - 2) | (guide.leaves.array[0] == 0.0))
        assert (np.abs(gained * pdf - expected) <= error)[known].all()
        for i in range(DEPTH - 1):
            excess[i].append(gained[place == i] - ALBEDO * series(DEPTH - 1 - i))
    # Unbiased: the mean of f cos L / p is the light that is reflected.
    for mine in map(np.concatenate, excess):
        assert abs(mine.mean()) < LARGEST_Z * (mine.std() / np.sqrt(len(mine)) + 1e-6)
    # The guide was asked in some rounds, and not in the first.
    assert 0 < rounds < len(logs[1])


def test_the_frame_of_a_guide_is_what_training_saw(logs):
    """The root mean square of pixels, all alike in a furnace, and a box of all vertices."""
    guide, found = logs
    assert guide.picture.array == pytest.approx(series(DEPTH), rel=0.05)
    # With a margin around what camera and light paths met.
    low, scale = guide.box.array[:3], guide.box.array[3:]
    bounds = np.concatenate([rows[:, :3] for _, rows, *_ in found])
    assert (low <= bounds.min(0)).all() and (low + 1.0 / scale >= bounds.max(0)).all()
    assert 1.0 / scale == pytest.approx(np.ptp(bounds, axis=0), rel=0.05)


#: Of films, and (rows, columns) of the blocks of training.
SIZES = [((40, 28), (7, 10)), ((5, 9), (3, 2)), ((3, 3), (5, 4))]


@pytest.mark.parametrize(("size", "shape"), SIZES)
def test_a_pixel_asks_the_block_that_it_lies_in(size, shape):
    """Also where the film has other pixels than the picture of training."""
    rows, columns = shape
    picture = np.arange(1.0, rows * columns + 1.0, dtype=np.float32).reshape(shape)
    scale = np.array([columns / size[0], rows / size[1]], np.float32)
    blocks = np.array([columns, *scale.view(np.uint32)], np.uint32)
    guide = random_tree(0, 1).guide(Frame(FRAME.box, picture, blocks))
    x, y = (
        v.ravel().astype(np.uint32) for v in np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    )
    zero = 0 * x
    sampler = SamplerState(**dict.fromkeys(SamplerState._fields, zero) | {"x": x, "y": y})
    expected = picture[(y * rows) // size[1], (x * columns) // size[0]]
    # Where a pixel begins at the border of a block, rounding decides.
    inside = ((y * rows) % size[1] > 0) & ((x * columns) % size[0] > 0)
    found = np.broadcast_to(pixel_luminance(guide, sampler), x.shape)
    assert (found == expected)[inside].all()
    assert inside.sum() > 2
