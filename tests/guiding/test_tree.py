"""A guide's tree: a partition of space, densities of directions, and how both grow."""

import numpy as np
import pytest

from alight.core.equal_area import around_edges, sphere_to_square, square_to_sphere
from alight.core.vec import Vec3, length
from alight.guiding.lookup import Place, direction_density, draw_direction, leaf_at, place_at
from alight.guiding.parallax import NEAR, Focus, from_middle, from_point
from alight.guiding.records import CHOICES, UNITS, Totals
from alight.guiding.tables import Frame
from alight.guiding.tree import EVEN, FEW, FIRST_MIX, FIRST_SHARE, PART, SURE_OF_SHARE, Tree

FRAME = Frame(
    box=np.array([-1.0, 2.0, 0.5, 0.5, 0.25, 1.0], np.float32),
    picture=np.ones((1, 1), np.float32),
    blocks=np.zeros(3, np.uint32),
)


def random_tree(seed: int, rounds: int = 4, focused: int = 1) -> Tree:
    """A tree that has learnt from sums of every size."""
    rng = np.random.default_rng(seed)
    tree = Tree.new()
    for number in range(rounds):
        counts = rng.integers(0, 3000, len(tree.roots))
        cells = np.exp(4.0 * rng.standard_normal((len(tree.children), 4))) * UNITS
        cells[rng.random(cells.shape) < 0.2] = 0.0
        totals = tree.empty_totals()
        totals.cells.shaped[:] = cells
        totals.lit.shaped[:] = rng.permuted(cells, axis=0)
        totals.leaves.shaped[:] = rng.integers(0, 1 << 30, totals.leaves.shaped.shape)
        totals.leaves.shaped[:, 0] = counts
        totals.middles.shaped[:] = counts[:, None] * UNITS * rng.random((len(counts), 3))
        totals.near.shaped[:] = rng.integers(1, 100, (len(counts), 2)) * int(UNITS)
        tree.learn(totals, 1.0, asked=number > 0)
        if number == focused:
            tree = tree.focused(totals, FRAME.box)
        tree = tree.grown(counts, 1 << 14)
    return tree


def of_cells(tree: Tree, cells, lit, leaves) -> Totals:
    """Sums of a round, as far as a tree learns densities from them."""
    totals = tree.empty_totals()
    for table, values in zip(totals, (cells, lit, leaves), strict=False):
        table.shaped[:] = values
    return totals


def at_middle(leaf: int, n: int) -> Place:
    """Points of a leaf that keep their directions."""
    zero = np.zeros(n, np.float32)
    return Place(np.full(n, leaf, np.uint32), Focus(Vec3(zero, zero, zero), zero))


def test_the_map_of_directions_has_an_inverse_and_equal_areas():
    """Catches a wrong fold of the lower hemisphere, and a radius that does not keep areas."""
    rng = np.random.default_rng(1)
    x, y = rng.random((2, 200_000)).astype(np.float32)
    w = square_to_sphere(x, y)
    assert np.abs(w.x**2 + w.y**2 + w.z**2 - 1.0).max() < 1e-6
    # Pairs of bins that are equal on the sphere: z, and the angle around the axis.
    bins, _, _ = np.histogram2d(
        w.z, np.arctan2(w.y, w.x), (8, 16), range=[(-1.0, 1.0), (-np.pi, np.pi)]
    )
    expected = x.size / bins.size
    chi2 = ((bins - expected) ** 2 / expected).sum()
    # 127 degrees of freedom: mean 127, standard deviation 16.
    assert chi2 < 127 + 5 * 16
    a, b = sphere_to_square(w)
    assert max(np.abs(a - x).max(), np.abs(b - y).max()) < 1e-6
    poles = Vec3(*np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0]], np.float32).T)
    there = square_to_sphere(*sphere_to_square(poles))
    # The lower pole is a corner of the square, which belongs to the next pixel.
    for axis in "xyz":
        assert np.abs(getattr(there, axis) - getattr(poles, axis)).max() < 1e-3


