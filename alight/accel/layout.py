"""How the bounding volume hierarchy lies in memory.

A *node* is 64 words of 4 bytes (256 bytes, four cache lines), one column a child:

======  ==================================================================
word    meaning (8 words each, one a child)
======  ==================================================================
0..23   lower bounds x, y, z
24..47  upper bounds x, y, z
48..55  child: index of a node, or LEAF | first block << 4 | number of blocks
56      number of children
57..63  unused once the build is over
======  ==================================================================

Children come first; a missing one has the bounds (inf, -inf), which no ray meets.

A *block* holds up to WIDTH triangles side by side, so that one ray meets all of them at once, and
their vertices, up to WIDTH, each once: rows of WIDTH words x, y, z; the triangles' corners (numbers
of vertices, in bits 0 to 3, 4 to 7 and 8 to 11); the triangles' indices. A block that is not full
repeats its first vertex and its last triangle. A block whose last corners are OTHER holds one
analytic shape or instance instead: word 0 its kind (`KINDS`), word 1 the row in the data, or for an
instance the root node of its geometry, words 2..13 the map of the world to its own space (3 rows of
4); the first index is its own. Of what moves (`MOVING`) words 0 and 1 are alike, word 2 is the
number of its motion.
"""

from __future__ import annotations

from collections import namedtuple

#: Views. nodes, blocks: float32 as described above (whole numbers as bit patterns); ids: u32, shape
#: and prim of each index. waits: 1 where rays wait for memory (`cost`), else 0.
Bvh = namedtuple("Bvh", "nodes blocks ids waits")

NODE = 64
CHILD = 48
COUNT = 56

#: Triangles and vertices of a block: the width of a leaf test.
WIDTH = 16
CORNERS = 3 * WIDTH
IDS = 4 * WIDTH
BLOCK = 5 * WIDTH

#: A leaf never has more blocks (four bits of its code), nor more primitives, but for triangles that
#: share vertices: of those it may have WIDTH.
MAX_LEAF = 15

LEAF = 0x80000000
OTHER = 0xFFFFFFFF

#: What a block can hold besides triangles.
KINDS = ("sphere", "rectangle", "disk", "instance", "cylinder")
ANALYTIC = tuple(kind for kind in KINDS if kind != "instance")

#: The same of what moves while the shutter is open; their numbers follow.
MOVING = ("sphere", "rectangle", "disk", "mesh", "cylinder")


def moving_number(kind: str) -> int:
    """Number of a moving kind in a block."""
    return len(KINDS) + MOVING.index(kind)


#: Levels of nodes below the root until the build gives up on surface areas and halves by count.
SAH_DEPTH = 24

#: Deepest possible tree: below SAH_DEPTH each level has an eighth of the primitives, and there are
#: fewer than 2^31.
MAX_DEPTH = SAH_DEPTH + 11

#: A node leaves at most 7 children behind on the stack, on each level.
STACK = 7 * (MAX_DEPTH + 1) + 1
