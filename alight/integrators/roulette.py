"""Russian roulette: dim paths end at random, and the survivors carry their light.

A path ends with probability 1 - q; otherwise its throughput is divided by q, so the mean stays.

Source: Arvo and Kirk, Particle transport and image synthesis, SIGGRAPH 1990.
"""

from __future__ import annotations

from alight.integrators.walk import ROULETTE
from alight.samplers.sampling import get_1d
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import minimum, where

#: Longest expected rest of a path: even a white path ends with 5 % at each vertex (as Mitsuba 3).
MAX_SURVIVAL = 0.95


@kernel
def play_roulette(settings, path, dimension, brightness):
    """The path, if it survives.

    Parameters
    ----------
    settings : Settings
        Paths play from the vertex `rr_depth` on.
    path : PathState
        With the vertex's depth, and the throughput of its next ray.
    dimension : u32
        First dimension of the vertex.
    brightness : float
        What the path would bring of a white light: the probability q, but for `MAX_SURVIVAL`.
    """
    beta, active = path.beta, path.active
    survival = minimum(brightness, MAX_SURVIVAL)
    playing = path.depth >= settings.rr_depth
    survived = get_1d(path.sampler, dimension + ROULETTE) < survival
    beta = where(playing, beta / survival, beta)
    return replace(path, beta=beta, active=active & (survived | ~playing))


@kernel
def survival_by_throughput(settings, path, brightness):
    """With which probability `play_roulette` lets paths go on."""
    return where(path.depth >= settings.rr_depth, minimum(brightness, MAX_SURVIVAL), 1.0)


@kernel
def rarer_alone(settings, path, brightness, played):
    """Paths, as rare as ordinary roulette would have made them without their guide.

    brightness: as of `play_roulette`; played: mask, where the guided path plays that roulette too.
    """
    rarity = path.unguided.rarity
    alone = survival_by_throughput(settings, path, brightness * rarity)
    own = where(played, survival_by_throughput(settings, path, brightness), 1.0)
    going = path.active & (alone > 0.0)
    rarity = where(going, rarity * own / where(going, alone, 1.0), rarity)
    return replace(path, unguided=replace(path.unguided, rarity=rarity))
