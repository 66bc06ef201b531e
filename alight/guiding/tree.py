r"""Growing a guide: from the sums of one round of training to the tree of the next.

Space is divided where many vertices lie, and squares of directions where much of the density is.
Both follow from whole numbers alone, and so are the same on every machine.

The density that minimises the variance of a vertex is
:math:`p \propto \sqrt{\operatorname E[(f \cos\theta\, L_i)^2]}`, the mean being over all that a
leaf sees. A quadrant knows the integral of the square, :math:`M`; it gets
:math:`\sqrt{M A}` with its area :math:`A`, which is right where the square does not vary within it.
Light that camera paths do not find has no such square; there the density follows the flux that
light paths bring. Each leaf mixes the two by what has served it best.

Sources: Müller, Gross and Novák, Practical path guiding, EGSR 2017; Rath et al., Variance-aware
path guiding, SIGGRAPH 2020.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from alight.guiding.parallax import NEAR
from alight.guiding.records import CHOICES, LEAF_SUMS, UNITS, Totals
from alight.guiding.tables import (
    LEAF,
    NODE,
    PART_BITS,
    PARTS,
    QUADRANTS,
    Frame,
    Guide,
)
from lanewise.view import View

#: Density of all directions alike.
EVEN = 1 / (4 * np.pi)

#: A quadrant with more than this part of its leaf's density is divided, down to so many levels.
PART, LEVELS = 0.01, 16

#: A leaf is divided while it has more vertices than this many times the root of the round's, and
#: more than `LEAST`.
CROWD, LEAST = 2.0, 64.0

#: Light from farther than so many sizes of a leaf comes from the same direction everywhere in it.
FAR = 64.0

#: Flux comes from few directions where the guide's density is so many times `EVEN`, in the mean.
FEW = 12.0

#: The guide's share before anything is known of what it gains, and that of light paths in it.
FIRST_SHARE, FIRST_MIX = 0.5, 0.5

#: All leaves together count as much as so many vertices of a leaf's own, for its share and for its
#: gain: a leaf with few vertices does as the others do.
SURE_OF_SHARE, SURE_OF_GAIN = 256.0, 4.0


@dataclass
class Tree:
    """A guide in the making.

    Attributes
    ----------
    space : list of int
        Words of the binary tree, see `alight.guiding.tables`.
    roots : (leaves,) int64
    children : (nodes, 4) int64
        Nodes that divide the quadrants further, one after another; 0 where there is none.
    level : (nodes,) int64
        0 at roots. Nodes are in the order of their levels.
    leaf : (nodes,) int64
        Whose quadtree a node is of.
    parts : (nodes, 4, 2) float64
        Probability of each quadrant within its leaf, with all that lies in it: by what camera paths
        gained there, and by the flux of light paths.
    shares, mixes, gains : (leaves,) float64
        Probability of drawing from the guide; part of light paths in it; root mean square of what a
        vertex gains, as luminance (0: nothing is known).
    focus : (leaves, 4) float64
        Middle and radius of `alight.guiding.parallax`, in metres.
    """

    space: list[int]
    roots: NDArray[np.int64]
    children: NDArray[np.int64]
    level: NDArray[np.int64]
    leaf: NDArray[np.int64]
    parts: NDArray[np.float64]
    shares: NDArray[np.float64]
    mixes: NDArray[np.float64]
    gains: NDArray[np.float64]
    focus: NDArray[np.float64]

    @classmethod
    def new(cls) -> Tree:
        """One leaf, which knows nothing and is not asked."""
        return cls(
            space=[LEAF],
            roots=np.zeros(1, np.int64),
            children=np.zeros((1, 4), np.int64),
            level=np.zeros(1, np.int64),
            leaf=np.zeros(1, np.int64),
            parts=np.full((1, QUADRANTS, 2), 1 / QUADRANTS),
            shares=np.zeros(1),
            mixes=np.zeros(1),
            gains=np.zeros(1),
            focus=np.zeros((1, 4)),
        )

    @property
    def weight(self) -> NDArray[np.float64]:
        """(nodes, 4): probability of each quadrant within its leaf."""
        return _mixed(self.parts, self.mixes[self.leaf])

    def guide(self, frame: Frame) -> Guide:
        """The tables for kernels."""
        return Guide(
            box=View(frame.box),
            space=View(np.array(self.space, np.uint32)),
            roots=View(self.roots.astype(np.uint32)),
            leaves=View(np.column_stack([self.shares, self.gains, self.focus]).astype(np.float32)),
            nodes=View(self._packed()),
            picture=View(frame.picture),
            blocks=View(frame.blocks),
        )

    def _packed(self) -> NDArray[np.uint32]:
        weight = self.weight
        lower, upper = weight[:, :2].sum(1), weight[:, 2:].sum(1)
        parts = (
            _ratio(lower, lower + upper),
            _ratio(weight[:, 0], lower),
            _ratio(weight[:, 2], upper),
        )
        nodes = np.zeros((len(self.children), NODE), np.uint32)
        for place, part in enumerate(parts):
            nodes[:, 0] |= np.rint(part * (PARTS - 1)).astype(np.uint32) << (place * PART_BITS)
        divided = self.children > 0
        first = np.where(divided, self.children, len(self.children)).min(1)
        first[~divided.any(1)] = 0
        nodes[:, 1] = (first << QUADRANTS) | (divided @ (1 << np.arange(QUADRANTS)))
        return nodes

    def densities(self) -> View:
        """(nodes, 4, 2) float32: of the two `parts`, per steradian."""
        # A leaf that knows nothing is even.
        known = self.parts[self.roots].sum(1)[self.leaf][:, None] > 0.0
        per_steradian = np.where(known, self.parts / (4 * np.pi * self._area()[..., None]), EVEN)
        return View(per_steradian.astype(np.float32))

    def _area(self) -> NDArray[np.float64]:
        """(nodes, 1): of each of a node's quadrants."""
        return np.power(0.25, self.level + 1.0)[:, None]

    def empty_totals(self) -> Totals:
        """Room for the sums of a round."""
        shape = len(self.children), QUADRANTS
        return Totals(
            View(np.zeros(shape, np.int64)),
            View(np.zeros(shape, np.int64)),
            View(np.zeros((len(self.roots), LEAF_SUMS), np.int64)),
            View(np.zeros((len(self.roots), 3), np.int64)),
            View(np.zeros((len(self.roots), 2), np.int64)),
        )

    def learn(self, totals: Totals, unit: float, *, asked: bool) -> None:
        """Take parts, shares, mixes and gains from the sums of a round.

        Parameters
        ----------
        totals : Totals
        unit : float
            As given to `add_records`.
        asked : bool
            Whether the guide knew anything that directions were drawn from.
        """
        gained = np.sqrt(totals.cells.shaped * self._area())
        own = np.stack([gained, totals.lit.shaped.astype(np.float64)], axis=2)
        parts = self._upwards(np.where(self.children[..., None] == 0, own, 0.0))
        whole = parts[self.roots].sum(1)
        # Who has nothing to say takes the other's word.
        parts = np.where((whole > 0.0)[self.leaf][:, None], parts, parts[..., ::-1])
        whole = np.where(whole > 0.0, whole, whole[:, ::-1])
        self.parts = parts / np.where(whole > 0.0, whole, 1.0)[self.leaf][:, None]

        counts, moments = np.split(totals.leaves.shaped.astype(np.float64), [1], axis=1)
        # A few bright vertices would outweigh all others: each leaf compares its own choices.
        profile = counts * moments / np.maximum(moments.mean(1, keepdims=True), 1.0)
        usual = profile.sum(0) / max(counts.sum(), 1.0)
        best = np.argmin(profile + SURE_OF_SHARE * usual, axis=1)
        typical = moments.sum(0) / max(counts.sum(), 1.0)
        first = np.tile((FIRST_SHARE, FIRST_MIX), (len(self.roots), 1))
        self.shares, self.mixes = (np.array(CHOICES)[best] if asked else first).T
        least = (moments + SURE_OF_GAIN * typical) / (counts + SURE_OF_GAIN)
        self.gains = np.sqrt(least.min(1) / UNITS) * unit

    def _upwards(self, parts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sums of what lies in each quadrant."""
        for level in range(int(self.level.max()) - 1, -1, -1):
            at = np.flatnonzero(self.level == level)
            child = self.children[at]
            parts[at] += np.where(child[..., None] > 0, parts[child].sum(2), 0.0)
        return parts

    def grown(self, counts: NDArray[np.int64], most_nodes: int) -> Tree:
        """The tree with crowded leaves and bright quadrants divided, and dark quadrants joined.

        Parameters
        ----------
        counts : (leaves,) int64
            Vertices of each leaf.
        most_nodes : int
            Of all quadtrees together; with less room the quadrants are larger.
        """
        crowd = max(CROWD * float(np.sqrt(counts.sum())), LEAST)
        space, parents = self._divided(counts, crowd)
        part, squares = PART, None
        while squares is None:
            squares = self._squares(parents, part, max(most_nodes, len(parents)))
            part *= 1.5
        own = self.shares, self.mixes, self.gains, self.focus
        leaves = (values[parents] for values in own)
        return Tree(space, np.arange(len(parents)), *squares, *leaves)

    def focused(self, totals: Totals, box: NDArray[np.float32]) -> Tree:
        """The tree with a sphere for each leaf where most of its light comes from.

        What is known of directions is forgotten.

        Parameters
        ----------
        totals : Totals
        box : (6,) float32
            As in `Guide`.
        """
        low, extent = box[:3].astype(np.float64), 1.0 / box[3:].astype(np.float64)
        counts = totals.leaves.shaped[:, :1]
        middle = low + extent * (totals.middles.shaped / np.maximum(counts, 1)) / UNITS
        return replace(
            self,
            focus=np.column_stack([middle, self._radii(totals, extent)]),
            children=np.zeros((len(self.roots), QUADRANTS), np.int64),
            level=np.zeros(len(self.roots), np.int64),
            leaf=np.arange(len(self.roots)),
            parts=np.full((len(self.roots), QUADRANTS, 2), 1 / QUADRANTS),
        )

    def refocused(self, totals: Totals, box: NDArray[np.float32]) -> Tree:
        """The tree with new radii where light comes from few directions.

        Their middles stay, and so does what is known: what the middle sees does not move.

        Parameters
        ----------
        totals, box
            As for `focused`.
        """
        flux = np.bincount(self.leaf, totals.lit.shaped.sum(1), len(self.roots))
        few = totals.near.shaped[:, 0] > FEW * EVEN * flux
        radius = self._radii(totals, 1.0 / box[3:].astype(np.float64))
        focus = self.focus.copy()
        focus[few, 3] = radius[few]
        return replace(self, focus=focus)

    def _radii(self, totals: Totals, extent: NDArray[np.float64]) -> NDArray[np.float64]:
        """(leaves,): harmonic mean of the ways of a round's light, in metres, 0 from afar."""
        flux, near = totals.near.shaped.T.astype(np.float64)
        radius = np.where(near > 0.0, extent.max() * flux / np.where(near > 0.0, near, 1.0), 0.0)
        # A sphere holds the leaf that it is made for; points of a later one may lie outside, and
        # keep their directions. What comes from afar has no parallax.
        size = np.linalg.norm(self._sizes() * extent, axis=1)
        return np.maximum(radius, size / NEAR) * (radius > 0.0) * (radius < FAR * size)

    def _sizes(self) -> NDArray[np.float64]:
        """(leaves, 3): sides of each leaf, as parts of the box's."""
        sizes = np.ones((len(self.roots), 3))
        waiting = [(0, 0)]
        while waiting:
            place, level = waiting.pop()
            word = self.space[place]
            if word >= LEAF:
                # Nodes are halved along x, y and z in turn.
                sizes[word - LEAF] = 0.5 ** ((level + np.array([2, 1, 0])) // 3)
            else:
                waiting += [(word, level + 1), (word + 1, level + 1)]
        return sizes

    def _divided(
        self, counts: NDArray[np.int64], crowd: float
    ) -> tuple[list[int], NDArray[np.int64]]:
        """The words of space with crowded leaves halved, and the old leaf of each new one."""
        space, parents = list(self.space), []
        waiting = [
            (place, float(counts[word - LEAF])) for place, word in enumerate(space) if word >= LEAF
        ]
        while waiting:
            place, count = waiting.pop()
            leaf = space[place] - LEAF
            if count > crowd:
                space[place] = len(space)
                waiting += [(len(space), count / 2), (len(space) + 1, count / 2)]
                space += [LEAF + leaf, LEAF + leaf]
            else:
                space[place] = LEAF + len(parents)
                parents.append(leaf)
        return space, np.array(parents)

    def _squares(
        self, parents: NDArray[np.int64], part: float, most_nodes: int
    ) -> tuple[NDArray, NDArray, NDArray, NDArray] | None:
        """Children, levels, leaves and parts of the leaves' quadtrees, made of their parents'.

        None where they have too many nodes.
        """
        # Nodes to be made: the old node in the same place, or -1, its leaf, and its parts.
        old, leaf = self.roots[parents], np.arange(len(parents))
        parts, mixes = self.parts[old], self.mixes[parents]
        made, count = [], 0
        for level in range(LEVELS):
            count += len(old)
            if count > most_nodes:
                return None
            divided = (_mixed(parts, mixes[leaf]) > part) & (level + 1 < LEVELS)
            numbers = np.zeros((len(old), QUADRANTS), np.int64)
            numbers[divided] = count + np.arange(divided.sum())
            made.append((numbers, np.full(len(old), level), leaf, parts))
            row, place = np.nonzero(divided)
            if not len(row):
                break
            further = np.where(old[row] >= 0, self.children[old[row], place], 0)
            even = np.repeat(parts[row, place][:, None] / QUADRANTS, QUADRANTS, axis=1)
            parts = np.where(further[:, None, None] > 0, self.parts[further], even)
            old, leaf = np.where(further > 0, further, -1), leaf[row]
        children, levels, leaves, parts = (
            np.concatenate(column) for column in zip(*made, strict=True)
        )
        return children, levels, leaves, parts


def _mixed(parts: NDArray[np.float64], mix: NDArray[np.float64]) -> NDArray[np.float64]:
    """(nodes, 4): the two parts of (nodes, 4, 2), the second with the weight mix, (nodes,)."""
    return parts[..., 0] + mix[:, None] * (parts[..., 1] - parts[..., 0])


def _ratio(part: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """Part of the whole, one half of nothing."""
    return np.where(whole > 0.0, part / np.where(whole > 0.0, whole, 1.0), 0.5)
