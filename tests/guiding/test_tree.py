"""A guide's tree: a partition of space, densities of directions, and how both grow."""

import numpy as np
import pytest

from alight.core.equal_area import sphere_to_square, square_to_sphere
from alight.core.vec import Vec3
from alight.guiding.lookup import direction_density, draw_direction, leaf_at
from alight.guiding.records import LEAF_SUMS, SHARES, UNITS, Totals
from alight.guiding.tables import Frame
from alight.guiding.tree import FIRST_SHARE, PART, Tree
from lanewise.view import View

FRAME = Frame(
    box=np.array([-1.0, 2.0, 0.5, 0.5, 0.25, 1.0], np.float32),
    picture=np.ones((1, 1), np.float32),
    blocks=np.zeros(3, np.uint32),
)


def random_tree(seed: int, rounds: int = 4) -> Tree:
    """A tree that has learnt from sums of every size."""
    rng = np.random.default_rng(seed)
    tree = Tree.new()
    for number in range(rounds):
        counts = rng.integers(0, 3000, len(tree.roots))
        cells = np.exp(4.0 * rng.standard_normal((len(tree.children), 4))) * UNITS
        cells[rng.random(cells.shape) < 0.2] = 0.0
        leaves = rng.integers(0, 1 << 30, (len(tree.roots), LEAF_SUMS))
        leaves[:, 0] = counts
        tree.learn(Totals(View(cells.astype(np.int64)), View(leaves)), 1.0, asked=number > 0)
        tree = tree.grown(counts, 1 << 14)
    return tree


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
    for leaf in rng.integers(0, len(tree.roots), leaves):
        mine = np.full(n, leaf, np.uint32)
        u = rng.random((2, n)).astype(np.float32)
        yes = np.ones(n, bool)
        none = Vec3(*np.ones((3, n), np.float32))
        w, told = draw_direction(guide, mine, yes, (u[0], u[1]), none, yes)
        again = direction_density(guide, mine, w, yes)
        # A direction at the border of a quadrant may be rounded into the next one.
        assert (np.abs(told - again) > 1e-4 * told).mean() < 0.01
        x, y = sphere_to_square(w)
        drawn, _, _ = np.histogram2d(x, y, grid, range=[(0, 1), (0, 1)])
        # The density of each cell, by many points of the square.
        fine = 64
        a, b = np.meshgrid((np.arange(fine) + 0.5) / fine, (np.arange(fine) + 0.5) / fine)
        v = square_to_sphere(a.ravel().astype(np.float32), b.ravel().astype(np.float32))
        some = np.full(fine * fine, leaf, np.uint32)
        density = 4.0 * np.pi * direction_density(guide, some, v, np.ones(fine * fine, bool))
        cells = density.reshape(grid, fine // grid, grid, fine // grid).mean((1, 3)).T
        if not np.isclose(cells.mean(), 1.0, atol=2e-3):
            # Squares finer than the points.
            continue
        expected = n * cells / cells.size
        many = expected > 5
        chi2 = ((drawn - expected)[many] ** 2 / expected[many]).sum()
        worst.append((chi2 - many.sum()) / np.sqrt(2.0 * many.sum()))
    assert len(worst) > leaves / 4
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
        density = direction_density(guide, np.full(n, leaf, np.uint32), w, np.ones(n, bool))
        share = 4.0 * np.pi * density * size**2
        assert share.sum() == pytest.approx(1.0, abs=1e-4)
        # Ten bits for each half of each level.
        assert np.abs(share - weight / weight.sum()).max() < 5e-3


def test_weights_follow_the_root_of_moment_times_area():
    """Four quadrants, one of them divided: the parts are in the ratio of the optimal density."""
    tree = Tree.new()
    cells = np.array([[1, 4, 9, 16]]) * (1 << 20)
    sums = np.ones((1, LEAF_SUMS), np.int64)
    tree.learn(Totals(View(cells), View(sums)), 1.0, asked=False)
    assert tree.weight[0] / tree.weight[0, 0] == pytest.approx([1, 2, 3, 4])
    assert tree.shares == [FIRST_SHARE]


def test_the_share_is_the_one_with_the_least_second_moment():
    """And a leaf without vertices does as all others do."""
    tree = random_tree(3)
    n = len(tree.roots)
    leaves = np.full((n, LEAF_SUMS), 1 << 30)
    leaves[:, 0] = 1 << 20
    best = np.arange(n) % len(SHARES)
    leaves[np.arange(n), 1 + best] = 1 << 20
    leaves[0] = 0
    cells = np.ones((len(tree.children), 4), np.int64)
    tree.learn(Totals(View(cells), View(leaves)), 1.0, asked=True)
    assert tree.shares[1:].tolist() == [SHARES[i] for i in best[1:]]
    leaves[1:, 1:] = 1 << 30
    leaves[1:, 1 + 2] -= 1 << 20
    tree.learn(Totals(View(cells), View(leaves)), 1.0, asked=True)
    assert tree.shares[0] == SHARES[2]


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
