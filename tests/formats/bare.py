"""Scenes as their files have them: without the floor that the studio brings."""

from alight import formats
from alight.formats.scenes.made_up import without_floor


def load(*arguments, **options):
    """A scene, as `alight.load`."""
    return without_floor(formats.load(*arguments, **options))


def nodes_of(parsed):
    """Descriptions of a file's own nodes, in its order."""
    return {name: node for name, node in parsed.data["nodes"].items() if name != "studio floor"}
