"""Repeated searches count one over their probability, however lanes are dealt out."""

import numpy as np
import pytest

from alight.integrators.caustics.manifold_sampling import BLOCK, _counted, _share_out
from alight.laws.statistics import LARGEST_Z
from lanewise.jit import instantiate
from lanewise.simd import LANES

WIDTH = int(LANES)
COUNTED = instantiate(_counted, None, compiled=False)


def _of_one(random, probability, lane, width):
    """Searches of one lane, by packets that give it `width` lanes: what they count."""
    successes = random.random(1 << 12) < probability
    waiting, made, number = 1 << lane, np.zeros(WIDTH, np.float32), np.zeros(WIDTH, np.uint32)
    stop, done = np.zeros(WIDTH, np.float32), 0
    while waiting:
        assert done < len(successes), "a lane waits for ever"
        bits = sum(int(b) << i for i, b in enumerate(successes[done : done + width]))
        waiting, made, number = COUNTED(waiting, width, bits, made, number, stop)
        done += width
    assert np.count_nonzero(made) == 1
    return made[lane]


@pytest.mark.parametrize("probability", [0.03, 0.3, 0.9])
def test_the_mean_count_is_one_over_the_probability(probability):
    random = np.random.default_rng(11)
    counts = np.array([_of_one(random, probability, 5, BLOCK) for _ in range(1200)])
    z = (counts.mean() - 1.0 / probability) / (counts.std() / np.sqrt(len(counts)))
    assert abs(z) < LARGEST_Z
    assert counts.std() / np.sqrt(len(counts)) < 0.03 / probability


def test_a_count_does_not_know_how_many_lanes_it_was_given():
    for seed in range(40):
        by_width = {
            float(_of_one(np.random.default_rng(seed), 0.1, 3, width))
            for width in (BLOCK, WIDTH // 2, WIDTH)
        }
        assert len(by_width) == 1


@pytest.mark.parametrize("waiting", [0b1, 0b10010, 0b1011, 0b11111011])
def test_lanes_are_dealt_out_to_those_that_wait(waiting):
    owner, width = instantiate(_share_out, None, compiled=False)(waiting)
    lanes = [lane for lane in range(WIDTH) if waiting >> lane & 1]
    served = np.broadcast_to(owner, WIDTH).reshape(-1, width)
    assert (served == served[:, :1]).all()
    first = served[:, 0].tolist()
    count = min(len(lanes), WIDTH // width)
    assert first[:count] == lanes[:count]
    # As many as there are, while each has a block.
    assert width == BLOCK or len(first) <= len(lanes) * 2 - 1
