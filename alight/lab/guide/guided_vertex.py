"""`alight.guide`: what a guide has learnt at the place that a pixel sees."""

from __future__ import annotations

import os
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from alight.compiled.scene import compile_scene
from alight.core.errors import OptionError
from alight.core.registry import specs_of
from alight.core.spec import Integrator
from alight.lab.guide.disks import draw_disks, write_disks
from alight.lab.guide.sides import Side, sides_of
from alight.lab.guide.vertex import ScatteringVertex, vertex_of
from alight.lab.panels import check_sheet
from alight.options.entry import takes
from alight.options.laboratory import GuideOptions
from alight.options.loading import scene_of
from alight.outputs import html
from alight.rendering.resources import usable_processors
from alight.rendering.training.guide_training import Training, trained
from alight.scene import Scene, flatten


@dataclass(frozen=True)
class GuidedVertex:
    """What a guide has learnt where a pixel's path first scatters.

    Attributes
    ----------
    pixel : (int, int)
    vertex : ScatteringVertex
    leaf, leaves : int
        Number of the guide's leaf, and how many there are.
    share : float
        Probability with which the guide chooses the direction there.
    without_lamps : bool
        Light that comes straight from lamps is left out, because light sampling finds it.
    sides : tuple of Side
        One, or two where the surface transmits light.
    training : Training
    """

    pixel: tuple[int, int]
    vertex: ScatteringVertex
    leaf: int
    leaves: int
    share: float
    without_lamps: bool
    sides: tuple[Side, ...]
    training: Training

    @property
    def relative_variances(self) -> dict[str, float]:
        """Of one direction, over the square of the mean, if arriving light were known exactly.

        By the BSDF, by the guide alone (infinite where it leaves directions out), and by their
        mixture, which is what paths draw from.
        """
        columns = {"BSDF": "of_bsdf", "guide": "of_guide", "mixture": "of_mixture"}
        return {
            name: sum(side.relative_square(getattr(side, column)) for side in self.sides) - 1.0
            for name, column in columns.items()
        }

    def __str__(self) -> str:
        """What ``alight guide`` prints."""
        vertex, (x, y) = self.vertex, self.pixel
        at = ", ".join(f"{c:.4g}" for c in vertex.position)
        edges = "1 edge" if vertex.depth == 1 else f"{vertex.depth} edges"
        found = self.relative_variances
        lines = [
            f"pixel {x},{y}: {vertex.shape} ({vertex.material}) at ({at}), {edges} from the camera",
            f"leaf {self.leaf} of {self.leaves}; the guide chooses {self.share:.0%} of directions",
        ]
        if self.without_lamps:
            lines.append("light straight from lamps is left out: light sampling finds it")
        figures = ", ".join(f"{name} {value:.3g}" for name, value in found.items())
        return "\n".join(
            [*lines, f"relative variance of a direction: {figures}", self.training.line]
        )

    def to_dict(self) -> dict[str, Any]:
        """All numbers but the disks, ready for JSON."""
        vertex, found = self.vertex, self.relative_variances
        return {
            "pixel": list(self.pixel),
            "shape": vertex.shape,
            "material": vertex.material,
            "position": list(vertex.position),
            "depth": vertex.depth,
            "leaf": self.leaf,
            "leaves": self.leaves,
            "share": self.share,
            "without_lamps": self.without_lamps,
            "relative_variances": {k: v if np.isfinite(v) else None for k, v in found.items()},
            "training": self.training.state(),
        }

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the disks as PNG.

        Raises
        ------
        OutputError
            If they cannot be written.
        """
        return write_disks(Path(path), self.sides)

    def _repr_html_(self) -> str:
        """Show the disks in a notebook."""
        file = BytesIO()
        draw_disks(self.sides).save(file, format="PNG")
        disks = html.picture(file.getvalue(), "disks of directions")
        return html.division(disks, html.preformatted(str(self).splitlines()))


@takes(GuideOptions)
def guide(
    scene: Scene | str | os.PathLike[str], pixel: tuple[int, int], options: GuideOptions
) -> GuidedVertex:
    """Train a scene's guide, and compare what it knows at a point with the light that arrives.

    The point is the first vertex of the pixel's first path that scatters light smoothly.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
        With an integrator that can be guided and knows no media; its guide is that of a render
        with the same seed.
    pixel : (int, int)
        x and y on the full film, from the top left.
    {options}

    Returns
    -------
    GuidedVertex

    Raises
    ------
    AlightError
        For a scene, pixel or number that is wrong.

    Examples
    --------
    >>> print(alight.guide("door-ajar", (200, 150)))  # doctest: +SKIP
    """
    if options.output is not None:
        check_sheet(Path(options.output))
    progress = options.progress or (lambda text: None)
    description = _to_be_guided(scene_of(scene, options))
    vertex = vertex_of(description, pixel, seed=options.seed)
    progress("training")
    threads = usable_processors()
    compiled = compile_scene(flatten(description), threads=threads)
    guided, training = trained(compiled, seed=options.seed, threads=threads)
    assert guided.guide is not None
    progress("light that arrives")
    leaf, share = vertex.leaf_of(guided.guide)
    # Light sampling leaves to directions what it cannot find.
    without_lamps = not guided.integrator.finds_light_by_chance
    sides = sides_of(
        vertex, guided, share, without_lamps=without_lamps,
        spp=options.spp, seed=options.seed, threads=threads,
    )  # fmt: skip
    x, y = pixel
    leaves = len(guided.guide.leaves.shaped)
    found = GuidedVertex(
        (int(x), int(y)), vertex, leaf, leaves, share, without_lamps, sides, training
    )
    if options.output is not None:
        found.save(options.output)
    return found


def _to_be_guided(scene: Scene) -> Scene:
    """The scene with a guide, even where it would not pay.

    Raises
    ------
    OptionError
        If its integrator knows none, or goes through media.
    """
    able = [
        name
        for name, kind in specs_of(Integrator).items()
        if "guiding" in kind.model_fields and not kind.sees_media
    ]
    own = scene.integrator.type_name()
    if own not in able:
        why = "goes through media" if scene.integrator.sees_media else "follows no guide"
        raise OptionError(f"the integrator {own} {why}; between surfaces {', '.join(able)} can")
    integrator = scene.integrator.replaced(guiding="on")
    return scene.replaced(integrator=integrator).from_source(scene.source)