def test_beyond_an_edge_of_the_square_the_map_goes_on():
    """From any edge or corner on, directions move by no more than the map stretches a step."""
    rng = np.random.default_rng(2)
    n, step = 20_000, 1e-3
    x, y = rng.random((2, n))
    side = rng.integers(0, 4, n)
    x, y = np.where(side < 2, side, x), np.where(side < 2, y, side - 2)
    inside, beyond = (
        square_to_sphere(
            *around_edges(*(np.float32(0.5 + (v - 0.5) * (1.0 + way * 2.0 * step)) for v in (x, y)))
        )
        for way in (-1.0, 1.0)
    )
    apart = [np.asarray(getattr(inside, c) - getattr(beyond, c), np.float64) for c in "xyz"]
    distance = np.sqrt(sum(a * a for a in apart))
    assert distance.max() < 20.0 * step
    # And they do move, but for the middles of edges: a mirrored map would come back.
    assert np.quantile(distance, 0.01) > 3.0 * step
    # Points of the square stay where they are.
    a, b = rng.random((2, n)).astype(np.float32)
    for found, expected in zip(around_edges(a, b), (a, b), strict=True):
        assert (found == np.minimum(expected, np.float32(1.0 - 2.0**-24))).all()


@pytest.mark.parametrize("seed", range(3))
def test_leaves_are_a_partition_of_the_box(seed):
    """Every word is reached once, and a point's leaf is the one whose box holds it."""
    tree = random_tree(seed)
    guide = tree.guide(FRAME)
    rng = np.random.default_rng(seed)
    p = rng.random((3, 4000)).astype(np.float32)
    low, scale = FRAME.box[:3, None], FRAME.box[3:, None]
    found = leaf_at(guide, Vec3(*(low + p / scale)))
    assert len(tree.roots) > 20
    for i in range(0, 4000, 37):
        place, axis = 0, 0
        low_, high_ = np.zeros(3), np.ones(3)
        while tree.space[place] < 0x80000000:
            middle = (low_[axis] + high_[axis]) / 2
            if abs(p[axis, i] - middle) < 1e-5:
                break
            upper = p[axis, i] > middle
            (low_ if upper else high_)[axis] = middle
            place, axis = tree.space[place] + int(upper), (axis + 1) % 3
        else:
            assert found[i] == tree.space[place] - 0x80000000
    assert sorted(word - 0x80000000 for word in tree.space if word >= 0x80000000) == list(
        range(len(tree.roots))
    )
    # Outside the box, that at its border.
    outside = leaf_at(guide, Vec3(*(low - 5.0 / scale).astype(np.float32)))
    assert outside == leaf_at(guide, Vec3(*low))


