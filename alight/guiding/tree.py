r"""Growing a guide: from the sums of one round of training to the tree of the next.

Space is divided where many vertices lie, and squares of directions where much of the density is.
Both follow from whole numbers alone, and so are the same on every machine.

The density that minimises the variance of a vertex is
:math:`p \propto \sqrt{\operatorname E[(f \cos\theta\, L_i)^2]}`, the mean being over all that a
leaf sees. A quadrant knows the integral of the square, :math:`M`; it gets
:math:`\sqrt{M A}` with its area :math:`A`, which is right where the square does not vary within it.

Sources: Müller, Gross and Novák, Practical path guiding, EGSR 2017; Rath et al., Variance-aware
path guiding, SIGGRAPH 2020.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from alight.guiding.records import LEAF_SUMS, SHARES, UNITS, Totals
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

#: A quadrant with more than this part of its leaf's density is divided, down to so many levels.
PART, LEVELS = 0.01, 16

#: A leaf is divided while it has more vertices than this many times the root of the round's, and
#: more than `LEAST`.
CROWD, LEAST = 4.0, 64.0

#: The guide's share before anything is known of what it gains.
FIRST_SHARE = 0.5

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
    weight : (nodes, 4) float64
        Of each quadrant, with all that lies in it.
    shares, gains : (leaves,) float64
        Probability of drawing from the guide; root mean square of what a vertex gains, as luminance
        (0: nothing is known).
    """

    space: list[int]
    roots: NDArray[np.int64]
    children: NDArray[np.int64]
    level: NDArray[np.int64]
    weight: NDArray[np.float64]
    shares: NDArray[np.float64]
    gains: NDArray[np.float64]

    @classmethod
    def new(cls) -> Tree:
        """One leaf, which knows nothing and is not asked."""
        return cls(
            space=[LEAF],
            roots=np.zeros(1, np.int64),
            children=np.zeros((1, 4), np.int64),
            level=np.zeros(1, np.int64),
            weight=np.ones((1, 4)),
            shares=np.zeros(1),
            gains=np.zeros(1),
        )

    def guide(self, frame: Frame) -> Guide:
        """The tables for kernels."""
        return Guide(
            box=View(frame.box),
            space=View(np.array(self.space, np.uint32)),
            roots=View(self.roots.astype(np.uint32)),
            leaves=View(np.stack([self.shares, self.gains], axis=1).astype(np.float32)),
            nodes=View(self._packed()),
            picture=View(frame.picture),
            blocks=View(frame.blocks),
        )

    def _packed(self) -> NDArray[np.uint32]:
        lower, upper = self.weight[:, :2].sum(1), self.weight[:, 2:].sum(1)
        parts = (
            _ratio(lower, lower + upper),
            _ratio(self.weight[:, 0], lower),
            _ratio(self.weight[:, 2], upper),
        )
        nodes = np.zeros((len(self.children), NODE), np.uint32)
        for place, part in enumerate(parts):
            nodes[:, 0] |= np.rint(part * (PARTS - 1)).astype(np.uint32) << (place * PART_BITS)
        divided = self.children > 0
        first = np.where(divided, self.children, len(self.children)).min(1)
        first[~divided.any(1)] = 0
        nodes[:, 1] = (first << QUADRANTS) | (divided @ (1 << np.arange(QUADRANTS)))
        return nodes

    def empty_totals(self) -> Totals:
        """Room for the sums of a round."""
        return Totals(
            View(np.zeros((len(self.children), QUADRANTS), np.int64)),
            View(np.zeros((len(self.roots), LEAF_SUMS), np.int64)),
        )

    def learn(self, totals: Totals, unit: float, *, asked: bool) -> None:
        """Take weights, shares and gains from the sums of a round.

        Parameters
        ----------
        totals : Totals
        unit : float
            As given to `add_records`.
        asked : bool
            Whether the guide knew anything that directions were drawn from.
        """
        area = 0.25 ** (self.level + 1.0)
        own = np.sqrt(totals.cells.shaped * area[:, None])
        self.weight = self._upwards(np.where(self.children == 0, own, 0.0))
        counts, moments = np.split(totals.leaves.shaped.astype(np.float64), [1], axis=1)
        typical = moments.sum(0) / max(counts.sum(), 1.0)
        best = np.argmin(moments + SURE_OF_SHARE * typical, axis=1)
        self.shares = np.array(SHARES)[best] if asked else np.full(len(self.roots), FIRST_SHARE)
        least = (moments + SURE_OF_GAIN * typical) / (counts + SURE_OF_GAIN)
        self.gains = np.sqrt(least.min(1) / UNITS) * unit

    def _upwards(self, weight: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sums of what lies in each quadrant."""
        for level in range(int(self.level.max()) - 1, -1, -1):
            at = np.flatnonzero(self.level == level)
            child = self.children[at]
            weight[at] += np.where(child > 0, weight[child].sum(2), 0.0)
        return weight

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
        return Tree(space, *squares, self.shares[parents], self.gains[parents])

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
        """Roots, children, levels and weights of the leaves' quadtrees, made of their parents'.

        None where they have too many nodes.
        """
        # Nodes to be made: the old node in the same place, or -1, and the weights.
        old = self.roots[parents]
        weight = self.weight[old]
        bound = part * weight.sum(1)
        children, levels, weights, count = [], [], [], 0
        for level in range(LEVELS):
            count += len(old)
            if count > most_nodes:
                return None
            divided = (weight > bound[:, None]) & (level + 1 < LEVELS)
            numbers = np.zeros((len(old), QUADRANTS), np.int64)
            numbers[divided] = count + np.arange(divided.sum())
            children.append(numbers)
            levels.append(np.full(len(old), level))
            weights.append(weight)
            row, place = np.nonzero(divided)
            if not len(row):
                break
            further = np.where(old[row] >= 0, self.children[old[row], place], 0)
            even = np.repeat(weight[row, place][:, None] / QUADRANTS, QUADRANTS, axis=1)
            weight = np.where(further[:, None] > 0, self.weight[further], even)
            old, bound = np.where(further > 0, further, -1), bound[row]
        return (
            np.arange(len(parents)),
            np.concatenate(children),
            np.concatenate(levels),
            np.concatenate(weights),
        )


def _ratio(part: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """Part of the whole, one half of nothing."""
    return np.where(whole > 0.0, part / np.where(whole > 0.0, whole, 1.0), 0.5)
