"""`alight.why`: where a picture's noise comes from, and what was measured to lower it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from alight.integrators.model import INTEGRATORS
from alight.lab.panels import check_sheet
from alight.lab.why.maps import draw_maps, write_maps
from alight.lab.why.pyramid import Pyramid, pyramid_of
from alight.lab.why.pyramid_sheet import write_pyramid
from alight.lab.why.shares import Part, Shares, shares_of
from alight.lab.why.trials import Trial, try_alternatives
from alight.lab.why.words import plain, ranked, share_lines, share_tables, trial_lines
from alight.options.entry import takes
from alight.options.laboratory import WhyOptions
from alight.options.loading import scene_of
from alight.outputs import html
from alight.scene import Scene

#: Parts that get a map of their own.
MAPS = 4


@dataclass(frozen=True)
class Explanation:
    """Where the noise of a picture comes from.

    Attributes
    ----------
    shares : Shares
    trials : tuple of Trial
        The most efficient first; those that help are advice.
    not_tried : tuple of str
        Changes for which there was no time.
    measured : bool
        Whether anything was to be tried.
    pyramid : Pyramid or None
        Of paths from both ends: what each technique adds.
    """

    shares: Shares
    trials: Sequence[Trial] = ()
    not_tried: Sequence[str] = ()
    measured: bool = False
    pyramid: Pyramid | None = None

    @property
    def parts(self) -> list[Part]:
        """The parts that have maps, the largest first."""
        return list(ranked(self.shares))[:MAPS]

    def __str__(self) -> str:
        """What ``alight why`` prints."""
        table = self.pyramid.lines() if self.pyramid else ()
        return "\n".join([*share_lines(self.shares), *table, *self._advice()])

    def _advice(self) -> list[str]:
        return list(trial_lines(self.trials, self.not_tried)) if self.measured else []

    def to_dict(self) -> dict[str, Any]:
        """All numbers, ready for JSON."""
        found = plain(self.shares, self.trials, self.not_tried)
        return found | ({"pyramid": self.pyramid.to_dict()} if self.pyramid else {})

    def save_maps(self, path: str | os.PathLike[str]) -> Path:
        """Write the picture, the map of its noise and those of the largest parts as PNG.

        Of paths from both ends: the pictures of all techniques, weighted and not.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        if self.pyramid:
            return write_pyramid(Path(path), self.pyramid)
        return write_maps(Path(path), self.shares, self.parts)

    def _repr_html_(self) -> str:
        """Show the maps, the shares and the advice in a notebook."""
        file = BytesIO()
        draw_maps(self.shares, self.parts).save(file, format="PNG")
        tables = [html.table(rows, caption=title) for title, rows in share_tables(self.shares)]
        first = next(share_lines(self.shares))
        maps = html.picture(file.getvalue(), f"maps of the noise: {first}")
        return html.division(
            html.paragraph(first), maps, *tables, html.preformatted(self._advice())
        )


@takes(WhyOptions)
def why(scene: Scene | str | os.PathLike[str], options: WhyOptions) -> Explanation:
    """Explain a picture's noise by path depth, technique, light and first material.

    Pictures of paths from both ends are divided by the techniques (s, t).

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
    {options}

    Returns
    -------
    Explanation

    Raises
    ------
    AlightError
        For a scene or an option that is wrong, and for an integrator that does not say where its
        light comes from.

    Examples
    --------
    >>> print(alight.why("cornell-box", size=64, measure=False))  # doctest: +SKIP
    """
    if options.output is not None:
        check_sheet(options.output)
    progress = options.progress or (lambda text: None)
    description = scene_of(scene, options)
    progress("contributions of all paths")
    numbers = {"size": options.size, "spp": options.spp, "seed": options.seed}
    if INTEGRATORS[description.integrator.type_name()].both_ends is not None:
        # Nothing is tried: the techniques are what there is to choose from, and all are in use.
        pyramid = pyramid_of(description, **numbers)
        found, cause = Explanation(pyramid.shares, pyramid=pyramid), None
    else:
        shares = shares_of(description, **numbers)
        found, cause = Explanation(shares), next(iter(ranked(shares)), None)
    if options.measure and cause is not None:
        trials, left = try_alternatives(
            description, cause=cause, seed=options.seed, limit=options.time_limit,
            progress=progress,
        )  # fmt: skip
        found = Explanation(found.shares, trials, left, True)
    if options.output is not None:
        found.save_maps(options.output)
    return found
