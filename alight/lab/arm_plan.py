"""What an arm renders in a scene, and where it is compared."""

from __future__ import annotations

from dataclasses import dataclass

from alight.lab.arms import Arm
from alight.lab.references import Reference
from alight.lab.replicates.steering import is_biased, is_steered
from alight.lab.statistics.equal_time import Bracket, powers_of_two
from alight.lab.study import SCHEDULE


@dataclass(frozen=True)
class Plan:
    """What one arm renders in one scene.

    Attributes
    ----------
    arm : Arm
    key : str
        Of its replicates in the store.
    samples : tuple of int
        Samples per pixel at which arms are compared.
    times : tuple of Bracket
        Where the arm takes the time that the baseline takes at each of them; may be empty.
    reference : Reference
    own_reference : bool
    """

    arm: Arm
    key: str
    samples: tuple[int, ...]
    times: tuple[Bracket, ...]
    reference: Reference
    own_reference: bool

    @property
    def ladder(self) -> tuple[int, ...]:
        """All steps, rising."""
        around = {spp for step in self.times for spp in (step.low, step.high)}
        steps = {*self.samples, *around}
        if self.times and not is_steered(self.arm.spec.options.get(SCHEDULE)):
            # Each stop costs some time: with these all arms make about the same.
            steps |= powers_of_two(min(self.samples) // 2, max(steps))
        return tuple(sorted(steps))

    @property
    def tops(self) -> tuple[int, ...]:
        """The steps whose pictures are added up."""
        return tuple(sorted({self.samples[-1], self.shown}))

    @property
    def judged(self) -> Bracket:
        """Where arms are compared: the last step of equal time, if there is one."""
        return self.times[-1] if self.times else Bracket.at(self.samples[-1])

    @property
    def shown(self) -> int:
        """The step nearest to where arms are compared: whose pictures are shown."""
        return self.judged.shown

    @property
    def votes(self) -> bool:
        """Whether the arm means to compute what the others do."""
        return not (self.arm.spec.declares_different or self.decides_by_kept_samples)

    @property
    def decides_by_kept_samples(self) -> bool:
        """Whether it is biased by its rule."""
        return is_biased(self.arm.spec.options.get(SCHEDULE))