@pytest.mark.parametrize(
    ("seed", "leaves"),
    [(0, 60), *(pytest.param(i, 340, marks=pytest.mark.proofs) for i in (1, 2, 3))],
)
def test_directions_have_the_density_that_is_told(seed, leaves):
    """Chi-squared of random leaves (a thousand as a proof): drawn directions against their density.

    Catches a density without the Jacobian, and quadrants that are drawn in another order than they
    are looked up.
    """
    tree = random_tree(seed)
    guide = tree.guide(FRAME)
    rng = np.random.default_rng(100 + seed)
    n, grid = 4096, 8
    worst = []
    moved = 0
    # Leaves with much in quadrants that are finer than the points below.
    deep = tree.leaf[(tree.level >= 5) & (tree.weight.max(1) > 1e-3)]
    for p in FRAME.box[:3] + rng.random((8 * leaves, 3)) / FRAME.box[3:]:
        mine = place_at(guide, Vec3(*np.tile(p[:, None], n).astype(np.float32)))
        if mine.leaf[0] in deep:
            continue
        u = rng.random((2, n)).astype(np.float32)
        yes = np.ones(n, bool)
        none = Vec3(*np.ones((3, n), np.float32))
        w, told = draw_direction(guide, mine, yes, (u[0], u[1]), none, yes)
        again = direction_density(guide, mine, w, yes)
        # A direction at the border of a quadrant may be rounded into the next one.
        assert (np.abs(told - again) > 1e-4 * told).mean() < 0.01
        x, y = sphere_to_square(w)
        drawn, _, _ = np.histogram2d(x, y, grid, range=[(0, 1), (0, 1)])
        # The density of each cell, by many points of it. Quadrants that a sphere has moved do not
        # end where cells do, so that some cells are not known well enough.
        fine = 128
        a, b = (np.indices((fine, fine))[::-1] + rng.random((2, fine, fine))) / fine
        v = square_to_sphere(a.ravel().astype(np.float32), b.ravel().astype(np.float32))
        there = place_at(guide, Vec3(*np.tile(p[:, None], fine * fine).astype(np.float32)))
        density = 4.0 * np.pi * direction_density(guide, there, v, np.ones(fine * fine, bool))
        cells = density.reshape(grid, fine // grid, grid, fine // grid).transpose(2, 0, 1, 3)
        cells = cells.reshape(grid, grid, -1)
        expected = n * cells.mean(2) / grid**2
        error = n * cells.std(2) / grid**2 / (fine // grid)
        many = (expected > 5) & (error < 0.2 * np.sqrt(expected))
        # It integrates to one, even where only few cells are known.
        assert abs(expected.sum() - n) < 6.0 * np.sqrt((error**2).sum()) + 1e-4 * n
        if many.sum() < 4:
            continue
        chi2 = ((drawn - expected)[many] ** 2 / expected[many]).sum()
        worst.append((chi2 - many.sum()) / np.sqrt(2.0 * many.sum()))
        moved += mine.focus.r[0] > 0.0
        if len(worst) == leaves:
            break
    assert len(worst) == leaves and moved > leaves / 4
    # Standard normal, but for a tail to the right.
    assert abs(np.mean(worst)) < 4.5 / np.sqrt(len(worst))
    assert max(worst) < 7.0


@pytest.mark.parametrize("seed", range(3))
def test_densities_are_the_weights_of_quadrants(seed):
    """In the middle of each undivided quadrant; with their areas they sum to one."""
    tree = random_tree(seed)
    guide = tree.guide(FRAME)
    for leaf in range(0, len(tree.roots), 7):
        quadrants, waiting = [], [(int(tree.roots[leaf]), 0.0, 0.0, 0.5)]
        while waiting:
            node, x, y, size = waiting.pop()
            for place in range(4):
                corner = x + size * (place % 2), y + size * (place // 2)
                child = int(tree.children[node, place])
                if child:
                    waiting.append((child, *corner, size / 2))
                else:
                    quadrants.append((*corner, size, tree.weight[node, place]))
        x, y, size, weight = np.array(quadrants).T
        w = square_to_sphere(*((v + size / 2).astype(np.float32) for v in (x, y)))
        n = len(size)
        density = direction_density(guide, at_middle(leaf, n), w, np.ones(n, bool))
        share = 4.0 * np.pi * density * size**2
        assert share.sum() == pytest.approx(1.0, abs=1e-4)
        # Ten bits for each half of each level.
        assert np.abs(share - weight / weight.sum()).max() < 5e-3


def test_weights_follow_the_root_of_moment_times_area():
    """Four quadrants: the parts are in the ratio of the optimal density, and of the flux."""
    tree = Tree.new()
    cells, lit = np.array([[1, 4, 9, 16]]) << 20, np.array([[4, 3, 2, 1]]) << 20
    tree.learn(of_cells(tree, cells, lit, 1), 1.0, asked=False)
    assert tree.parts[0, :, 0] == pytest.approx(np.array([1, 2, 3, 4]) / 10)
    assert tree.parts[0, :, 1] == pytest.approx(np.array([4, 3, 2, 1]) / 10)
    assert (tree.shares, tree.mixes) == ([FIRST_SHARE], [FIRST_MIX])
    assert tree.weight[0] == pytest.approx(tree.parts[0].mean(1))


@pytest.mark.parametrize(("gained", "arrived"), [(0, 1), (1, 0)])
def test_who_knows_nothing_takes_the_others_word(gained, arrived):
    """A leaf where no camera path found light, and one that no light path reached."""
    tree = Tree.new()
    known = np.array([[1, 4, 9, 16]]) << 20
    tree.learn(of_cells(tree, gained * known, arrived * known, 1), 1.0, asked=False)
    assert (tree.parts[..., 0] == tree.parts[..., 1]).all()
    assert tree.parts[0, :, 0].sum() == pytest.approx(1.0)
    tree.learn(of_cells(tree, 0 * known, 0 * known, 1), 1.0, asked=False)
    assert tree.densities().shaped == pytest.approx(1 / (4 * np.pi))


def test_a_leaf_chooses_what_has_the_least_second_moment():
    """And a leaf without vertices does as all others do, however bright these are."""
    tree = random_tree(3)
    n = len(tree.roots)
    # A few leaves are so bright that their sums are larger than those of all others together.
    bright = np.where(np.arange(n) % 9 == 1, 1 << 12, 1)[:, None]
    leaves = np.full((n, 1 + len(CHOICES)), 1 << 40) * bright
    leaves[:, 0] = 1 << 20
    best = np.arange(n) % len(CHOICES)
    leaves[np.arange(n), 1 + best] = (1 << 30) * bright[:, 0]
    leaves[0] = 0
    tree.learn(of_cells(tree, 1, 1, leaves), 1.0, asked=True)
    chosen = list(zip(tree.shares, tree.mixes, strict=True))
    assert chosen[1:] == [CHOICES[i] for i in best[1:]]
    # Most leaves prefer the third choice, the brightest the second.
    leaves[1:, 1:] = (1 << 40) * bright[1:]
    leaves[np.arange(1, n), np.where(bright[1:, 0] > 1, 2, 3)] //= 2
    tree.learn(of_cells(tree, 1, 1, leaves), 1.0, asked=True)
    assert (tree.shares[0], tree.mixes[0]) == CHOICES[2]


def test_a_leaf_is_sure_of_its_choice_after_some_vertices():
    """Before, it does as the others do."""
    tree = random_tree(3)
    leaves = np.full((len(tree.roots), 1 + len(CHOICES)), 1 << 40)
    leaves[:, 1 + 4] -= 1 << 35
    for count, choice in ((SURE_OF_SHARE // 4, 4), (4 * SURE_OF_SHARE, 7)):
        leaves[:, 0] = 1 << 20
        leaves[5] = 1 << 40
        leaves[5, 0], leaves[5, 1 + 7] = count, (1 << 40) - (1 << 35)
        tree.learn(of_cells(tree, 1, 1, leaves), 1.0, asked=True)
        assert (tree.shares[5], tree.mixes[5]) == CHOICES[choice]


def test_directions_are_moved_to_the_middle_of_a_leaf_and_back():
    """One to one, with the derivative that is told; for a point at the middle nothing changes."""
    rng = np.random.default_rng(5)
    n = 100_000
    w = rng.standard_normal((3, n))
    w = Vec3(*(w / np.linalg.norm(w, axis=0)).astype(np.float32))
    for distance in (0.0, 0.3, 0.69):
        o = Vec3(*(np.full(n, distance * v, np.float32) for v in (0.6, 0.0, -0.8)))
        focus = Focus(o, np.ones(n, np.float32))
        seen, spread = from_middle(focus, w)
        back, again = from_point(focus, seen)
        assert length(back - w).max() < 2e-6
        assert np.abs(again / spread - 1.0).max() < 1e-5
        # Uniform directions have the density 1 / spread there: its mean over the sphere is one.
        _, spread = from_point(focus, w)
        assert abs(np.mean(1.0 / spread) - 1.0) <= 5.0 * np.std(1.0 / spread) / n**0.5 + 1e-6
        # A lamp on the sphere is seen from the middle in the same direction by all points.
        lamp = Vec3(np.float32(0.0), np.float32(0.6), np.float32(0.8))
        there = [getattr(lamp, axis) - getattr(o, axis) for axis in "xyz"]
        there = Vec3(*(there / np.linalg.norm(there, axis=0)))
        found, _ = from_middle(focus, there)
        assert (
            max(np.abs(getattr(found, axis) - getattr(lamp, axis)).max() for axis in "xyz") < 1e-6
        )


def test_a_focus_is_where_the_light_is():
    """The mean of 1 / distance by flux; a sphere always holds its leaf, and nothing is infinite."""
    tree = random_tree(4, focused=9)
    n = len(tree.roots)
    totals = tree.empty_totals()
    totals.leaves.shaped[:, 0] = 100
    totals.middles.shaped[:] = [UNITS * 25, UNITS * 50, UNITS * 75]
    # The longest side is 4 m: light from 8 m, from 1 cm, from infinity, and none at all.
    ratios = np.resize([0.5, 400.0, 0.0, 0.0], n)
    totals.near.shaped[:, 0] = np.where(np.arange(n) % 4 == 3, 0, 1 << 30)
    totals.near.shaped[:, 1] = ratios * (1 << 30)
    focus = tree.focused(totals, FRAME.box).focus
    assert focus[:, :3] == pytest.approx(np.tile([-0.5, 4.0, 1.25], (n, 1)))
    size = np.linalg.norm(tree._sizes() / FRAME.box[3:], axis=1)
    first, second = focus[0::4, 3], focus[1::4, 3]
    assert first == pytest.approx(np.maximum(8.0, size[0::4] / NEAR))
    assert second == pytest.approx(size[1::4] / NEAR)
    assert (focus[2::4, 3] == 0.0).all() and (focus[3::4, 3] == 0.0).all()


def test_a_new_focus_forgets_nothing():
    """Only leaves whose light comes from few directions have one, around the same middle."""
    tree = random_tree(4)
    n = len(tree.roots)
    totals = tree.empty_totals()
    totals.lit.shaped[:n] = 1 << 20
    few = np.arange(n) % 2 == 0
    density = np.where(few, 1.01, 0.99) * FEW * EVEN
    totals.near.shaped[:, 0] = 4.0 * density * (1 << 20)
    # Light from 8 m.
    totals.near.shaped[:, 1] = totals.near.shaped[:, 0] // 2
    again = tree.refocused(totals, FRAME.box)
    assert (again.focus[:, :3] == tree.focus[:, :3]).all()
    assert (again.focus[~few] == tree.focus[~few]).all()
    size = np.linalg.norm(tree._sizes() / FRAME.box[3:], axis=1)
    assert again.focus[few, 3] == pytest.approx(np.maximum(8.0, size / NEAR)[few], rel=1e-5)
    assert again.parts is tree.parts and again.children is tree.children


def test_bright_quadrants_are_divided_and_dark_ones_are_joined():
    """No quadrant that is not divided has more than its part; none that is has less."""
    tree = random_tree(5)
    assert (tree.level > 0).any()
    grown = tree.grown(np.zeros(len(tree.roots), np.int64), 1 << 16)
    assert len(grown.roots) == len(tree.roots)
    leaf_of = np.full(len(grown.children), -1)
    leaf_of[: len(grown.roots)] = np.arange(len(grown.roots))
    for node in range(len(grown.children)):
        leaf_of[grown.children[node][grown.children[node] > 0]] = leaf_of[node]
    total = grown.weight[grown.level == 0].sum(1)
    part = grown.weight / np.maximum(total[leaf_of], 1e-300)[:, None]
    deepest = grown.level == grown.level.max()
    assert (part[grown.children > 0] > PART).all()
    assert (part[~deepest][grown.children[~deepest] == 0] <= PART).all()


def test_the_memory_of_a_guide_is_bounded():
    """With less room the quadrants are larger; the leaves stay."""
    tree = random_tree(6)
    counts = np.full(len(tree.roots), 50)
    free, bound = tree.grown(counts, 1 << 16), tree.grown(counts, 2 * len(tree.roots))
    assert len(bound.children) <= 2 * len(tree.roots) < len(free.children)
    assert bound.space == free.space
