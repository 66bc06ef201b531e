"""What all scenes of a study share while it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from alight.lab.replicates.spread import Spread
from alight.lab.store import Store
from alight.lab.study import SceneSpec, Study

#: Under ``--quick``: replicates, and most samples per pixel of the ladder.
QUICK_REPLICATES, QUICK_SPP = 8, 16


@dataclass(frozen=True)
class StudyProgress:
    """How far a study is.

    Attributes
    ----------
    text : str
        What is being done.
    done, total : float
        CPU seconds of rendering in the present phase; the total is 0 where it is not known.
    warnings : tuple of str
        What is suspicious of the scenes of all arms that are compiled.
    """

    text: str
    done: float = 0.0
    total: float = 0.0
    warnings: tuple[str, ...] = ()


@dataclass
class Session:
    """What all scenes of a study share while it runs.

    Attributes
    ----------
    study : Study
    store : Store
    quick : bool
    threads : int
    progress : callable
    spread : Spread or None
        The cluster whose workers render replicates; None for this process's threads.
    seconds : dict of str to float
        Spent so far, by kind.
    """

    study: Study
    store: Store
    quick: bool
    threads: int
    progress: Callable[[StudyProgress], None]
    spread: Spread | None = None
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(
            ("render", "reference", "load", "compile", "statistics"), 0.0
        )
    )

    @property
    def replicates(self) -> int:
        """S."""
        return min(self.study.replicates, QUICK_REPLICATES) if self.quick else self.study.replicates

    def ladder(self, scene: SceneSpec) -> tuple[int, ...]:
        """Samples per pixel at which arms are compared."""
        full = tuple(scene.spp or self.study.spp)
        if not self.quick:
            return full
        return tuple(n for n in full if n <= QUICK_SPP) or full[:1]
