"""``displacement`` -> heights of a mesh.

Source: MaterialX specification, version 1.39, "PBS library": displacement shader nodes.
"""

from __future__ import annotations

from alight.core.errors import quote
from alight.formats.geometry.displacement import Heights
from alight.formats.materialx.evaluate import Evaluator
from alight.formats.materialx.nodes import Node
from alight.formats.materialx.protocols import Host
from alight.formats.materialx.values import Plain


def heights_of(
    node: Node, host: Host, sets: tuple[str, ...]
) -> tuple[Heights | None, tuple[str, ...]]:
    """What a displacement shader says.

    Parameters
    ----------
    node : Node
    host : Host
    sets : tuple of str
        Sets of coordinates that the surface shader uses.

    Returns
    -------
    heights : Heights or None
    sets : tuple of str
        The same, or that of the heights where the surface has none.
    """
    evaluator = Evaluator(host)
    if node.category != "displacement":
        evaluator.say(node, f"displacement by {quote(node.category)} is left out")
        return None, sets
    value = evaluator.value(node, "displacement", 0.0)
    scale = evaluator.constant(node, evaluator.value(node, "scale", 1.0), 1)[0]
    if value.width > 1:
        evaluator.say(node, "displacement by vectors is left out: surfaces move along normals")
        return None, sets
    if isinstance(value, Plain):
        return Heights(1.0, scale * value.numbers[0]), sets
    own = tuple(evaluator.sets)
    if own and sets and own != sets[:1]:
        evaluator.say(node, "displacement by other coordinates than the material's is left out")
        return None, sets
    heights = Heights.of(value.texture, scale * value.factor[0], scale * value.offset[0])
    return heights, sets or own
