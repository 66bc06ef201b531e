"""The memory layout of the bounding volume hierarchy.

A *node* is 112 words of 4 bytes (448 bytes, seven cache lines), one column a child:

=======  ==================================================================
word     meaning (CHILDREN words each, one a child)
=======  ==================================================================
0..47    lower bounds x, y, z
48..95   upper bounds x, y, z
96..111  child: index of a node, or LEAF | first block << 4 | number of blocks
=======  ==================================================================

Children come first. A missing one is 0, as the root is nobody's child, and has the bounds
(inf, -inf), which no ray meets.

A *block* holds up to WIDTH triangles side by side, so that one ray meets all of them at once, and
their vertices, up to WIDTH, each once: rows of WIDTH words x, y, z; the triangles' corners (numbers
of vertices, in bits 0 to 3, 4 to 7 and 8 to 11); the triangles' indices. A block that is not full
repeats its first vertex and its last triangle. A block whose last corners are OTHER holds one
analytic shape or instance instead: word 0 its kind (`number_of`), word 1 the row in the data, or
for an instance the root node of its geometry, words 2..13 the map of the world to its own space (3
rows of 4); the first index is its own. Of what moves words 0 (by `MOVING` more) and 1 are alike,
word 2 is the number of its motion.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.shapes.model import SHAPES

#: Views. nodes, blocks: float32 as described above (whole numbers as bit patterns); ids: u32, shape
#: and prim of each index. waits: 1 where rays wait for memory (`cost`) in the tree that starts at
#: node 0, else 0.
Bvh = namedtuple("Bvh", "nodes blocks ids waits")

#: Most children of a node: the boxes that a ray tests at once. Words where the upper bounds and the
#: children start, and words of a node.
CHILDREN = 16
UPPER = 3 * CHILDREN
CHILD = 6 * CHILDREN
NODE = 7 * CHILDREN

#: Triangles and vertices of a block: the width of a leaf test.
WIDTH = 16
CORNERS = 3 * WIDTH
IDS = 4 * WIDTH
BLOCK = 5 * WIDTH

#: Primitives that are not triangles: a leaf has more of them only if dividing it costs more.
OTHERS_IN_LEAF = 8

#: A leaf never has more blocks (four bits of its code), nor more primitives, but for triangles that
#: share vertices: of those it may have WIDTH.
MAX_LEAF = 15

LEAF = 0x80000000

#: Blocks that the code of a leaf can number.
MAX_BLOCKS = 1 << 27
OTHER = 0xFFFFFFFF

#: What primitives are beside the shapes with a formula (`alight.shapes.model.SHAPES`): a geometry
#: that is placed several times, and one that moves.
INSTANCE, TRIANGLES = "instance", "triangles"

#: Where a plan says that primitives of a kind are, as in "tree sphere": in lists or in the tree, at
#: rest or moving while the shutter is open.
LIST, TREE, MOVING_LIST, MOVING_TREE = "list", "tree", "moving list", "moving tree"


def kinds_in(plan: tuple[str, ...], where: str) -> tuple[str, ...]:
    """The kinds that a plan has there."""
    entries = (entry.rpartition(" ") for entry in plan)
    return tuple(kind for place, _, kind in entries if place == where)


def kinds_in_order(kinds: set[str]) -> tuple[str, ...]:
    """Kinds in the order of plans."""
    names = (*SHAPES, INSTANCE, TRIANGLES)
    return tuple(name for name in names if name in kinds)


def number_of(kind: str) -> int:
    """Number of a kind in a block and in the list of what moves."""
    return {INSTANCE: 0, TRIANGLES: 1}[kind] if kind not in SHAPES else 2 + SHAPES[kind].number


#: Added to the numbers of what moves in a block.
MOVING = 1 << 20


def check_blocks(count: int) -> None:
    """Raise ValueError if the codes of leaves cannot number this many blocks."""
    if count > MAX_BLOCKS:
        raise ValueError(
            f"{count} blocks of primitives, more than {MAX_BLOCKS}: some 1e9 triangles are the most"
        )


#: Levels of the binary tree (`collapse`) that are divided with all threads together, those after
#: them in which the build goes by surface areas, and those in which it halves by count: fewer than
#: 2^31 primitives, until a leaf may take what is left.
TOP_LEVELS, SAH_LEVELS, HALVED_LEVELS = 12, 64, 29

#: Levels of nodes that are chosen by their cost; below them each takes up four binary levels.
CHOSEN_LEVELS = 16

#: Deepest possible tree.
MAX_DEPTH = CHOSEN_LEVELS + (TOP_LEVELS + SAH_LEVELS + HALVED_LEVELS - CHOSEN_LEVELS + 3) // 4 + 1

#: A node leaves all children but one behind on the stack, on each level.
STACK = (CHILDREN - 1) * (MAX_DEPTH + 1) + 1


def aligned_zeros(rows: int, columns: int) -> np.ndarray:
    """Zeros of shape (rows, columns), float32, that start at a cache line."""
    n = rows * columns
    memory = np.zeros(n + 16, np.float32)
    skip = (-memory.ctypes.data // 4) % 16
    return memory[skip : skip + n].reshape(rows, columns)
