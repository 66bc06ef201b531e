"""Seeds of a render's parts: its rounds, and what is not the picture."""

from __future__ import annotations

#: The ledger's pilot, and the first round of training a guide, from the camera and from the lights;
#: no schedule has so many rounds.
PILOT, TRAINING, LIGHT_TRAINING = 2**16, 2**17, 2**18


def seed_of_round(seed: int, round: int) -> int:
    """Random numbers of a round's film: those of two rounds are independent, for every sampler.

    Later samples of a sequence are not: they fill what its earlier ones left open.
    """
    return (seed + 0x9E3779B9 * round) % 2**32
