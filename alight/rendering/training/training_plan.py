"""How long a guide is trained where the scene leaves the choice, and when it is given up.

A guide that does not pay shall cost no more than `MOST_SPENT` of the picture, one that looks as if
it will a quarter, and one that pays no more than half of it, or a tenth if it is long. A round's
cost is counted in paths, the picture's in samples: neither clocks nor threads decide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

#: Rounds of training: 1, 2, 4 ... samples a pixel. Where the scene leaves the choice, a long render
#: may have more: guides still get better.
ROUNDS, MOST_ROUNDS = 7, 9

#: A guide is used where each of its rays is worth so many without it: such a ray takes up to 2.4
#: times as long, and evenly distributed samples help unguided paths up to 1.3 times as much.
LEAST_GAIN = 3.0

#: What a guide must be worth after a round, by the number of the round, or it is given up. Gains
#: that are less hardly reach `LEAST_GAIN` any more; after the first of these rounds some still do,
#: whatever they seem to be worth.
GATES = {2: 0.0, 3: 0.5, 4: 1.5, 5: 2.0}
FIRST_GATE = min(GATES)

#: A guide that is worth so much already is likely to pay, where samples without it have so much
#: variance, in relMSE(0.01); of less noise it hardly takes more than it does so early. The limit is
#: low, since few samples seldom meet the light that makes most noise.
PROMISING, NOISY = 1.5, 0.1

#: A path of training, with the light path beside it, takes as long as so many samples of a picture
#: without a guide: 1.6 to 7.5 in random scenes, 10 to 15 where light paths bounce and no camera is.
COST = 6.0

#: Of the picture: what may be spent on a guide before it is promising; before it has shown that it
#: pays; after that; and on rounds beyond `ROUNDS`.
MOST_SPENT, MOST_SPENT_IN_HOPE, MOST_SPENT_WELL, MOST_SPENT_LONG = 0.05, 0.25, 0.5, 0.1


class Length(NamedTuple):
    """How long a picture is to be.

    Attributes
    ----------
    samples : float
        Of all pixels of the whole film together; infinite where nobody knows.
    is_limit : bool
        It may end before: when its error is reached, or the time is up.
    """

    samples: float = math.inf
    is_limit: bool = False


#: Nobody knows.
UNKNOWN = Length()


class Signs(NamedTuple):
    """What a round has shown of a guide.

    Attributes
    ----------
    gain : float
        How many rays without it a ray with it is worth, see `Trainer.gain`.
    noise : float
        Variance of a sample without it, in relMSE(0.01).
    """

    gain: float
    noise: float

    @property
    def promising(self) -> bool:
        """Whether it is likely to pay."""
        return self.gain >= PROMISING and self.noise >= NOISY


class Step(Enum):
    """What follows a round of training."""

    GO_ON = auto()
    USE = auto()
    GIVE_UP = auto()


@dataclass(frozen=True)
class TrainingPlan:
    """The rounds of one training.

    Parameters
    ----------
    rounds : int
        To be run; where the plan chooses, perhaps fewer, or up to `MOST_ROUNDS`.
    chooses : bool
        Whether the guide may be given up; if not, all rounds are run.
    length : Length
        Of the picture.
    pixels : int
        Of training's small picture.
    """

    rounds: int = ROUNDS
    chooses: bool = False
    length: Length = UNKNOWN
    pixels: int = 1

    @property
    def most_rounds(self) -> int:
        """That may be run."""
        samples, is_limit = self.length
        is_long = math.isfinite(samples) and not is_limit
        return MOST_ROUNDS if self.chooses and self.rounds == ROUNDS and is_long else self.rounds

    @property
    def begins(self) -> bool:
        """Whether the picture is worth the rounds before a guide is first judged."""
        first = min(FIRST_GATE, self.rounds - 1)
        return not self.chooses or self._spent(first) <= MOST_SPENT

    def is_judged(self, number: int) -> bool:
        """Whether a round is followed by a verdict on the guide."""
        return number in GATES or number >= self.rounds - 1

    def step(self, number: int, signs: Signs) -> Step:
        """What follows a round, counted from 0.

        Of rounds that are not judged, `signs` do not count.
        """
        last = number == self.most_rounds - 1
        if not self.chooses or not self.is_judged(number):
            return Step.USE if last else Step.GO_ON
        long = number >= self.rounds - 1
        if signs.gain >= LEAST_GAIN:
            most = MOST_SPENT_LONG if long else MOST_SPENT_WELL
            return Step.USE if last or self._spent(number + 1) > most else Step.GO_ON
        # One more round, to pay after all: if it still can, and little is lost if it does not.
        most = MOST_SPENT_IN_HOPE if signs.promising else MOST_SPENT
        goes_on = not long and signs.gain >= GATES[number] and self._spent(number + 1) <= most
        return Step.GO_ON if goes_on else Step.GIVE_UP

    def _spent(self, number: int) -> float:
        """What the rounds up to this one cost, as a part of the picture."""
        return COST * self.pixels * (2 ** (number + 1) - 1) / self.length.samples
