"""The scene of a file that shows a model: light around it and a camera, where it has none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from alight.formats.glow import Glow
from alight.formats.parsed import Parsed
from alight.formats.report import Report
from alight.formats.surroundings import (
    Bounds,
    add_camera,
    add_light,
    say_if_empty,
    use_first_camera,
)
from alight.scene.build import FORMAT_VERSION

#: Pixels, of pictures whose shape a file's camera decides.
HEIGHT, MOST_WIDTH = 600, 2**14


def model_scene(
    tables: dict[str, Any],
    places: dict[str, str],
    report: Report,
    bounds: Bounds,
    glow: Glow,
    *,
    is_lit: bool = False,
    cameras: Sequence[str] = (),
    aspect: float = 1.0,
    view: NDArray[Any] | None = None,
) -> Parsed:
    """Put a description together, and say what was made up.

    Parameters
    ----------
    tables : dict
        Nodes, prototypes, materials, and perhaps what is around them.
    places : dict of str to str
        Key path -> place in the file.
    report : Report
    bounds, glow : Bounds and Glow
        Of all meshes, and of those that shine.
    is_lit : bool
        Whether the file has lights.
    cameras : sequence of str
        Node paths of its cameras; the first one is shown.
    aspect : float
        Width of its picture divided by the height.
    view : (4, 4) float64, optional
        Camera to world of the first camera.
    """
    scene = {"alight": FORMAT_VERSION, **tables}
    say_if_empty(report, bounds)
    if not is_lit and not glow.suffices(bounds):
        add_light(scene, report, shines=glow.total > 0.0, view=view)
    if not cameras:
        add_camera(scene, report, bounds)
        return Parsed.of(scene, places, report, framed=bounds)
    use_first_camera(scene, report, cameras)
    scene["film"] = {"size": [max(1, min(round(HEIGHT * aspect), MOST_WIDTH)), HEIGHT]}
    return Parsed.of(scene, places, report)
