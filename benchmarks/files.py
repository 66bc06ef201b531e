"""Mitsuba's own files for both renderers, with the same size, depth, filter and sampler.

Both open the file as it is. Then the picture gets `height` rows and the file's aspect, the box
filter, and the path integrator with depth 8 and roulette from depth 5.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from alight import Scene

DEPTHS = {"max_depth": 8, "rr_depth": 5}


def alight_file(path: Path, height: int, sampler: str | None) -> Scene:
    """Open a file with alight; `sampler` in place of alight's default."""
    import alight

    changes = ["film.crop=null", "film.filter=box", "integrator.type=path"]
    changes += [f"integrator.{name}={depth}" for name, depth in DEPTHS.items()]
    changes.append(f"sampler.type={sampler or 'sobol'}")
    width, rows = alight.load(path).film.size
    return alight.load(path, [*changes, f"film.size=[{round(width * height / rows)}, {height}]"])


def mitsuba_file(mi: Any, path: Path, height: int, sampler: str) -> Any:
    """Open a file with Mitsuba, whose variant must have been set."""
    mi.file_resolver().prepend(str(path.parent.resolve()))
    config = mi.parser.ParserConfig(mi.variant())
    # Loading in parallel sometimes hangs (3.9.1).
    config.parallel = False
    state = mi.parser.parse_file(config, str(path))
    mi.parser.transform_all(config, state)
    for node in state.nodes:
        if node.type == mi.ObjectType.Film:
            node.props["width"] = round(node.props["width"] * height / node.props["height"])
            node.props["height"] = height
        elif node.type == mi.ObjectType.ReconstructionFilter:
            node.props = mi.Properties("box")
        elif node.type == mi.ObjectType.Sampler:
            node.props = mi.Properties(sampler)
        elif node.type == mi.ObjectType.Integrator:
            node.props = mi.Properties("path")
            for name, depth in DEPTHS.items():
                node.props[name] = depth
    scene = mi.parser.instantiate(config, state)
    # A film without a filter of its own would have Mitsuba's default, which is wider.
    assert "BoxFilter" in str(scene.sensors()[0].film().rfilter())
    return scene
