"""A reference of a wanted error, for others to use.

A pilot is extended until its replicates say that its relRMSE lies below the wanted one with 95 %
confidence. The picture is then rendered again with as many samples of another seed: samples that
had a say in when to stop are not in it, so stopping cannot bias it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from alight.films import Film
from alight.lab.arms import seed_of
from alight.lab.study import StudyError
from alight.metrics.error_estimate import LEAST_FOR_INTERVAL
from alight.rendering import render

if TYPE_CHECKING:
    from alight.scene import Scene

#: Samples per pixel of the first look, and at most.
FIRST, MOST = 64, 1 << 20


@dataclass(frozen=True)
class MadeReference:
    """A picture and how it came about.

    Attributes
    ----------
    film : Film
        With standard errors.
    pilot_spp : int
    """

    film: Film
    pilot_spp: int


def make_reference(
    scene: Scene,
    error: float,
    *,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[Any], None] | None = None,
) -> MadeReference:
    """Render a reference.

    Parameters
    ----------
    scene : Scene
        Its film needs at least two replicates.
    error : float
        relRMSE wanted, as 0.005.
    seed : int
        From which both seeds follow.
    threads : int, optional
    progress : callable, optional
        As for `alight.render`.

    Raises
    ------
    StudyError
        If the error cannot be known, or would need more than 2^20 samples per pixel.
    """
    if scene.film.replicates < LEAST_FOR_INTERVAL:
        raise StudyError(
            f"a reference needs film.replicates of at least {LEAST_FOR_INTERVAL}, to know its own "
            f"error, got {scene.film.replicates}"
        )

    def run(role: str, spp: int, first: int = 0) -> Film:
        return render(
            scene, spp=spp, first_sample=first, seed=seed_of(role, seed), threads=threads,
            progress=progress,
        )  # fmt: skip

    spp = FIRST
    pilot = run("pilot", spp)
    while True:
        found = pilot.relmse_estimate().relrmse
        if math.isnan(found.high):
            raise StudyError("the error of this picture is not known: is it black?")
        if found.high <= error:
            break
        # Errors fall as 1 / sqrt(spp) at least; a step is never a leap on the word of one pilot.
        wanted = spp * min(max((found.high / error) ** 2, 1.25), 8.0)
        if wanted > MOST:
            raise StudyError(
                f"error {error:.3g} would need about {spp * (found.value / error) ** 2:.3g} spp, "
                f"more than {MOST}: the picture has {found.value:.2%} at {spp} spp"
            )
        more = max(math.ceil(wanted), spp + 1) - spp
        pilot = Film.merge(pilot, run("pilot", more, first=spp))
        spp += more
    return MadeReference(run("final", spp), spp)
