"""Ways to the leaves of a light tree, read from its table.

Tables hold ways to shapes alone, as paths meet nothing else. A pilot asks for lamps at a point too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.lights.tables import INFO
from alight.lights.tree.traversal import (
    CHILD,
    FIRST_LEAF,
    LEAF,
    LEAVES,
    NEXT,
    ROWS,
    START,
    TOP,
    TOP_BITS,
    TOP_NEXT,
    TOP_ROW,
)
from lanewise.view import View


def with_ways(lights: Any) -> Any:
    """Tables in which `mis_probability` finds lamps at a point, and nothing else.

    Parameters
    ----------
    lights : namedtuple
        `alight.lights.tables.LightTables` of a program with a light tree.
    """
    cdf = lights.cdf.array
    words = cdf.view(np.uint32)
    start = int(cdf[START])
    first = start + TOP * TOP_ROW
    ways = np.zeros((int(cdf[ROWS]), 2), np.uint32)
    onward = words[start:first].reshape(TOP, TOP_ROW)[:, TOP_NEXT]
    way, level = np.arange(TOP, dtype=np.uint32), TOP_BITS
    # The root may have fewer children: no node begins at 0.
    onward, way = onward[onward > 0], way[onward > 0]
    while len(onward):
        ends = onward >= LEAF
        ways[onward[ends] & (LEAF - 1), 0] = way[ends]
        node, way = onward[~ends], way[~ends]
        onward = np.concatenate([words[node + NEXT], words[node + CHILD + NEXT]])
        way, level = np.concatenate([way, way | np.uint32(1 << level)]), level + 1
    count = int(words[first + FIRST_LEAF + 1])
    rows = int(words[LEAVES]) + count + 1
    ways[words[rows : rows + count], 1] = np.arange(count)
    info = lights.info.array.copy().reshape(-1, INFO)
    info[: len(ways), 3] = cdf.size + 2 * np.arange(len(ways))
    table = np.concatenate([cdf, ways.ravel().view(np.float32)])
    return lights._replace(info=View(info.ravel()), cdf=View(table))
