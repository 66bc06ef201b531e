"""Russian roulette: dim paths end at random, and the survivors carry their light.

A path ends with probability 1 - q; otherwise its throughput is divided by q, so the mean stays.

Source: Arvo and Kirk, Particle transport and image synthesis, SIGGRAPH 1990.
"""

from __future__ import annotations

from alight.bsdfs.switch import concentration, refracts
from alight.integrators.walk import ROULETTE, vertex_dimension
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
def play_beside_guide(settings, path, dimension, brightness, gain):
    """Roulette of a guided path, which has played by the guide's gain where that has learnt any.

    What the path would be without its guide plays by throughput in any case.
    """
    unlearnt = gain == 0.0
    alone = _survival(settings, path, brightness * path.unguided.rarity)
    own = where(unlearnt, _survival(settings, path, brightness), 1.0)
    going = path.active & (alone > 0.0)
    rarity = path.unguided.rarity * where(going, own / where(going, alone, 1.0), 1.0)
    left = play_roulette(settings, path, dimension, brightness)
    return replace(
        path,
        beta=where(unlearnt, left.beta, path.beta),
        active=path.active & (left.active | ~unlearnt),
        unguided=replace(path.unguided, rarity=rarity),
    )


@kernel
def _survival(settings, path, brightness):
    """With which probability `play_roulette` lets paths go on."""
    return where(path.depth >= settings.rr_depth, minimum(brightness, MAX_SURVIVAL), 1.0)


def write_end_dim_paths(program, guided):
    """Roulette by throughput, of ``(scene, settings, path, surface, wi, brightness, here)``."""
    refracting = refracts(program)

    @kernel
    def end_dim_paths(scene, settings, path, surface, wi, brightness, here):
        if refracting:
            # A path in glass is not dim: it regains on the way out what it lost on the way in.
            brightness = brightness * concentration(scene, surface, wi)
        dimension = vertex_dimension(path.depth)
        if guided:
            return play_beside_guide(settings, path, dimension, brightness, here.gain)
        return play_roulette(settings, path, dimension, brightness)

    return end_dim_paths
